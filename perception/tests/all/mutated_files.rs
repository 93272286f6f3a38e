//! No file makes the readers panic or allocate what it cannot hold.

use std::path::Path;

use perception::{SensorOptions, parse_scan};
use proptest::prelude::*;
use proptest::sample::Index;

use crate::scan_files::*;

/// Changes of a file: places, as parts of its length, with what stands there then, the same of digits near its
/// beginning, what is cut out or doubled, and where it ends.
#[derive(Clone, Debug)]
pub struct Edits {
    bytes: Vec<(Index, u8)>,
    digits: Vec<(Index, u8)>,
    splice: [Index; 2],
    end: Index,
}

pub fn edits() -> impl Strategy<Value = Edits> {
    let bytes = prop::collection::vec((any::<Index>(), any::<u8>()), 0..12);
    let digits = prop::collection::vec((any::<Index>(), b'0'..=b'9'), 0..4);
    let splice = prop::array::uniform2(any::<Index>());
    let all = (bytes, digits, splice, any::<Index>());
    all.prop_map(|(bytes, digits, splice, end)| Edits {
        bytes,
        digits,
        splice,
        end,
    })
}

/// A file with some bytes changed, some cut out or doubled, or its end cut off.
pub fn edited(mut file: Vec<u8>, edits: &Edits) -> Vec<u8> {
    let n = file.len();
    for (at, value) in &edits.bytes {
        file[at.index(n)] = *value;
    }
    for (at, value) in &edits.digits {
        file[at.index(n.min(400))] = *value;
    }
    let mut splice = edits.splice.map(|at| at.index(n));
    splice.sort_unstable();
    let [a, b] = splice;
    match (a + b) % 4 {
        0 => drop(file.drain(a..b.min(a + 40))),
        1 => file.extend_from_within(a..b),
        2 => file.truncate(edits.end.index(n + 1)),
        _ => {}
    }
    file
}

/// Reads what may be anything: a scan holds a finite point, an error names the file.
fn survives(name: &str, bytes: &[u8]) {
    let mut options = SensorOptions::default();
    options.bag.topic = name.ends_with("e57").then(|| "1".into());
    match parse_scan(Path::new(name), bytes, &options) {
        Ok(scan) => {
            assert!(scan.cloud.finite().next().is_some());
            if let Some((w, h)) = scan.cloud.organised {
                assert_eq!(w * h, scan.cloud.points.len());
            }
        }
        Err(error) => assert!(error.to_string().starts_with(name), "{error}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn mutated_files_survive(edits in edits()) {
        let le = |z: u16| z.to_le_bytes().to_vec();
        for (name, bytes) in [
            ("m.pcd", pcd_ascii()),
            ("m.pcd", pcd_binary(3, 2)),
            ("m.pcd", pcd_compressed()),
            ("m.ply", ply("ascii")),
            ("m.ply", ply("binary_little_endian")),
            ("m.ply", ply("binary_big_endian")),
            ("m.png", depth_png()),
            ("m.npy", npy("<u2", false, le)),
            ("m.npz", npz(&[("depth", &npy("<u2", false, le))], zip::CompressionMethod::Deflated)),
            ("m.tif", tiff::<tiff::encoder::colortype::Gray16>(&[1000; 64 * 48])),
            ("m.las", las(4, 0.0)),
        ] {
            survives(name, &edited(bytes, &edits));
        }
    }

    #[test]
    fn mutated_e57_survives(edits in edits(), at in 0_usize..16, digit in b'0'..=b'9') {
        // Now and then a number of the prototype or of the points.
        let mut bytes = edited(e57(), &edits);
        let marks: Vec<usize> = (2..bytes.len()).filter(|&i| bytes[i - 1] == b'"' && bytes[i].is_ascii_digit()).collect();
        if let Some(&mark) = marks.get(at) {
            bytes[mark] = digit;
        }
        survives("m.e57", &resealed(bytes));
    }
}
