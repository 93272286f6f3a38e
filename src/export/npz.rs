//! A plan with its motion as arrays, for numpy: an episode of a data set.

use std::io::{Cursor, Write as _};

use anyhow::Result;
use plan::{Motion, Plan, Sample};
use robot_model::Robot;
use serde_json::json;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::frames;

/// The archive in the making: stored, with no time, so that the same motion is the same bytes.
struct Archive(ZipWriter<Cursor<Vec<u8>>>);

/// What a row of an array is.
type OfSample = fn(&Sample) -> &[f64];

/// What a card says that it is of.
const FORMAT: &str = "scandent-episode/2";

/// An archive of arrays, a row a sample: `t`, `q`, `v`, `a`, `tau`, `com_W`, `phase` (an index of the card's), and
/// `wrenches` (samples × patches × 6: force and moment about the patch's origin on the robot, in W; NaN in the
/// air); `joint_names` and `patches` name columns. A row a stance are `stances_q` and `stances_at`, the sample at
/// which it is reached. `card` is a text of JSON with the plan and the motion's phases.
///
/// # Errors
/// A motion that contradicts itself or is another robot's.
pub(super) fn write(plan: &Plan, motion: &Motion, robot: &Robot) -> Result<Vec<u8>> {
    frames::check_motion(motion, robot)?;
    let samples = &motion.samples;
    let mut archive = Archive(ZipWriter::new(Cursor::new(Vec::new())));
    archive.floats("t", &[samples.len()], samples.iter().map(|s| s.t_s))?;
    let rows: [(&str, OfSample); 5] = [
        ("q", |s| &s.q),
        ("v", |s| &s.v),
        ("a", |s| &s.a),
        ("tau", |s| &s.tau),
        ("com_W", |s| &s.com_W),
    ];
    for (name, of) in rows {
        let width = samples.first().map_or(0, |s| of(s).len());
        let values = samples.iter().flat_map(of).copied();
        archive.floats(name, &[samples.len(), width], values)?;
    }
    let phases = samples.iter().map(|s| motion.phase_at(s.t_s).unwrap_or(0));
    archive.indices("phase", phases)?;
    let shape = [samples.len(), robot.patches.len(), 6];
    archive.floats("wrenches", &shape, frames::wrenches(motion, robot))?;
    let joints: Vec<&str> = robot.joint_names().collect();
    archive.texts("joint_names", &joints)?;
    let patches: Vec<&str> = robot.patches.iter().map(|p| p.name.as_str()).collect();
    archive.texts("patches", &patches)?;
    let stances = &plan.stances;
    let postures = stances.iter().flat_map(|s| &s.q).copied();
    archive.floats("stances_q", &[stances.len(), 7 + robot.nj()], postures)?;
    let reached = |stance| {
        let last = motion.phases.iter().rfind(|p| p.to_stance == stance);
        last.map_or(0, |phase| (phase.t_end_s / motion.dt_s).round() as usize)
    };
    archive.indices("stances_at", (0..stances.len()).map(reached))?;
    let card = json!({"format": FORMAT, "plan": plan, "phases": motion.phases}).to_string();
    archive.array("card", &format!("|S{}", card.len()), &[], card.bytes())?;
    Ok(archive.0.finish()?.into_inner())
}

impl Archive {
    fn floats(
        &mut self,
        name: &str,
        shape: &[usize],
        values: impl Iterator<Item = f64>,
    ) -> Result<()> {
        self.array(name, "<f8", shape, values.flat_map(f64::to_le_bytes))
    }

    fn indices(&mut self, name: &str, all: impl ExactSizeIterator<Item = usize>) -> Result<()> {
        let shape = [all.len()];
        let bytes = all.flat_map(|index| (index as i64).to_le_bytes());
        self.array(name, "<i8", &shape, bytes)
    }

    fn texts(&mut self, name: &str, texts: &[&str]) -> Result<()> {
        let longest = texts.iter().map(|text| text.chars().count()).max();
        let longest = longest.unwrap_or(0).max(1);
        // UCS-4, filled up with zeros.
        let padded = |text: &&str| {
            let letters = text.chars().map(u32::from);
            let letters: Vec<u32> = letters.chain(std::iter::repeat(0)).take(longest).collect();
            letters.into_iter().flat_map(u32::to_le_bytes)
        };
        let bytes = texts.iter().flat_map(padded);
        self.array(name, &format!("<U{longest}"), &[texts.len()], bytes)
    }

    /// An array in version 1.0 of numpy's format: the header ends on a multiple of 64 bytes.
    fn array(
        &mut self,
        name: &str,
        kind: &str,
        shape: &[usize],
        bytes: impl Iterator<Item = u8>,
    ) -> Result<()> {
        let shape: String = shape.iter().map(|n| format!("{n},")).collect();
        let says = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({shape}), }}");
        let length = (10 + says.len() + 1).next_multiple_of(64) - 10;
        let mut npy = b"\x93NUMPY\x01\x00".to_vec();
        npy.extend(u16::try_from(length)?.to_le_bytes());
        npy.extend(format!("{says:<width$}\n", width = length - 1).bytes());
        npy.extend(bytes);
        let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        self.0.start_file(format!("{name}.npy"), stored)?;
        Ok(self.0.write_all(&npy)?)
    }
}
