//! Edges beyond which a view looked through the plane: the face ends there.

use super::edges::Trace;
use super::growing::GrowingFace;
use crate::EdgeKind;
use crate::free_space::FreeSpace;
use crate::outline::Outline;

/// A strip beyond an edge begins and ends so far from it, m: three cells wide, of which a view
/// looks through blocks of two.
const STRIP_M: [f64; 2] = [0.01, 0.07];
/// The face ends where this part of the strip was looked through.
const THROUGH_MIN: f64 = 0.5;

/// Makes edges real beyond which a view looked through the plane.
pub(super) fn look_beyond(face: &mut GrowingFace, free_space: &FreeSpace) {
    let open = |trace: &Trace| !matches!(trace.edge.kind, EdgeKind::Real | EdgeKind::Fold);
    let strips = face.traces.iter().filter(|trace| open(trace)).map(strip);
    let zone = strips.fold(Outline::default(), |zone, strip| zone.union(&strip));
    if zone.is_empty() {
        return;
    }
    let carved = face.carved(free_space, &zone);
    if carved.through.is_empty() {
        return;
    }
    for trace in face.traces.iter_mut().filter(|trace| open(trace)) {
        let strip = strip(trace);
        if strip.common(&carved.through).area() >= THROUGH_MIN * strip.area() {
            trace.edge.kind = EdgeKind::Real;
        }
    }
}

/// The strip of the plane beyond an edge.
fn strip(trace: &Trace) -> Outline {
    let [a, b] = trace.ends;
    let [near, far] = STRIP_M.map(|d| trace.out * d);
    let corners = [a + near, b + near, b + far, a + far];
    Outline::from_rings(&[corners.iter().map(|p| [p.x, p.y]).collect()])
}
