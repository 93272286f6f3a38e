//! Network captures (pcap, pcapng) → the payloads of their UDP datagrams.

use std::io::Cursor;
use std::path::Path;

use pcap_parser::{Block, Linktype, PcapBlockOwned, PcapError, create_reader};

use crate::Error;

const FORMAT: &str = "pcap";
/// What the reader holds at once at first; a longer block makes it grow.
const CAPACITY: usize = 1 << 17;

/// What a capture holds.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Capture {
    /// Payloads of the UDP datagrams, in order.
    pub payloads: Vec<Vec<u8>>,
    /// Frames that carry no whole UDP datagram.
    pub others: usize,
    /// Whether the file ends in the middle of a frame.
    pub truncated: bool,
}

/// Whether the bytes begin like a capture.
pub(super) fn is_capture(bytes: &[u8]) -> bool {
    let Some(magic) = bytes.first_chunk::<4>() else {
        return false;
    };
    // pcap in µs and ns, either byte order; pcapng's section header.
    matches!(
        u32::from_le_bytes(*magic),
        0xa1b2_c3d4 | 0xd4c3_b2a1 | 0xa1b2_3c4d | 0x4d3c_b2a1 | 0x0a0d_0d0a
    )
}

/// The payloads of a capture.
///
/// # Errors
/// [`Error::File`] for a header or a block that is none.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Capture, Error> {
    let fail = |what: String| Error::parse(path, FORMAT, what);
    let mut reader = create_reader(CAPACITY, Cursor::new(bytes))
        .map_err(|e| fail(format!("its header is no capture's ({})", kind(&e))))?;
    let mut capture = Capture::default();
    let mut links: Vec<Linktype> = Vec::new();
    let mut stalled = false;
    loop {
        match reader.next() {
            Ok((length, block)) => {
                stalled = false;
                match block {
                    PcapBlockOwned::LegacyHeader(header) => links = vec![header.network],
                    PcapBlockOwned::Legacy(frame) => {
                        take(&mut capture, links.first(), frame.data);
                    }
                    PcapBlockOwned::NG(Block::SectionHeader(_)) => links.clear(),
                    PcapBlockOwned::NG(Block::InterfaceDescription(interface)) => {
                        links.push(interface.linktype);
                    }
                    PcapBlockOwned::NG(Block::EnhancedPacket(frame)) => {
                        let length = frame.data.len().min(frame.caplen as usize);
                        take(
                            &mut capture,
                            links.get(frame.if_id as usize),
                            &frame.data[..length],
                        );
                    }
                    PcapBlockOwned::NG(Block::SimplePacket(frame)) => {
                        let length = frame.data.len().min(frame.origlen as usize);
                        take(&mut capture, links.first(), &frame.data[..length]);
                    }
                    PcapBlockOwned::NG(_) => {}
                }
                reader.consume(length);
            }
            Err(PcapError::Eof) => break,
            Err(PcapError::Incomplete(_)) if !stalled => {
                // Once without anything new is the end.
                stalled = reader.reader_exhausted();
                reader
                    .refill()
                    .map_err(|e| fail(format!("cannot be read on ({})", kind(&e))))?;
            }
            Err(PcapError::BufferTooSmall) => {
                // No block is longer than the file.
                if !reader.grow(bytes.len() + CAPACITY) {
                    return Err(fail("a block is longer than the file".into()));
                }
                reader
                    .refill()
                    .map_err(|e| fail(format!("cannot be read on ({})", kind(&e))))?;
            }
            Err(PcapError::Incomplete(_) | PcapError::UnexpectedEof) => {
                capture.truncated = true;
                break;
            }
            Err(e) => {
                let at = capture.payloads.len() + capture.others;
                return Err(fail(format!(
                    "the block after {at} frames is broken ({})",
                    kind(&e)
                )));
            }
        }
    }
    Ok(capture)
}

/// An error without the bytes that it may hold.
fn kind<I>(error: &PcapError<I>) -> &'static str {
    match error {
        PcapError::Eof | PcapError::UnexpectedEof | PcapError::Incomplete(_) => "it ends too early",
        PcapError::BufferTooSmall => "a block is too long",
        PcapError::ReadError => "not readable",
        PcapError::HeaderNotRecognized => "unknown magic number",
        _ => "not of the format",
    }
}

fn take(capture: &mut Capture, link: Option<&Linktype>, frame: &[u8]) {
    match link.and_then(|link| datagram(*link, frame)) {
        Some(payload) => capture.payloads.push(payload.to_vec()),
        None => capture.others += 1,
    }
}

/// The payload of the UDP datagram that a frame carries whole.
fn datagram(link: Linktype, frame: &[u8]) -> Option<&[u8]> {
    let be16 = |at: usize| Some(u16::from_be_bytes(*frame.get(at..)?.first_chunk::<2>()?));
    // Where the packet begins, by the kind of link.
    let ip = match link.0 {
        // Ethernet, with VLAN tags.
        1 => {
            let mut at = 12;
            while matches!(be16(at)?, 0x8100 | 0x88a8) {
                at += 4;
            }
            if be16(at)? != 0x0800 {
                return None;
            }
            at + 2
        }
        // Loopback, raw, Linux cooked (both versions).
        0 | 108 => 4,
        12 | 14 | 101 | 228 => 0,
        113 => 16,
        276 => 20,
        _ => return None,
    };
    let packet = frame.get(ip..)?;
    let (version, words) = (packet.first()? >> 4, packet.first()? & 15);
    let header = usize::from(words) * 4;
    // IPv4, UDP, no fragment of a longer one.
    let fragment = u16::from_be_bytes(*packet.get(6..)?.first_chunk::<2>()?) & 0x3fff;
    if version != 4 || *packet.get(9)? != 17 || fragment != 0 {
        return None;
    }
    let udp = packet.get(header..)?;
    let length = usize::from(u16::from_be_bytes(*udp.get(4..)?.first_chunk::<2>()?));
    udp.get(8..length)
}
