//! Slopes over angles, noise and obstructions, and staircases: what is found, and how true its σ is.
//!
//!   cargo run --release -p scandent-perception --example judge_slopes -- [FIRST_SEED [SEEDS]]
//!
//! A row is as many sweeps as there are seeds; mount, place, direction and device are drawn. `pull`
//! is the root mean square of error over claimed σ.

use std::path::Path;

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use perception::lidar::{LidarConfig, Slope, SlopeScan, detect};
use perception::parse_lidar;
use scenes::simulator::lidar::{RangeNoise, Vlp16, pcd, sweep};
use scenes::simulator::rng::Stream;
use scenes::truth::{OrientedBox, Truth};
use scenes::worlds::slope::{Ramp, room};

/// Where a person stands.
#[derive(Clone, Copy, PartialEq)]
pub enum Person {
    /// Nowhere.
    Nowhere,
    /// Before the start line.
    Before,
    /// On the ramp.
    OnIt,
}

/// Errors of more than this many σ are listed.
const FAR: f64 = 2.5;

/// Uniform in a range, and normal, by number.
struct Draw(Stream);

impl Draw {
    fn between(&self, index: u64, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform(index)
    }
}

fn main() {
    let mut args = std::env::args().skip(1).filter_map(|arg| arg.parse().ok());
    let (first, seeds) = (args.next().unwrap_or(0), args.next().unwrap_or(8_u64));
    let usual = RangeNoise::default();
    let even = RangeNoise {
        ring_bias_sigma_m: 0.0,
        ..usual
    };
    let coarse = RangeNoise {
        range_sigma_m: 0.015,
        ring_bias_sigma_m: 0.004,
        ..usual
    };
    println!(
        "ramp, noise, person       found  false  error °  σ °    pull   ends: worst mm, mean, pull; hidden: worst, pull"
    );
    let angles = [5.0, 8.0, 10.5, 15.0, 20.0, 24.0, 28.0, 32.0, 35.0];
    for (noise_name, noise) in [("8+8 mm", &usual), ("8+0 mm", &even), ("15+4 mm", &coarse)] {
        let mut total = Row::default();
        for angle in angles {
            let row = ramps(first..first + seeds, angle, 1.2, noise, Person::Nowhere);
            total.merge(&row);
            row.print(&format!("{angle:4.1}° 1.2 m {noise_name} none"));
        }
        total.print(&format!("all   1.2 m {noise_name} none"));
    }
    for (width, person) in [
        (0.4, Person::Nowhere),
        (1.2, Person::Before),
        (1.2, Person::OnIt),
        (0.8, Person::Before),
    ] {
        let name = ["none", "before", "on it"][person as usize];
        let mut total = Row::default();
        for angle in angles {
            let row = ramps(first..first + seeds, angle, width, &usual, person);
            total.merge(&row);
            row.print(&format!("{angle:4.1}° {width} m 8+8 mm {name}"));
        }
        total.print(&format!("all   {width} m 8+8 mm {name}"));
    }
    let mut called = 0;
    let noises = [&usual, &even, &coarse];
    let cases: Vec<u64> = (first..first + 20.max(seeds)).collect();
    let cases: Vec<_> = noises
        .iter()
        .flat_map(|noise| cases.iter().map(move |seed| (*seed, *noise)))
        .collect();
    for &(seed, noise) in &cases {
        let (riser, tread, scan) = stairs(seed, noise);
        let slopes = scan.as_ref().map_or(&[][..], |scan| &scan.slopes);
        called += usize::from(!slopes.is_empty());
        for slope in slopes {
            println!(
                "stairs {riser:.3} × {tread:.3} m, seed {seed}: a slope of {:.2}° ± {:.2}°, {} points",
                slope.description.delta_rad.to_degrees(),
                slope.delta_sigma_rad.to_degrees(),
                slope.members.len(),
            );
        }
    }
    println!("staircases called a slope: {called} of {}", cases.len());
}

/// What became of the sweeps of a row.
#[derive(Default)]
pub struct Row {
    /// Sweeps.
    pub sweeps: usize,
    /// Slopes that are no ramp.
    pub wrong: usize,
    /// Error and σ of each angle that was found, degrees.
    pub angles: Vec<[f64; 2]>,
    /// Error and σ of each end of a start line, m.
    pub ends: Vec<[f64; 2]>,
    /// The same of ends that something hides.
    pub hidden: Vec<[f64; 2]>,
}

impl Row {
    fn merge(&mut self, other: &Self) {
        self.sweeps += other.sweeps;
        self.wrong += other.wrong;
        self.angles.extend(&other.angles);
        self.ends.extend(&other.ends);
        self.hidden.extend(&other.hidden);
    }

    fn print(&self, name: &str) {
        let mean = |values: &mut dyn Iterator<Item = f64>| {
            let (sum, n) = values.fold((0.0, 0), |(s, n), v| (s + v, n + 1));
            sum / f64::from(n.max(1))
        };
        let pull = |of: &[[f64; 2]]| mean(&mut of.iter().map(|[e, s]| (e / s).powi(2))).sqrt();
        println!(
            "{name:26}{:3}/{:<3} {:4} {:+8.3} {:6.3} {:6.2} {:8.0} {:6.1} {:6.2}   {:5.0} {:6.2}",
            self.angles.len(),
            self.sweeps,
            self.wrong,
            mean(&mut self.angles.iter().map(|[e, _]| *e)),
            mean(&mut self.angles.iter().map(|[_, s]| *s)),
            pull(&self.angles),
            1e3 * self.ends.iter().fold(0.0, |most, [e, _]| e.abs().max(most)),
            1e3 * mean(&mut self.ends.iter().map(|[e, _]| *e)),
            pull(&self.ends),
            1e3 * self
                .hidden
                .iter()
                .fold(0.0, |most, [e, _]| e.abs().max(most)),
            pull(&self.hidden),
        );
    }
}

fn mount(draw: &Draw) -> Isometry3<f64> {
    let angle = |index, low, high| draw.between(index, low, high).to_radians();
    Isometry3::from_parts(
        Translation3::new(0.0, 0.0, draw.between(0, 0.6, 0.9)),
        UnitQuaternion::from_euler_angles(angle(1, -3.0, 3.0), angle(2, 4.0, 12.0), 0.0),
    )
}

/// The scan of a world without a calibration; none without ground.
fn scan(truth: &Truth, X_WV: &Isometry3<f64>, noise: &RangeNoise, seed: u64) -> Option<SlopeScan> {
    let taken = sweep(&truth.world(), &Vlp16::default(), X_WV, noise, seed, seed);
    let read = parse_lidar(Path::new("sweep.pcd"), &pcd(&taken), None).ok()?;
    detect(&read.cloud, None, &LidarConfig::default()).ok()
}

/// Sweeps of a ramp of this angle and width.
pub fn ramps(
    seeds: std::ops::Range<u64>,
    angle_deg: f64,
    width_m: f64,
    noise: &RangeNoise,
    person: Person,
) -> Row {
    let mut row = Row::default();
    for seed in seeds {
        let draw = Draw(Stream::new(seed, 0x510b));
        let X_WV = mount(&draw);
        let ramp = Ramp {
            angle_deg,
            start_m: [draw.between(3, 1.5, 2.3), draw.between(4, -0.4, 0.4)],
            ascent_deg: draw.between(5, -25.0, 25.0),
            width_m,
            length_m: 2.0,
        };
        let mut truth = room("ramp", &[ramp]);
        // Along and across the ramp from the middle of its start line.
        let at = match person {
            Person::Nowhere => None,
            Person::Before => Some([draw.between(6, -0.7, -0.3), draw.between(7, -0.5, 0.5)]),
            Person::OnIt => Some([
                draw.between(6, 0.3, 1.2),
                draw.between(7, -0.4, 0.4) * width_m,
            ]),
        };
        if let Some([along, across]) = at {
            let (s, c) = ramp.ascent_deg.to_radians().sin_cos();
            let [x, y] = ramp.start_m;
            let foot = along.max(0.0) * angle_deg.to_radians().tan();
            let place = Vector3::new(x + along * c - across * s, y + along * s + across * c, foot);
            truth.boxes.extend(body(place, draw.between(8, 0.0, 180.0)));
        }
        row.sweeps += 1;
        let found = scan(&truth, &X_WV, noise, seed);
        // From the frame that the ground gave to the true one.
        let X_WL = found
            .as_ref()
            .map_or(X_WV, |scan| X_WV * scan.X_WV.inverse());
        let mut slopes = found.map(|scan| scan.slopes).unwrap_or_default();
        let is_it = |slope: &Slope| {
            let d = &slope.description;
            let psi = X_WL * d.psi_W;
            let psi = psi.y.atan2(psi.x).to_degrees();
            (d.delta_rad.to_degrees() - angle_deg).abs() < 2.0
                && (psi - ramp.ascent_deg).abs() < 10.0
        };
        let own = slopes.iter().position(is_it).map(|at| slopes.remove(at));
        row.wrong += slopes.len();
        let Some(slope) = own else {
            eprintln!("{angle_deg}° {width_m} m, seed {seed}: lost");
            continue;
        };
        let error = slope.description.delta_rad.to_degrees() - angle_deg;
        let far = |what: &str, [error, sigma]: [f64; 2], unit: &str| {
            if error.abs() > FAR * sigma {
                eprintln!(
                    "{angle_deg}° {width_m} m, seed {seed}: {what} {error:+.3} ± {sigma:.3} {unit}"
                );
            }
            [error, sigma]
        };
        let sigma = slope.delta_sigma_rad.to_degrees();
        row.angles.push(far("angle", [error, sigma], "°"));
        let d = &slope.description;
        let [left, right] = ramp.ends_m().map(Point3::from);
        // Outward.
        let l = X_WL * d.l_W;
        for (k, end, outward) in [(0, right, -l), (1, left, l)] {
            let p = X_WL * [d.p1_W, d.p2_W][k];
            let (of, what) = match slope.hidden[k] {
                true => (&mut row.hidden, "hidden end"),
                false => (&mut row.ends, "end"),
            };
            let one = [outward.dot(&(p - end)), slope.along_sigma_m[k]];
            of.push(far(what, one, "m"));
        }
    }
    row
}

/// Legs, trunk and head.
fn body(place: Vector3<f64>, turned_deg: f64) -> Vec<OrientedBox> {
    let R = Rotation3::from_axis_angle(&Vector3::z_axis(), turned_deg.to_radians());
    let part = |name: &str, at: [f64; 3], size: [f64; 3]| {
        OrientedBox::new(name, place + R * Vector3::from(at), size, R)
    };
    vec![
        part("left leg", [0.0, 0.12, 0.42], [0.14, 0.14, 0.88]),
        part("right leg", [0.0, -0.12, 0.42], [0.14, 0.14, 0.88]),
        part("trunk", [0.0, 0.0, 1.15], [0.24, 0.46, 0.6]),
        part("head", [0.0, 0.0, 1.58], [0.2, 0.16, 0.24]),
    ]
}

/// A staircase ahead: riser and tread, and what is seen.
pub fn stairs(seed: u64, noise: &RangeNoise) -> (f64, f64, Option<SlopeScan>) {
    let draw = Draw(Stream::new(seed, 0x57a1));
    let (riser, tread) = (draw.between(10, 0.05, 0.20), draw.between(11, 0.22, 0.36));
    let X_WV = mount(&draw);
    let (x, y) = (draw.between(3, 1.2, 2.2), draw.between(4, -0.4, 0.4));
    let (width, turned) = (draw.between(5, 0.8, 1.6), draw.between(6, -25.0, 25.0));
    let R = Rotation3::from_axis_angle(&Vector3::z_axis(), turned.to_radians());
    let mut truth = room("stairs", &[]);
    for step in 0..8 {
        let height = riser * f64::from(step + 1);
        let depth = tread * f64::from(8 - step);
        let middle = Vector3::new(8.0 * tread - depth / 2.0, 0.0, height / 2.0);
        let centre = Vector3::new(x, y, 0.0) + R * middle;
        let size = [depth, width, height];
        truth
            .boxes
            .push(OrientedBox::new(&format!("step {step}"), centre, size, R));
    }
    (riser, tread, scan(&truth, &X_WV, noise, seed))
}
