//! One row a stance, for spreadsheets and plots.

use anyhow::Result;
use plan::{Change, Plan};
use robot_model::{JointKind, Robot};

use super::timeline::phases;
use super::{Config, frames};

/// The plan as a table: what changes and when the posture is reached, centre of mass, q, and for
/// every patch whether it touches and its force (N) and moment about its frame's origin (N·m) in W.
pub(super) fn write(
    plan: &Plan,
    motion: Option<&plan::Motion>,
    robot: &Robot,
    config: &Config,
) -> Result<String> {
    let mut text = header(robot).join(",") + "\n";
    let phases = phases(plan, motion, config);
    for (index, stance) in plan.stances.iter().enumerate() {
        let (kind, patch, face) = match &stance.change {
            Change::Start => ("start", "", ""),
            Change::Goal => ("goal", "", ""),
            Change::Add { patch, face } => ("add", patch.as_str(), face.as_str()),
            Change::Remove { patch, face } => ("remove", patch.as_str(), face.as_str()),
        };
        // The first phase that leads to the stance; the start is there from the beginning.
        let first = phases.iter().find(|p| p.stance == index);
        let reached = first.map_or(0.0, |p| p.end_s);
        let mut cells = vec![index.to_string()];
        cells.extend([kind, patch, face].map(quoted));
        cells.push(number(reached));
        cells.extend(stance.com_W.iter().chain(&stance.q).map(|x| number(*x)));
        for patch in &robot.patches {
            match stance.contacts.iter().find(|c| c.patch == patch.name) {
                None => cells.extend(["free", "", "", "", "", "", ""].map(str::to_owned)),
                Some(contact) => {
                    let state = if contact.loaded { "loaded" } else { "touching" };
                    cells.push(state.to_owned());
                    cells.extend(frames::wrench(contact).map(number));
                }
            }
        }
        text += &cells.join(",");
        text.push('\n');
    }
    Ok(text)
}

fn header(robot: &Robot) -> Vec<String> {
    let known = "index,change,patch,face,time_s,com_x_m,com_y_m,com_z_m,base_x_m,base_y_m,\
                 base_z_m,base_qx,base_qy,base_qz,base_qw";
    let mut names: Vec<String> = known.split(',').map(str::to_owned).collect();
    names.extend(robot.joint_bodies().iter().map(|body| {
        let slides = body.kind == JointKind::Prismatic;
        quoted(&format!(
            "{}_{}",
            body.joint,
            if slides { "m" } else { "rad" }
        ))
    }));
    for patch in &robot.patches {
        names.push(quoted(&patch.name));
        for axis in ["fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"] {
            names.push(quoted(&format!("{}_{axis}", patch.name)));
        }
    }
    names
}

/// The shortest decimal that reads back as the value.
fn number(value: f64) -> String {
    format!("{}", frames::rounded(value))
}

/// A cell that may hold anything, quoted where RFC 4180 wants it.
pub fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn separators_and_quotes_are_quoted() {
        assert_eq!(quoted("step"), "step");
        assert_eq!(quoted("a,b"), "\"a,b\"");
        assert_eq!(quoted("the \"top\""), "\"the \"\"top\"\"\"");
    }
}
