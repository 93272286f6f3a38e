//! A slope in numbers: start line, orientation, angle, stepping angle.

use nalgebra::{Point3, Vector3};

/// Where a slope begins and how it rises, in W.
///
/// Source: \[meng\] Eqs. 11 to 15, corrected: l and ψ are unit vectors, ψ points uphill, the start line
/// is the intersection of the two planes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Description {
    /// First end of the start line, m; p₂ − p₁ is along l.
    pub p1_W: Point3<f64>,
    /// Second end of the start line, m.
    pub p2_W: Point3<f64>,
    /// Unit direction of the start line: n_slope × n_ground, so that uphill is to its right.
    pub l_W: Vector3<f64>,
    /// Unit direction of steepest ascent in the slope's plane, ψ = l × n_slope.
    pub psi_W: Vector3<f64>,
    /// Upward unit normal of the slope.
    pub normal_W: Vector3<f64>,
    /// Angle between slope and ground, rad.
    pub delta_rad: f64,
}

impl Description {
    /// Λ_L = (x₁, y₁, z₁, x₂, y₂, z₂, l_x, l_y, l_z).
    ///
    /// Source: \[meng\] Eq. 12.
    pub fn nine_tuple(&self) -> [f64; 9] {
        let (a, b, l) = (self.p1_W, self.p2_W, self.l_W);
        [a.x, a.y, a.z, b.x, b.y, b.z, l.x, l.y, l.z]
    }

    /// Λ_LS = (x₁, y₁, x₂, y₂, l_x, l_y), for ground at z = 0.
    ///
    /// Source: \[meng\] Eq. 13.
    pub fn six_tuple(&self) -> [f64; 6] {
        let (a, b, l) = (self.p1_W, self.p2_W, self.l_W);
        [a.x, a.y, b.x, b.y, l.x, l.y]
    }

    /// The angle by which the way rises on the slope for a heading (yaw about z_W from x_W), rad:
    /// negative downhill.
    ///
    ///   δ_s = atan( −(n_x cos ψ + n_y sin ψ) / n_z )
    ///
    /// Source: \[meng\] Eq. 15; deviation: that one takes a heading on the slope and loses the sign.
    pub fn stepping_angle_rad(&self, heading_rad: f64) -> f64 {
        let (s, c) = heading_rad.sin_cos();
        let n = self.normal_W;
        (-(n.x * c + n.y * s) / n.z).atan()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slope of δ that rises in the direction `yaw`.
    fn slope(delta: f64, yaw: f64) -> Description {
        let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), yaw);
        let n = turn * Vector3::new(-delta.sin(), 0.0, delta.cos());
        let l = n.cross(&Vector3::z()).normalize();
        Description {
            p1_W: Point3::origin() - l,
            p2_W: Point3::origin() + l,
            l_W: l,
            psi_W: l.cross(&n),
            normal_W: n,
            delta_rad: delta,
        }
    }

    #[test]
    fn the_stepping_angle_is_the_slopes_along_psi_and_changes_sign_downhill() {
        for (delta, yaw) in [(0.2_f64, 0.0), (0.41, 0.7), (0.3, -2.5)] {
            let s = slope(delta, yaw);
            assert!(s.psi_W.z > 0.0 && (s.psi_W.z - delta.sin()).abs() < 1e-12);
            assert!((s.stepping_angle_rad(yaw) - delta).abs() < 1e-12);
            assert!((s.stepping_angle_rad(yaw + std::f64::consts::PI) + delta).abs() < 1e-12);
            assert!(
                s.stepping_angle_rad(yaw + std::f64::consts::FRAC_PI_2)
                    .abs()
                    < 1e-12
            );
            // Eq. 15 for a heading on the slope: tan δ_s = tan δ sin η_h with the horizontal angle.
            let eta = 0.6;
            let heading = yaw + std::f64::consts::FRAC_PI_2 - eta;
            let expected = (delta.tan() * eta.sin()).atan();
            assert!((s.stepping_angle_rad(heading) - expected).abs() < 1e-12);
        }
    }

    /// Eq. 15 as printed, with s on the slope itself, says the same for headings within a right angle.
    #[test]
    fn the_printed_formula_agrees_where_its_heading_lies_on_the_slope() {
        let s = slope(23.8_f64.to_radians(), 0.0);
        for eta_h in [0.2_f64, 0.7, 1.2, 1.5] {
            let heading = std::f64::consts::FRAC_PI_2 - eta_h;
            let rise = s.stepping_angle_rad(heading);
            let on_slope = Vector3::new(heading.cos(), heading.sin(), rise.tan()).normalize();
            let eta = on_slope.dot(&s.l_W).acos();
            let (te, td) = (eta.tan(), s.delta_rad.tan());
            let printed = (te * td / (te * te + td * td + 1.0).sqrt()).atan();
            assert!((printed - rise).abs() < 1e-9, "{printed} {rise}");
        }
    }

    #[test]
    fn tuples_hold_the_end_points_and_the_direction() {
        let s = slope(0.3, 0.0);
        assert_eq!(s.nine_tuple()[6..], [s.l_W.x, s.l_W.y, s.l_W.z]);
        assert_eq!(s.six_tuple(), [0.0, -1.0, 0.0, 1.0, s.l_W.x, s.l_W.y]);
    }
}
