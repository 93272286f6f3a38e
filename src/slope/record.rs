//! `slope.json`: what a LiDAR's cloud shows of ground and slopes.

use nalgebra::Point3;
use perception::lidar::{LidarCounts, ObstacleCluster, Slope, SlopeScan, Wall};
use plan::{Input, Program};
use schemars::JsonSchema;
use serde::Serialize;
use surfaces::Face;

/// The value of the field `format`.
pub const SLOPE_FORMAT: &str = "scandent-slope/2";

/// The file. SI units; vectors in W, whose origin is on the ground below the sensor, z up.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SlopeFile {
    /// [`SLOPE_FORMAT`].
    pub format: &'static str,
    /// The program that wrote it.
    pub program: Program,
    /// The files that it was made from.
    pub inputs: Vec<Input>,
    /// The settings.
    pub config: serde_json::Value,
    /// Whether W is a calibration's; else the ground gives it, and x is the sensor's.
    pub calibrated: bool,
    /// Where the sensor stood in the frame of a cloud that was moved after the scan, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eye_m: Option<[f64; 3]>,
    /// Position of the sensor in W, m.
    pub sensor_position_m: [f64; 3],
    /// Orientation of the sensor in W.
    pub sensor_quat_xyzw: [f64; 4],
    /// Points after each step.
    pub counts: LidarCounts,
    /// The ground; `null` where nothing is ground: W is then the sensor's frame.
    pub ground: Option<GroundRecord>,
    /// The slopes, the largest first.
    pub slopes: Vec<SlopeRecord>,
    /// The walls, the largest first.
    pub walls: Vec<WallRecord>,
    /// What else stands over the ground, the nearest first.
    pub things: Vec<ThingRecord>,
    /// Slopes, ground and walls as faces, as in `surfaces.json`.
    pub faces: Vec<Face>,
}

/// The ground.
#[derive(Debug, Serialize, JsonSchema)]
pub struct GroundRecord {
    /// Whether the cloud shows it; else it is the calibrated one.
    pub seen: bool,
    /// Unit normal.
    pub normal: [f64; 3],
    /// Height of the sensor over it, m.
    pub sensor_height_m: f64,
    /// Root mean square distance of its points, m.
    pub rms_m: f64,
}

/// A wall, or the part of one between two openings.
#[derive(Debug, Serialize, JsonSchema)]
pub struct WallRecord {
    /// Unit normal, toward the sensor.
    pub normal: [f64; 3],
    /// Distance of its plane from the sensor, m.
    pub distance_m: f64,
    /// Its ends over the ground plan, from the right to the left as the sensor sees it: x and y, m.
    pub ends_m: [[f64; 2]; 2],
    /// Width, m.
    pub width_m: f64,
    /// Heights over the ground between which it was seen, m; over the sensor without ground.
    pub heights_m: [f64; 2],
    /// Points on it.
    pub inliers: usize,
    /// Root mean square distance of these, m.
    pub rms_m: f64,
}

/// Something that is neither ground nor slope nor wall.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ThingRecord {
    /// The middle of its points, m.
    pub centre: [f64; 3],
    /// Width across the ray, m.
    pub width_m: f64,
    /// Heights over the ground between which it was seen, m; over the sensor without ground.
    pub heights_m: [f64; 2],
    /// Its points.
    pub points: usize,
}

/// A slope.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SlopeRecord {
    /// First end of the start line, m.
    pub p1: [f64; 3],
    /// Second end of the start line, m; p2 − p1 is along l.
    pub p2: [f64; 3],
    /// Unit direction of the start line; uphill is to its right.
    pub l: [f64; 3],
    /// Unit direction of steepest ascent on the slope.
    pub psi: [f64; 3],
    /// Angle between slope and ground, degrees.
    pub delta_deg: f64,
    /// Standard deviation of `delta_deg`, degrees.
    pub delta_sigma_deg: f64,
    /// Standard deviation of p1 and p2 across the start line, m.
    pub across_sigma_m: [f64; 2],
    /// Standard deviation of p1 and p2 along the start line, m.
    pub along_sigma_m: [f64; 2],
    /// Whether something hides where the start line ends at p1 and at p2; it then ends where the slope
    /// was last seen, and the deviation along the line reaches over what is hidden.
    pub hidden: [bool; 2],
    /// Upward unit normal.
    pub normal: [f64; 3],
    /// (x1, y1, z1, x2, y2, z2, lx, ly, lz).
    pub lambda_l: [f64; 9],
    /// (x1, y1, x2, y2, lx, ly), for ground at z = 0.
    pub lambda_ls: [f64; 6],
    /// Direction of ψ over the ground, degrees from x towards y.
    pub ascent_deg: f64,
    /// The stepping angle of headings, degrees from x towards y, in degrees.
    pub stepping: Vec<Stepping>,
    /// Points on it.
    pub inliers: usize,
    /// Root mean square distance of these, m.
    pub rms_m: f64,
}

/// The angle by which the way rises for a heading.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Stepping {
    /// Heading, degrees from x towards y.
    pub heading_deg: f64,
    /// Stepping angle δ_s, degrees; negative downhill.
    pub delta_s_deg: f64,
}

impl GroundRecord {
    /// The record of a scan's ground.
    pub fn of(scan: &SlopeScan) -> Self {
        let plane = &scan.ground.plane_V;
        Self {
            seen: scan.ground.seen,
            normal: (scan.X_WV * plane.normal).into(),
            sensor_height_m: plane.offset_m,
            rms_m: scan.ground.rms_m,
        }
    }
}

impl WallRecord {
    /// The record of a wall.
    pub fn of(wall: &Wall) -> Self {
        let face = &wall.face;
        // x_F is level, to the sensor's right.
        let x = |best: fn(f64, f64) -> f64| {
            let vertices = face.region.segments().map(|(_, [p, _])| p.x);
            vertices.reduce(best).unwrap_or(0.0)
        };
        let ends = [x(f64::max), x(f64::min)].map(|x| {
            let end = face.X_WF * Point3::new(x, 0.0, 0.0);
            [end.x, end.y]
        });
        let fit = face.fit.as_ref();
        Self {
            normal: face.normal_W().into(),
            distance_m: wall.distance_m,
            ends_m: ends,
            width_m: wall.width_m,
            heights_m: wall.heights_m,
            inliers: fit.map_or(0, |fit| fit.points),
            rms_m: fit.map_or(0.0, |fit| fit.rms_m),
        }
    }
}

impl ThingRecord {
    /// The record of a thing.
    pub fn of(thing: &ObstacleCluster) -> Self {
        Self {
            centre: thing.centre_W.coords.into(),
            width_m: thing.width_m,
            heights_m: thing.heights_m,
            points: thing.points,
        }
    }
}

impl SlopeRecord {
    /// The record of a slope, with the stepping angles of these headings (degrees).
    pub fn of(slope: &Slope, headings_deg: &[f64]) -> Self {
        let d = &slope.description;
        let array = |p: &Point3<f64>| p.coords.into();
        let stepping = |&heading_deg: &f64| Stepping {
            heading_deg,
            delta_s_deg: d.stepping_angle_rad(heading_deg.to_radians()).to_degrees(),
        };
        Self {
            p1: array(&d.p1_W),
            p2: array(&d.p2_W),
            l: d.l_W.into(),
            psi: d.psi_W.into(),
            delta_deg: d.delta_rad.to_degrees(),
            delta_sigma_deg: slope.delta_sigma_rad.to_degrees(),
            across_sigma_m: slope.across_sigma_m,
            along_sigma_m: slope.along_sigma_m,
            hidden: slope.hidden,
            normal: d.normal_W.into(),
            lambda_l: d.nine_tuple(),
            lambda_ls: d.six_tuple(),
            ascent_deg: d.psi_W.y.atan2(d.psi_W.x).to_degrees(),
            stepping: headings_deg.iter().map(stepping).collect(),
            inliers: slope.members.len(),
            rms_m: slope.rms_m,
        }
    }
}
