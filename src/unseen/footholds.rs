//! Contacts that rest on what no view showed.

use nalgebra::Point3;
use plan::Plan;
use schemars::JsonSchema;
use serde::Serialize;
use surfaces::{Face, Source};

/// A face that is touched where another one hides it from every view, because it is taken to go on there.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct HiddenFoothold {
    /// The face.
    pub face: String,
    /// The face that hides it.
    pub under: String,
    /// The first patch that rests there at least in part.
    pub patch: String,
    /// Index of the stance in which it does.
    pub stance: usize,
}

/// The faces of a plan that are touched where they are hidden, each once.
pub fn hidden(plan: &Plan) -> Vec<HiddenFoothold> {
    let mut found: Vec<HiddenFoothold> = Vec::new();
    for stance in &plan.stances {
        for contact in &stance.contacts {
            let id = contact.face.as_str();
            let is_known = found.iter().any(|known| known.face == id);
            let face = plan.faces.iter().find(|face| face.id == contact.face);
            let Some(face) = face.filter(|face| !is_known && face.source == Source::Scan) else {
                continue;
            };
            let mut vertices = contact.vertices_W.iter().map(|p| Point3::from(*p));
            if let Some(under) = vertices.find_map(|p| hides(plan, face, &p)) {
                found.push(HiddenFoothold {
                    face: id.to_owned(),
                    under: under.id.to_string(),
                    patch: contact.patch.clone(),
                    stance: stance.index,
                });
            }
        }
    }
    found
}

/// What hides a place of a face from all views of it.
fn hides<'a>(plan: &'a Plan, face: &Face, p_W: &Point3<f64>) -> Option<&'a Face> {
    let hiding = face.views.iter().map(|view| {
        let others = plan.faces.iter().filter(|other| other.id != face.id);
        let hiding = others.filter(|other| other.hides(p_W, &view.eye_W));
        // The nearest one: the place is behind the planes of all of them.
        hiding.max_by(|a, b| a.height_of(p_W).total_cmp(&b.height_of(p_W)))
    });
    hiding.reduce(|all, one| all.and(one)).flatten()
}
