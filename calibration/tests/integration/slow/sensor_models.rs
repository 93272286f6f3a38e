//! Mistakes in a sensor's model: named where the poses tell them, and none of a sensor that is right.

use calibration::GroundPlane;
use calibration::camera::{Mistake, PlanePair, SensorModel, identify_checked};
use nalgebra::{Unit, Vector3};
use scenes::simulator::DepthNoise;

use crate::support::{Device, Series};

/// The plane as it comes out with focal lengths that are `focal` times the true ones, a principal point `shift` focal
/// lengths off and depths `scale` times the true ones.
fn mistaken(plane: &GroundPlane, focal: f64, shift: [f64; 2], scale: f64) -> GroundPlane {
    let m = plane.normal.into_inner() / plane.distance_m;
    let [x, y] = [m.x * focal, m.y * focal];
    let m = Vector3::new(x, y, m.z - shift[0] * x - shift[1] * y) / scale;
    GroundPlane {
        normal: Unit::new_normalize(m),
        distance_m: 1.0 / m.norm(),
        covariance: plane.covariance,
    }
}

const RUNS: u64 = 20;

/// Of each run: none of a sensor that is right; where it is not, its own mistake among those that are named or none, and it alone in most of those that are as
/// large as the poses tell.
#[test]
fn mistakes_are_named_and_none_where_there_is_none() {
    let noise = DepthNoise {
        distortion: 0.0,
        ..DepthNoise::default()
    };
    let (f, scale, none) = (525.0, 1.0, [0.0; 2]);
    let cases = [
        (1.0, none, scale, None, 0),
        (1.01, none, scale, Some(Mistake::Focal), 0),
        (1.03, none, scale, Some(Mistake::Focal), 18),
        (1.0, [0.0, 5.0 / f], scale, Some(Mistake::Centre), 0),
        (1.0, [0.0, 15.0 / f], scale, Some(Mistake::Centre), 18),
        (1.0, none, 1.01, Some(Mistake::Scale), 0),
        (1.0, none, 1.03, Some(Mistake::Scale), 18),
    ];
    for noise in [noise, DepthNoise::default()] {
        let series = Series::new(Device::kinect(5, &noise));
        let mut named = [0; 7];
        for run in 0..RUNS {
            let right = series.measure(run);
            for ((focal, shift, scale, truth, _), named) in cases.iter().zip(&mut named) {
                let wrong = |pair: &PlanePair| PlanePair {
                    sensor: mistaken(&pair.sensor, *focal, *shift, *scale),
                    ..pair.clone()
                };
                let pairs: Vec<PlanePair> = right.iter().map(wrong).collect();
                let found = identify_checked(&pairs, &series.config.camera).expect("a mount");
                let likely = SensorModel::likely(&found.sensor);
                let likely: Vec<Mistake> = likely.iter().map(|model| model.mistake).collect();
                let is_none = likely.is_empty();
                let is_named = truth.is_some_and(|truth| likely == [truth]);
                let is_among = truth.is_some_and(|truth| likely.contains(&truth));
                assert!(is_none || is_among, "run {run}: {likely:?} for {truth:?}");
                *named += usize::from(is_named);
            }
        }
        println!("distortion {}: named {named:?} of {RUNS}", noise.distortion);
        for ((.., least), named) in cases.iter().zip(named) {
            assert!(named >= *least, "{named} of {RUNS}");
        }
    }
}
