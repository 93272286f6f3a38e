//! Readers: every encoding gives the same points, and headers that lie are named.

use std::path::Path;

use perception::{Error, Scan, SensorOptions, is_depth_image, parse_scan, read_scan};
use tiff::encoder::colortype::{Gray8, Gray16, Gray32Float};
use zip::CompressionMethod;

use crate::scan_files::*;

fn parse(name: &str, bytes: &[u8]) -> Result<Scan, Error> {
    parse_scan(Path::new(name), bytes, &SensorOptions::default())
}

/// The message of the error, which always begins with the file's name.
fn refusal(name: &str, bytes: &[u8]) -> String {
    let message = parse(name, bytes).unwrap_err().to_string();
    assert!(message.starts_with(name), "{message}");
    message
}

fn finite(scan: &Scan) -> Vec<[f32; 3]> {
    scan.cloud.finite().copied().collect()
}

#[test]
fn every_encoding_of_pcd_gives_the_same_points_and_viewpoint() {
    for bytes in [pcd_ascii(), pcd_binary(6, 1), pcd_compressed()] {
        let scan = parse("a.pcd", &bytes).unwrap();
        assert_eq!(finite(&scan), expected());
        assert_eq!(scan.cloud.points.len(), 4);
        assert_eq!((scan.cloud.invalid, scan.cloud.organised), (2, None));
        let [x, y, z] = [1.0, 0.0, 0.0];
        // w x y z = ½ ½ ½ ½ turns x to y.
        let moved = scan.X_WV * nalgebra::Point3::new(x, y, z);
        assert!((moved - nalgebra::Point3::new(1.0, 3.0, 3.0)).norm() < 1e-12);
    }
    let organised = parse("a.pcd", &pcd_binary(3, 2)).unwrap();
    assert_eq!(organised.cloud.organised, Some((3, 2)));
    assert_eq!(organised.cloud.points.len(), 6);
    assert!(organised.cloud.points[4].iter().all(|c| c.is_nan()));
    assert!(organised.depth.is_none());
}

#[test]
fn every_encoding_of_ply_gives_the_same_points() {
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let scan = parse("a.ply", &ply(format)).unwrap();
        assert_eq!(finite(&scan), expected(), "{format}");
        assert_eq!(scan.cloud.invalid, 2, "{format}");
    }
}

#[test]
fn a_depth_png_gives_metres_points_and_scaled_intrinsics() {
    let options = SensorOptions {
        depth_scale_m: Some(0.002),
        ..SensorOptions::default()
    };
    let scan = parse_scan(Path::new("a.png"), &depth_png(), &options).unwrap();
    let depth = scan.depth.unwrap();
    assert_eq!((depth.width, depth.height), (64, 48));
    assert_eq!((depth.z_m[0], depth.z_m[40]), (2.0, 0.0));
    assert_eq!(depth.intrinsics.fx, 52.5);
    assert_eq!(scan.cloud.organised, Some((64, 48)));
    assert_eq!(scan.cloud.invalid, 32 * 48);
    let [x, y, z] = scan.cloud.points[0];
    let k = depth.intrinsics;
    assert!((f64::from(x) + 2.0 * k.cx / k.fx).abs() < 1e-6);
    assert!((f64::from(y) + 2.0 * k.cy / k.fy).abs() < 1e-6);
    assert_eq!(z, 2.0);
}

#[test]
fn a_depth_array_is_the_depth_image_it_came_from() {
    let image = parse("a.png", &depth_png()).unwrap();
    let le = |z: u16| z.to_le_bytes().to_vec();
    let metres = |z: u16| (f32::from(z) * 1e-3).to_be_bytes().to_vec();
    for bytes in [
        npy("<u2", false, le),
        npy("<u2", true, le),
        npy(">f4", false, metres),
        npy("<f8", true, |z| {
            (f64::from(z) * 1e-3).to_le_bytes().to_vec()
        }),
    ] {
        assert_eq!(parse("a.npy", &bytes).unwrap().depth, image.depth);
    }
    // An array of three columns is a cloud.
    let mut bytes = npy("<f4", false, |z| {
        (f32::from(z) * 1e-3 + 1.0).to_le_bytes().to_vec()
    });
    let at = bytes.windows(8).position(|w| w == b"(48, 64)").unwrap();
    bytes[at..at + 8].copy_from_slice(b"(999, 3)");
    let scan = parse("a.npy", &bytes).unwrap();
    assert!(scan.depth.is_none() && scan.cloud.points.len() == 999);
    assert_eq!(scan.cloud.points[0], [2.0; 3]);
    // With colours or normals, too, and in either order of numpy's.
    let point = |i: usize| [i as f32, 0.5, -1.0];
    let points: Vec<[f32; 3]> = (0..40).map(point).collect();
    let row = |i: usize| [point(i), [0.1; 3]].concat();
    let rows = (0..40).flat_map(row).collect::<Vec<f32>>();
    let columns = (0..6).flat_map(|c| (0..40).map(move |i| row(i)[c]));
    for (fortran, values) in [(false, rows.clone()), (true, columns.collect())] {
        let scan = parse("a.npy", &floats("(40, 6)", fortran, &values)).unwrap();
        assert_eq!((scan.depth, scan.cloud.points), (None, points.clone()));
    }
    // Rows × columns × 3 are an organised cloud, with its image where a pinhole made it.
    let flat: Vec<f32> = image.cloud.points.iter().flatten().copied().collect();
    let scan = parse("a.npy", &floats("(48, 64, 3)", false, &flat)).unwrap();
    assert_eq!(scan.cloud.organised, Some((64, 48)));
    assert_eq!(scan.depth.unwrap().z_m, image.depth.as_ref().unwrap().z_m);
    let text = |from: &str, to: &str| {
        let bytes = npy("<u2", false, le);
        let at = bytes
            .windows(from.len())
            .position(|w| w == from.as_bytes())
            .unwrap();
        let mut bytes = bytes;
        bytes[at..at + from.len()].copy_from_slice(to.as_bytes());
        bytes
    };
    for (bytes, said) in [
        (text("<u2", "|b1"), "descr: |\"b1\" is none of"),
        (
            text("(48, 64)", "(9,9, 9)"),
            "shape: [9, 9, 9] is neither a depth image's",
        ),
        (
            text("(48, 64)", "(48,965)"),
            "shape: [48, 965] of u2 cannot be in 6144 bytes",
        ),
        (text("'shape'", "'shepe'"), "shape: is missing"),
        (
            npy("<u2", false, le)[..20].to_vec(),
            "header: ends in the middle",
        ),
    ] {
        let message = refusal("a.npy", &bytes);
        assert!(message.contains(said), "{message}");
    }
}

/// An array of float32 as numpy saves it.
fn floats(shape: &str, fortran: bool, values: &[f32]) -> Vec<u8> {
    let mut bytes = npy("<f4", fortran, |_| Vec::new());
    let at = bytes.windows(8).position(|w| w == b"(48, 64)").unwrap();
    bytes.splice(at..at + 8, shape.bytes());
    let length = bytes.len() as u16 - 10;
    bytes[8..10].copy_from_slice(&length.to_le_bytes());
    bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

#[test]
fn of_arrays_saved_together_the_one_that_may_be_a_scan_is_read() {
    let image = parse("a.png", &depth_png()).unwrap();
    let depth = npy("<u2", false, |z| z.to_le_bytes().to_vec());
    let (k, points) = (floats("(3, 3)", false, &[1.0; 9]), [2.0; 300]);
    let points = floats("(100, 3)", false, &points);
    for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
        let file = npz(&[("depth", &depth), ("K", &k)], method);
        let scan = parse("a.npz", &file).unwrap();
        assert_eq!(scan.depth, image.depth);
        assert_eq!(scan.notes, ["a.npz: array depth"]);
    }
    let file = npz(
        &[("depth", &depth), ("points", &points)],
        CompressionMethod::Stored,
    );
    let said = refusal("a.npz", &file);
    assert!(
        said.contains("several of its arrays (depth, points)"),
        "{said}"
    );
    let mut options = SensorOptions::default();
    options.bag.topic = Some("points".into());
    let scan = parse_scan(Path::new("a.npz"), &file, &options).unwrap();
    assert_eq!(scan.cloud.points.len(), 100);
    for (topic, is_image) in [(None, true), (Some("depth"), true), (Some("points"), false)] {
        assert_eq!(is_depth_image(Path::new("a.npz"), &file, topic), is_image);
    }
    options.bag.topic = Some("nothing".into());
    assert!(parse_scan(Path::new("a.npz"), &file, &options).is_err());
}

#[test]
fn tiff_gives_the_depths_of_the_png() {
    let image = parse("a.png", &depth_png()).unwrap();
    let units = (0..48 * 64).map(|i| if i % 64 < 32 { 1000_u16 } else { 0 });
    let units: Vec<u16> = units.collect();
    let metres: Vec<f32> = units.iter().map(|z| f32::from(*z) * 1e-3).collect();
    for bytes in [tiff::<Gray16>(&units), tiff::<Gray32Float>(&metres)] {
        assert_eq!(parse("a.tif", &bytes).unwrap().depth, image.depth);
    }
    let said = refusal("a.tif", &tiff::<Gray8>(&[7; 48 * 64]));
    assert!(said.contains("this is Gray(8)"), "{said}");
    assert!(refusal("a.tif", b"II*\0\x08\0\0\0").contains("TIFF file"));
}

#[test]
fn an_eye_among_the_points_goes_before_their_viewpoint() {
    let stated = parse("a.pcd", &pcd_ascii()).unwrap();
    assert_eq!(stated.X_WV.translation.vector.as_slice(), [1.0, 2.0, 3.0]);
    assert!(
        stated.notes[0].contains("--eye 1,2,3"),
        "{:?}",
        stated.notes
    );
    let options = SensorOptions {
        eye_m: Some([1.0, 2.0, 3.0]),
        ..SensorOptions::default()
    };
    let scan = parse_scan(Path::new("a.pcd"), &pcd_ascii(), &options).unwrap();
    assert_eq!(scan.X_WV, nalgebra::Isometry3::identity());
    assert!(
        scan.notes[0].contains("moves no points"),
        "{:?}",
        scan.notes
    );
}

#[test]
fn surveys_are_read_near_their_origin_and_in_their_scanners_frames() {
    for minor in [2, 4] {
        let scan = parse("a.las", &las(minor, 0.0)).unwrap();
        assert_eq!(finite(&scan), expected());
        assert!(scan.notes.is_empty());
    }
    // Coordinates of a map: counted from the least, in whole metres.
    let scan = parse("a.las", &las(2, 5e5)).unwrap();
    assert!(
        scan.notes[0].contains("counted from 499999, 499999, 500000"),
        "{:?}",
        scan.notes
    );
    for (near, point) in finite(&scan).iter().zip(expected()) {
        assert!((near[0] - point[0] - 1.0).abs() < 1e-6 && near[2] == point[2]);
    }
    let mut packed = las(2, 0.0);
    packed[104] = 0x83;
    assert!(refusal("a.las", &packed).contains("packed (LAZ)"));
    let mut many = las(2, 0.0);
    many[107..111].fill(255);
    assert!(refusal("a.las", &many).contains("4294967295 of 28 bytes cannot be in 112 bytes"));

    assert!(
        refusal("a.e57", &e57())
            .contains("2 scans; name one of them as topic: 0 \"far\", 1 \"near\"")
    );
    // Points that take no byte of the file could be any number.
    let fields = [
        e57::RecordName::CartesianX,
        e57::RecordName::CartesianY,
        e57::RecordName::CartesianZ,
    ];
    let fields = fields.map(|name| e57::Record {
        name,
        data_type: e57::RecordDataType::Integer { min: 5, max: 6 },
    });
    let mut constant = e57_of(&["one"], &fields, |_| e57::RecordValue::Integer(5));
    let most = b"maximum=\"6\"";
    while let Some(at) = constant.windows(most.len()).position(|w| w == most) {
        constant[at + most.len() - 2] = b'5';
    }
    assert!(
        refusal("a.e57", &resealed(constant)).contains("3 fields without coordinates that vary")
    );
    for topic in ["near", "1"] {
        let mut options = SensorOptions::default();
        options.bag.topic = Some(topic.into());
        let scan = parse_scan(Path::new("a.e57"), &e57(), &options).unwrap();
        assert_eq!((finite(&scan), scan.cloud.invalid), (expected(), 2));
        let moved = scan.X_WV * nalgebra::Point3::new(1.0, 0.0, 0.0);
        assert!((moved - nalgebra::Point3::new(1.0, 3.0, 3.0)).norm() < 1e-9);
    }
}

#[test]
fn the_first_bytes_name_the_format_before_the_extension_does() {
    assert_eq!(
        finite(&parse("cloud.png", &ply("ascii")).unwrap()),
        expected()
    );
    assert_eq!(
        finite(&parse("cloud.bin", &pcd_binary(6, 1)).unwrap()),
        expected()
    );
    assert_eq!(
        finite(&parse("cloud.xyz", b"1 2 3").unwrap()),
        [[1.0, 2.0, 3.0]]
    );
    assert!(refusal("cloud.bin", b"1 2 3").contains("unknown scan format"));
}

#[test]
fn lying_headers_are_named() {
    let with = |from: &str, to: &str| {
        let text = pcd_header(6, 1, 6, "binary");
        assert!(text.contains(from), "{from}");
        let body = pcd_binary(6, 1)[text.len()..].to_vec();
        [text.replace(from, to).into_bytes(), body].concat()
    };
    for (from, to, field) in [
        ("POINTS 6", "POINTS 7", "POINTS: 7 is not WIDTH × HEIGHT"),
        ("WIDTH 6\nHEIGHT 1", "WIDTH 3\nHEIGHT 3", "POINTS: 6 is not"),
        ("WIDTH 6", "WIDTH 18446744073709551615", "POINTS: 6 is not"),
        (
            "WIDTH 6\nHEIGHT 1\nVIEWPOINT 1 2 3 0.5 0.5 0.5 0.5\nPOINTS 6",
            "WIDTH 4000000000\nHEIGHT 1\nVIEWPOINT 1 2 3 0.5 0.5 0.5 0.5\nPOINTS 4000000000",
            "POINTS: 4000000000 points need 80000000000 bytes, 120 follow",
        ),
        (
            "COUNT 1 2 1 1",
            "COUNT 1 4294967295 1 1",
            "COUNT: a point is longer",
        ),
        ("COUNT 1 2 1 1", "COUNT 2 2 1 1", "COUNT: x occurs 2×"),
        (
            "FIELDS x intensity y z",
            "FIELDS x intensity y w",
            "FIELDS: has no z",
        ),
        ("0.5 0.5 0.5 0.5", "0 0 0 0", "VIEWPOINT"),
        ("1 2 3 0.5", "NaN 2 3 0.5", "VIEWPOINT"),
        ("SIZE 4 2 4 8", "SIZE 4 2 4", "PCD file"),
        ("TYPE F U F F", "TYPE F U F Q", "PCD file"),
        ("DATA binary", "DATA packed", "PCD file"),
    ] {
        let message = refusal("lie.pcd", &with(from, to));
        assert!(message.contains(field), "{message}");
    }
    let huge = with("POINTS 6", "POINTS 6").len() - 1;
    assert!(refusal("cut.pcd", &pcd_binary(6, 1)[..huge]).contains("6 points need 120 bytes"));
    // Compressed: the sizes before the block.
    let header = pcd_header(6, 1, 6, "binary_compressed").len();
    for (at, value, field) in [
        (0, u32::MAX, "DATA: 4294967295 compressed bytes stated"),
        (4, u32::MAX, "unpack to 4294967295, 6 points are 120"),
    ] {
        let mut bytes = pcd_compressed();
        bytes[header + at..header + at + 4].copy_from_slice(&value.to_le_bytes());
        assert!(refusal("lie.pcd", &bytes).contains(field));
    }
    assert!(refusal("cut.pcd", &pcd_compressed()[..header + 5]).contains("DATA: ends before"));
    // PLY: counts against bytes.
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let text = String::from_utf8_lossy(&ply(format)).into_owned();
        let lie = text.replace("element vertex 6", "element vertex 4000000000");
        let message = refusal("lie.ply", lie.as_bytes());
        assert!(
            message.contains("element vertex: 4000000000 of them"),
            "{message}"
        );
    }
    let lie = String::from_utf8_lossy(&ply("ascii")).replace("float z", "float w");
    assert!(refusal("lie.ply", lie.as_bytes()).contains("element vertex: has no scalar z"));
    let lie = String::from_utf8_lossy(&ply("ascii")).replace("vertex 6", "vertex 9");
    assert!(refusal("lie.ply", lie.as_bytes()).contains("element vertex"));
    let empty = "ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\n\
                 property float y\nproperty float z\nend_header\n";
    assert!(refusal("no.ply", empty.as_bytes()).contains("no valid point"));
    // A first element that takes no bytes must not be read four billion times.
    let idle = empty.replace("element vertex", "element idle 4000000000\nelement vertex");
    assert!(refusal("idle.ply", idle.as_bytes()).contains("element idle: 4000000000"));
    // PNG: another depth, and a header that promises what the file cannot hold.
    let eight = png(4, 4, png::BitDepth::Eight, &[9; 16]);
    assert!(refusal("a.png", &eight).contains("IHDR: a depth image is 16-bit grey"));
    let mut lie = depth_png();
    lie[16..24].copy_from_slice(&[0, 0, 0x60, 0, 0, 0, 0x60, 0]);
    let sum = crc32fast::hash(&lie[12..29]);
    lie[29..33].copy_from_slice(&sum.to_be_bytes());
    let message = refusal("a.png", &lie);
    assert!(
        message.contains("IHDR: 24576x24576 pixels cannot be in"),
        "{message}"
    );
    let cut = depth_png();
    assert!(refusal("a.png", &cut[..cut.len() / 2]).contains("PNG file"));
}

#[test]
fn a_cloud_without_a_valid_point_is_refused_by_name() {
    let header = pcd_header(2, 1, 2, "ascii");
    let all_nan = header.clone() + "nan 0 0 nan nan\nnan 0 0 nan nan\n";
    assert!(refusal("nan.pcd", all_nan.as_bytes()).contains("no valid point (2 read"));
    let none = pcd_header(0, 0, 0, "binary");
    assert!(refusal("none.pcd", none.as_bytes()).contains("no valid point (0 read"));
    let dark = png(8, 6, png::BitDepth::Sixteen, &[0; 96]);
    assert!(refusal("dark.png", &dark).contains("no valid point (48 read"));
    assert!(refusal("empty.pcd", b"").contains("PCD file"));
}

#[test]
fn a_missing_file_and_bad_options_are_named() {
    let missing = Path::new("no/such/scan.pcd");
    let error = read_scan(missing, &SensorOptions::default()).unwrap_err();
    assert!(
        error.to_string().starts_with("no/such/scan.pcd: "),
        "{error}"
    );
    let with = |options: SensorOptions| {
        parse_scan(Path::new("a.png"), &depth_png(), &options)
            .unwrap_err()
            .to_string()
    };
    let sensor = |name: &str| SensorOptions {
        sensor: name.into(),
        ..SensorOptions::default()
    };
    assert!(with(sensor("kinect")).contains("known are xtion, kinect_v1"));
    assert!(with(sensor("kinect_v2")).contains("no intrinsics for 64x48"));
    assert!(
        with(SensorOptions {
            depth_scale_m: Some(0.0),
            ..sensor("xtion")
        })
        .starts_with("depth_scale_m = 0")
    );
    assert!(
        with(SensorOptions {
            eye_m: Some([f64::NAN; 3]),
            ..sensor("xtion")
        })
        .starts_with("eye_m")
    );
}

#[test]
fn an_organised_cloud_in_its_optical_frame_takes_the_organised_path() {
    let world = [crate::support::block(
        "wall",
        [2.1, 0.0, 1.0],
        [0.2, 9.0, 9.0],
        0.0,
        0.0,
    )];
    let pose = crate::support::camera(1.0, 0.0);
    let scan = crate::support::scan(&world, &pose, false, 0);
    let mut bytes = b"VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 640\n\
        HEIGHT 480\nPOINTS 307200\nDATA binary\n"
        .to_vec();
    bytes.extend(
        scan.cloud
            .points
            .iter()
            .flatten()
            .flat_map(|c| c.to_le_bytes()),
    );
    let again = parse("wall.pcd", &bytes).unwrap();
    let depth = again.depth.unwrap();
    assert!(
        (depth.intrinsics.fx - 525.0).abs() < 0.01,
        "{:?}",
        depth.intrinsics
    );
    assert_eq!(depth.z_m, scan.depth.unwrap().z_m);
}
