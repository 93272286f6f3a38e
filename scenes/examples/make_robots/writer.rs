//! A robot as data, and its three files. Units: m, kg, rad, N, N·m.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write;

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
        let moments = box_moments(mass_kg, edges_m);
        let inertial = Inertial {
            mass_kg,
            com_m,
            moments,
            xz: 0.0,
        };
        Link {
            inertial: Some(inertial),
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
        let (name, parent) = (joint.into(), parent.into());
        Link {
            joint: Some(Joint {
                name,
                parent,
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
pub fn leg_joints(table: &str) -> [Motion; 3] {
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

/// The ball at the end of a leg that stands on the frame `{leg}_foot`.
pub fn ball_foot(leg: &str, radius_m: f64, friction: f64) -> Patch {
    let (name, link) = (leg.into(), format!("{leg}_foot"));
    Patch {
        name,
        link,
        kind: PatchKind::Ball(radius_m),
        role: "foot",
        friction,
    }
}

impl Robot {
    /// Name and text of every file.
    pub fn files(&self) -> [(String, String); 3] {
        [
            (format!("{}.urdf", self.name), self.urdf()),
            (format!("{}.srdf", self.name), self.srdf()),
            ("contacts.toml".to_owned(), self.contacts()),
        ]
    }

    fn urdf(&self) -> String {
        let mut out = format!(
            "<?xml version=\"1.0\"?>\n<!-- {}\n     Generated by the example make_robots of the crate scenes; edit \
             the generator, not this file. -->\n<robot name=\"{}\">\n",
            self.about.trim(),
            self.name
        );
        for link in &self.links {
            out.push('\n');
            if let Some(note) = &link.note {
                out += &format!("  <!-- {note} -->\n");
            }
            if let Some(joint) = &link.joint {
                out += &joint.urdf(&link.name);
            }
            out += &link.urdf();
        }
        out + "</robot>\n"
    }

    /// The joints that move, with their links.
    fn moving(&self) -> impl Iterator<Item = (&Joint, &Link)> {
        let joints = self
            .links
            .iter()
            .filter_map(|link| Some((link.joint.as_ref()?, link)));
        joints.filter(|(joint, _)| joint.motion.is_some())
    }

    fn srdf(&self) -> String {
        let (robot, base) = (self.name, &self.links[0].name);
        let mut out = format!(
            "<?xml version=\"1.0\"?>\n<!-- Named postures and pairs that are never checked, for {robot}.urdf. \
             Generated by the\n     example make_robots of the crate scenes. -->\n<robot name=\"{robot}\">\n  \
             <virtual_joint name=\"floating_base\" type=\"floating\" parent_frame=\"world\" \
             child_link=\"{base}\"/>\n  <group name=\"all\">\n"
        );
        for (joint, _) in self.moving() {
            out += &format!("    <joint name=\"{}\"/>\n", joint.name);
        }
        let (posture, values) = &self.posture;
        out += &format!("  </group>\n  <group_state name=\"{posture}\" group=\"all\">\n");
        for ((joint, _), value) in self.moving().zip(values) {
            let value = number(*value);
            out += &format!("    <joint name=\"{}\" value=\"{value}\"/>\n", joint.name);
        }
        out += "  </group_state>\n";
        let adjacent = self.moving();
        let adjacent = adjacent.map(|(joint, link)| (&joint.parent, &link.name, "Adjacent"));
        let overlapping = self
            .overlapping
            .iter()
            .map(|(a, b, reason)| (a, b, *reason));
        for (a, b, reason) in adjacent.chain(overlapping) {
            out += &format!(
                "  <disable_collisions link1=\"{a}\" link2=\"{b}\" reason=\"{reason}\"/>\n"
            );
        }
        out + "</robot>\n"
    }

    fn contacts(&self) -> String {
        let mut out = format!(
            "# Contact patches of {}.urdf: {}.\n# Generated by `cargo run -p scandent-scenes --example make_robots`.\n",
            self.name, self.about_patches
        );
        for Patch {
            name,
            link,
            kind,
            role,
            friction,
        } in &self.patches
        {
            let (note, shape) = match kind {
                PatchKind::Rectangle(p, [x, y], note) => (
                    format!("# {note}\n"),
                    format!(
                        "position_m = {p:?}\nrpy_rad = [0.0, 0.0, 0.0]\n\
                         polygon_m = [[-{x}, -{y}], [{x}, -{y}], [{x}, {y}], [-{x}, {y}]]\n"
                    ),
                ),
                PatchKind::Ball(r) => {
                    (String::new(), format!("kind = \"point\"\nradius_m = {r}\n"))
                }
            };
            out += &format!(
                "\n{note}[[patch]]\nname = \"{name}\"\nlink = \"{link}\"\n{shape}roles = [\"{role}\"]\n\
                 friction = {friction}\n"
            );
        }
        out
    }
}

impl Link {
    fn urdf(&self) -> String {
        let name = &self.name;
        let Some(Inertial {
            mass_kg,
            com_m,
            moments,
            xz,
        }) = &self.inertial
        else {
            return format!("  <link name=\"{name}\"/>\n");
        };
        let ([xx, yy, zz], xz) = (moments.map(number), number(*xz));
        let mut out = format!(
            "  <link name=\"{name}\">\n    <inertial>\n      <origin xyz=\"{}\" rpy=\"0 0 0\"/>\n      \
             <mass value=\"{}\"/>\n      <inertia ixx=\"{xx}\" ixy=\"0\" ixz=\"{xz}\" iyy=\"{yy}\" iyz=\"0\" \
             izz=\"{zz}\"/>\n    </inertial>\n",
            vector(*com_m),
            number(*mass_kg)
        );
        for tag in ["visual", "collision"] {
            for shape in &self.shapes {
                let (middle, rpy, geometry) = shape.urdf();
                out += &format!(
                    "    <{tag}>\n      <origin xyz=\"{}\" rpy=\"{}\"/>\n      \
                     <geometry>{geometry}</geometry>\n    </{tag}>\n",
                    vector(middle),
                    vector(rpy)
                );
            }
        }
        out + "  </link>\n"
    }
}

impl Joint {
    fn urdf(&self, child: &str) -> String {
        let Joint {
            name,
            parent,
            xyz,
            rpy,
            motion,
        } = self;
        let kind = match motion {
            None => "fixed",
            Some(Motion { slides: true, .. }) => "prismatic",
            Some(_) => "revolute",
        };
        // The angles of a frame are written in full.
        let rpy = rpy.map(|a| {
            if motion.is_some() {
                number(a)
            } else {
                a.to_string()
            }
        });
        let mut out = format!(
            "  <joint name=\"{name}\" type=\"{kind}\">\n    <parent link=\"{parent}\"/>\n    \
             <child link=\"{child}\"/>\n    <origin xyz=\"{}\" rpy=\"{}\"/>\n",
            vector(*xyz),
            rpy.join(" ")
        );
        if let Some(motion) = motion {
            let [lower, upper, effort, velocity] =
                [motion.lower, motion.upper, motion.effort, motion.velocity].map(number);
            let _ = writeln!(
                out,
                "    <axis xyz=\"{}\"/>\n    <!-- effort: {} -->\n    <limit lower=\"{lower}\" \
                 upper=\"{upper}\" effort=\"{effort}\" velocity=\"{velocity}\"/>",
                vector(motion.axis),
                motion.reason
            );
        }
        out + "  </joint>\n"
    }
}

impl Shape {
    /// Its middle, its roll, pitch and yaw, and its element.
    fn urdf(&self) -> ([f64; 3], [f64; 3], String) {
        let cylinder = |length: f64, radius: f64| {
            let (length, radius) = (number(length), number(radius));
            format!("<cylinder radius=\"{radius}\" length=\"{length}\"/>")
        };
        match *self {
            Shape::Box(p, edges) => (p, [0.0; 3], format!("<box size=\"{}\"/>", vector(edges))),
            Shape::AlongX(p, length, radius) => {
                (p, [0.0, FRAC_PI_2, 0.0], cylinder(length, radius))
            }
            Shape::AlongY(p, length, radius) => {
                (p, [FRAC_PI_2, 0.0, 0.0], cylinder(length, radius))
            }
            Shape::AlongZ(p, length, radius) => (p, [0.0; 3], cylinder(length, radius)),
            Shape::Ball(p, r) => (p, [0.0; 3], format!("<sphere radius=\"{}\"/>", number(r))),
        }
    }
}

fn vector(v: [f64; 3]) -> String {
    v.map(number).join(" ")
}

/// A decimal with at most ten places and no trailing zeros.
fn number(value: f64) -> String {
    let text = format!("{value:.10}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".into()
    } else {
        text.into()
    }
}
