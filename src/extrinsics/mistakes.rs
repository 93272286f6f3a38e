//! Mistakes that a table of stances may hold, and whether one explains why the stances do not fit.

use std::f64::consts::PI;

use anyhow::{Error, anyhow};
use calibration::Config;
use calibration::camera::{PlanePair, misfit};
use nalgebra::{Isometry3, Vector3};
use robot_model::Robot;

use super::feet::Feet;
use super::identify::{Measured, stances};
use super::stances_file::{Reading, StanceRow};

/// Stances fit where they disagree by no more than this, root mean square, in standard deviations.
const FITS: f64 = 2.5;
/// A mistake explains a misfit that is less by this factor without it.
const EXPLAINS: f64 = 3.0;
/// Frames by which rows may be shifted, and rows that tell where that begins.
const SHIFT_MAX: isize = 3;
const TOLD_BY: usize = 8;

/// A table as it would be without a mistake.
struct Mended {
    /// The mistake.
    what: String,
    rows: Vec<StanceRow>,
}

/// A mistake without which the stances fit, and by how much they then disagree.
type Explained = (f64, String);

/// What is likely wrong with stances of which the feet do not fit the ground; the error as it is where
/// nothing that is known explains it.
pub fn of_feet(robot: &Robot, feet: &Feet, rows: &[StanceRow], error: Error) -> Error {
    let missed_m = |mended: Mended| {
        let found = stances(robot, feet, &mended.rows).ok()?;
        let worst = found
            .poses
            .iter()
            .map(|(_, error)| *error)
            .fold(0.0, f64::max);
        // Legs that are mirrored fit as well, under a robot that lies on its back.
        let upright = |(X_GR, _): &(Isometry3<f64>, f64)| (X_GR * Vector3::z()).z > 0.0;
        (found.poses.iter().all(upright)).then_some((worst, mended.what))
    };
    let best = (mended(rows).into_iter())
        .filter_map(missed_m)
        .min_by(|a, b| a.0.total_cmp(&b.0));
    match best {
        Some((worst_m, what)) => anyhow!(
            "{what}: with that mended the feet fit to {:.1} mm ({error:#})",
            1e3 * worst_m
        ),
        None => error,
    }
}

/// The mistake that explains why stances and frames do not fit, if they do not.
pub fn of_stances(
    robot: &Robot,
    feet: &Feet,
    rows: &[StanceRow],
    measured: &[Measured],
    config: &Config,
) -> Option<String> {
    let as_given = misfit_of(measured.iter().map(|one| one.pair.clone()))?;
    if as_given < FITS {
        return None;
    }
    let explains = |mended: Mended| {
        let found = stances(robot, feet, &mended.rows).ok()?;
        let pairs = (found.poses.iter().zip(measured)).map(|((X_GR, _), frame)| PlanePair {
            robot: config.camera.robot_plane(X_GR),
            ..frame.pair.clone()
        });
        misfit_of(pairs).map(|left| (left, mended.what))
    };
    let best = (mended(rows).into_iter())
        .filter_map(explains)
        .chain(shifted(measured))
        .filter(|(left, _)| left * EXPLAINS < as_given)
        .min_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(left, what)| {
        format!(
            "{what}: with that mended stances and frames disagree by {left:.1} times the stated noise, \
             as they are by {as_given:.1} times"
        )
    })
}

/// What may be wrong where no mistake that is known explains why no mount fits.
pub fn unexplained(measured: &[Measured]) -> String {
    let off = misfit_of(measured.iter().map(|one| one.pair.clone())).unwrap_or(f64::INFINITY);
    format!(
        "stances and frames disagree by {off:.0} times the stated noise, and neither units, signs nor shifted rows \
         explain it: are the frames those of their rows (by name, or in the rows' order), and is the sensor on --link?"
    )
}

fn misfit_of(pairs: impl Iterator<Item = PlanePair>) -> Option<f64> {
    let pairs: Vec<PlanePair> = pairs.collect();
    // Six unknowns are met by two stances.
    (pairs.len() > 3).then(|| misfit(&pairs).ok()).flatten()
}

/// The table without each of the mistakes that are known.
fn mended(rows: &[StanceRow]) -> Vec<Mended> {
    let mut all = Vec::new();
    let mut add = |what: String, change: &dyn Fn(&mut Reading)| {
        let mut rows = rows.to_vec();
        rows.iter_mut().for_each(|row| change(&mut row.reading));
        all.push(Mended { what, rows });
    };
    match rows.first().map(|row| &row.reading) {
        Some(Reading::Pose(_)) => {
            let scaled = |height: f64, angle: f64| {
                move |reading: &mut Reading| {
                    if let Reading::Pose([h, roll, pitch]) = reading {
                        *h *= height;
                        *roll *= angle;
                        *pitch *= angle;
                    }
                }
            };
            let degrees = "roll_rad and pitch_rad are in degrees";
            add(degrees.to_owned(), &scaled(1.0, PI / 180.0));
            add("height_m is in mm".to_owned(), &scaled(1e-3, 1.0));
            let both = format!("height_m is in mm, and {degrees}");
            add(both, &scaled(1e-3, PI / 180.0));
            let sign = "the sign of roll_rad or of pitch_rad is wrong";
            add(sign.to_owned(), &|reading| {
                if let Reading::Pose([_, roll, _]) = reading {
                    *roll = -*roll;
                }
            });
        }
        Some(Reading::Joints(values)) => {
            let scaled = |factor: f64, of: &dyn Fn(&str) -> bool, reading: &mut Reading| {
                if let Reading::Joints(values) = reading {
                    let wanted = values.iter_mut().filter(|(name, _)| of(name));
                    wanted.for_each(|(_, value)| *value *= factor);
                }
            };
            add(
                "the sign of all joint readings is wrong".to_owned(),
                &|reading| {
                    scaled(-1.0, &|_| true, reading);
                },
            );
            let mut kinds: Vec<&str> = values.keys().map(|name| kind(name)).collect();
            kinds.sort_unstable();
            kinds.dedup();
            for of in kinds {
                let what = format!("the sign of the joints \"…{of}\" is wrong");
                add(what, &|reading| {
                    scaled(-1.0, &|name| kind(name) == of, reading)
                });
            }
            for joint in values.keys() {
                let what = format!("the sign of {joint:?} is wrong");
                add(what, &|reading| {
                    scaled(-1.0, &|name| name == joint, reading)
                });
            }
            for (k, one) in values.keys().enumerate() {
                for other in values.keys().skip(k + 1) {
                    let what = format!("the columns of {one:?} and {other:?} are swapped");
                    add(what, &|reading| swap(reading, one, other));
                }
            }
            // Small angles make all postures the same, and the same feet fit any.
            if values.values().any(|value| value.abs() > PI) {
                add("the joint readings are in degrees".to_owned(), &|reading| {
                    scaled(PI / 180.0, &|_| true, reading);
                });
            }
        }
        None => {}
    }
    all
}

/// Exchanges the readings of two joints.
fn swap(reading: &mut Reading, one: &str, other: &str) {
    if let Reading::Joints(values) = reading
        && let (Some(&a), Some(&b)) = (values.get(one), values.get(other))
    {
        values.insert(one.to_owned(), b);
        values.insert(other.to_owned(), a);
    }
}

/// What is left where the frames of all rows, or of those from one on, stand some rows earlier or later.
fn shifted(measured: &[Measured]) -> Vec<Explained> {
    let count = measured.len();
    let mut all = Vec::new();
    for shift in (-SHIFT_MAX..=SHIFT_MAX).filter(|shift| *shift != 0) {
        // As many rows before and after tell.
        let starts = std::iter::once(0).chain(TOLD_BY..count.saturating_sub(TOLD_BY));
        for from in starts {
            // The frames of the first rows after it were lost.
            let begins = match from {
                0 => 0,
                _ => from + shift.min(0).unsigned_abs(),
            };
            let pairs = measured.iter().enumerate().filter_map(|(i, row)| {
                let by = match i {
                    i if i < from => 0,
                    i if i < begins => return None,
                    _ => shift,
                };
                let frame = measured.get(usize::try_from(i as isize + by).ok()?)?;
                Some(PlanePair {
                    robot: row.pair.robot,
                    ..frame.pair.clone()
                })
            });
            let Some(left) = misfit_of(pairs) else {
                continue;
            };
            let (rows_on, way) = (
                shift.unsigned_abs(),
                if shift > 0 { "later" } else { "earlier" },
            );
            let of = match from {
                0 => "each row".to_owned(),
                _ => format!("row {} and of each after it", begins + 1),
            };
            let what = format!(
                "the rows are shifted against the frames: the frame of {of} stands {rows_on} {way}"
            );
            all.push((left, what));
        }
    }
    all
}

/// The last word of a joint's name, which the legs' joints of one kind share.
fn kind(joint: &str) -> &str {
    joint.rsplit('_').next().unwrap_or(joint)
}
