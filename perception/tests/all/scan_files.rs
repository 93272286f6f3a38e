//! Files of every format with the same few points, or the same depth image.

use std::io::{Cursor, Write as _};

use tiff::encoder::colortype::ColorType;
use tiff::encoder::{TiffEncoder, TiffValue};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

pub const POINTS: [[f32; 3]; 6] = [
    [0.1, 0.2, 1.0],
    [-0.5, 0.25, 2.0],
    [f32::NAN, f32::NAN, f32::NAN],
    [1.5, -0.75, 3.5],
    [f32::INFINITY, 0.0, 1.0],
    [0.0, 0.0, 0.5],
];

pub fn expected() -> Vec<[f32; 3]> {
    POINTS
        .into_iter()
        .filter(|p| p.iter().all(|c| c.is_finite()))
        .collect()
}

pub fn pcd_header(width: usize, height: usize, points: usize, data: &str) -> String {
    format!(
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x intensity y z\nSIZE 4 2 4 8\nTYPE F U F F\n\
         COUNT 1 2 1 1\nWIDTH {width}\nHEIGHT {height}\nVIEWPOINT 1 2 3 0.5 0.5 0.5 0.5\n\
         POINTS {points}\nDATA {data}\n"
    )
}

pub fn pcd_ascii() -> Vec<u8> {
    let rows = POINTS.map(|[x, y, z]| format!("{x} 7 8 {y} {z}\n"));
    (pcd_header(6, 1, 6, "ascii") + &rows.concat()).into_bytes()
}

pub fn pcd_binary(width: usize, height: usize) -> Vec<u8> {
    let mut bytes = pcd_header(width, height, 6, "binary").into_bytes();
    for [x, y, z] in POINTS {
        bytes.extend(x.to_le_bytes());
        bytes.extend([7, 0, 8, 0]);
        bytes.extend(y.to_le_bytes());
        bytes.extend(f64::from(z).to_le_bytes());
    }
    bytes
}

/// The block of a compressed file: a field after the other, packed as LZF literals.
pub fn pcd_compressed() -> Vec<u8> {
    let mut columns = Vec::new();
    columns.extend(POINTS.iter().flat_map(|p| p[0].to_le_bytes()));
    columns.extend(POINTS.iter().flat_map(|_| [7, 0, 8, 0]));
    columns.extend(POINTS.iter().flat_map(|p| p[1].to_le_bytes()));
    columns.extend(POINTS.iter().flat_map(|p| f64::from(p[2]).to_le_bytes()));
    let packed: Vec<u8> = columns
        .chunks(32)
        .flat_map(|run| std::iter::once(run.len() as u8 - 1).chain(run.iter().copied()))
        .collect();
    let mut bytes = pcd_header(6, 1, 6, "binary_compressed").into_bytes();
    bytes.extend((packed.len() as u32).to_le_bytes());
    bytes.extend((columns.len() as u32).to_le_bytes());
    bytes.extend(packed);
    bytes
}

pub fn ply(format: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {format} 1.0\ncomment made by a test\nelement camera 1\n\
         property list uchar short size\nelement vertex 6\nproperty double x\n\
         property float y\nproperty uchar red\nproperty float z\nelement face 1\n\
         property list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    match format {
        "ascii" => {
            bytes.extend(b"2 640 480\n");
            for [x, y, z] in POINTS {
                bytes.extend(format!("{x} {y} 200 {z}\n").bytes());
            }
            bytes.extend(b"3 0 1 3\n");
        }
        _ => {
            let big = format == "binary_big_endian";
            let mut word = |le: &[u8]| {
                let mut word = le.to_vec();
                if big {
                    word.reverse();
                }
                bytes.extend(word);
            };
            word(&[2]);
            word(&640_i16.to_le_bytes());
            word(&480_i16.to_le_bytes());
            for [x, y, z] in POINTS {
                word(&f64::from(x).to_le_bytes());
                word(&y.to_le_bytes());
                word(&[200]);
                word(&z.to_le_bytes());
            }
            word(&[3]);
            (0..3).for_each(|i: i32| word(&i.to_le_bytes()));
        }
    }
    bytes
}

pub fn png(width: u32, height: u32, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(depth);
    encoder
        .write_header()
        .unwrap()
        .write_image_data(data)
        .unwrap();
    bytes
}

/// A 64 × 48 image: 1 m on the left, nothing on the right.
pub fn depth_png() -> Vec<u8> {
    let row = (0..64_u16).flat_map(|u| if u < 32 { 1000_u16 } else { 0 }.to_be_bytes());
    let row: Vec<u8> = row.collect();
    png(64, 48, png::BitDepth::Sixteen, &row.repeat(48))
}

/// The image of [`depth_png`] as numpy saves it.
pub fn npy(descr: &str, fortran: bool, element: impl Fn(u16) -> Vec<u8>) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let header = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': (48, 64), }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    let of = |u: usize| element(if u < 32 { 1000 } else { 0 });
    bytes.extend((0..48 * 64).flat_map(|i| of(if fortran { i / 48 } else { i % 64 })));
    bytes
}

/// Arrays as numpy saves them together.
pub fn npz(arrays: &[(&str, &[u8])], method: CompressionMethod) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(method);
    for (name, bytes) in arrays {
        archive.start_file(format!("{name}.npy"), options).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// An image of 64 × 48.
pub fn tiff<C: ColorType>(pixels: &[C::Inner]) -> Vec<u8>
where
    [C::Inner]: TiffValue,
{
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file).unwrap();
    encoder.write_image::<C>(64, 48, pixels).unwrap();
    file.into_inner()
}

pub fn las(minor: u8, offset: f64) -> Vec<u8> {
    let mut bytes = vec![0; if minor < 4 { 227 } else { 375 }];
    let start = bytes.len() as u32;
    bytes[..4].copy_from_slice(b"LASF");
    bytes[25] = minor;
    bytes[96..100].copy_from_slice(&start.to_le_bytes());
    bytes[105..107].copy_from_slice(&28_u16.to_le_bytes());
    if minor < 4 {
        bytes[107..111].copy_from_slice(&4_u32.to_le_bytes());
    } else {
        bytes[247..255].copy_from_slice(&4_u64.to_le_bytes());
    }
    for axis in 0..3 {
        bytes[131 + 8 * axis..][..8].copy_from_slice(&0.05_f64.to_le_bytes());
        bytes[155 + 8 * axis..][..8].copy_from_slice(&offset.to_le_bytes());
    }
    for point in expected() {
        bytes.extend(
            point
                .iter()
                .flat_map(|c| ((c * 20.0).round() as i32).to_le_bytes()),
        );
        bytes.extend([0; 16]);
    }
    bytes
}

pub fn e57() -> Vec<u8> {
    use e57::{Record, RecordValue};
    let fields = vec![
        Record::CARTESIAN_X_F32,
        Record::CARTESIAN_Y_F32,
        Record::CARTESIAN_Z_F32,
    ];
    e57_of(&["far", "near"], &fields, RecordValue::Single)
}

pub fn e57_of(
    names: &[&str],
    fields: &[e57::Record],
    value: impl Fn(f32) -> e57::RecordValue,
) -> Vec<u8> {
    let mut file = std::io::Cursor::new(Vec::new());
    let mut writer = e57::E57Writer::new(&mut file, "file").unwrap();
    for name in names {
        let mut points = writer.add_pointcloud(name, fields.to_vec()).unwrap();
        points.set_name(Some((*name).into()));
        let [w, x, y, z] = [0.5; 4];
        points.set_transform(Some(e57::Transform {
            rotation: e57::Quaternion { w, x, y, z },
            translation: e57::Translation {
                x: 1.0,
                y: 2.0,
                z: 3.0,
            },
        }));
        for point in POINTS {
            points.add_point(point.map(&value).into()).unwrap();
        }
        points.finalize().unwrap();
    }
    writer.finalize().unwrap();
    drop(writer);
    file.into_inner()
}

/// Every page of an E57 file with its true sum, so that what is changed in it is read.
pub fn resealed(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.resize(bytes.len().next_multiple_of(1024), 0);
    for page in bytes.chunks_exact_mut(1024) {
        let (data, sum) = page.split_at_mut(1020);
        let crc = !data.iter().fold(!0, |crc: u32, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |c, _| {
                (c >> 1) ^ (0x82f6_3b78 & (c & 1).wrapping_neg())
            })
        });
        sum.copy_from_slice(&crc.to_be_bytes());
    }
    bytes
}
