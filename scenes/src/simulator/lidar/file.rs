//! A sweep as the files that such sensors leave: PCD, and the packets of a network capture.

use super::device::{RINGS, Vlp16, fired_at};
use super::sweep::Sweep;

/// Twelve blocks of two cycles a packet.
const BLOCKS: usize = 12;
/// Steps of a range in a packet, m.
const UNIT_M: f64 = 0.002;

/// Binary PCD with x y z intensity ring azimuth time, in V; the azimuth in degrees as drivers write
/// it, the time in seconds since the sweep began.
pub fn pcd(sweep: &Sweep) -> Vec<u8> {
    let n = sweep.returns.len();
    let mut bytes = format!(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n\
         FIELDS x y z intensity ring azimuth time\nSIZE 4 4 4 4 2 4 4\nTYPE F F F F U F F\n\
         COUNT 1 1 1 1 1 1 1\nWIDTH {n}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {n}\n\
         DATA binary\n"
    )
    .into_bytes();
    for r in &sweep.returns {
        for value in [r.p_V.x, r.p_V.y, r.p_V.z, 100.0] {
            bytes.extend((value as f32).to_le_bytes());
        }
        bytes.extend((r.ring as u16).to_le_bytes());
        bytes.extend((r.azimuth_rad.to_degrees() as f32).to_le_bytes());
        bytes.extend((r.time_s as f32).to_le_bytes());
    }
    bytes
}

/// A capture (pcap) of the VLP-16's data packets, single return, that carries the sweep.
///
/// The last packet is filled with empty ranges. Azimuths are clockwise in the packets, in hundredths
/// of a degree; every beam's own lies between those of two blocks.
pub fn pcap(sensor: &Vlp16, sweep: &Sweep) -> Vec<u8> {
    let mut bytes = Vec::new();
    // Global header: magic, version 2.4, zone, accuracy, longest packet, Ethernet.
    bytes.extend(0xa1b2_c3d4_u32.to_le_bytes());
    bytes.extend(2_u16.to_le_bytes());
    bytes.extend(4_u16.to_le_bytes());
    for word in [0_u32, 0, 65_535, 1] {
        bytes.extend(word.to_le_bytes());
    }

    let mut ranges = vec![0_u16; sensor.firings() * RINGS];
    for r in &sweep.returns {
        let units = (r.range_m / UNIT_M).round().min(f64::from(u16::MAX));
        ranges[r.firing * RINGS + r.ring] = units as u16;
    }
    let firings: Vec<usize> = (0..sensor.firings()).collect();
    for (number, packet) in firings.chunks(2 * BLOCKS).enumerate() {
        let time_us = (number * 2 * BLOCKS) as u32 * 55;
        let payload = payload(sensor, &ranges, packet, time_us);
        let frame = frame(&payload);
        let (s, us, length) = (time_us / 1_000_000, time_us % 1_000_000, frame.len() as u32);
        for word in [s, us, length, length] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(frame);
    }
    bytes
}

/// The 1206 bytes of a data packet.
fn payload(sensor: &Vlp16, ranges: &[u16], firings: &[usize], time_us: u32) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(1206);
    for block in 0..BLOCKS {
        let first = firings.get(2 * block).copied();
        // Past the sweep's end the head turns on, and nothing comes back.
        let degrees = -sensor.azimuth_rad(firings[0] + 2 * block, 0).to_degrees();
        let hundredths = (degrees.rem_euclid(360.0) * 100.0).round() as u16 % 36_000;
        bytes.extend([0xff, 0xee]);
        bytes.extend(hundredths.to_le_bytes());
        for cycle in 0..2 {
            let firing = match cycle {
                0 => first,
                _ => firings.get(2 * block + 1).copied(),
            };
            for place in 0..RINGS {
                let ring = (0..RINGS).find(|&r| fired_at(r) == place).unwrap_or(0);
                let range = firing.map_or(0, |f| ranges[f * RINGS + ring]);
                bytes.extend(range.to_le_bytes());
                bytes.push(100);
            }
        }
    }
    bytes.extend(time_us.to_le_bytes());
    // Strongest return; VLP-16.
    bytes.extend([0x37, 0x22]);
    bytes
}

/// The payload in UDP in IPv4 in Ethernet.
fn frame(payload: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0xff; 6];
    bytes.extend([0x60, 0x76, 0x88, 0, 0, 0, 0x08, 0x00]);
    let ip_length = (20 + 8 + payload.len()) as u16;
    bytes.extend([0x45, 0]);
    bytes.extend(ip_length.to_be_bytes());
    bytes.extend([0, 0, 0x40, 0, 0xff, 17, 0, 0]);
    bytes.extend([192, 168, 1, 201, 255, 255, 255, 255]);
    for word in [2368_u16, 2368, (8 + payload.len()) as u16, 0] {
        bytes.extend(word.to_be_bytes());
    }
    bytes.extend(payload);
    bytes
}
