//! The ROS 2 messages that a scan is made of, as CDR writes them.

use byteorder::{BigEndian, LittleEndian};
use serde::Deserialize;

/// Types of messages, as schemas name them.
pub(super) const IMAGE: &str = "sensor_msgs/msg/Image";
pub(super) const COMPRESSED_IMAGE: &str = "sensor_msgs/msg/CompressedImage";
pub(super) const CAMERA_INFO: &str = "sensor_msgs/msg/CameraInfo";
pub(super) const POINT_CLOUD: &str = "sensor_msgs/msg/PointCloud2";
pub(super) const TRANSFORMS: &str = "tf2_msgs/msg/TFMessage";

#[derive(Deserialize)]
pub(super) struct Time {
    sec: i32,
    nanosec: u32,
}

impl Time {
    pub fn ns(&self) -> i64 {
        i64::from(self.sec) * 1_000_000_000 + i64::from(self.nanosec)
    }
}

#[derive(Deserialize)]
pub(super) struct Header {
    pub stamp: Time,
    pub frame_id: String,
}

#[derive(Deserialize)]
pub(super) struct Image<'a> {
    pub header: Header,
    pub height: u32,
    pub width: u32,
    pub encoding: String,
    pub is_bigendian: u8,
    pub step: u32,
    #[serde(borrow)]
    pub data: &'a [u8],
}

#[derive(Deserialize)]
pub(super) struct CompressedImage<'a> {
    pub header: Header,
    pub format: String,
    #[serde(borrow)]
    pub data: &'a [u8],
}

#[derive(Deserialize)]
pub(super) struct CameraInfo {
    pub header: Header,
    pub height: u32,
    pub width: u32,
    pub distortion_model: String,
    pub d: Vec<f64>,
    pub k: [f64; 9],
    _r: [f64; 9],
    pub p: [f64; 12],
}

#[derive(Deserialize)]
pub(super) struct PointField {
    pub name: String,
    pub offset: u32,
    pub datatype: u8,
    _count: u32,
}

#[derive(Deserialize)]
pub(super) struct PointCloud2<'a> {
    pub header: Header,
    pub height: u32,
    pub width: u32,
    pub fields: Vec<PointField>,
    pub is_bigendian: bool,
    pub point_step: u32,
    pub row_step: u32,
    #[serde(borrow)]
    pub data: &'a [u8],
}

#[derive(Deserialize)]
pub(super) struct TransformStamped {
    pub header: Header,
    pub child_frame_id: String,
    /// x, y, z, m.
    pub translation: [f64; 3],
    /// x, y, z, w.
    pub rotation: [f64; 4],
}

#[derive(Deserialize)]
pub(super) struct Transforms {
    pub transforms: Vec<TransformStamped>,
}

/// A message of a type, after the four bytes that say how it is written.
pub(super) fn decode<'a, T: Deserialize<'a>>(data: &'a [u8]) -> Result<T, String> {
    let (how, body) = data.split_at_checked(4).ok_or("a message ends early")?;
    let read = match how {
        [0, 1, ..] => cdr_encoding::from_bytes::<T, LittleEndian>(body),
        [0, 0, ..] => cdr_encoding::from_bytes::<T, BigEndian>(body),
        _ => return Err(format!("a message begins with {how:?}, not as plain CDR")),
    };
    let (message, _) = read.map_err(|e| format!("a message is not of its type: {e}"))?;
    Ok(message)
}
