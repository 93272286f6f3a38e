//! The true geometry of the scenes that ship, each built from the numbers at the top of its file.

pub mod families;
pub mod ground;
pub mod hexapod_obstacles;
pub mod irregular_stairs;
pub mod slope;
pub mod slope_and_hand;

use nalgebra::{Rotation3, Vector3};

use crate::truth::OrientedBox;

/// A solid box that stands on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Name.
    pub name: &'static str,
    /// Centre x, y in W, m.
    pub centre_m: [f64; 2],
    /// Edges along its own x and y, m.
    pub size_m: [f64; 2],
    /// Height of its top over the floor, m.
    pub top_m: f64,
    /// Rotation about z, degrees.
    pub yaw_deg: f64,
}

impl Block {
    /// The values in the order of the fields.
    const fn new(name: &'static str, c: [f64; 2], size_m: [f64; 2], top_m: f64, yaw: f64) -> Self {
        Self {
            name,
            centre_m: c,
            size_m,
            top_m,
            yaw_deg: yaw,
        }
    }

    /// The box.
    pub fn body(&self) -> OrientedBox {
        let centre = Vector3::new(self.centre_m[0], self.centre_m[1], self.top_m / 2.0);
        let size = [self.size_m[0], self.size_m[1], self.top_m];
        OrientedBox::new(self.name, centre, size, about_z(self.yaw_deg))
    }
}

/// A table: a slab on four legs. Its block says where the slab is, edge to edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table {
    /// Place, size and height of the table top.
    pub block: Block,
    /// Thickness of the slab, m.
    pub slab_m: f64,
    /// Edge of the square legs, m.
    pub leg_m: f64,
    /// Distance of the legs from the slab's edges, m.
    pub leg_inset_m: f64,
}

impl Table {
    /// The slab and its legs, `NAME` and `NAME leg 1` … `4`.
    pub fn bodies(&self) -> Vec<OrientedBox> {
        let Block { name, top_m, .. } = self.block;
        let ([x, y], [width, depth]) = (self.block.centre_m, self.block.size_m);
        let rotation = about_z(self.block.yaw_deg);
        let centre = Vector3::new(x, y, top_m - self.slab_m / 2.0);
        let slab = OrientedBox::new(name, centre, [width, depth, self.slab_m], rotation);
        let height = top_m - self.slab_m;
        let reach = |edge: f64| edge / 2.0 - self.leg_inset_m - self.leg_m / 2.0;
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
        let legs = corners.into_iter().enumerate().map(|(i, (sx, sy))| {
            let corner = rotation * Vector3::new(sx * reach(width), sy * reach(depth), 0.0);
            let centre = Vector3::new(x, y, height / 2.0) + corner;
            let size = [self.leg_m, self.leg_m, height];
            OrientedBox::new(&format!("{name} leg {}", i + 1), centre, size, rotation)
        });
        std::iter::once(slab).chain(legs).collect()
    }
}

/// A floor of 12 m × 12 m, its top at z = 0.
pub fn floor() -> OrientedBox {
    let centre = Vector3::new(2.0, 0.0, -0.05);
    OrientedBox::new("floor", centre, [12.0, 12.0, 0.1], Rotation3::identity())
}

fn about_z(yaw_deg: f64) -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Vector3::z_axis(), yaw_deg.to_radians())
}
