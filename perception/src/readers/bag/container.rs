//! The records of an MCAP file → its messages, chunk by chunk.
//!
//! No more is held at once than one chunk, and no chunk may promise more than a recorder writes.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use mcap::read::parse_record;
use mcap::records::{ChunkHeader, Record, op};

use crate::Error;

/// No recorder writes longer chunks, unpacked.
const CHUNK_BYTES_MAX: u64 = 256 << 20;
/// Images of nothing pack by about this factor; a file that unpacks to more is none of a sensor.
const RATIO_MAX: u64 = 1024;
/// A small file may unpack to this much all the same.
const UNPACKED_MIN: u64 = 64 << 20;
/// Opcode and length before each record.
const RECORD_HEADER: usize = 9;

/// Where messages of one kind are.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Channel {
    /// The topic.
    pub topic: String,
    /// The name of the messages' type, as `sensor_msgs/msg/Image`.
    pub schema: String,
    /// How messages are written: `cdr`.
    pub encoding: String,
}

/// One message, and when it was recorded.
pub(super) struct Message<'a> {
    pub channel: &'a Channel,
    pub log_time_ns: u64,
    pub data: &'a [u8],
}

/// Times of the messages of a chunk, ns.
pub(super) type Span = std::ops::RangeInclusive<u64>;

/// Whether the bytes begin like an MCAP file.
pub(in crate::readers) fn is_mcap(bytes: &[u8]) -> bool {
    bytes.starts_with(mcap::MAGIC)
}

/// A file of records, and the channels that it declared so far.
pub(super) struct Bag<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
}

impl<'a> Bag<'a> {
    pub fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        Self {
            path,
            bytes,
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
        }
    }

    /// Gives every message to `visit`; chunks whose times `skip` are not unpacked. Returns whether the file
    /// ends in the middle of a record, as where a recorder was killed.
    ///
    /// # Errors
    /// [`Error::File`] for a chunk that cannot be unpacked or whose sum is another; those of `visit`.
    pub fn messages(
        &mut self,
        mut skip: impl FnMut(&Span) -> bool,
        mut visit: impl FnMut(Message<'_>) -> Result<(), Error>,
    ) -> Result<bool, Error> {
        let mut rest = self.bytes.get(mcap::MAGIC.len()..).unwrap_or_default();
        let mut allowance = RATIO_MAX.saturating_mul(self.bytes.len() as u64);
        allowance = allowance.saturating_add(UNPACKED_MIN);
        let mut number = 0;
        while let Some((code, body)) = next_record(&mut rest) {
            if matches!(code, op::DATA_END | op::FOOTER) {
                return Ok(false);
            }
            if code != op::CHUNK {
                self.take(code, body, &mut visit)?;
                continue;
            }
            number += 1;
            let fail = |cause: String| Error::field(self.path, format!("chunk {number}"), cause);
            let Ok(Record::Chunk { header, data }) = parse_record(code, body) else {
                return Err(fail("is shorter than it states".to_owned()));
            };
            if skip(&(header.message_start_time..=header.message_end_time)) {
                continue;
            }
            let unpacked = unpack(&header, &data, &mut allowance).map_err(fail)?;
            let mut inner = &unpacked[..];
            while let Some((code, body)) = next_record(&mut inner) {
                self.take(code, body, &mut visit)?;
            }
            if !inner.is_empty() {
                let cause = "ends in the middle of a record";
                return Err(Error::field(self.path, format!("chunk {number}"), cause));
            }
        }
        Ok(true)
    }

    fn take(
        &mut self,
        code: u8,
        body: &[u8],
        visit: &mut impl FnMut(Message<'_>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        if !matches!(code, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
            return Ok(());
        }
        match parse_record(code, body).map_err(|e| Error::parse(self.path, "MCAP", e))? {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                let schema = self.schemas.get(&channel.schema_id).cloned();
                let declared = Channel {
                    topic: channel.topic,
                    schema: schema.unwrap_or_default(),
                    encoding: channel.message_encoding,
                };
                self.channels.insert(channel.id, declared);
            }
            Record::Message { header, data } => {
                let id = header.channel_id;
                let Some(channel) = self.channels.get(&id) else {
                    let cause = format!("a message is of channel {id}, which is not declared");
                    return Err(Error::field(self.path, "channels", cause));
                };
                visit(Message {
                    channel,
                    log_time_ns: header.log_time,
                    data: &data,
                })?;
            }
            _ => {}
        }
        Ok(())
    }
}

/// The next record's code and body; `None` where no whole one follows.
fn next_record<'a>(rest: &mut &'a [u8]) -> Option<(u8, &'a [u8])> {
    let (header, after) = rest.split_at_checked(RECORD_HEADER)?;
    let length = u64::from_le_bytes(*header[1..].first_chunk()?);
    let (body, after) = after.split_at_checked(usize::try_from(length).ok()?)?;
    *rest = after;
    Some((header[0], body))
}

/// The records in a chunk, in the size and with the sum that it states.
fn unpack(header: &ChunkHeader, data: &[u8], allowance: &mut u64) -> Result<Vec<u8>, String> {
    let size = header.uncompressed_size;
    if size > CHUNK_BYTES_MAX || size > *allowance {
        let packed = data.len();
        return Err(format!(
            "{packed} bytes that unpack to {size} are none of a recorder"
        ));
    }
    *allowance -= size;
    let mut unpacked = Vec::new();
    let read = |reader: &mut dyn Read, to: &mut Vec<u8>| {
        let read = reader.take(size + 1).read_to_end(to);
        read.map_err(|e| format!("cannot be unpacked ({}): {e}", header.compression))
    };
    match header.compression.as_str() {
        "" => read(&mut &data[..], &mut unpacked)?,
        "lz4" => read(&mut lz4_flex::frame::FrameDecoder::new(data), &mut unpacked)?,
        "zstd" => {
            let decoder =
                ruzstd::decoding::StreamingDecoder::new_with_max_window_size(data, CHUNK_BYTES_MAX);
            let mut decoder = decoder.map_err(|e| format!("cannot be unpacked (zstd): {e}"))?;
            read(&mut decoder, &mut unpacked)?
        }
        other => return Err(format!("is packed by {other:?}, not by lz4 or zstd")),
    };
    if unpacked.len() as u64 != size {
        return Err(format!(
            "does not unpack to the {size} bytes that it states"
        ));
    }
    let sum = header.uncompressed_crc;
    if sum != 0 && sum != crc32fast::hash(&unpacked) {
        return Err("has another checksum than it states: it was changed".to_owned());
    }
    Ok(unpacked)
}
