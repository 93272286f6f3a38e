//! A node of the tree: a contact set with the posture that reached it.

use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};
use posture::{Contact, Place, Posture};

use crate::plan::Change;
use crate::request::{FootState, Prepared};

/// A contact of a node, at its pose.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub(crate) struct Held {
    pub patch: usize,
    pub surface: usize,
    /// Of a ball: its centre, with the axes of the surface that it touches.
    pub X_WC: Isometry3<f64>,
}

impl Held {
    /// The place that is touched, in W: C's origin, or the point of a ball.
    #[allow(non_snake_case)]
    pub fn place_W(&self, prepared: &Prepared) -> Vector3<f64> {
        prepared.request.robot.patches[self.patch].touched_W(&self.X_WC)
    }
}

/// A contact set with its posture.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub parent: Option<usize>,
    /// Contact changes from the root.
    pub depth: usize,
    pub change: Change,
    /// Whether the contact is beside one that no motion leads to.
    pub elsewhere: bool,
    /// The contact set, in the order of the patches.
    pub contacts: Vec<Held>,
    /// The contacts of the posture problem: the set, and the one just released, if any.
    pub touching: Vec<(Held, bool)>,
    pub posture: Arc<Posture>,
    /// Last place of every patch in W, whether it still touches or not.
    pub last: Vec<Option<Vector3<f64>>>,
}

impl Node {
    pub fn holds(&self, patch: usize) -> bool {
        self.contacts.iter().any(|c| c.patch == patch)
    }

    /// Distance along the guide path that the feet still have to go, on the mean, m.
    pub fn distance_m(&self, prepared: &Prepared) -> f64 {
        let end = prepared.request.guide.length_m();
        let feet = self.feet(prepared);
        let behind: f64 = feet.iter().map(|f| (end - f.along_m).max(0.0)).sum();
        behind / feet.len().max(1) as f64
    }

    /// The feet as the estimate sees them.
    pub fn feet(&self, prepared: &Prepared) -> Vec<FootState> {
        prepared
            .feet
            .iter()
            .map(|&patch| {
                let place = self.last[patch].unwrap_or_else(Vector3::zeros);
                let progress = prepared
                    .request
                    .guide
                    .foot_progress(&place, &prepared.offset[patch]);
                FootState {
                    along_m: progress.along_m,
                    // Height beside the path is the surfaces' business, not a detour.
                    aside_m: aside(prepared, patch, &place),
                    in_air: !self.holds(patch),
                }
            })
            .collect()
    }
}

/// Horizontal distance of a foot from its place on the path, beyond half its usual offset, m.
pub(crate) fn aside(prepared: &Prepared, patch: usize, place: &Vector3<f64>) -> f64 {
    let guide = &prepared.request.guide;
    let offset = &prepared.offset[patch];
    let along = guide.foot_progress(place, offset).along_m;
    let usual = guide.foot_at(along, offset);
    ((place - usual).xy().norm() - 0.5 * offset.y.abs()).max(0.0)
}

/// The contact as the posture generator wants it.
pub(crate) fn fixed(prepared: &Prepared, held: &Held, loaded: bool) -> Contact {
    Contact {
        patch: held.patch,
        place: Place::Fixed {
            X_WC: held.X_WC,
            yaw_free: false,
            surface: Some(held.surface),
        },
        loaded,
        friction: prepared.request.robot.patches[held.patch].friction,
    }
}

/// What tells one contact set from another: patches, faces and places, to the cell.
pub(crate) fn key(prepared: &Prepared, contacts: &[Held]) -> Vec<(usize, usize, [i64; 3])> {
    let cell_m = prepared.config.same_place_m;
    contacts
        .iter()
        .map(|c| {
            let p = c.X_WC.translation.vector / cell_m;
            (
                c.patch,
                prepared.face.get(c.surface).copied().unwrap_or(c.surface),
                [p.x, p.y, p.z].map(|x| x.round() as i64),
            )
        })
        .collect()
}
