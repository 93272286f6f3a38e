//! What postures keep to spare for the motion between them.

/// What a posture keeps beyond the margins that are asked for.
pub(crate) struct Reserve {
    /// Part of the torques.
    torque: f64,
    /// Of the joints' ranges, rad.
    joint_rad: f64,
    /// Of all distances, m.
    clearance_m: f64,
}

/// The motion between two postures strays from what both keep: of postures on their bounds it is beyond
/// them by a hair somewhere.
pub(crate) const RESERVE: Reserve = Reserve {
    torque: 0.96,
    joint_rad: 3e-3,
    clearance_m: 2e-3,
};
/// Where no posture has it, none is asked for.
pub(crate) const NO_RESERVE: Reserve = Reserve {
    torque: 1.0,
    joint_rad: 0.0,
    clearance_m: 0.0,
};

impl Reserve {
    /// The settings with margins beyond what they ask for.
    pub fn beyond(&self, asked: &posture::Config) -> posture::Config {
        posture::Config {
            torque_use: asked.torque_use * self.torque,
            joint_margin_rad: asked.joint_margin_rad + self.joint_rad,
            clearance_m: asked.clearance_m + self.clearance_m,
            self_clearance_m: asked.self_clearance_m + self.clearance_m,
            ..asked.clone()
        }
    }
}
