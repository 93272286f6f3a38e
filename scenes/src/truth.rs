//! The true world behind a scan: oriented boxes, and their faces as polygons.

use nalgebra::{Isometry3, Point3, Rotation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::simulator::{ConvexBody, World};

/// What really stands in a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// Name of the scene.
    pub scene: String,
    /// The bodies; the floor is one of them.
    pub boxes: Vec<OrientedBox>,
}

/// A solid box at a pose in W.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrientedBox {
    /// Name, unique in its world.
    pub name: String,
    /// Centre in W, m.
    pub position_m: [f64; 3],
    /// Orientation in W.
    pub quat_xyzw: [f64; 4],
    /// Edge lengths, m.
    pub size_m: [f64; 3],
}

/// A face of a body: n·p = b with the body on the side n·p ≤ b.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// `body/+z`, the sign and axis being those of the box.
    pub name: String,
    /// Name of the body.
    pub body: String,
    /// Outward unit normal in W.
    pub normal_W: Vector3<f64>,
    /// b, m.
    pub offset_m: f64,
    /// Corners in W, counter-clockwise seen from outside.
    pub vertices_W: Vec<Point3<f64>>,
}

impl Truth {
    /// All faces, in the order in which the simulator numbers them.
    pub fn faces(&self) -> Vec<Face> {
        self.boxes.iter().flat_map(OrientedBox::faces).collect()
    }

    /// The bodies as the simulator casts rays at them.
    pub fn world(&self) -> World {
        World::new(self.boxes.iter().map(ConvexBody::from).collect())
    }

    /// The box of this name.
    pub fn body(&self, name: &str) -> Option<&OrientedBox> {
        self.boxes.iter().find(|b| b.name == name)
    }
}

impl OrientedBox {
    /// A box from its centre, edges and orientation.
    pub fn new(
        name: &str,
        centre: Vector3<f64>,
        size_m: [f64; 3],
        rotation: Rotation3<f64>,
    ) -> Self {
        let q = UnitQuaternion::from_rotation_matrix(&rotation);
        Self {
            name: name.into(),
            position_m: centre.into(),
            quat_xyzw: q.coords.into(),
            size_m,
        }
    }

    /// Pose of the box's centre and axes in W.
    pub fn X_WO(&self) -> Isometry3<f64> {
        let rotation = UnitQuaternion::from_quaternion(self.quat_xyzw.into());
        Isometry3::from_parts(self.position_m.into(), rotation)
    }

    /// The six faces in the order −x, +x, −y, +y, −z, +z.
    pub fn faces(&self) -> Vec<Face> {
        (0..3)
            .flat_map(|axis| [-1.0, 1.0].map(|sign| self.face(axis, sign)))
            .collect()
    }

    /// The face on the side +z of the box.
    pub fn top(&self) -> Face {
        self.face(2, 1.0)
    }

    fn face(&self, axis: usize, sign: f64) -> Face {
        let X_WO = self.X_WO();
        let half = Vector3::from(self.size_m) / 2.0;
        // (a, b, axis) is right-handed; going round the other way for the negative side keeps the
        // corners counter-clockwise seen from outside.
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let corner = |(sa, sb): (f64, f64)| {
            let mut p_O = Vector3::zeros();
            p_O[axis] = sign * half[axis];
            p_O[a] = sa * half[a];
            p_O[b] = sign * sb * half[b];
            X_WO * Point3::from(p_O)
        };
        let vertices_W: Vec<_> = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
            .map(corner)
            .to_vec();
        let mut n_O = Vector3::zeros();
        n_O[axis] = sign;
        let normal_W = X_WO * n_O;
        let name = format!(
            "{}/{}{}",
            self.name,
            if sign > 0.0 { '+' } else { '-' },
            ['x', 'y', 'z',][axis]
        );
        let offset_m = normal_W.dot(&X_WO.translation.vector) + half[axis];
        Face {
            name,
            body: self.name.clone(),
            normal_W,
            offset_m,
            vertices_W,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn faces_are_planar_outward_and_counter_clockwise(
            rpy in prop::array::uniform3(-1.5f64..1.5),
            centre in prop::array::uniform3(-3.0f64..3.0),
            size in prop::array::uniform3(0.05f64..2.0),
        ) {
            let rotation = Rotation3::from_euler_angles(rpy[0], rpy[1], rpy[2]);
            let body = OrientedBox::new("b", Vector3::from(centre), size, rotation);
            let faces = body.faces();
            prop_assert_eq!(faces.len(), 6);
            for face in &faces {
                for p in &face.vertices_W {
                    prop_assert!((face.normal_W.dot(&p.coords) - face.offset_m).abs() < 1e-9);
                }
                let v = &face.vertices_W;
                let turn = (v[1] - v[0]).cross(&(v[2] - v[1]));
                prop_assert!(turn.normalize().dot(&face.normal_W) > 1.0 - 1e-9);
                prop_assert!(face.normal_W.dot(&Vector3::from(centre)) < face.offset_m);
            }
            let area: f64 = faces.iter().map(|f| {
                let v = &f.vertices_W;
                (v[1] - v[0]).norm() * (v[2] - v[1]).norm()
            }).sum();
            let [x, y, z] = size;
            prop_assert!((area - 2.0 * (x * y + y * z + z * x)).abs() < 1e-9);
        }
    }
}
