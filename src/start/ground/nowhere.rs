//! Feet that stand on nothing of a world that is known without a scan.

use nalgebra::{Point3, Vector3};
use surfaces::{Face, Source, Terrain};

/// Faces that lean by more than this are neither over nor under a place: the cosine of 60°.
const LEVEL: f64 = 0.5;
/// A face that is this near to the soles is their floor, m; turned round, where it looks down.
const THERE_M: f64 = 0.01;

/// What to say where soles about a point stand on no face of a file or a mesh, but on a ground of their own: what is
/// there instead. Nothing in a world that was scanned, whose sensor does not see where the robot stands.
pub(super) fn note(terrain: &Terrain, soles: &Point3<f64>) -> Option<String> {
    let mut known = terrain.faces.iter().filter(|f| f.source != Source::Robot);
    if terrain.faces.iter().any(|f| f.source == Source::Scan) || known.next().is_none() {
        return None;
    }
    // Along the vertical through the point: how far over it each face is, m.
    let over_m = |face: &Face| -> Option<f64> {
        let n = face.normal_W();
        if n.z.abs() < LEVEL {
            return None;
        }
        let over_m = -face.height_of(soles) / n.z;
        let p_F = face
            .X_WF
            .inverse_transform_point(&(soles + Vector3::z() * over_m));
        let p_F = p_F.xy();
        ((face.region.nearest(&p_F) - p_F).norm() < THERE_M).then_some(over_m)
    };
    let met = terrain.faces.iter().filter_map(|f| Some((f, over_m(f)?)));
    let nearest = |up: f64| {
        let met = met.clone().filter(|(f, _)| up * f.normal_W().z > 0.0);
        met.min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
    };
    let place = format!("({:.2}, {:.2}, {:.2})", soles.x, soles.y, soles.z);
    let why = match (nearest(1.0), nearest(-1.0)) {
        (_, Some((face, over_m))) if over_m.abs() < THERE_M => format!(
            "{} is there and looks down: is the mesh wound the other way?",
            face.id
        ),
        (Some((face, over_m)), _) => {
            let lean = face.normal_W().z.clamp(-1.0, 1.0).acos().to_degrees();
            let is_level = lean < 0.5;
            if is_level && over_m.abs() < THERE_M {
                // They stand at the border of that face.
                return None;
            }
            let leaning = if is_level {
                String::new()
            } else {
                format!(" and leans by {lean:.0}°")
            };
            let side = if over_m < 0.0 { "under" } else { "over" };
            let apart_m = over_m.abs();
            format!(
                "{} is {apart_m:.3} m {side} that{leaning}; --start @X,Y puts the feet onto what is there",
                face.id
            )
        }
        (None, _) => {
            "nothing is over or under that: --start @X,Y[,Z] says where it stands".to_owned()
        }
    };
    Some(format!(
        "warning: the soles at {place} are on no face and are given a ground of their own: {why}"
    ))
}
