//! Files of faces that are likely in another unit or turned round.

use nalgebra::{Point3, UnitQuaternion, Vector3};
use surfaces::{Face, Terrain, TriangleMesh};

/// Faces that lean by more than this carry no one, rad.
const STEEPEST_RAD: f64 = 0.6;
/// Worlds of faces are hardly smaller than the first and larger than the second, m.
const SPAN_M: [f64; 2] = [0.3, 100.0];

/// How much of a terrain could be walked on, m².
pub struct LevelArea {
    /// Of all faces.
    pub all_m2: f64,
    /// Of those that face up.
    pub up_m2: f64,
    /// Of those that would, turned round.
    pub down_m2: f64,
    /// Of those that would face up if y were up.
    pub up_by_y_m2: f64,
}

/// A world of which this many times as much faces along y as faces up is likely one whose y is up.
const BY_Y: f64 = 4.0;

impl LevelArea {
    /// That of all faces.
    pub fn of(terrain: &Terrain) -> Self {
        let area = |up: Vector3<f64>| area_facing_m2(terrain, up);
        Self {
            all_m2: terrain.faces.iter().map(|face| face.region.area()).sum(),
            up_m2: area(Vector3::z()),
            down_m2: area(-Vector3::z()),
            up_by_y_m2: area(Vector3::y()),
        }
    }
}

/// The area of the faces that could be walked on if `up` were up, m².
fn area_facing_m2(terrain: &Terrain, up: Vector3<f64>) -> f64 {
    let carries = |face: &&Face| face.normal_W().dot(&up) > STEEPEST_RAD.cos();
    let faces = terrain.faces.iter().filter(carries);
    faces.map(|face| face.region.area()).sum()
}

/// The warning of a mesh that was turned by `R_up`, as its file asks for, and has little to walk on then: many
/// programs write z up into a format whose y is up.
pub fn of_turned(name: &str, terrain: &Terrain, R_up: UnitQuaternion<f64>) -> Option<String> {
    let turned_m2 = area_facing_m2(terrain, Vector3::z());
    let as_it_is_m2 = area_facing_m2(terrain, R_up * Vector3::z());
    (as_it_is_m2 > BY_Y * turned_m2).then(|| {
        format!(
            "warning: {name}: {turned_m2:.2} m² face up as its file says what is up, {as_it_is_m2:.2} m² if z were: was \
             it saved with z up? Save it as STL, OBJ or PLY, which are taken as they are"
        )
    })
}

/// The warning of a mesh as large as a world of which most is faces too small to stand on: no stairs have such,
/// what was reconstructed from noisy views has nothing else.
pub fn of_mesh(name: &str, mesh: &TriangleMesh, part_dropped: f64) -> Option<String> {
    let is_large = span_m(&mesh.vertices) > SPAN_M[0];
    (is_large && part_dropped > 0.5).then(|| {
        format!(
            "warning: {name}: {:.0} % of it are faces too small to stand on: is it a reconstruction with noise? Its \
             vertices are a scan, in which faces are found: --scan {name} --eye X,Y,Z (a PLY)",
            100.0 * part_dropped
        )
    })
}

/// The longest side of the box around points, m.
fn span_m(points: &[Point3<f64>]) -> f64 {
    let spans = (0..3).map(|axis| {
        let values = points.iter().map(|p| p[axis]);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    });
    spans.fold(0.0, f64::max)
}

/// Warnings of a file of surfaces or a mesh.
pub fn doubts(name: &str, terrain: &Terrain) -> Vec<String> {
    let mut doubts = Vec::new();
    let points: Vec<_> = terrain.faces.iter().flat_map(|f| f.vertices_W()).collect();
    let span_m = span_m(&points);
    if !points.is_empty() && !(SPAN_M[0]..=SPAN_M[1]).contains(&span_m) {
        doubts.push(format!(
            "warning: {name}: its faces span {span_m:.3} m: is the file in m, not in mm or cm?"
        ));
    }
    let level = LevelArea::of(terrain);
    if level.up_m2 == 0.0 && level.down_m2 > 0.0 {
        doubts.push(format!(
            "warning: {name}: no face that could be walked on faces up, {:.2} of {:.2} m² face down: are its normals, \
             or the order of its corners, turned round?",
            level.down_m2, level.all_m2
        ));
    }
    if level.up_by_y_m2 > BY_Y * level.up_m2 {
        doubts.push(format!(
            "warning: {name}: {:.2} m² face along y and {:.2} m² up: is y up in it? It has to be z: turn it by 90° about x",
            level.up_by_y_m2, level.up_m2
        ));
    }
    doubts
}
