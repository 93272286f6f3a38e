//! What the rays hit: convex bodies as intersections of half-spaces.

use nalgebra::{Point3, Vector3};

use crate::truth::OrientedBox;

/// The side n·p ≤ b of a plane in W, n a unit vector out of the body.
#[derive(Clone, Debug, PartialEq)]
pub struct HalfSpace {
    /// Outward unit normal n in W.
    pub normal_W: Vector3<f64>,
    /// b, m.
    pub offset_m: f64,
}

/// A convex body: the intersection of its half-spaces, one a face.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexBody {
    /// Name.
    pub name: String,
    /// Faces; their index is the face's number.
    pub faces: Vec<HalfSpace>,
}

/// Where a ray meets a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Parameter along the ray.
    pub t: f64,
    /// Index of the face among all faces of the [`World`].
    pub face: usize,
}

impl ConvexBody {
    /// Parameter and face at which the ray `origin + t·direction`, t > 0, enters the body.
    ///
    /// Clips the ray by every half-space; a ray that starts inside does not enter.
    pub fn enter(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> Option<(f64, usize)> {
        let mut entry = (0.0, None);
        let mut exit = f64::INFINITY;
        for (index, face) in self.faces.iter().enumerate() {
            let speed = face.normal_W.dot(direction);
            let gap = face.offset_m - face.normal_W.dot(&origin.coords);
            if speed < 0.0 {
                let t = gap / speed;
                if t > entry.0 {
                    entry = (t, Some(index));
                }
            } else if speed > 0.0 {
                exit = exit.min(gap / speed);
            } else if gap < 0.0 {
                return None;
            }
            if entry.0 > exit {
                return None;
            }
        }
        entry
            .1
            .filter(|_| entry.0 <= exit)
            .map(|face| (entry.0, face))
    }
}

impl From<&OrientedBox> for ConvexBody {
    /// Faces in the order of [`OrientedBox::faces`].
    fn from(b: &OrientedBox) -> Self {
        let half_space = |face: crate::truth::Face| HalfSpace {
            normal_W: face.normal_W,
            offset_m: face.offset_m,
        };
        Self {
            name: b.name.clone(),
            faces: b.faces().into_iter().map(half_space).collect(),
        }
    }
}

/// All bodies, their faces numbered through.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    bodies: Vec<ConvexBody>,
    first_face: Vec<usize>,
}

impl World {
    /// A world of these bodies.
    pub fn new(bodies: Vec<ConvexBody>) -> Self {
        let mut next = 0;
        let mut first = |body: &ConvexBody| {
            let first = next;
            next += body.faces.len();
            first
        };
        let first_face = bodies.iter().map(&mut first).collect();
        Self { bodies, first_face }
    }

    /// The bodies.
    pub fn bodies(&self) -> &[ConvexBody] {
        &self.bodies
    }

    /// All faces, in the order of [`Hit::face`].
    pub fn faces(&self) -> impl Iterator<Item = &HalfSpace> {
        self.bodies.iter().flat_map(|body| &body.faces)
    }

    /// The nearest entry of a ray into a body.
    pub fn cast(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        for (body, first) in self.bodies.iter().zip(&self.first_face) {
            if let Some((t, face)) = body.enter(origin, direction)
                && nearest.is_none_or(|hit| t < hit.t)
            {
                nearest = Some(Hit {
                    t,
                    face: first + face,
                });
            }
        }
        nearest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;
    use proptest::prelude::*;

    /// A regular tetrahedron about the origin, to show that bodies need not be boxes.
    fn tetrahedron() -> ConvexBody {
        let faces = [
            [1.0, 1.0, 1.0],
            [1.0, -1.0, -1.0],
            [-1.0, 1.0, -1.0],
            [-1.0, -1.0, 1.0],
        ]
        .map(|n| HalfSpace {
            normal_W: Vector3::from(n).normalize(),
            offset_m: 0.4,
        });
        ConvexBody {
            name: "tetrahedron".into(),
            faces: faces.to_vec(),
        }
    }

    proptest! {
        #[test]
        fn entry_lies_on_the_named_face_and_on_the_body(
            from in prop::array::uniform3(-2.0f64..2.0),
            to in prop::array::uniform3(-0.3f64..0.3),
        ) {
            let body = tetrahedron();
            let origin = Point3::from(from);
            let direction = Point3::from(to) - origin;
            let inside = |p: &Point3<f64>| {
                body.faces.iter().all(|f| f.normal_W.dot(&p.coords) <= f.offset_m + 1e-9)
            };
            prop_assume!(!inside(&origin) && direction.norm() > 1e-3);
            // Aimed at a point within the inscribed sphere (radius 0.4) wherever |to| < 0.4.
            match body.enter(&origin, &direction) {
                Some((t, face)) => {
                    let p = origin + direction * t;
                    prop_assert!(t > 0.0 && inside(&p));
                    let on = body.faces[face].normal_W.dot(&p.coords) - body.faces[face].offset_m;
                    prop_assert!(on.abs() < 1e-9);
                }
                None => prop_assert!(Vector3::from(to).norm() > 0.4),
            }
        }
    }

    #[test]
    fn the_nearer_of_two_bodies_is_seen_and_faces_are_numbered_through() {
        let at = |x: f64, name: &str| {
            let centre = Vector3::new(x, 0.0, 0.0);
            OrientedBox::new(name, centre, [0.2, 2.0, 2.0], Rotation3::identity())
        };
        let world = World::new(vec![(&at(3.0, "far")).into(), (&at(1.0, "near")).into()]);
        let hit = world.cast(&Point3::origin(), &Vector3::x()).unwrap();
        assert!((hit.t - 0.9).abs() < 1e-12);
        assert_eq!(world.faces().nth(hit.face).unwrap().normal_W, -Vector3::x());
        assert!(hit.face >= 6);
        assert_eq!(world.cast(&Point3::origin(), &-Vector3::x()), None);
    }
}
