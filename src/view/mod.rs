//! One self-contained HTML page that shows a plan: it needs no network and no server.
//!
//! | in the page | made by |
//! |---|---|
//! | frame, style and script | `viewer/` (three.js bundled in) |
//! | the scan | `cloud` |
//! | the robot's shapes and where its bodies are in every stance | `robot` |
//! | the faces | `face` |
//! | the motion | `motion` |
//! | the stances with their forces | `stance` |
//! | plans side by side | `compare` |
//! | surfaces alone, to look at and to edit | `surfaces_page` |
//! | where the centre of mass may stand | `support` |
//!
//! All that needs a model of the robot is computed here; the script only draws.

mod cloud;
mod compare;
mod face;
mod motion;
mod number;
mod robot;
mod robot_page;
mod stance;
mod support;
mod surfaces_page;

pub use compare::{Compared, compare_page};
pub use robot_page::robot_page;
pub use surfaces_page::{SurfacesInput, surfaces_page};

use anyhow::{Context, Result};
use plan::{Motion, Plan, Trace};
use robot_model::{GRAVITY_M_S2, Robot};
use serde_json::{Value, json};
use verify::Certificate;

use crate::template::escape;

const TEMPLATE: &str = include_str!("../../viewer/index.html");
const STYLE: &str = include_str!("../../viewer/viewer.css");
const SCRIPT: &str = include_str!("../../viewer/dist/viewer.js");

/// What the page's script reads.
const FORMAT: &str = "scandent-view/1";

/// Most points of the scan that the page carries.
pub const CLOUD_POINTS_MAX: usize = 60_000;

/// What the page shows.
#[derive(Clone, Copy, Debug)]
pub struct ViewInput<'a> {
    /// The plan; one without stances shows its surfaces.
    pub plan: &'a Plan,
    /// The plan's robot.
    pub robot: &'a Robot,
    /// The motion between its stances.
    pub motion: Option<&'a Motion>,
    /// What the search tried for it, where that is known.
    pub trace: Option<&'a Trace>,
    /// The verifier's word on it, where it was asked.
    pub certificate: Option<&'a Certificate>,
    /// The scan's points in W, m; thinned to [`CLOUD_POINTS_MAX`], points that are not finite are
    /// left out.
    pub cloud_W: &'a [[f32; 3]],
}

impl<'a> ViewInput<'a> {
    /// A plan alone.
    pub fn new(plan: &'a Plan, robot: &'a Robot) -> Self {
        Self {
            plan,
            robot,
            motion: None,
            trace: None,
            certificate: None,
            cloud_W: &[],
        }
    }
}

/// The page as HTML.
///
/// # Errors
/// When the robot is not the plan's, or a stance contradicts itself: which stance, and how.
pub fn page(input: &ViewInput<'_>) -> Result<String> {
    page_of("plan", input)
}

/// The page as HTML; `kind` is what it is of.
fn page_of(kind: &str, input: &ViewInput<'_>) -> Result<String> {
    let title = match &input.plan.search.unsolved {
        Some(_) => format!("No plan · {}", input.plan.scene),
        None => input.plan.scene.clone(),
    };
    framed(&title, &data(kind, input)?, false)
}

/// The page of a title that shows such data; one that is `served` may ask its server.
fn framed(title: &str, data: &Value, served: bool) -> Result<String> {
    // Nothing in the JSON may end the script element that carries it.
    let data = data.to_string().replace('<', "\\u003c");
    let title = escape(title);
    let parts = [
        ("@CONNECT@", if served { "'self'" } else { "'none'" }),
        ("@TITLE@", title.as_str()),
        ("@STYLE@", STYLE),
        ("@DATA@", &data),
        ("@SCRIPT@", SCRIPT),
    ];

    let mut html = String::with_capacity(TEMPLATE.len() + STYLE.len() + SCRIPT.len() + data.len());
    let mut rest = TEMPLATE;
    for (mark, text) in parts {
        let parted = rest.split_once(mark);
        let (before, after) = parted.with_context(|| format!("the page's frame has no {mark}"))?;
        html.push_str(before);
        html.push_str(text);
        rest = after;
    }
    html.push_str(rest);
    Ok(html)
}

/// The JSON that the page's script reads.
fn data(kind: &str, input: &ViewInput<'_>) -> Result<Value> {
    let (plan, robot, points) = (input.plan, input.robot, input.cloud_W);
    robot::check_joints(robot, plan)?;
    let stances = plan.stances.iter().map(|stance| {
        let record = stance::record(stance, &plan.required, robot);
        record.with_context(|| format!("stance {} of the plan", stance.index))
    });
    let stances = stances.collect::<Result<Vec<_>>>()?;
    Ok(json!({
        "format": FORMAT,
        "kind": kind,
        "program": format!("{} {}", plan.program.name, plan.program.version),
        "scene": plan.scene,
        "seed": plan.seed,
        "inputs": plan.inputs,
        "robot": {
            "name": robot.name,
            "mass_kg": robot.mass_kg,
            "weight_N": robot.mass_kg * GRAVITY_M_S2,
            "bodies": robot::bodies(robot),
        },
        "cloud": cloud::record(&cloud::thinned(points, CLOUD_POINTS_MAX), points.len()),
        "surfaces": plan.faces.iter().map(|f| face::record(f, plan.required.edge_sigmas)).collect::<Vec<_>>(),
        "obstacles": plan.obstacles.iter().map(face::obstacle).collect::<Vec<_>>(),
        "unseen": face::unseen(&plan.faces, plan.thin_body_m),
        "required": plan.required,
        "goal": plan.goal,
        "search": plan.search,
        "trace": input.trace,
        "stances": stances,
        "motion": motion::record(input.motion, robot)?,
        "certificate": input.certificate.map(|certificate| json!({
            "verdict": certificate.verdict(),
            "checks": certificate.rows.len(),
            "conditions": certificate.conditions.iter().chain(&certificate.notes).collect::<Vec<_>>(),
        })),
    }))
}
