//! What a recording holds, and which of its topics is the scan.

use std::collections::BTreeMap;
use std::path::Path;

use super::container::{Bag, Message};
use super::messages::{self, CameraInfo, CompressedImage, Image};
use crate::Error;

/// Encodings of images that are depths.
const DEPTHS: [&str; 3] = ["16UC1", "mono16", "32FC1"];
/// Longer lists of topics are cut.
const LISTED_MAX: usize = 30;

/// One topic.
pub(super) struct Topic {
    pub schema: String,
    /// How the first of its images is encoded.
    kind: Kind,
    count: usize,
    /// Time of the first and the last message, ns.
    pub first_ns: u64,
    pub last_ns: u64,
}

#[derive(PartialEq)]
enum Kind {
    Depth(String),
    Cloud,
    Other(String),
}

/// All topics, and the first CameraInfo of those that have them.
pub(super) struct Topics {
    pub topics: BTreeMap<String, Topic>,
    pub cameras: BTreeMap<String, CameraInfo>,
    pub first_ns: u64,
    /// Whether the file ends in the middle of a record.
    pub cut: bool,
}

impl Topics {
    /// # Errors
    /// Those of the container; [`Error::File`] for a CameraInfo that is none.
    pub fn of(path: &Path, bag: &mut Bag<'_>) -> Result<Self, Error> {
        let mut topics: BTreeMap<String, Topic> = BTreeMap::new();
        let mut cameras = BTreeMap::new();
        let mut first_ns = u64::MAX;
        let visit = |message: Message<'_>| {
            let (channel, at) = (message.channel, message.log_time_ns);
            first_ns = first_ns.min(at);
            if let Some(topic) = topics.get_mut(&channel.topic) {
                topic.count += 1;
                topic.first_ns = topic.first_ns.min(at);
                topic.last_ns = topic.last_ns.max(at);
                return Ok(());
            }
            let topic = Topic {
                schema: channel.schema.clone(),
                kind: kind(&message),
                count: 1,
                first_ns: at,
                last_ns: at,
            };
            topics.insert(channel.topic.clone(), topic);
            if channel.schema == messages::CAMERA_INFO && channel.encoding == "cdr" {
                let info = messages::decode(message.data);
                let info =
                    info.map_err(|cause| Error::field(path, channel.topic.as_str(), cause))?;
                cameras.insert(channel.topic.clone(), info);
            }
            Ok(())
        };
        let cut = bag.messages(|_| false, visit)?;
        Ok(Self {
            topics,
            cameras,
            first_ns,
            cut,
        })
    }

    /// The topic that is asked for, or the only one of depth images, or without one the only one of clouds.
    ///
    /// # Errors
    /// [`Error::File`] that lists the topics: none or several may be it, or the one asked for is no scan's.
    pub fn choose(&self, path: &Path, asked: Option<&str>) -> Result<(&str, &Topic), Error> {
        let fail = |cause: String| {
            let cause = format!("{cause}; it holds {}", self.list());
            Err(Error::field(path, "topic", cause))
        };
        if self.topics.is_empty() {
            let cut = if self.cut {
                ": it ends in the middle of a record"
            } else {
                ""
            };
            return Err(Error::field(
                path,
                "topic",
                format!("no message is in it{cut}"),
            ));
        }
        if let Some(asked) = asked {
            return match self.topics.get_key_value(asked) {
                Some((name, topic)) if !matches!(topic.kind, Kind::Other(_)) => Ok((name, topic)),
                Some(_) => fail(format!(
                    "{asked} has no depths and no points that can be read"
                )),
                None => fail(format!("no {asked} is in it")),
            };
        }
        let of = |depth: bool| {
            let mut of = self
                .topics
                .iter()
                .filter(move |(_, topic)| match topic.kind {
                    Kind::Depth(_) => depth,
                    Kind::Cloud => !depth,
                    Kind::Other(_) => false,
                });
            (of.next(), of.next())
        };
        match (of(true), of(false)) {
            ((Some((name, topic)), None), _) | ((None, _), (Some((name, topic)), None)) => {
                Ok((name, topic))
            }
            ((None, _), (None, _)) => fail("no topic has depth images or point clouds".to_owned()),
            _ => fail("more than one topic may be the scan, name it".to_owned()),
        }
    }

    /// The CameraInfo of an image: the one beside it, or the only one of its frame, with its topic.
    pub fn camera(&self, topic: &str, frame: &str) -> Option<(&str, &CameraInfo)> {
        let bare = topic.strip_suffix("/compressedDepth").unwrap_or(topic);
        let beside = match bare.rsplit_once('/') {
            Some((space, _)) => format!("{space}/camera_info"),
            None => "camera_info".to_owned(),
        };
        let mut of_frame = self
            .cameras
            .iter()
            .filter(|(_, info)| info.header.frame_id == frame);
        let found = match (
            self.cameras.get_key_value(&beside),
            of_frame.next(),
            of_frame.next(),
        ) {
            (Some(beside), ..) => Some(beside),
            (None, only, None) => only,
            _ => None,
        };
        found.map(|(name, info)| (name.as_str(), info))
    }

    /// A time, s, after the first message of all.
    pub fn seconds(&self, ns: u64) -> f64 {
        (ns as f64 - self.first_ns as f64) * 1e-9
    }

    /// The topics in words: type, number of messages, times.
    fn list(&self) -> String {
        let one = |(name, topic): (&String, &Topic)| {
            let kind = match &topic.kind {
                Kind::Depth(encoding) | Kind::Other(encoding) if !encoding.is_empty() => {
                    format!(" ({encoding})")
                }
                _ => String::new(),
            };
            let (first, last) = (self.seconds(topic.first_ns), self.seconds(topic.last_ns));
            let (schema, count) = (&topic.schema, topic.count);
            format!("{name} of {schema}{kind}, {count} from {first:.3} to {last:.3} s")
        };
        let mut list: Vec<String> = self.topics.iter().take(LISTED_MAX).map(one).collect();
        if self.topics.len() > LISTED_MAX {
            list.push(format!("{} more", self.topics.len() - LISTED_MAX));
        }
        list.join("; ")
    }
}

/// What a topic's first message says that all are.
fn kind(message: &Message<'_>) -> Kind {
    let channel = message.channel;
    let known = |encoding: String, depth: bool| match depth {
        true => Kind::Depth(encoding),
        false => Kind::Other(encoding),
    };
    if channel.encoding != "cdr" {
        return Kind::Other(format!("written as {:?}, not cdr", channel.encoding));
    }
    match channel.schema.as_str() {
        messages::POINT_CLOUD => Kind::Cloud,
        messages::IMAGE => match messages::decode::<Image<'_>>(message.data) {
            Ok(image) => {
                let depth = DEPTHS.contains(&image.encoding.as_str());
                known(image.encoding, depth)
            }
            // What is wrong is said when it is asked for.
            Err(_) => Kind::Depth("broken".to_owned()),
        },
        messages::COMPRESSED_IMAGE => match messages::decode::<CompressedImage<'_>>(message.data) {
            Ok(image) => {
                let depth = image.format.contains("compressedDepth");
                known(image.format, depth)
            }
            Err(_) => Kind::Depth("broken".to_owned()),
        },
        _ => Kind::Other(String::new()),
    }
}
