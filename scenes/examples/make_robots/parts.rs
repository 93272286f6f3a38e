//! A robot as data. Units: m, kg, rad, N, N·m.

/// What the files of a robot say.
pub struct Robot {
    pub name: &'static str,
    /// What it is and where its figures are from, for the head of the URDF.
    pub about: &'static str,
    /// Links in the order of the tree, the base first.
    pub links: Vec<Link>,
    /// Name of a posture and its joint values, in the order of the moving joints.
    pub posture: (&'static str, Vec<f64>),
    /// Pairs of links that are never checked, and why, beside those of parent and child.
    pub overlapping: Vec<(String, String, &'static str)>,
    /// What the contact patches are, for the head of their file.
    pub about_patches: &'static str,
    pub patches: Vec<Patch>,
}

/// A link, and the joint that it hangs on.
pub struct Link {
    pub name: String,
    /// A remark for the file.
    pub note: Option<String>,
    pub joint: Option<Joint>,
    /// None for a mere frame.
    pub inertial: Option<Inertial>,
    pub shapes: Vec<Shape>,
}

pub struct Inertial {
    pub mass_kg: f64,
    pub com_m: [f64; 3],
    /// xx, yy and zz.
    pub moments: [f64; 3],
    pub xz: f64,
}

pub struct Joint {
    pub name: String,
    pub parent: String,
    pub xyz: [f64; 3],
    pub rpy: [f64; 3],
    /// None for a fixed joint.
    pub motion: Option<Motion>,
}

/// How a joint moves, and why its greatest effort is what it is.
pub struct Motion {
    pub name: String,
    pub slides: bool,
    pub axis: [f64; 3],
    pub lower: f64,
    pub upper: f64,
    pub effort: f64,
    pub velocity: f64,
    pub reason: String,
}

/// A primitive: its middle, then a box's edges, a cylinder's length and radius along an axis, or a
/// ball's radius.
#[derive(Clone, Copy)]
pub enum Shape {
    Box([f64; 3], [f64; 3]),
    AlongX([f64; 3], f64, f64),
    AlongY([f64; 3], f64, f64),
    AlongZ([f64; 3], f64, f64),
    Ball([f64; 3], f64),
}

/// A contact patch: a rectangle about a place of its link, given by half its edges, or a ball.
pub struct Patch {
    pub name: String,
    pub link: String,
    pub kind: PatchKind,
    pub role: &'static str,
    pub friction: f64,
}

#[derive(Clone, Copy)]
pub enum PatchKind {
    Rectangle([f64; 3], [f64; 2], &'static str),
    Ball(f64),
}

impl Link {
    /// A link with the inertia of a homogeneous box.
    pub fn solid(name: &str, mass_kg: f64, com_m: [f64; 3], edges_m: [f64; 3]) -> Self {
        Link {
            inertial: Some(Inertial {
                mass_kg,
                com_m,
                moments: box_moments(mass_kg, edges_m),
                xz: 0.0,
            }),
            ..Link::frame(name)
        }
    }

    /// A link without a body.
    pub fn frame(name: &str) -> Self {
        Link {
            name: name.into(),
            note: None,
            joint: None,
            inertial: None,
            shapes: Vec::new(),
        }
    }

    /// The link with these shapes.
    pub fn with(self, shapes: &[Shape]) -> Self {
        Link {
            shapes: shapes.to_vec(),
            ..self
        }
    }

    /// The link on a joint at a place of its parent.
    pub fn on(self, joint: &str, parent: &str, xyz: [f64; 3], rpy: [f64; 3]) -> Self {
        Link {
            joint: Some(Joint {
                name: joint.into(),
                parent: parent.into(),
                xyz,
                rpy,
                motion: None,
            }),
            ..self
        }
    }

    /// The link on a joint that moves.
    pub fn moving(mut self, motion: Motion) -> Self {
        if let Some(joint) = &mut self.joint {
            joint.motion = Some(motion);
        }
        self
    }
}

/// Moments of inertia (xx, yy, zz) of a homogeneous box about its centre, kg·m².
pub fn box_moments(mass_kg: f64, edges_m: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = edges_m.map(|e| e * e);
    [y + z, x + z, x + y].map(|sum| mass_kg / 12.0 * sum)
}

/// The joints of a leg, one a line: name, axis, lower and upper limit, effort, velocity, reason of
/// the effort, with bars between them.
fn leg_joints(table: &str) -> [Motion; 3] {
    let mut rows = table
        .lines()
        .map(str::trim)
        .filter(|row| !row.is_empty())
        .map(|row| {
            let cells: Vec<&str> = row.split('|').map(str::trim).collect();
            let numbers = |i: usize| cells[i].split(' ').map(|n| n.parse().expect("a number"));
            let one = |i: usize| numbers(i).next().expect("a number");
            let axis: Vec<f64> = numbers(1).collect();
            Motion {
                name: cells[0].into(),
                slides: cells[0] == "slide",
                axis: [axis[0], axis[1], axis[2]],
                lower: one(2),
                upper: one(3),
                effort: one(4),
                velocity: one(5),
                reason: cells[6].into(),
            }
        });
    std::array::from_fn(|_| rows.next().expect("three joints"))
}

/// A leg on the body: each of its links on the joint that moves it, at a place (xyz, rpy) of the one
/// before, and the foot's frame at `end` of the last. Names begin with the leg's.
pub fn leg(
    name: &str,
    joints: &str,
    links: [(Link, [f64; 3], [f64; 3]); 3],
    end: [f64; 3],
) -> impl Iterator<Item = Link> {
    let mut parent = "body".to_owned();
    let mut leg = Vec::new();
    for (motion, (mut link, xyz, rpy)) in leg_joints(joints).into_iter().zip(links) {
        link.name = format!("{name}_{}", link.name);
        let next = link.name.clone();
        let joint = format!("{name}_{}", motion.name);
        leg.push(link.on(&joint, &parent, xyz, rpy).moving(motion));
        parent = next;
    }
    let (foot, mount) = (format!("{name}_foot"), format!("{name}_foot_mount"));
    leg.push(Link::frame(&foot).on(&mount, &parent, end, [0.0; 3]));
    leg.into_iter()
}

/// The ball at the end of a leg that stands on the frame `{leg}_foot`.
pub fn ball_foot(leg: &str, radius_m: f64, friction: f64) -> Patch {
    Patch {
        name: leg.into(),
        link: format!("{leg}_foot"),
        kind: PatchKind::Ball(radius_m),
        role: "foot",
        friction,
    }
}
