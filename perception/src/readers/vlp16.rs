//! Data packets of a VLP-16 → points, sweep by sweep.
//!
//! Source: Velodyne's VLP-16 User Manual 63-9243, chapter 9: packet structure, firing sequence, vertical
//! angles and corrections.

use std::collections::BTreeMap;
use std::path::Path;

use super::capture::{self, Capture};
use crate::Error;
use crate::lidar::LidarCloud;

/// Bytes of a data packet.
const DATA: usize = 1206;
/// Bytes of a position packet.
const POSITION: usize = 512;
/// Blocks a packet, bytes a block, firing cycles a block, beams a cycle.
const BLOCKS: usize = 12;
const BLOCK: usize = 100;
const CYCLES: usize = 2;
const BEAMS: usize = 16;
/// Time between the beams of a cycle, and between cycles, µs.
const BEAM_US: f64 = 2.304;
const CYCLE_US: f64 = 55.296;
/// Metres a unit of range.
const UNIT_M: f64 = 0.002;
/// Hundredths of a degree a turn; and the most between two blocks (1200 turns a minute: 80).
const TURN: i32 = 36_000;
const GAP_MAX: i32 = 200;
/// Mode: two returns a beam. Product: VLP-16.
const DUAL: u8 = 0x39;
const VLP16: u8 = 0x22;

/// Vertical angle (degrees) and vertical correction (mm) of every beam, in the order of firing.
const VERTICAL: [(f64, f64); BEAMS] = [
    (-15.0, 11.2),
    (1.0, -0.7),
    (-13.0, 9.7),
    (3.0, -2.2),
    (-11.0, 8.1),
    (5.0, -3.7),
    (-9.0, 6.6),
    (7.0, -5.1),
    (-7.0, 5.1),
    (9.0, -6.6),
    (-5.0, 3.7),
    (11.0, -8.1),
    (-3.0, 2.2),
    (13.0, -9.7),
    (-1.0, 0.7),
    (15.0, -11.2),
];

/// A LiDAR's file: its points, and what the user should know of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LidarScan {
    /// The points.
    pub cloud: LidarCloud,
    /// Sweeps in the file; 1 where it holds one by its nature.
    pub sweeps: usize,
    /// What was left out, and why.
    pub notes: Vec<String>,
}

/// One sweep of the capture: the number `sweep`, counted from 0, else the first that is whole.
///
/// Sweeps part where the head looks backwards. Every beam has its own azimuth, between those of its
/// block and the next. Of two returns of a beam both are points where they differ. Packets that are no
/// data of a VLP-16 are counted, by what is wrong with them.
///
/// # Errors
/// [`Error::File`] for a file that is no capture, or where no packet is good, with what
/// the bad ones are, or where there is no such sweep.
pub(super) fn parse(path: &Path, bytes: &[u8], sweep: Option<usize>) -> Result<LidarScan, Error> {
    let Capture {
        payloads,
        others,
        truncated,
    } = capture::parse(path, bytes)?;
    let mut sweeps = Sweeps::default();
    let mut bad: BTreeMap<String, usize> = BTreeMap::new();
    let mut good = 0_usize;
    for payload in &payloads {
        match payload.len() {
            POSITION => {}
            DATA => match sweeps.add(payload) {
                Ok(()) => good += 1,
                Err(cause) => *bad.entry(cause).or_default() += 1,
            },
            length => {
                *bad.entry(format!("of {length} bytes, not {DATA}"))
                    .or_default() += 1
            }
        }
    }
    let mut notes: Vec<String> = bad
        .iter()
        .map(|(cause, count)| format!("{count} packets {cause}"))
        .collect();
    if others > 0 {
        notes.push(format!("{others} frames without a whole UDP datagram"));
    }
    if truncated {
        notes.push("the file ends in the middle of a frame".to_owned());
    }
    if good == 0 {
        let cause = match notes.as_slice() {
            [] => "none of a VLP-16".to_owned(),
            notes => format!("none of a VLP-16; {}", notes.join(", ")),
        };
        return Err(Error::field(path, "data packets", cause));
    }
    let mut clouds = sweeps.finished();
    let count = clouds.len();
    let chosen = match sweep {
        Some(number) if number < count => number,
        Some(number) => {
            let cause = format!("number {number} asked for, the file has 0 to {}", count - 1);
            return Err(Error::field(path, "sweep", cause));
        }
        // A capture begins and ends anywhere in a turn.
        None => {
            let most = clouds.iter().map(LidarCloud::len).max().unwrap_or(0);
            let whole = clouds.iter().position(|c| c.len() * 20 >= most * 19);
            whole.unwrap_or(0)
        }
    };
    Ok(LidarScan {
        cloud: clouds.swap_remove(chosen),
        sweeps: count,
        notes,
    })
}

/// The sweeps read so far.
#[derive(Default)]
struct Sweeps {
    clouds: Vec<LidarCloud>,
    current: LidarCloud,
    /// Azimuth of the last block since the back, hundredths of a degree.
    last: Option<i32>,
    /// Gap between two blocks in the packets so far.
    gap: Option<i32>,
    /// Time of the sweep's first packet, µs.
    begun_us: Option<u32>,
}

impl Sweeps {
    /// Adds a data packet, all of it or nothing.
    ///
    /// # Errors
    /// What is wrong with it.
    fn add(&mut self, payload: &[u8]) -> Result<(), String> {
        let product = payload[DATA - 1];
        if product != VLP16 {
            return Err(format!(
                "of product 0x{product:02x}, not a VLP-16's 0x{VLP16:02x}"
            ));
        }
        let blocks: Vec<&[u8]> = payload[..BLOCKS * BLOCK].chunks_exact(BLOCK).collect();
        let mut azimuths = [0_i32; BLOCKS];
        for (azimuth, block) in azimuths.iter_mut().zip(&blocks) {
            if block[..2] != [0xff, 0xee] {
                return Err("with a block that does not begin with 0xffee".to_owned());
            }
            *azimuth = i32::from(u16::from_le_bytes([block[2], block[3]]));
            if *azimuth >= TURN {
                return Err("with an azimuth beyond 360°".to_owned());
            }
        }
        let dual = payload[DATA - 2] == DUAL;
        let stride = if dual { 2 } else { 1 };
        let bytes = [1200, 1201, 1202, 1203].map(|i| payload[i]);
        let time_us = u32::from_le_bytes(bytes);
        for first in (0..BLOCKS).step_by(stride) {
            // The way to the next block; the last one turns on as before.
            let next = azimuths
                .get(first + stride)
                .map(|a| (a - azimuths[first]).rem_euclid(TURN));
            if let Some(gap) = next.filter(|gap| (1..=GAP_MAX).contains(gap)) {
                self.gap = Some(gap);
            }
            let Some(gap) = self.gap else {
                return Err("with an azimuth that stands still or jumps".to_owned());
            };
            self.part(azimuths[first]);
            let begun = *self.begun_us.get_or_insert(time_us);
            let since_us = f64::from(time_us.wrapping_sub(begun));
            for cycle in 0..CYCLES {
                for beam in 0..BEAMS {
                    let after_us = cycle as f64 * CYCLE_US + beam as f64 * BEAM_US;
                    let azimuth = f64::from(azimuths[first])
                        + f64::from(gap) * after_us / (CYCLES as f64 * CYCLE_US);
                    let block_us = (first / stride) as f64 * CYCLES as f64 * CYCLE_US;
                    let time_s = (since_us + block_us + after_us) * 1e-6;
                    let range = |block: usize| {
                        let at = 4 + (cycle * BEAMS + beam) * 3;
                        u16::from_le_bytes([blocks[block][at], blocks[block][at + 1]])
                    };
                    let returned = range(first);
                    self.point(beam, azimuth, returned, time_s);
                    if dual && range(first + 1) != returned {
                        self.point(beam, azimuth, range(first + 1), time_s);
                    }
                }
            }
        }
        Ok(())
    }

    /// Begins a new sweep where the head has passed the back.
    fn part(&mut self, azimuth: i32) {
        let since_back = (azimuth - TURN / 2).rem_euclid(TURN);
        if self.last.is_some_and(|last| since_back < last - TURN / 2) {
            self.clouds.push(std::mem::take(&mut self.current));
            self.begun_us = None;
        }
        self.last = Some(since_back);
    }

    /// Adds a return; a range of 0 is none.
    fn point(&mut self, beam: usize, hundredths: f64, range: u16, time_s: f64) {
        if range == 0 {
            return;
        }
        let (degrees, correction_mm) = VERTICAL[beam];
        let (sin_e, cos_e) = degrees.to_radians().sin_cos();
        // The sensor counts clockwise from its y axis; V has x there and y to the left.
        let azimuth = -(hundredths / 100.0).to_radians();
        let azimuth = azimuth - std::f64::consts::TAU * (azimuth / std::f64::consts::TAU).round();
        let r = f64::from(range) * UNIT_M;
        let point = [
            r * cos_e * azimuth.cos(),
            r * cos_e * azimuth.sin(),
            r * sin_e + correction_mm * 1e-3,
        ];
        let ring = ((degrees + 15.0) / 2.0).round() as u16;
        self.current.push(
            point.map(|c| c as f32),
            Some(ring),
            Some(azimuth as f32),
            Some(time_s as f32),
        );
    }

    fn finished(mut self) -> Vec<LidarCloud> {
        if !self.current.is_empty() || self.clouds.is_empty() {
            self.clouds.push(self.current);
        }
        self.clouds
    }
}
