use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use proptest::prelude::*;

use super::*;
use crate::Source;

/// The twelve triangles of a box with one corner at the origin, wound outward.
fn cuboid(size: [f64; 3], at: [f64; 3]) -> TriangleMesh {
    let corner = |i: usize| {
        let along = |axis: usize| at[axis] + size[axis] * ((i >> axis) & 1) as f64;
        Point3::new(along(0), along(1), along(2))
    };
    // Four corners a side, counter-clockwise seen from outside.
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    TriangleMesh {
        vertices: (0..8).map(corner).collect(),
        triangles: sides
            .iter()
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
            .collect(),
    }
}

fn joined(parts: &[TriangleMesh]) -> TriangleMesh {
    let mut all = TriangleMesh::default();
    for part in parts {
        let shift = all.vertices.len();
        all.vertices.extend(&part.vertices);
        all.triangles
            .extend(part.triangles.iter().map(|t| t.map(|i| i + shift)));
    }
    all
}

/// Three corners a triangle and nothing shared, as STL files have it.
fn soup(mesh: &TriangleMesh) -> TriangleMesh {
    TriangleMesh {
        vertices: mesh
            .triangles
            .iter()
            .flatten()
            .map(|i| mesh.vertices[*i])
            .collect(),
        triangles: (0..mesh.triangles.len())
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect(),
    }
}

/// A ring in the x-z plane extruded along y from 0 to `width`, fans as caps: the ring must be
/// star-shaped about its first vertex, and counter-clockwise seen against y.
fn extruded(profile: &[[f64; 2]], width: f64) -> TriangleMesh {
    let count = profile.len();
    let at = |y: f64| profile.iter().map(move |[x, z]| Point3::new(*x, y, *z));
    let mut triangles = Vec::new();
    for i in 0..count {
        let j = (i + 1) % count;
        triangles.extend([[i, j, j + count], [i, j + count, i + count]].map(|[a, b, c]| [a, c, b]));
        if (1..count - 1).contains(&i) {
            triangles.push([0, i, i + 1]);
            triangles.push([count, count + i + 1, count + i]);
        }
    }
    TriangleMesh {
        vertices: at(0.0).chain(at(width)).collect(),
        triangles,
    }
}

/// Two steps of 0.2 m height and 0.3 m depth.
fn stairs() -> TriangleMesh {
    let profile = [
        [0.3, 0.2],
        [0.3, 0.4],
        [0.6, 0.4],
        [0.6, 0.0],
        [0.0, 0.0],
        [0.0, 0.2],
    ];
    let mut mesh = extruded(&profile, 0.8);
    // The profile runs clockwise seen against y.
    mesh.triangles.iter_mut().for_each(|t| t.reverse());
    mesh
}

fn run(mesh: &TriangleMesh) -> (Terrain, Report) {
    extract(mesh, 0.03).unwrap()
}

fn up(terrain: &Terrain) -> Vec<&Face> {
    let faces = terrain.faces.iter();
    faces.filter(|face| face.normal_W().z > 0.99).collect()
}

#[test]
fn a_box_is_six_faces_and_one_body() {
    for mesh in [
        cuboid([2.0, 1.0, 0.5], [3.0, -1.0, 0.0]),
        soup(&cuboid([2.0, 1.0, 0.5], [3.0, -1.0, 0.0])),
    ] {
        let (terrain, report) = run(&mesh);
        assert_eq!(terrain.faces.len(), 6);
        let areas: Vec<f64> = terrain.faces.iter().map(|f| f.region.area()).collect();
        for (area, expected) in areas.iter().zip([2.0, 2.0, 1.0, 1.0, 0.5, 0.5]) {
            approx::assert_relative_eq!(*area, expected, max_relative = 1e-6);
        }
        let centre = Point3::new(4.0, -0.5, 0.25);
        for face in &terrain.faces {
            // Outward: the middle of the box is behind every face.
            assert!(face.height_of(&centre) < -0.2, "{}", face.id);
            assert_eq!(face.source, Source::Mesh);
            // The mesh is its own body.
            assert!(face.bodies_W(0.03).is_empty());
        }
        assert_eq!(terrain.obstacles.len(), 1);
        assert_eq!(terrain.obstacles[0].points_W.len(), 8);
        let clean = Report {
            triangles: 12,
            solids: 1,
            faces: 6,
            ..Report::default()
        };
        let welded_vertices = mesh.vertices.len() - 8;
        assert_eq!(
            report,
            Report {
                welded_vertices,
                ..clean
            }
        );
        // What is on the box is not behind its top; the box itself is.
        let top = up(&terrain)[0];
        assert!(top.is_behind(&terrain.obstacles[0].points_W, 1e-9));
    }
}

#[test]
fn stairs_are_treads_risers_and_bodies_of_their_own() {
    let (terrain, report) = run(&stairs());
    assert_eq!(
        (report.solids, report.open_edges, report.flipped_edges),
        (0, 0, 0)
    );
    // Two treads, two risers, back, bottom and two concave cheeks.
    assert_eq!((report.faces, report.faces_dropped), (8, 0));
    let mut treads: Vec<(f64, f64)> = up(&terrain)
        .iter()
        .map(|f| (f.X_WF.translation.z, f.region.area()))
        .collect();
    treads.sort_by(|a, b| a.0.total_cmp(&b.0));
    for ((height, area), expected) in treads.iter().zip([0.2, 0.4]) {
        approx::assert_relative_eq!(*height, expected, epsilon = 1e-9);
        approx::assert_relative_eq!(*area, 0.24, epsilon = 1e-6);
    }
    let cheeks = terrain.faces.iter().filter(|f| f.normal_W().y > 0.99);
    let cheeks: Vec<f64> = cheeks.map(|f| f.region.area()).collect();
    assert_eq!(cheeks.len(), 1);
    approx::assert_relative_eq!(cheeks[0], 0.18, epsilon = 1e-6);
    // Nothing of the bodies is in the free space over a tread or before a riser.
    for obstacle in &terrain.obstacles {
        for p in &obstacle.points_W {
            let step = if p.x < 0.3 - 1e-6 { 0.2 } else { 0.4 };
            assert!(
                p.z < step + 1e-6 && p.x > -1e-6 && p.z > -1e-6,
                "{} {p}",
                obstacle.id
            );
        }
    }
}

#[test]
fn a_hole_stays_open() {
    // A table top of four triangles around each side of a square hole.
    let at = |r: f64, i: usize| {
        let (x, y) = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)][i];
        Point3::new(r * x, r * y, 0.7)
    };
    let vertices = (0..4)
        .map(|i| at(1.0, i))
        .chain((0..4).map(|i| at(0.4, i)))
        .collect();
    let ring = |i: usize| {
        let j = (i + 1) % 4;
        [[i, j, j + 4], [i, j + 4, i + 4]]
    };
    let mesh = TriangleMesh {
        vertices,
        triangles: (0..4).flat_map(ring).collect(),
    };
    let (terrain, report) = run(&mesh);
    assert_eq!((report.faces, report.open_edges), (1, 8));
    let [top] = &terrain.faces[..] else {
        panic!("{:?}", terrain.faces)
    };
    assert_eq!((top.id.as_str(), top.region.rings().len()), ("m0", 2));
    approx::assert_relative_eq!(top.region.area(), 4.0 - 0.64, max_relative = 1e-6);
    let middle = top
        .X_WF
        .inverse_transform_point(&Point3::new(0.0, 0.0, 0.7));
    assert!(!crate::outline::Outline::from(&top.region).contains(&middle.xy()));
}

#[test]
fn tiles_that_share_no_edge_are_one_face() {
    // Two tiles beside a long one: T-junctions, no common edge.
    let tile = |x: [f64; 2], y: [f64; 2]| TriangleMesh {
        vertices: [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]]
            .map(|[x, y]| Point3::new(x, y, 0.0))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let floor = joined(&[
        tile([0.0, 2.0], [0.0, 1.0]),
        tile([0.0, 0.9], [1.0, 2.0]),
        tile([0.9, 2.0], [1.0, 2.0]),
        tile([5.0, 6.0], [0.0, 1.0]),
    ]);
    let (terrain, report) = run(&floor);
    assert_eq!(report.faces, 2);
    approx::assert_relative_eq!(terrain.faces[0].region.area(), 4.0, max_relative = 1e-6);
    assert_eq!(terrain.faces[0].region.rings()[0].vertices.len(), 4);
}

#[test]
fn boards_are_one_face_over_joints_and_apart_over_gaps() {
    let deck = |gap: f64| {
        let board = |i: usize| cuboid([2.0, 0.1, 0.03], [0.0, i as f64 * (0.1 + gap), 0.0]);
        run(&joined(&(0..6).map(board).collect::<Vec<_>>())).0
    };
    let tops = |terrain: &Terrain| -> Vec<f64> {
        let up = terrain.faces.iter().filter(|face| face.normal_W().z > 0.9);
        up.map(|face| face.region.area()).collect()
    };
    let (joints, gaps) = (tops(&deck(0.005)), tops(&deck(0.010)));
    assert_eq!((joints.len(), gaps.len()), (1, 6));
    approx::assert_relative_eq!(joints[0], 2.0 * (0.6 + 5.0 * 0.005), max_relative = 1e-6);
    approx::assert_relative_eq!(gaps[5], 0.2, max_relative = 1e-6);
}

#[test]
fn blocks_wall_to_wall_are_solids_each() {
    // Four in a square, one of them lower, and a fifth on them that shares an edge with the side of another.
    let mut blocks = vec![cuboid([1.0, 1.0, 0.2], [0.0, 0.0, -0.1])];
    blocks.push(cuboid([1.0, 1.0, 0.2], [1.0, 0.0, -0.1]));
    blocks.push(cuboid([1.0, 1.0, 0.1], [0.0, 1.0, -0.15]));
    blocks.push(cuboid([1.0, 1.0, 0.2], [1.0, 1.0, -0.1]));
    blocks.push(cuboid([1.0, 1.0, 0.2], [0.0, 0.0, 0.1]));
    let (terrain, report) = run(&joined(&blocks));
    assert_eq!((report.solids, report.crowded_edges), (5, 0));
    assert_eq!(terrain.obstacles.len(), 5);
}

#[test]
fn small_faces_are_dropped_as_surfaces_and_kept_as_bodies() {
    let floor = cuboid([2.0, 2.0, 0.1], [0.0, 0.0, -0.1]);
    let pebble = cuboid([0.03, 0.03, 0.03], [1.0, 1.0, 0.0]);
    let (terrain, report) = run(&joined(&[floor, pebble]));
    assert_eq!(
        (report.faces, report.faces_dropped, report.solids),
        (6, 6, 2)
    );
    assert_eq!(terrain.obstacles.len(), 2);
}

#[test]
fn a_thin_open_plate_does_not_reach_through_its_other_side() {
    // Top and underside of a plate of 1 cm, without its rim.
    let mut plate = cuboid([1.0, 1.0, 0.01], [0.0, 0.0, 0.5]);
    plate.triangles.truncate(4);
    let (terrain, report) = run(&plate);
    assert_eq!((report.faces, report.open_edges, report.solids), (2, 8, 0));
    for obstacle in &terrain.obstacles {
        for p in &obstacle.points_W {
            assert!((0.5 - 1e-9..=0.51 + 1e-9).contains(&p.z), "{p}");
        }
    }
}

#[test]
fn a_part_that_is_wound_the_other_way_is_reported_and_taken_as_it_is() {
    let mut room = cuboid([3.0, 3.0, 2.5], [0.0, 0.0, 0.0]);
    room.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let (terrain, report) = run(&room);
    assert_eq!(
        (report.inward_parts, report.solids, report.flipped_edges),
        (1, 0, 0)
    );
    let floor = up(&terrain)[0];
    approx::assert_relative_eq!(floor.X_WF.translation.z, 0.0, epsilon = 1e-12);
    // The bodies are outside of the room.
    for obstacle in &terrain.obstacles {
        let inside = |p: &Point3<f64>| {
            p.iter()
                .zip([3.0, 3.0, 2.5])
                .all(|(c, s)| *c > 1e-9 && *c < s - 1e-9)
        };
        assert!(!obstacle.points_W.iter().any(inside));
    }
}

#[test]
fn triangles_turned_among_their_neighbours_are_turned_back() {
    let whole = cuboid([2.0, 1.0, 0.5], [0.0; 3]);
    let (wanted, _) = run(&whole);
    for wrong in [vec![0], vec![2, 3], vec![0, 5, 7, 8]] {
        let mut mesh = whole.clone();
        wrong.iter().for_each(|t| mesh.triangles[*t].swap(0, 1));
        let (terrain, report) = run(&mesh);
        assert_eq!(
            (report.turned_triangles, report.flipped_edges),
            (wrong.len(), 0)
        );
        assert_eq!(report.solids, 1);
        for (face, wanted) in terrain.faces.iter().zip(&wanted.faces) {
            approx::assert_relative_eq!(face.normal_W(), wanted.normal_W(), epsilon = 1e-12);
            approx::assert_relative_eq!(face.region.area(), wanted.region.area(), epsilon = 1e-9);
        }
    }
    // Of two halves neither is more likely.
    let mut sheet = cuboid([1.0; 3], [0.0; 3]);
    sheet.triangles.truncate(2);
    sheet.triangles[0].swap(0, 1);
    let (_, report) = run(&sheet);
    assert_eq!((report.turned_triangles, report.flipped_edges), (0, 1));
}

proptest! {
    /// Edges between what triangles of a few times what is welded are cut into pass for edges of others: cutting them again
    /// did not end.
    #[test]
    fn triangles_as_small_as_what_is_welded_are_cut_once(
        vertices in prop::collection::vec((0..12_u32, 0.0..4.0 * WELD_M), 10),
        triangles in prop::collection::vec(prop::array::uniform3(0..10_usize), 4..16),
    ) {
        let vertices = vertices.iter().map(|&(x, y)| Point3::new(2.0 * WELD_M * f64::from(x), y, 0.0));
        let mesh = TriangleMesh { vertices: vertices.collect(), triangles };
        let _ = extract(&mesh, 0.03);
    }
}

/// As exporters leave it: one of two triangles at an edge was cut in the middle of it, in single precision.
#[test]
fn edges_that_end_against_others_leave_no_slit() {
    let turn = Isometry3::rotation(Vector3::new(0.1, 0.2, 0.7));
    let single = |p: &Point3<f64>| (turn * p).map(|x| f64::from(x as f32));
    let mut whole = cuboid([2.0, 1.0, 0.5], [0.3, 0.1, 0.0]);
    whole.vertices = whole.vertices.iter().map(single).collect();
    let mut mesh = whole.clone();
    mesh.triangles.clear();
    for (number, &[a, b, c]) in whole.triangles.iter().enumerate() {
        if number % 2 == 0 {
            mesh.triangles.push([a, b, c]);
            continue;
        }
        let middle = nalgebra::center(&whole.vertices[a], &whole.vertices[b]);
        mesh.vertices.push(middle.map(|x| f64::from(x as f32)));
        let m = mesh.vertices.len() - 1;
        mesh.triangles.extend([[a, m, c], [m, b, c]]);
    }
    let (terrain, report) = run(&mesh);
    assert_eq!(
        (report.open_edges, report.solids, report.faces),
        (0, 1, 6),
        "{report:?}"
    );
    assert!(report.stitched_edges > 0);
    let (wanted, _) = run(&whole);
    for (face, wanted) in terrain.faces.iter().zip(&wanted.faces) {
        approx::assert_relative_eq!(face.region.area(), wanted.region.area(), epsilon = 1e-5);
    }
}

#[test]
fn degenerate_triangles_are_skipped_and_counted() {
    let mut mesh = cuboid([1.0, 1.0, 1.0], [0.0, 0.0, 0.0]);
    mesh.vertices.push(Point3::new(0.5, 0.0, 0.0));
    mesh.triangles.extend([[0, 0, 1], [0, 1, 8], [2, 2, 2]]);
    let (terrain, report) = run(&mesh);
    assert_eq!((report.triangles, report.degenerate_triangles), (15, 3));
    assert_eq!(terrain.faces.len(), 6);
}

#[test]
fn bad_meshes_are_errors_that_name_the_cause() {
    let mut nan = cuboid([1.0; 3], [0.0; 3]);
    nan.vertices[5].y = f64::NAN;
    let mut beyond = cuboid([1.0; 3], [0.0; 3]);
    beyond.triangles[7][2] = 8;
    let flat = TriangleMesh {
        vertices: vec![
            Point3::origin(),
            Point3::new(1.0, 0.0, 0.0),
            Point3::new(2.0, 0.0, 0.0),
        ],
        triangles: vec![[0, 1, 2]],
    };
    for (mesh, message) in [
        (nan, "vertex 5 is not within"),
        (
            beyond,
            "triangle 7 refers to vertex 8, but the mesh has 8 vertices",
        ),
        (
            TriangleMesh::default(),
            "no triangle with an area (0 triangles, 0 vertices)",
        ),
        (flat, "no triangle with an area (1 triangles, 3 vertices)"),
    ] {
        let error = extract(&mesh, 0.03).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
    let error = extract(&cuboid([1.0; 3], [0.0; 3]), 0.0).unwrap_err();
    assert!(error.to_string().starts_with("thickness_m is 0"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_box_is_found_wherever_and_however_it_stands(
        size in prop::array::uniform3(0.2..3.0), at in prop::array::uniform3(-20.0..20.0),
        turn in prop::array::uniform3(-2.0..2.0),
    ) {
        let pose = Isometry3::from_parts(
            Vector3::from(at).into(),
            UnitQuaternion::from_scaled_axis(Vector3::from(turn)),
        );
        let mut mesh = soup(&cuboid(size, [0.0; 3]));
        // Rounded as in a file with single precision.
        for p in &mut mesh.vertices {
            *p = (pose * *p).map(|c| f64::from(c as f32));
        }
        let (terrain, report) = run(&mesh);
        prop_assert_eq!((report.faces, report.solids, report.open_edges), (6, 1, 0));
        let [a, b, c] = size;
        let area: f64 = terrain.faces.iter().map(|f| f.region.area()).sum();
        prop_assert!((area - 2.0 * (a * b + b * c + c * a)).abs() < 1e-4);
        prop_assert_eq!(terrain.obstacles[0].points_W.len(), 8);
        for face in &terrain.faces {
            prop_assert!(face.is_behind(&terrain.obstacles[0].points_W, 1e-5));
            prop_assert_eq!(face.region.rings()[0].vertices.len(), 4);
        }
    }

    #[test]
    fn any_heap_of_triangles_gives_a_valid_set_or_an_error(
        points in prop::collection::vec(prop::array::uniform3(-1.0..1.0), 3..12),
        picks in prop::collection::vec(prop::array::uniform3(0_usize..12), 0..24),
        flat in any::<bool>(),
    ) {
        let vertices: Vec<Point3<f64>> = points
            .iter()
            .map(|p| Point3::from(*p))
            .map(|p| if flat { Point3::new(p.x, p.y, 0.0) } else { p })
            .collect();
        let mesh = TriangleMesh { vertices, triangles: picks };
        if let Ok((terrain, report)) = extract(&mesh, 0.03) {
            prop_assert!(terrain.validate().is_ok());
            for face in &terrain.faces {
                prop_assert!(!face.inset_region(0.0, 0.02 - 1e-6).is_empty());
                // Whatever is a face of the mesh is covered by its bodies: none lies before it.
                prop_assert!(report.solids > 0 || !terrain.obstacles.is_empty());
            }
        }
    }
}

#[test]
fn a_closed_part_without_an_inside_is_no_solid_and_the_rest_is_read() {
    // A sheet: two triangles back to back.
    let corners = [[5.0, 0.0, 1.0], [6.0, 0.0, 1.0], [5.0, 1.0, 1.0]];
    let sheet = TriangleMesh {
        vertices: corners.map(Point3::from).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 1]],
    };
    let (terrain, report) = run(&joined(&[cuboid([1.0; 3], [0.0; 3]), sheet]));
    assert_eq!((report.solids, report.flat_parts), (1, 1));
    assert_eq!(terrain.faces.len(), 8);
    assert!(
        terrain
            .obstacles
            .iter()
            .all(|body| body.points_W.len() >= 4)
    );
}
