//! The table of stances: a frame and the joint readings (or the pose) of every stance, as CSV.

use std::collections::BTreeMap;

use anyhow::{Result, anyhow, bail};

/// Column of the frames' file names.
const FRAME: &str = "frame";
/// Columns of a pose that is known by other means than the legs.
const POSE: [&str; 3] = ["height_m", "roll_rad", "pitch_rad"];

/// One stance.
#[derive(Clone, Debug, PartialEq)]
pub struct StanceRow {
    /// Line in the file, counted from 1.
    pub line: usize,
    /// Name of the frame's file, where the table has them.
    pub frame: Option<String>,
    /// What the robot says of itself.
    pub reading: Reading,
}

/// What the robot says of itself in a stance.
#[derive(Clone, Debug, PartialEq)]
pub enum Reading {
    /// Joint values by the joint's name, rad or m.
    Joints(BTreeMap<String, f64>),
    /// The link's height over the ground (m) and its roll and pitch (fixed axes, rad).
    Pose([f64; 3]),
}

/// The stances of a table.
///
/// The first line names the columns: `frame` (optional), and either joints by name or `height_m`,
/// `roll_rad`, `pitch_rad`. Lines that are empty or begin with # are passed over.
///
/// # Errors
/// What is wrong, with its line: an unknown or missing column, a cell that is no number.
pub fn parse(text: &str, joint_names: &[&str]) -> Result<Vec<StanceRow>> {
    let lines = text.lines().enumerate();
    let mut lines = lines
        .map(|(i, line)| (i + 1, line.trim()))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let (number, header) = lines.next().ok_or_else(|| anyhow!("the table is empty"))?;
    let columns: Vec<&str> = header.split(',').map(str::trim).collect();
    check_columns(&columns, joint_names).map_err(|error| anyhow!("line {number}: {error}"))?;
    let rows = lines.map(|(line, text)| {
        row(line, text, &columns).map_err(|error| anyhow!("line {line}: {error}"))
    });
    let rows = rows.collect::<Result<Vec<_>>>()?;
    if rows.is_empty() {
        bail!("the table has no stances");
    }
    Ok(rows)
}

fn check_columns(columns: &[&str], joint_names: &[&str]) -> Result<()> {
    let (pose, known) = (POSE.join(", "), joint_names.join(", "));
    for (i, column) in columns.iter().enumerate() {
        if columns[..i].contains(column) {
            bail!("column {column:?} is there twice");
        }
        if *column != FRAME && !POSE.contains(column) && !joint_names.contains(column) {
            bail!("column {column:?} is neither {FRAME:?} nor one of {pose} nor a joint: {known}");
        }
    }
    let given = POSE.iter().filter(|name| columns.contains(name)).count();
    let joints = columns.iter().filter(|c| joint_names.contains(c)).count();
    match (given, joints) {
        (0, 0) => bail!("no column is a joint, and there is no {pose}; the joints: {known}"),
        (0, _) | (3, 0) => Ok(()),
        (3, _) => bail!("give joints, or {pose}, not both"),
        _ => bail!("a pose needs all of {pose}"),
    }
}

fn row(line: usize, text: &str, columns: &[&str]) -> Result<StanceRow> {
    let cells: Vec<&str> = text.split(',').map(str::trim).collect();
    if cells.len() != columns.len() {
        bail!("{} cells for {} columns", cells.len(), columns.len());
    }
    let mut frame = None;
    let mut values = BTreeMap::new();
    for (column, cell) in columns.iter().zip(cells) {
        if *column == FRAME {
            if cell.is_empty() {
                bail!("column {FRAME:?} is empty");
            }
            frame = Some(cell.to_owned());
            continue;
        }
        match cell.parse::<f64>() {
            Ok(value) if value.is_finite() => values.insert((*column).to_owned(), value),
            _ => bail!("column {column:?}: {cell:?} is not a finite number"),
        };
    }
    let pose = POSE.map(|name| values.get(name).copied());
    let reading = match pose {
        [Some(height_m), Some(roll), Some(pitch)] => Reading::Pose([height_m, roll, pitch]),
        _ => Reading::Joints(values),
    };
    Ok(StanceRow {
        line,
        frame,
        reading,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const JOINTS: [&str; 2] = ["hip", "knee"];

    #[test]
    fn joints_and_poses_are_read() {
        let text = "# taken today\nframe, hip, knee\n\na.png, 0.1, -2\n";
        let rows = parse(text, &JOINTS).unwrap();
        assert_eq!(rows.len(), 1);
        assert_eq!((rows[0].line, rows[0].frame.as_deref()), (4, Some("a.png")));
        let Reading::Joints(values) = &rows[0].reading else {
            panic!("{rows:?}");
        };
        assert_eq!((values["hip"], values["knee"]), (0.1, -2.0));
        let rows = parse("height_m,roll_rad,pitch_rad\n0.6,0.1,-0.2", &JOINTS).unwrap();
        assert_eq!(rows[0].reading, Reading::Pose([0.6, 0.1, -0.2]));
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        for (text, words) in [
            ("", vec!["empty"]),
            ("hip", vec!["no stances"]),
            ("frame\na.png", vec!["line 1", "hip, knee"]),
            ("hipp\n1", vec!["line 1", "hipp", "hip, knee"]),
            ("hip,hip\n1,1", vec!["twice"]),
            ("hip,knee\n1", vec!["line 2", "1 cells for 2"]),
            ("hip\n0\nfar", vec!["line 3", "hip", "far"]),
            ("hip\nNaN", vec!["NaN"]),
            ("frame,hip\n,1", vec!["line 2", "frame"]),
            ("height_m,hip\n1,1", vec!["all of"]),
            ("height_m,roll_rad,pitch_rad,hip\n1,1,1,1", vec!["not both"]),
        ] {
            let error = parse(text, &JOINTS).unwrap_err().to_string();
            for word in words {
                assert!(error.contains(word), "{text:?}: no {word:?} in {error}");
            }
        }
    }
}
