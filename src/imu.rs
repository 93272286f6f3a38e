//! The file of an IMU beside a frame: which way is up.

use std::path::Path;

use anyhow::{Context, Result, bail};
use nalgebra::Vector3;

use crate::provenance::Inputs;

/// Which way is up in the optical frame V (x right, y down, z forward), by the file of an IMU at rest with
/// the sensor: the mean of its accelerations, at any unit.
///
/// A line of names separated by commas comes before the numbers; `Acc[0-2]` stands for three columns. The
/// three columns that begin with "acc" or "linear_acceleration" are the accelerations along the axes x
/// forward, y left and z up, as REP 103 has them for a body.
///
/// # Errors
/// A file that cannot be read, with its name; no line of names with three such columns; a row of which
/// they are no numbers.
pub fn up_V(path: &Path, inputs: &mut Inputs) -> Result<[f64; 3]> {
    let text = inputs.text("imu", path)?;
    parse(&text).with_context(|| path.display().to_string())
}

fn parse(text: &str) -> Result<[f64; 3]> {
    let mut columns: Option<Vec<usize>> = None;
    let (mut sum, mut rows) = (Vector3::zeros(), 0.0);
    for (number, line) in text.lines().enumerate() {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let Some(columns) = &columns else {
            columns = accelerations(&cells);
            continue;
        };
        if line.trim().is_empty() {
            continue;
        }
        let value = |k: &usize| cells.get(*k)?.parse::<f64>().ok().filter(|x| x.is_finite());
        let values: Option<Vec<f64>> = columns.iter().map(value).collect();
        let Some([x, y, z]) = values.as_deref() else {
            bail!("line {}: its accelerations are no numbers", number + 1);
        };
        sum += Vector3::new(-y, -z, *x);
        rows += 1.0;
    }
    if columns.is_none() {
        bail!("no line names three columns Acc… (x forward, y left, z up)");
    }
    if rows == 0.0 || sum.norm() < 1e-9 {
        bail!("no acceleration is measured");
    }
    Ok((sum / rows).into())
}

/// The columns of the accelerations in a line of names, if it has three.
fn accelerations(names: &[&str]) -> Option<Vec<usize>> {
    let (mut found, mut at) = (Vec::new(), 0);
    for name in names {
        let range = name.split_once('[').and_then(|(_, range)| {
            let (from, to) = range.trim_end_matches(']').split_once('-')?;
            to.parse::<usize>().ok()?.checked_sub(from.parse().ok()?)
        });
        let count = range.map_or(1, |more| more.min(100) + 1);
        let name = name.to_ascii_lowercase();
        if name.starts_with("acc") || name.starts_with("linear_acceleration") {
            found.extend(at..at + count);
        }
        at += count;
    }
    (found.len() == 3).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gravity_is_read_in_the_optical_axes() {
        // A sensor that looks down by 27°: `k2_stairs_0001_imu.txt`.
        let text = "[2018-4-13-Fri 21:41:50]\nEuler[0-2],Acc[0-2],Gyo[0-2],Mag[0-2]\n\
                    26.96,0.12,48.8,-442,0,875,10,-12,2,290,340,-200,\n";
        assert_eq!(parse(text).unwrap(), [0.0, -875.0, -442.0]);
        assert_eq!(
            parse("t,acc_x,acc_y,acc_z\n0,1,2,9\n1,3,2,9").unwrap(),
            [-2.0, -9.0, 2.0]
        );
        for (text, words) in [
            ("", "no line names"),
            ("Acc[0-1]\n1,2", "no line names"),
            ("Acc[0-2]\n1,2", "line 2"),
            ("Acc[0-2]\n1,2,NaN", "line 2"),
            ("Acc[0-2]\n", "no acceleration"),
            ("Acc[9-2]\n", "no line names"),
        ] {
            let error = parse(text).unwrap_err().to_string();
            assert!(error.contains(words), "{text:?}: {error}");
        }
    }
}
