//! How far a plan may be from perfect: every tolerance with its reason.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Tolerances of [`verify`](crate::verify). What a plan promises is bounded by the plan's
/// `required` margins; these are the slacks of the arithmetic and the limits of what a plan may
/// promise itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Largest distance of a patch vertex from its surface's plane, of a stated pose or vertex
    /// from the posture's, and of a kept contact from where it was made, m. A millimetre is what
    /// a foot's sole gives under load; solvers close contacts a hundred times better.
    pub closure_m: f64,
    /// Largest angle between the normals of a patch and its surface, rad. A millimetre across a
    /// sole of 0.2 m.
    pub normal_rad: f64,
    /// Largest rotation of a stated or kept contact frame from the posture's, rad. 0.1°: a
    /// millimetre at the end of a lever of 0.6 m.
    pub pose_rad: f64,
    /// How far a patch vertex may be over the edge of the inset polygon, m; as `closure_m`: the
    /// inset itself is ten times that.
    pub inclusion_m: f64,
    /// Largest distance of the stated centre of mass from the computed one, m. Both come from the
    /// same q and the same masses: only rounding may differ, that of a file with six decimals
    /// included.
    pub com_m: f64,
    /// Largest distance of a quaternion's length from 1: a rotation of a 2 m robot is then off by
    /// micrometres.
    pub quaternion: f64,
    /// Largest residual of the stated forces over the weight, and of their moment over the weight
    /// (m): one millimetre of the centre of mass.
    pub balance: f64,
    /// Forces smaller than this part of the weight are rounding: 0.06 N of 58 kg.
    pub force: f64,
    /// How far a part (of friction, torque) may exceed the promised one: a tenth of a percent, far
    /// below what friction and torque limits are known to.
    pub part: f64,
    /// How far a joint may be inside its margin, rad or m: below the resolution of an encoder.
    pub joint_rad: f64,
    /// How far a distance may be inside its margin, m: a tenth of the closure tolerance, above
    /// the rounding of distance algorithms.
    pub distance_m: f64,
    /// How deep a touching link may sink into the body behind its surface, m. Collision shapes
    /// are not exact where soles and pads are: they may overlap by what they are drawn off. What is beside a
    /// ball does not touch at all.
    pub contact_depth_m: f64,
    /// Bodies that do not rise by more than this over the plane of a contact may be touched by the
    /// link that carries it (pieces of one face, the riser under a tread), m: the errors of two
    /// planes fitted to one scan.
    pub same_plane_m: f64,
    /// The same on a face of a mesh, which is where the mesh has it, to the offset up to which its triangles are joined.
    pub same_plane_mesh_m: f64,
    /// How far from the plane of a ball's contact ground beside it may lean that its link may touch as well, rad. At
    /// 30° friction of 0.58 holds a ball that touches it instead.
    pub beside_ball_rad: f64,
    /// Largest heading error at the goal, rad, where the goal asks for a heading.
    pub goal_yaw_rad: f64,
    /// What is left of the distance from a patch's centroid to its nearest edge where the patch is narrow for
    /// the margin of the centre of mass: the lesser of this part of it and this length, m.
    pub left_of_patch: [f64; 2],
    /// Largest coefficient of friction that a plan may claim: clean rubber on dry concrete has
    /// about 1.
    pub friction_max: f64,
    /// Largest margin that a plan may promise, m or rad: more is a mistake of unit.
    pub margin_max: f64,
    /// Largest number of standard deviations by which a plan may take faces back: more is a mistake.
    pub edge_sigmas_max: f64,
    /// Smallest and largest body behind a surface, m: thinner ones let a robot through.
    pub thin_body_m: [f64; 2],
    /// Largest coordinate of anything, m: beyond it digits are lost.
    pub extent_m: f64,
    /// Edges of the polygonal cone in which forces are looked for, inscribed in the round one;
    /// with 48 at most 0.2 % of the friction is given away.
    pub cone_edges: usize,
    /// Largest time between two samples of a motion, s.
    pub motion_step_s: f64,
    /// How far a part (of speed, acceleration, friction, torque) may exceed the promised one between the
    /// samples at which it was set: one percent.
    pub motion_part: f64,
    /// Largest acceleration of a joint that a motion may promise itself, rad/s²: what a fall takes is
    /// less.
    pub motion_acceleration: f64,
    /// Largest difference of a stated velocity from that of the samples, over what the largest acceleration
    /// of a joint makes of it between two of them: accelerations are not known between the samples.
    pub motion_rate: f64,
    /// Largest difference of the stated accelerations from those of the velocities, over some samples, over
    /// the largest that a joint may have: one that goes from bound to bound between two of them differs by
    /// a quarter, one that comes back by a half.
    pub motion_jump: f64,
    /// Largest distance of a motion from a stance that it passes, m and rad: what the postures'
    /// contacts are closed to.
    pub motion_end: f64,
    /// How far a joint may be inside its margin between the stances, rad: 7 % of the usual one. A
    /// smooth curve between postures on their bounds cannot follow the bounds exactly.
    pub motion_joint_rad: f64,
    /// The same of distances, m: 5 % of the usual clearance.
    pub motion_distance_m: f64,
    /// How near to a surface that it leaves or lands on a patch counts as touching, m; to a body that rises over that,
    /// over what rises.
    pub motion_touch_m: f64,
}

impl Default for Options {
    fn default() -> Self {
        TOLERANCES
    }
}

/// What every plan is held against.
pub const TOLERANCES: Options = Options {
    closure_m: 1e-3,
    normal_rad: 5e-3,
    pose_rad: 1.75e-3,
    inclusion_m: 1e-3,
    com_m: 1e-5,
    quaternion: 1e-6,
    balance: 1e-3,
    force: 1e-4,
    part: 1e-3,
    joint_rad: 1e-4,
    distance_m: 1e-4,
    contact_depth_m: 5e-3,
    same_plane_m: 0.015,
    same_plane_mesh_m: 0.003,
    beside_ball_rad: 30.0_f64.to_radians(),
    goal_yaw_rad: 0.1,
    left_of_patch: [0.4, 0.01],
    friction_max: 1.5,
    margin_max: 0.5,
    edge_sigmas_max: 10.0,
    thin_body_m: [0.01, 2.0],
    extent_m: 1e4,
    cone_edges: 48,
    motion_step_s: 0.02,
    motion_part: 0.01,
    motion_acceleration: 100.0,
    motion_rate: 0.1,
    motion_jump: 0.5,
    motion_end: 1e-4,
    motion_joint_rad: 2e-3,
    motion_distance_m: 6e-4,
    motion_touch_m: 0.03,
};
