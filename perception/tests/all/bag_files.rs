//! Bags of depth images, clouds and transforms.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::sync::Arc;

use byteorder::LittleEndian;
use mcap::{Channel, Message, Schema, WriteOptions};
use nalgebra::Isometry3;
use serde::Serialize;

use crate::scan_files::png;

pub const TOPIC: &str = "/camera/depth/image_raw";
pub const INFO: &str = "/camera/depth/camera_info";
pub const FRAME: &str = "depth_optical";
pub const SIZE: (u32, u32) = (64, 48);
pub const K: [f64; 4] = [60.0, 62.0, 31.0, 22.5];
pub const S: u64 = 1_000_000_000;
pub const START: u64 = 1_700_000_000 * S;

pub type Bytes = Vec<u8>;
pub type Sent = (&'static str, &'static str, u64, Bytes);

/// As CDR writes it, after the four bytes that say so.
pub fn cdr(message: &impl Serialize) -> Bytes {
    let body = cdr_encoding::to_vec::<_, LittleEndian>(message).unwrap();
    [vec![0, 1, 0, 0], body].concat()
}

pub fn header(at: u64, frame: &str) -> ((i32, u32), String) {
    let stamp = ((at / S) as i32, (at % S) as u32);
    (stamp, frame.to_owned())
}

/// Depths of a slope, with holes, mm.
pub fn depths() -> Vec<u16> {
    let pixels = 0..SIZE.0 * SIZE.1;
    pixels
        .map(|i| {
            if i % 7 == 0 {
                0
            } else {
                (1000 + i / SIZE.0 * 9) as u16
            }
        })
        .collect()
}

pub fn image(at: u64, encoding: &str, big: bool, step: u32, data: Bytes) -> Sent {
    let (width, height) = SIZE;
    let message = (
        header(at, FRAME),
        height,
        width,
        encoding,
        u8::from(big),
        step,
        data,
    );
    (TOPIC, "sensor_msgs/msg/Image", at, cdr(&message))
}

pub fn plain(at: u64) -> Sent {
    let data = depths().iter().flat_map(|z| z.to_le_bytes()).collect();
    image(at, "16UC1", false, 2 * SIZE.0, data)
}

pub fn compressed(at: u64, format: &str, config: [f32; 2], units: &[u16]) -> Sent {
    let raw: Bytes = units.iter().flat_map(|z| z.to_be_bytes()).collect();
    let mut data = vec![0, 0, 0, 0];
    data.extend(config.iter().flat_map(|c| c.to_le_bytes()));
    data.extend(png(SIZE.0, SIZE.1, png::BitDepth::Sixteen, &raw));
    let message = cdr(&(header(at, FRAME), format, data));
    (
        "/camera/depth/image_raw/compressedDepth",
        "sensor_msgs/msg/CompressedImage",
        at,
        message,
    )
}

pub fn camera_info(at: u64, (width, height): (u32, u32), model: &str, d: &[f64]) -> Sent {
    let [fx, fy, cx, cy] = K;
    let k = [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0];
    let p = [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
    let roi = (0_u32, 0_u32, 0_u32, 0_u32, false);
    let message = (
        header(at, FRAME),
        height,
        width,
        model,
        d,
        k,
        [0.0; 9],
        p,
        (0_u32, 0_u32, roi),
    );
    (INFO, "sensor_msgs/msg/CameraInfo", at, cdr(&message))
}

pub fn info(at: u64) -> Sent {
    camera_info(at, SIZE, "plumb_bob", &[0.0; 5])
}

pub fn tf(topic: &'static str, at: u64, parent: &str, child: &str, X: &Isometry3<f64>) -> Sent {
    let q = X.rotation.coords;
    let pose = (
        [X.translation.x, X.translation.y, X.translation.z],
        [q.x, q.y, q.z, q.w],
    );
    let message = (1_u32, header(at, parent), child, pose);
    (topic, "tf2_msgs/msg/TFMessage", at, cdr(&message))
}

/// A bag of messages in the order given, in small chunks.
pub fn bag(sent: &[Sent]) -> Bytes {
    let mut file = Cursor::new(Vec::new());
    let options = WriteOptions::new().compression(None).chunk_size(Some(6000));
    let mut writer = options.profile("ros2").create(&mut file).unwrap();
    let mut channels = BTreeMap::new();
    for (i, (topic, name, at, data)) in sent.iter().enumerate() {
        let next = channels.len() as u16;
        let channel = channels.entry(*topic).or_insert_with(|| {
            Arc::new(Channel {
                id: next,
                topic: (*topic).to_owned(),
                schema: Some(Arc::new(Schema {
                    id: next + 1,
                    name: (*name).to_owned(),
                    encoding: "ros2msg".to_owned(),
                    data: Cow::Borrowed(b""),
                })),
                message_encoding: "cdr".to_owned(),
                metadata: BTreeMap::new(),
            })
        });
        let message = Message {
            channel: Arc::clone(channel),
            sequence: i as u32,
            log_time: *at,
            publish_time: *at,
            data: Cow::Borrowed(data),
        };
        writer.write(&message).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

/// The bag with its chunks packed by `how`, which states what it likes of the size.
pub fn packed(bag: &[u8], compression: &str, how: impl Fn(&[u8]) -> (Bytes, u64)) -> Bytes {
    let mut out = bag[..8].to_vec();
    let mut at = 8;
    while at + 9 <= bag.len() {
        let (code, length) = (
            bag[at],
            u64::from_le_bytes(bag[at + 1..at + 9].try_into().unwrap()),
        );
        let body = &bag[at + 9..at + 9 + length as usize];
        at += 9 + length as usize;
        if code != 0x06 {
            out.extend(&bag[at - 9 - length as usize..at]);
        } else {
            // Times, size, sum; the name of no compression; the records.
            let (data, size) = how(&body[40..]);
            let mut chunk = body[..16].to_vec();
            chunk.extend(size.to_le_bytes());
            chunk.extend(&body[24..28]);
            chunk.extend((compression.len() as u32).to_le_bytes());
            chunk.extend(compression.as_bytes());
            chunk.extend((data.len() as u64).to_le_bytes());
            chunk.extend(data);
            out.push(code);
            out.extend((chunk.len() as u64).to_le_bytes());
            out.extend(chunk);
        }
        if code == 0x02 {
            break;
        }
    }
    out.extend(mcap::MAGIC);
    out
}

pub fn zstd(records: &[u8]) -> (Bytes, u64) {
    let level = ruzstd::encoding::CompressionLevel::Fastest;
    let data = ruzstd::encoding::compress_to_vec(records, level);
    (data, records.len() as u64)
}

pub fn lz4(records: &[u8]) -> (Bytes, u64) {
    let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
    encoder.write_all(records).unwrap();
    (encoder.finish().unwrap(), records.len() as u64)
}

/// A bag of everything, without sums, so that what is changed is read.
pub fn small(pack: bool) -> Bytes {
    let X = Isometry3::translation(1.0, 2.0, 3.0);
    let units = depths();
    let sent = [
        info(START),
        tf("/tf_static", START, "odom", FRAME, &X),
        compressed(START, "16UC1; compressedDepth png", [0.0; 2], &units),
    ];
    let mut bytes = bag(&sent);
    let at = bytes.iter().position(|code| *code == 0x06).unwrap();
    bytes[at + 33..at + 37].fill(0);
    if pack {
        packed(&bytes, "zstd", zstd)
    } else {
        bytes
    }
}
