//! STL, binary and ASCII; equal corners become one vertex.

use std::collections::HashMap;
use std::str::FromStr;

use nalgebra::Point3;

use super::{TriangleMesh, check_count};

/// 80 bytes of header and a count.
const HEADER: usize = 84;
/// Normal, three corners, two bytes of attributes.
const RECORD: usize = 50;

/// The number of triangles that the header of a binary file announces.
fn count(bytes: &[u8]) -> Option<usize> {
    let counted = bytes.get(80..HEADER)?;
    let counted = <[u8; 4]>::try_from(counted).ok()?;
    Some(u32::from_le_bytes(counted) as usize)
}

/// The length decides, not the first word: many a binary file begins with "solid".
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    count(bytes).is_some_and(|n| bytes.len() - HEADER == n.saturating_mul(RECORD))
}

pub(super) fn parse(bytes: &[u8]) -> Result<TriangleMesh, String> {
    let count = count(bytes);
    let is_ascii = !is_binary(bytes) && bytes.trim_ascii_start().starts_with(b"solid");
    match count {
        _ if is_ascii && looks_like_text(bytes) => ascii(bytes),
        None => Err(format!("{} bytes are too few for an STL file", bytes.len())),
        Some(n) if n.saturating_mul(RECORD) > bytes.len() - HEADER => Err(format!(
            "its header announces {n} triangles, there are bytes for {} only",
            (bytes.len() - HEADER) / RECORD
        )),
        Some(n) => binary(&bytes[HEADER..], n),
    }
}

fn looks_like_text(bytes: &[u8]) -> bool {
    !bytes.iter().take(1000).any(|b| *b == 0 || *b >= 0x80)
}

fn binary(records: &[u8], count: usize) -> Result<TriangleMesh, String> {
    check_count("triangles", count)?;
    let mut welder = Welder::default();
    for (i, record) in records.chunks_exact(RECORD).take(count).enumerate() {
        let mut corners = record[12..48].chunks_exact(12).map(|corner| {
            let mut axes = corner.chunks_exact(4).map(|b| match *b {
                [a, b, c, d] => f64::from(f32::from_le_bytes([a, b, c, d])),
                _ => f64::NAN,
            });
            let mut next = || axes.next().unwrap_or(f64::NAN);
            Point3::new(next(), next(), next())
        });
        let mut next = || corners.next().unwrap_or_default();
        let triangle = [next(), next(), next()];
        welder
            .add(triangle)
            .map_err(|()| format!("triangle {i} has a corner that is not finite"))?;
    }
    Ok(welder.mesh)
}

/// Every three `vertex` lines are a triangle; that is all there is to know.
fn ascii(bytes: &[u8]) -> Result<TriangleMesh, String> {
    let text = String::from_utf8_lossy(bytes);
    let mut welder = Welder::default();
    let mut corners: Vec<Point3<f64>> = Vec::with_capacity(3);
    let mut is_closed = false;
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("vertex") => {
                let mut axis = || words.next().and_then(|word| f64::from_str(word).ok());
                let (Some(x), Some(y), Some(z)) = (axis(), axis(), axis()) else {
                    return Err(format!(
                        "line {}: a vertex has three coordinates",
                        number + 1
                    ));
                };
                corners.push(Point3::new(x, y, z));
            }
            Some("endloop") => {
                let Ok(triangle) = <[Point3<f64>; 3]>::try_from(std::mem::take(&mut corners))
                else {
                    return Err(format!("line {}: a facet has three vertices", number + 1));
                };
                welder
                    .add(triangle)
                    .map_err(|()| format!("line {}: a vertex is not finite", number + 1))?;
            }
            Some("endsolid") => is_closed = true,
            _ => {}
        }
    }
    if !corners.is_empty() || !is_closed {
        return Err(format!(
            "it ends after {} lines, within a facet or solid",
            text.lines().count()
        ));
    }
    Ok(welder.mesh)
}

/// Makes equal corners one vertex, numbered as they first come.
#[derive(Default)]
struct Welder {
    mesh: TriangleMesh,
    numbers: HashMap<[u64; 3], u32>,
}

impl Welder {
    fn add(&mut self, corners: [Point3<f64>; 3]) -> Result<(), ()> {
        if !corners.iter().flat_map(|p| p.iter()).all(|c| c.is_finite()) {
            return Err(());
        }
        let triangle = corners.map(|corner| {
            // Adding zero makes one of the two zeros.
            let key = [corner.x, corner.y, corner.z].map(|c| (c + 0.0).to_bits());
            *self.numbers.entry(key).or_insert_with(|| {
                self.mesh.vertices.push(corner);
                (self.mesh.vertices.len() - 1) as u32
            })
        });
        self.mesh.triangles.push(triangle);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one_triangle(header: &[u8]) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, b' ');
        bytes.extend(1_u32.to_le_bytes());
        for value in [
            0.0_f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.5,
        ] {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend([0, 0]);
        bytes
    }

    #[test]
    fn binary_is_read_even_where_it_begins_with_solid() {
        for header in [b"made by hand".as_slice(), b"solid part"] {
            let mesh = parse(&one_triangle(header)).unwrap();
            assert_eq!(mesh.triangles, [[0, 1, 2]]);
            assert_eq!(mesh.vertices[2], Point3::new(0.0, 1.0, 0.5));
        }
    }

    #[test]
    fn lying_headers_and_truncation_are_errors() {
        let mut lying = one_triangle(b"x");
        lying[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(parse(&lying).unwrap_err().contains("announces 4294967295"));
        let whole = one_triangle(b"x");
        assert!(
            parse(&whole[..whole.len() - 1])
                .unwrap_err()
                .contains("bytes for 0 only")
        );
        assert!(parse(&whole[..40]).unwrap_err().contains("too few"));
        let mut foul = one_triangle(b"x");
        foul[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(parse(&foul).unwrap_err().contains("triangle 0"));
    }

    #[test]
    fn ascii_is_read_and_its_corners_are_welded() {
        let facet = |z: &str| {
            format!(
                "facet normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1e0 0 0\n \
                 vertex 0 1 {z}\n endloop\nendfacet\n"
            )
        };
        let text = format!("solid s\n{}{}endsolid s\n", facet("0"), facet("2.5"));
        let mesh = parse(text.as_bytes()).unwrap();
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (4, 2));
        let cut = &text[..text.len() - 30];
        assert!(parse(cut.as_bytes()).unwrap_err().contains("ends after"));
        let bad = text.replace("1e0", "one");
        assert!(parse(bad.as_bytes()).unwrap_err().contains("line 5"));
    }
}
