//! LAS 1.0 to 1.4 → points: every record of every format begins with the three coordinates.

use std::path::Path;

use byteorder::{ByteOrder, LittleEndian as Le};

use crate::Error;

pub(super) const MAGIC: &[u8] = b"LASF";

/// The points, m or what the file's coordinates are in.
///
/// # Errors
/// [`Error::File`] for a packed file (LAZ) and for a header that contradicts the file's length.
pub(super) fn parse(
    path: &Path,
    bytes: &[u8],
) -> Result<impl Iterator<Item = [f64; 3]> + Clone, Error> {
    let fail = |field: &str, cause: String| Error::field(path, field, cause);
    let header = bytes.get(..227);
    let header = header.ok_or_else(|| fail("header", "ends in the middle".to_owned()))?;
    let (format, length) = (header[104], usize::from(Le::read_u16(&header[105..])));
    if format & 0xc0 != 0 {
        let cause = "is packed (LAZ): unpack it to LAS, as with `laszip` or `pdal translate`";
        return Err(fail("point format", cause.to_owned()));
    }
    if length < 20 {
        let cause = format!("{length} bytes hold no point; the least is 20");
        return Err(fail("point record length", cause));
    }
    let mut count = u64::from(Le::read_u32(&header[107..]));
    if count == 0 && header[25] >= 4 {
        count = bytes.get(247..255).map_or(0, Le::read_u64);
    }
    let start = Le::read_u32(&header[96..]) as usize;
    let data = bytes.get(start..).unwrap_or_default();
    if count > (data.len() / length) as u64 {
        let cause = format!(
            "{count} of {length} bytes cannot be in {} bytes",
            data.len()
        );
        return Err(fail("number of points", cause));
    }
    let [scale, offset] = [131, 155].map(|at| {
        let axis = |i: usize| Le::read_f64(&header[at + 8 * i..]);
        [axis(0), axis(1), axis(2)]
    });
    let records = data.chunks_exact(length).take(count as usize);
    Ok(records.map(move |record| {
        let axis = |i: usize| f64::from(Le::read_i32(&record[4 * i..])) * scale[i] + offset[i];
        [axis(0), axis(1), axis(2)]
    }))
}
