//! The humanoid: what is known or estimated of its joints and masses. Units: m, kg, rad, N·m.

use crate::hrp2_shapes::{collision, inertia_box};
use crate::parts::{Inertial, Link, Motion, Patch, PatchKind, Robot, box_moments};

/// Mass of the robot without batteries and covers: the sum that the single source gives, kg.
const DRY_MASS_KG: f64 = 56.04;
/// Mass at which the robot is quoted, kg; the difference is carried as batteries on BODY.
const QUOTED_MASS_KG: f64 = 58.0;

/// Centre and edges of the boxes that stand for BODY's structure and its batteries, m.
const STRUCTURE: ([f64; 3], [f64; 3]) = ([0.0, 0.0, 0.16], [0.23, 0.26, 0.24]);
const BATTERIES: ([f64; 3], [f64; 3]) = ([-0.08, 0.0, 0.20], [0.08, 0.20, 0.14]);

const ABOUT: &str = "
     An HRP-2-class humanoid of 30 joints, made from robots/hrp2/joints.csv.

     Known:     joint tree, axes, origins, position and speed limits; masses and centres of mass of
                all links but BODY (single source, 56.04 kg in all); sole rectangle; camera mount.
     Derived:   BODY's mass: 56.04 kg less its children, plus 1.96 kg of batteries on its back,
                which bring the robot to the 58 kg at which it is quoted.
     Estimated: torque limits (each with its reason below), BODY's centre of mass, every inertia
                (of a homogeneous box of the link's size), every collision shape, the hand.
     Every joint frame has zero rotation: x forward, y left, z up. Units: m, kg, rad, N m.
";

const CAMERA: &str = "Optical frame of an upright camera between the lower pair of head cameras, \
    pitched 10 deg\n       down: x right, y down, z forward.";
const DEPTH: &str = "Optical frame of the depth sensor in the same place, mounted on its side \
    (portrait) so that\n       its wider field of view, 63 deg, stands upright: its image's x axis points down.";

/// Torque limit in N·m, and why, by limb and indices of its joints; the first line that fits. The
/// column of the table is a placeholder in its source.
const EFFORTS: &str = "
    LEG 23        | 200 | estimate: single support on a 0.25-0.35 m step needs 124-149 N m at the knee
    LEG 0145      | 100 | estimate: other leg joints
    CHEST 01      | 100 | estimate: 24 kg above it leaning by 30 deg, and 100 N at a hand
    HEAD 01       | 10  | placeholder of the source; holding the head needs 1.1
    ARM 012       | 100 | estimate: 100 N at a hand 0.7 m away, and the arm's own 17
    ARM 3         | 60  | estimate: 100 N at a hand 0.45 m away, and 6 of its own
    ARM 4         | 30  | estimate: 100 N beside a bent wrist
    ARM 5         | 30  | estimate: 100 N across the hand 0.20 m below the wrist
    ARM 6         | 1   | placeholder of the source; holding the finger needs 0.03
";

/// Neighbours-but-one whose shapes meet in every or nearly every posture.
#[rustfmt::skip]
const OVERLAPPING: [(&str, &str, &str); 7] = [
    ("LEG_LINK3", "LEG_LINK5", "the ankle's limits keep shank and foot apart"),
    ("BODY", "CHEST_LINK1", "the chest sits on the waist"),
    ("CHEST_LINK1", "HEAD_LINK1", "the head sits on the chest"),
    ("CHEST_LINK1", "ARM_LINK1", "the shoulder sits in the chest"),
    ("ARM_LINK1", "ARM_LINK3", "kept apart by the upper arm"),
    ("ARM_LINK3", "ARM_LINK5", "the hand turns about the forearm's end"),
    ("ARM_LINK3", "ARM_LINK6", "the finger turns with the hand"),
];

/// A joint of `joints.csv`: its limb with side, and its index.
fn limb(joint: &str) -> (&str, usize) {
    let (limb, index) = joint.split_once("_JOINT").unwrap_or((joint, ""));
    (limb, index.parse().unwrap_or(0))
}

fn effort(joint: &str) -> Option<(f64, &'static str)> {
    let (limb, index) = limb(joint);
    EFFORTS.lines().find_map(|line| {
        let mut cells = line.split('|').map(str::trim);
        let (name, indices) = cells.next()?.split_once(' ')?;
        let fits = limb.ends_with(name) && indices.contains(&index.to_string());
        let effort = cells.next()?.parse().ok()?;
        fits.then_some((effort, cells.next()?))
    })
}

/// Half-sitting, degrees (grippers: 0.1 rad).
fn half_sitting_rad(joint: &str) -> f64 {
    match limb(joint) {
        ("LARM" | "RARM", 6) => 0.1,
        ("LLEG" | "RLEG", i) => [0.0, 0.0, -26.0, 50.0, -24.0, 0.0_f64][i].to_radians(),
        ("LARM", i) => [15.0, 10.0, 0.0, -30.0, 0.0, 0.0_f64][i].to_radians(),
        ("RARM", i) => [15.0, -10.0, 0.0, -30.0, 0.0, 0.0_f64][i].to_radians(),
        _ => 0.0,
    }
}

/// The link and joint of a line of `joints.csv`, all values in the link's frame.
fn link(line: &str) -> Result<Link, String> {
    let cells: Vec<&str> = line.trim().split(',').collect();
    let [joint, parent, child, numbers @ ..] = cells.as_slice() else {
        return Err(format!("{} cells in: {line}", cells.len()));
    };
    let numbers = numbers.iter().map(|cell| cell.parse::<f64>());
    let numbers: Vec<f64> =
        (numbers.collect::<Result<_, _>>()).map_err(|e| format!("{e} in: {line}"))?;
    let [axis, at, limits, com] = [0, 3, 6, 11].map(|i| numbers.get(i..i + 3));
    let (Some(axis), Some(at), Some(&[lower, upper, velocity]), Some(com)) =
        (axis, at, limits, com)
    else {
        let count = numbers.len();
        return Err(format!("{count} numbers instead of 14 in: {line}"));
    };
    let triple = |v: &[f64]| [v[0], v[1], v[2]];
    let (effort, reason) = effort(joint).ok_or_else(|| format!("no effort of {joint}"))?;
    // The tenth number is a placeholder for the effort, the eleventh the mass.
    let solid = Link::solid(child, numbers[10], triple(com), inertia_box(child));
    let placed = solid
        .with(&collision(child))
        .on(joint, parent, triple(at), [0.0; 3]);
    Ok(placed.moving(Motion {
        name: (*joint).into(),
        slides: false,
        axis: triple(axis),
        lower: lower.to_radians(),
        upper: upper.to_radians(),
        effort,
        velocity,
        reason: reason.into(),
    }))
}

/// What is not in the table: the floating base, which carries the batteries.
fn body(structure_kg: f64) -> Link {
    let parts = [
        (structure_kg, STRUCTURE),
        (QUOTED_MASS_KG - DRY_MASS_KG, BATTERIES),
    ];
    let mass_kg: f64 = parts.iter().map(|(m, _)| m).sum();
    let com_m = [0, 1, 2].map(|i| parts.iter().map(|(m, (c, _))| m * c[i]).sum::<f64>() / mass_kg);
    // Parallel axes; both parts lie in the plane y = 0, so xz is the only product of inertia.
    let (mut moments, mut xz) = ([0.0; 3], 0.0);
    for (m, (centre, edges)) in parts {
        let d = [0, 1, 2].map(|i| centre[i] - com_m[i]);
        let own = box_moments(m, edges);
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            moments[i] += own[i] + m * (d[j] * d[j] + d[k] * d[k]);
        }
        xz -= m * d[0] * d[2];
    }
    let batteries_kg = parts[1].0;
    Link {
        note: Some(format!(
            "{structure_kg:.5} kg of structure, {batteries_kg:.2} kg of batteries"
        )),
        inertial: Some(Inertial {
            mass_kg,
            com_m,
            moments,
            xz,
        }),
        shapes: collision("BODY"),
        ..Link::frame("BODY")
    }
}

/// The overlapping pairs on either side where they have one.
fn overlapping() -> Vec<(String, String, &'static str)> {
    let has_side = |name: &str| name.starts_with("ARM") || name.starts_with("LEG");
    let mut pairs = Vec::new();
    for (a, b, reason) in OVERLAPPING {
        let sides: &[&str] = if has_side(b) { &["R", "L"] } else { &[""] };
        for side in sides {
            let sided = |name: &str| match has_side(name) {
                true => format!("{side}{name}"),
                false => name.to_owned(),
            };
            pairs.push((sided(a), sided(b), reason));
        }
    }
    pairs
}

/// The sole (x −0.100…0.130, y −0.056…0.075 of the left ankle) and the fist, by half their edges.
fn patches() -> Vec<Patch> {
    let foot = |position| PatchKind::Rectangle(position, [0.115, 0.0655], "the whole sole");
    let note = "the closed fist; place and size are estimates";
    let hand = PatchKind::Rectangle([0.0, 0.0, -0.2], [0.03, 0.03], note);
    let (left, right) = (
        foot([0.015, 0.0095, -0.105]),
        foot([0.015, -0.0095, -0.105]),
    );
    let patches = [
        ("left_foot", "LLEG_LINK5", left, "foot", 0.6),
        ("right_foot", "RLEG_LINK5", right, "foot", 0.6),
        ("left_hand", "LARM_LINK5", hand, "hand", 0.5),
        ("right_hand", "RARM_LINK5", hand, "hand", 0.5),
    ];
    let patch = |(name, link, kind, role, friction): (&str, &str, _, _, _)| Patch {
        name: name.to_owned(),
        link: link.to_owned(),
        kind,
        role,
        friction,
    };
    patches.map(patch).into()
}

pub fn robot() -> Result<Robot, String> {
    let csv = include_str!("../../robots/hrp2/joints.csv").lines().skip(1);
    let rows: Vec<Link> = csv.map(link).collect::<Result<_, _>>()?;
    let masses = rows.iter().filter_map(|row| row.inertial.as_ref());
    let body = body(DRY_MASS_KG - masses.map(|inertial| inertial.mass_kg).sum::<f64>());
    let joints = rows.iter().filter_map(|row| row.joint.as_ref());
    let half_sitting = joints.map(|joint| half_sitting_rad(&joint.name)).collect();
    let mut links = vec![body];
    links.extend(rows);
    // Midpoint of the lower pair of the robot's cameras, 10 degrees down.
    let down = [-100.0_f64.to_radians(), 0.0, -90.0_f64.to_radians()];
    let camera = Link {
        note: Some(CAMERA.into()),
        ..Link::frame("head_camera")
    };
    links.push(camera.on("head_camera_mount", "HEAD_LINK1", [0.035, 0.0, 0.045], down));
    let depth = Link {
        note: Some(DEPTH.into()),
        ..Link::frame("head_depth")
    };
    let turned = [0.0, 0.0, 90.0_f64.to_radians()];
    links.push(depth.on("head_depth_mount", "head_camera", [0.0; 3], turned));
    Ok(Robot {
        name: "hrp2",
        about: ABOUT,
        links,
        posture: ("half_sitting", half_sitting),
        overlapping: overlapping(),
        about_patches: "frame C in the link's frame, z_C outward from the environment\n\
            # (up into a sole on the ground, from the touched surface into the fist)",
        patches: patches(),
    })
}
