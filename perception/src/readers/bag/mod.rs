//! A ROS 2 bag in MCAP → the scan of one of its messages: depth image (bare or compressedDepth, with its
//! CameraInfo) or PointCloud2, and the pose that tf gives its frame.

mod cloud;
mod container;
mod image;
mod messages;
mod topics;
mod transforms;

use std::path::{Path, PathBuf};

use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

use self::container::Bag;
use self::messages::{CompressedImage, Image, PointCloud2};
use self::topics::Topics;
use self::transforms::Transforms;
use super::{SensorOptions, depth_png, scan};
use crate::Error;
use crate::scan::{DepthImage, Scan};
use crate::sensor::Sensor;

pub(super) use self::container::is_mcap;

/// A time may lie this far outside a topic's own, s.
const OUTSIDE_S: f64 = 0.5;

/// Times of a clock are later than this, in 1973; no recording takes as long, s.
const CLOCK_S: f64 = 1e8;

/// Which message of a recording is the scan, and where tf is asked for its pose.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BagOptions {
    /// The topic; the only one of depth images, else of clouds, where none is named.
    pub topic: Option<String>,
    /// The time of the message next to it, s after the recording's first or, of the size of a clock's,
    /// since 1970; the topic's first message where none is given.
    pub at_s: Option<f64>,
    /// The frame that is the world; of `map`, `odom` and `world` the first that tf knows where none is named.
    pub frame: Option<String>,
}

/// The message that is the scan.
struct Chosen {
    schema: String,
    log_time_ns: u64,
    data: Vec<u8>,
}

/// The scan in the bag.
///
/// # Errors
/// [`Error::File`] with the topic for all that is wrong with it; a list of topics where it is not clear
/// which is the scan; as [`super::parse_scan`].
pub(super) fn parse(
    path: &Path,
    bytes: &[u8],
    sensor: &Sensor,
    options: &SensorOptions,
) -> Result<Scan, Error> {
    let asked = &options.bag;
    let mut bag = Bag::new(path, bytes);
    let topics = Topics::of(path, &mut bag)?;
    let (topic, _) = topics.choose(path, asked.topic.as_deref())?;
    let chosen = message(path, &mut bag, &topics, asked)?;

    // Its points, with errors that name the topic.
    let at = PathBuf::from(format!("{}: {topic}", path.display()));
    let fail = |cause| Error::field(&at, "message", cause);
    let mut notes = Vec::new();
    let (header, cloud, depth) = match chosen.schema.as_str() {
        messages::POINT_CLOUD => {
            let message: PointCloud2<'_> = messages::decode(&chosen.data).map_err(fail)?;
            let cloud = cloud::points(&at, &message)?;
            let depth = DepthImage::from_organised(&cloud);
            (message.header, cloud, depth)
        }
        schema => {
            let (header, depths) = if schema == messages::IMAGE {
                let message: Image<'_> = messages::decode(&chosen.data).map_err(fail)?;
                let depths = image::bare(&at, &message)?;
                (message.header, depths)
            } else {
                let message: CompressedImage<'_> = messages::decode(&chosen.data).map_err(fail)?;
                let depths = image::packed(&at, &message)?;
                (message.header, depths)
            };
            let mut given = options.clone();
            let mut lens = None;
            if given.intrinsics.is_none()
                && let Some((name, info)) = topics.camera(topic, &header.frame_id)
            {
                let (k, bends) = image::pinhole(&at, topic, info, depths.size)?;
                given.intrinsics = Some(k);
                lens = bends;
                notes.push(format!("{}: intrinsics of {name}", at.display()));
            }
            let units = depths.units.into_iter();
            let mut depth =
                depth_png::metric(&at, depths.size, units, depths.scale_m, sensor, &given)?;
            if let Some(lens) = lens {
                lens.straighten(&mut depth);
            }
            (header, depth.to_cloud(), Some(depth))
        }
    };

    // Where it was taken.
    let stamp_ns = match header.stamp.ns() {
        0 => i64::try_from(chosen.log_time_ns).unwrap_or(i64::MAX),
        stamp_ns => stamp_ns,
    };
    let tf = transforms(path, &mut bag, stamp_ns)?;
    let frame = header.frame_id;
    let found = tf.pose(&frame, asked.frame.as_deref());
    let (X_WV, by) = match found {
        Ok((fixed, X_WV)) => (X_WV, format!("tf gives its pose in {fixed:?}")),
        Err(cause) if asked.frame.is_some() => return Err(Error::field(&at, "tf", cause)),
        Err(cause) => (Isometry3::identity(), cause),
    };
    let taken_s = topics.seconds(chosen.log_time_ns);
    notes.push(format!(
        "{}: the message at {taken_s:.3} s; {by}",
        at.display()
    ));
    if topics.cut {
        let cut = "ends in the middle of a record; what is before that is read";
        notes.push(format!("warning: {}: {cut}", path.display()));
    }
    let mut scan = scan(&at, cloud, depth, X_WV, sensor, options)?;
    scan.notes = notes;
    Ok(scan)
}

/// The topic's message next to the time that is asked for.
fn message(
    path: &Path,
    bag: &mut Bag<'_>,
    topics: &Topics,
    asked: &BagOptions,
) -> Result<Chosen, Error> {
    let (name, topic) = topics.choose(path, asked.topic.as_deref())?;
    let wanted_ns = match asked.at_s {
        None => topic.first_ns,
        Some(at_s) => {
            let absolute = at_s >= CLOCK_S && topics.first_ns as f64 * 1e-9 >= CLOCK_S;
            let wanted = if absolute {
                at_s * 1e9
            } else {
                topics.first_ns as f64 + at_s * 1e9
            };
            let span = (topic.first_ns as f64, topic.last_ns as f64);
            let room = OUTSIDE_S * 1e9;
            if !(span.0 - room..=span.1 + room).contains(&wanted) {
                let (first, last) = (
                    topics.seconds(topic.first_ns),
                    topics.seconds(topic.last_ns),
                );
                let cause = format!(
                    "{at_s} s is not from {first:.3} to {last:.3} s, when {name} has messages"
                );
                return Err(Error::field(path, "at_s", cause));
            }
            wanted as u64
        }
    };
    let mut best_ns = u64::MAX;
    let mut chosen = None;
    let off = std::cell::Cell::new(u64::MAX);
    let skip = |span: &container::Span| {
        // A chunk of no stated times may hold any.
        let stated = *span.start() > 0 && span.start() <= span.end();
        let nearest = wanted_ns.clamp(*span.start(), (*span.end()).max(*span.start()));
        stated && nearest.abs_diff(wanted_ns) > off.get()
    };
    bag.messages(skip, |message| {
        let distance = message.log_time_ns.abs_diff(wanted_ns);
        let nearer = distance < best_ns || chosen.is_none();
        if message.channel.topic == name && nearer {
            best_ns = distance;
            off.set(distance);
            chosen = Some(Chosen {
                schema: message.channel.schema.clone(),
                log_time_ns: message.log_time_ns,
                data: message.data.to_vec(),
            });
        }
        Ok(())
    })?;
    chosen.ok_or_else(|| Error::field(path, name, "has no message"))
}

/// tf about a time.
fn transforms(path: &Path, bag: &mut Bag<'_>, at_ns: i64) -> Result<Transforms, Error> {
    let mut tf = Transforms::at(at_ns);
    bag.messages(
        |_| false,
        |message| {
            let channel = message.channel;
            if channel.schema != messages::TRANSFORMS || channel.encoding != "cdr" {
                return Ok(());
            }
            let fail = |cause| Error::field(path, channel.topic.as_str(), cause);
            let list: messages::Transforms = messages::decode(message.data).map_err(fail)?;
            let fixed = channel.topic.ends_with("tf_static");
            for transform in list.transforms {
                tf.add(transform, fixed).map_err(fail)?;
            }
            Ok(())
        },
    )?;
    Ok(tf)
}
