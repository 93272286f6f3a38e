//! Regions of planes → faces of the world.

use nalgebra::{Isometry3, Point2, Translation3};
use surfaces::{ConvexPolygon, Edge, EdgeView, Error, Face, Fit, Region, Ring, Source};

/// What is known of a face beside its rings.
pub(crate) struct Known {
    /// Index of its plane among those of the scan.
    pub plane: u16,
    pub fit: Fit,
    pub view: EdgeView,
}

/// The face of rings on a plane P in W, the outer one first, whose edges `of` tells: ring, index. Frame F
/// has its origin at the region's centroid; `covariance` is asked for with that, on P.
///
/// # Errors
/// [`Error::Part`] naming the plane where the rings are no region, or the face not valid.
pub(crate) fn face(
    rings: &[Vec<Point2<f64>>],
    of: impl Fn(usize, usize) -> Edge,
    X_WP: &Isometry3<f64>,
    known: &Known,
    covariance: impl FnOnce(&Point2<f64>) -> Option<[[f64; 3]; 3]>,
) -> Result<Face, Error> {
    let id = format!("plane {}", known.plane);
    let ring = |(k, vertices): (usize, &Vec<Point2<f64>>)| Ring {
        vertices: vertices.clone(),
        edges: (0..vertices.len()).map(|i| of(k, i)).collect(),
    };
    let region =
        Region::new(rings.iter().enumerate().map(ring)).map_err(|cause| cause.of_face(&id))?;
    let centroid = region.centroid();
    let X_PF = Translation3::new(centroid.x, centroid.y, 0.0);
    let face = Face {
        plane_covariance: covariance(&centroid),
        fit: Some(known.fit),
        views: vec![known.view],
        source: Source::Scan,
        ..Face::new(id, X_WP * X_PF, region.moved(&-centroid.coords))
    };
    face.validate()?;
    Ok(face)
}

/// The region of a polygon with the same edge all around.
pub(crate) fn convex(polygon: &ConvexPolygon, edge: Edge) -> Region {
    let mut region = Region::from(polygon);
    region.edges_mut().for_each(|ring| ring.fill(edge));
    region
}

/// The faces of a scan.
pub(crate) struct Faces {
    /// Named f0, f1, … by falling area.
    pub faces: Vec<Face>,
    /// The index of the plane of each.
    pub planes: Vec<u16>,
    /// Why others could not be used.
    pub refused: Vec<Error>,
}

impl Faces {
    /// Of what was found, each with the index of its plane.
    pub fn new(found: impl IntoIterator<Item = (u16, Result<Face, Error>)>) -> Self {
        let (mut kept, mut refused) = (Vec::new(), Vec::new());
        for (plane, face) in found {
            match face {
                Ok(face) => kept.push((plane, face)),
                Err(cause) => refused.push(cause),
            }
        }
        kept.sort_by(|(_, a), (_, b)| b.region.area().total_cmp(&a.region.area()));
        let (planes, mut faces): (Vec<u16>, Vec<Face>) = kept.into_iter().unzip();
        for (i, face) in faces.iter_mut().enumerate() {
            face.id = format!("f{i}").into();
        }
        Self {
            faces,
            planes,
            refused,
        }
    }
}
