//! Values of flags that are more than a number or a name.

use std::convert::Infallible;
use std::path::PathBuf;

use anyhow::Result;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use perception::{Intrinsics, SensorOptions};
use scenes::scene_file::GoalContact;
use surfaces::{WORLD_M, beyond_world};

use crate::dataset;
use crate::provenance::{Inputs, STANDARD};

/// Comma-separated numbers within [`WORLD_M`], as many as one of `counts` says.
///
/// # Errors
/// What is wrong with the text, in words for the user.
pub fn numbers(text: &str, counts: &[usize]) -> Result<Vec<f64>, String> {
    let values = text
        .split(',')
        .map(|part| match part.trim().parse::<f64>() {
            Ok(value) if beyond_world(&[value]).is_none() => Ok(value),
            _ => Err(format!(
                "\"{}\" is not a number up to {WORLD_M}",
                part.trim()
            )),
        })
        .collect::<Result<Vec<_>, _>>()?;
    let given = values.len();
    if counts.contains(&given) {
        return Ok(values);
    }
    let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
    let counts = counts.join(" or ");
    Err(format!("{given} numbers given, {counts} wanted"))
}

/// A file by its name, or the standard input by what it is to be read as: `stl:-` becomes `-.stl`.
pub fn file(name: &str) -> Result<PathBuf, Infallible> {
    let standard = name.strip_suffix(":-");
    Ok(standard.map_or_else(|| name.into(), |kind| format!("{STANDARD}.{kind}").into()))
}

/// A folder of results.
///
/// # Errors
/// The standard output, which is none.
pub fn folder(name: &str) -> Result<PathBuf, String> {
    match name == STANDARD {
        true => {
            Err("results are several files: name a folder (./- for one of this name)".to_owned())
        }
        false => Ok(name.into()),
    }
}

/// A place: `x,y,z`, m.
///
/// # Errors
/// As [`numbers`].
pub fn place(text: &str) -> Result<[f64; 3], String> {
    let values = numbers(text, &[3])?;
    Ok([values[0], values[1], values[2]])
}

/// Times that are not negative, s.
#[derive(Clone, Debug, PartialEq)]
pub struct Times(pub Vec<f64>);

/// More times than this are no set of scans.
const TIMES_MAX: f64 = 1000.0;

/// Times: one, or `FROM:TO:EVERY`, s.
///
/// # Errors
/// What is wrong with the text.
pub fn times(text: &str) -> Result<Times, String> {
    let value = |text: &str| match text.parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(value),
        _ => Err("not a time in s, nor FROM:TO:EVERY".to_owned()),
    };
    let values: Vec<f64> = text.split(':').map(value).collect::<Result<_, _>>()?;
    match values[..] {
        [at] => Ok(Times(vec![at])),
        [from, to, every] if from <= to && (to - from) / every < TIMES_MAX => {
            // A last one that rounding would lose counts.
            let last = ((to - from) / every + 1e-6) as usize;
            Ok(Times((0..=last).map(|i| from + i as f64 * every).collect()))
        }
        _ => Err(format!("not FROM:TO:EVERY, up to {TIMES_MAX} times")),
    }
}

/// A pose: `x,y,z`, `x,y,z,roll,pitch,yaw` (fixed axes, rad) or `x,y,z,qx,qy,qz,qw`; m.
///
/// # Errors
/// As [`numbers`]; a quaternion that is none of a rotation.
pub fn pose(text: &str) -> Result<Isometry3<f64>, String> {
    let values = numbers(text, &[3, 6, 7])?;
    match values[..] {
        [x, y, z] => Ok(Translation3::new(x, y, z).into()),
        [x, y, z, r, p, w] => {
            let rotation = UnitQuaternion::from_euler_angles(r, p, w);
            Ok(Isometry3::from_parts(Translation3::new(x, y, z), rotation))
        }
        [x, y, z, qx, qy, qz, qw] => {
            let pose = dataset::rigid([x, y, z], Quaternion::new(qw, qx, qy, qz));
            pose.map_err(|error| error.to_string())
        }
        _ => Err("not a pose".to_owned()),
    }
}

/// The pose of a sensor.
#[derive(Clone, Debug, PartialEq)]
pub enum PoseFlag {
    /// As [`pose`].
    Stated(Isometry3<f64>),
    /// By a trajectory's file, and by which time or number of it ([`dataset::pose`]).
    Of(PathBuf, String),
}

impl PoseFlag {
    /// The pose; its file is noted among the inputs.
    ///
    /// # Errors
    /// As [`dataset::pose`].
    pub fn pose(&self, inputs: &mut Inputs) -> Result<Isometry3<f64>> {
        match self {
            Self::Stated(pose) => Ok(*pose),
            Self::Of(file, key) => dataset::pose(file, key, inputs),
        }
    }
}

/// A [`PoseFlag`].
///
/// # Errors
/// As [`pose`].
pub fn sensor_pose(text: &str) -> Result<PoseFlag, String> {
    match text.rsplit_once('@') {
        Some((file, key)) => Ok(PoseFlag::Of(file.into(), key.to_owned())),
        None => pose(text).map(PoseFlag::Stated),
    }
}

/// A sensor: `NAME`, `fx,fy,cx,cy[,depth_scale_m]` (px), or both as `NAME:fx,fy,cx,cy…` for a
/// known sensor with its own calibration; in the place of the numbers a file ([`dataset::pinhole`]).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SensorFlag {
    /// Name in the sensor table.
    pub name: Option<String>,
    /// fx, fy, cx, cy, px.
    pub pinhole: Option<[f64; 4]>,
    /// Metres per unit of a depth image.
    pub depth_scale_m: Option<f64>,
    /// The file that states the pinhole.
    pub file: Option<PathBuf>,
}

impl SensorFlag {
    /// The same with what its file states, which is noted among the inputs.
    ///
    /// # Errors
    /// As [`dataset::pinhole`].
    pub fn read(&self, inputs: &mut Inputs) -> Result<Self> {
        let stated = self.file.as_deref();
        let stated = stated.map(|file| dataset::pinhole(file, inputs));
        Ok(Self {
            pinhole: stated.transpose()?.or(self.pinhole),
            ..self.clone()
        })
    }

    /// What a reader of scans must know beside the file; `unnamed` is the sensor where none is
    /// named.
    pub fn options(&self, unnamed: &str) -> SensorOptions {
        let intrinsics = |[fx, fy, cx, cy]: [f64; 4]| Intrinsics { fx, fy, cx, cy };
        SensorOptions {
            sensor: self.name.clone().unwrap_or_else(|| unnamed.to_owned()),
            intrinsics: self.pinhole.map(intrinsics),
            depth_scale_m: self.depth_scale_m,
            eye_m: None,
            bag: perception::BagOptions::default(),
        }
    }
}

/// A [`SensorFlag`].
///
/// # Errors
/// As [`numbers`]; a focal length or scale that is not positive.
pub fn sensor(text: &str) -> Result<SensorFlag, String> {
    let (name, calibration) = match text.split_once(':') {
        Some((name, calibration)) => (Some(name), Some(calibration)),
        None if text.contains(',') || text.ends_with(".json") => (None, Some(text)),
        None => (Some(text), None),
    };
    let mut flag = SensorFlag {
        name: name.map(|name| name.trim().to_owned()),
        ..SensorFlag::default()
    };
    if let Some(file) = calibration.filter(|text| text.ends_with(".json")) {
        flag.file = Some(file.into());
    } else if let Some(calibration) = calibration {
        let values = numbers(calibration, &[4, 5])?;
        flag.pinhole = Some([values[0], values[1], values[2], values[3]]);
        flag.depth_scale_m = values.get(4).copied();
        if values[0] <= 0.0 || values[1] <= 0.0 || flag.depth_scale_m.is_some_and(|s| s <= 0.0) {
            return Err("focal lengths and the depth scale must be positive".to_owned());
        }
    }
    Ok(flag)
}

/// A start: `POSTURE`, `POSTURE@x,y,z[,roll,pitch,yaw]`, `POSTURE@x,y` on whatever ground is there, `@x,y…`, one
/// `JOINT=VALUE` a joint, or one `PATCH=x,y,z…` a contact.
#[derive(Clone, Debug, PartialEq)]
pub enum StartFlag {
    /// A posture, and where its base is.
    Posture(Option<String>, Option<Isometry3<f64>>),
    /// A posture over a place, x and y in m, its feet on what is there.
    Over(Option<String>, [f64; 2]),
    /// A joint and its value, rad (m where prismatic).
    Joint(String, f64),
    /// A patch at a pose.
    Contact(String, Isometry3<f64>),
}

/// A [`StartFlag`].
///
/// # Errors
/// As [`pose`].
pub fn start(text: &str) -> Result<StartFlag, String> {
    if let Some((name, value)) = text.split_once('=') {
        let name = name.trim().to_owned();
        return Ok(match value.contains(',') {
            true => StartFlag::Contact(name, pose(value)?),
            false => StartFlag::Joint(name, numbers(value, &[1])?[0]),
        });
    }
    let (name, place) = match text.split_once('@') {
        Some((name, place)) => (name.trim(), Some(place)),
        None => (text.trim(), None),
    };
    let name = (!name.is_empty()).then(|| name.to_owned());
    Ok(match place {
        Some(place) if place.split(',').count() == 2 => {
            let at_m = numbers(place, &[2])?;
            StartFlag::Over(name, [at_m[0], at_m[1]])
        }
        place => StartFlag::Posture(name, place.map(pose).transpose()?),
    })
}

/// A stance of a plan: `PLAN.json:NUMBER`.
///
/// # Errors
/// What is none, in words.
pub fn stance_of(text: &str) -> Result<(PathBuf, usize), String> {
    let split = text.rsplit_once(':').filter(|(plan, _)| !plan.is_empty());
    let (plan, number) = split.ok_or("not a plan and the number of a stance, PLAN.json:4")?;
    let number = number.trim().parse();
    let number = number.map_err(|_| format!("{text:?} does not end in the number of a stance"))?;
    Ok((plan.into(), number))
}

/// A goal: `x,y`, `x,y,z` or `x,y,z,yaw` of the base, m and rad.
#[derive(Clone, Debug, PartialEq)]
pub struct GoalFlag {
    /// x, y or x, y, z.
    pub position_m: Vec<f64>,
    /// The heading.
    pub yaw_rad: Option<f64>,
}

/// A [`GoalFlag`].
///
/// # Errors
/// As [`numbers`].
pub fn goal(text: &str) -> Result<GoalFlag, String> {
    let values = numbers(text, &[2, 3, 4])?;
    let yaw_rad = values.get(3).copied();
    Ok(GoalFlag {
        position_m: values.into_iter().take(3).collect(),
        yaw_rad,
    })
}

/// A contact that the goal must have: `PATCH=SURFACE` or `PATCH=x,y,z`.
///
/// # Errors
/// Text without `=`; as [`numbers`].
pub fn goal_contact(text: &str) -> Result<GoalContact, String> {
    let (patch, place) = text
        .split_once('=')
        .ok_or("the form is PATCH=SURFACE or PATCH=x,y,z")?;
    let point = place.contains(',');
    Ok(GoalContact {
        patch: patch.trim().to_owned(),
        surface: (!point).then(|| place.trim().to_owned()),
        point_m: point.then(|| self::place(place)).transpose()?,
    })
}

/// A posture that the goal must have, or one joint of it.
#[derive(Clone, Debug, PartialEq)]
pub enum GoalPosture {
    /// All that a posture of the SRDF states.
    Named(String),
    /// A joint and its value, rad (m where prismatic).
    Joint(String, f64),
}

/// A [`GoalPosture`]: `NAME` or `JOINT=VALUE`.
///
/// # Errors
/// As [`numbers`].
pub fn goal_posture(text: &str) -> Result<GoalPosture, String> {
    match text.split_once('=') {
        None => Ok(GoalPosture::Named(text.trim().to_owned())),
        Some((joint, value)) => {
            let value = numbers(value, &[1])?[0];
            Ok(GoalPosture::Joint(joint.trim().to_owned(), value))
        }
    }
}

/// A key posture of the guide path: `x,y,z` or `x,y,z,yaw`.
///
/// # Errors
/// As [`numbers`].
pub fn key_posture(text: &str) -> Result<[f64; 4], String> {
    let values = numbers(text, &[3, 4])?;
    let yaw = values.get(3).copied().unwrap_or(0.0);
    Ok([values[0], values[1], values[2], yaw])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_counted_and_finite() {
        assert_eq!(numbers("1, -2.5,3e-1", &[3]), Ok(vec![1.0, -2.5, 0.3]));
        for (text, said) in [
            ("1,2", "2 numbers given, 3 or 4 wanted"),
            ("1,,2", "\"\" is not a number up to 10000"),
            ("1,nan,2", "\"nan\" is not a number up to 10000"),
        ] {
            assert_eq!(numbers(text, &[3, 4]), Err(said.to_owned()));
        }
    }

    #[test]
    fn times_are_one_or_a_row() {
        assert_eq!(times("2.5"), Ok(Times(vec![2.5])));
        let row = times("1:1.3:0.1").unwrap().0;
        assert_eq!(row.len(), 4);
        assert!((row[3] - 1.3).abs() < 1e-12);
        for text in ["-1", "1:2", "2:1:1", "0:1:0", "0:1e9:1", "nan:1:1"] {
            assert!(times(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_pose_may_state_its_rotation_both_ways() {
        let half = std::f64::consts::FRAC_PI_4;
        let by_angles = pose(&format!("1,2,3,0,0,{}", 2.0 * half)).unwrap();
        let by_quaternion = pose(&format!("1,2,3,0,0,{},{}", half.sin(), half.cos())).unwrap();
        assert!(by_angles.rotation.angle_to(&by_quaternion.rotation) < 1e-12);
        assert_eq!(by_angles.translation.vector.z, 3.0);
        assert!(pose("1,2,3,1,1,1,1").unwrap_err().contains("length 2"));
    }

    #[test]
    fn a_start_is_a_posture_a_place_or_contacts() {
        let place = pose("1,2,3").unwrap();
        let crouch = StartFlag::Posture(Some("crouch".to_owned()), None);
        let foot = StartFlag::Contact("left_foot".to_owned(), place);
        assert_eq!(start("crouch"), Ok(crouch));
        assert_eq!(start("@1,2,3"), Ok(StartFlag::Posture(None, Some(place))));
        assert_eq!(start("left_foot=1,2,3"), Ok(foot));
        let knee = StartFlag::Joint("knee".to_owned(), 0.5);
        assert_eq!(start("knee=0.5"), Ok(knee));
        assert_eq!(
            stance_of("a:b/plan.json:4"),
            Ok(("a:b/plan.json".into(), 4))
        );
        assert!(stance_of("plan.json").is_err() && stance_of("plan.json:x").is_err());
        let over = StartFlag::Over(Some("crouch".to_owned()), [1.0, -2.0]);
        assert_eq!(start("crouch@1,-2"), Ok(over));
        assert!(start("crouch@1").is_err() && start("crouch@1,y").is_err());
    }

    #[test]
    fn goals_and_sensors_are_told_apart_by_their_numbers() {
        assert_eq!(goal("2,0").unwrap().position_m, [2.0, 0.0]);
        assert_eq!(goal("2,0,1.3,0.5").unwrap().yaw_rad, Some(0.5));
        let surface = goal_contact("hand=s4").unwrap().surface;
        assert_eq!(surface.as_deref(), Some("s4"));
        let point_m = goal_contact("hand=1,2,3").unwrap().point_m;
        assert_eq!(point_m, Some([1.0, 2.0, 3.0]));
        assert!(goal_contact("hand").is_err());
        let named = GoalPosture::Named("crouch".to_owned());
        assert_eq!(goal_posture("crouch"), Ok(named));
        let knee = GoalPosture::Joint("knee".to_owned(), -0.5);
        assert_eq!(goal_posture("knee=-0.5"), Ok(knee));
        assert!(goal_posture("knee=bent").is_err());
        assert_eq!(sensor("xtion").unwrap().name.as_deref(), Some("xtion"));
        let own = sensor("kinect_v2:5,6,7,8,0.01").unwrap();
        assert_eq!(own.name.as_deref(), Some("kinect_v2"));
        assert_eq!(own.pinhole, Some([5.0, 6.0, 7.0, 8.0]));
        assert_eq!(own.depth_scale_m, Some(0.01));
        assert_eq!(sensor("5,6,7,8").unwrap().name, None);
        assert!(sensor("0,6,7,8").is_err());
    }
}
