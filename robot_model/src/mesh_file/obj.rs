//! Wavefront OBJ: vertices and faces; polygons become fans.

use std::str::FromStr;

use nalgebra::Point3;

use super::{TriangleMesh, check_count};

pub(super) fn parse(bytes: &[u8]) -> Result<TriangleMesh, String> {
    let text = String::from_utf8_lossy(bytes);
    let mut mesh = TriangleMesh::default();
    // A backslash at its end carries a line on.
    let mut carried = String::new();
    for (number, line) in text.lines().enumerate() {
        let line = match line.trim_end().strip_suffix('\\') {
            Some(part) => {
                carried.push_str(part);
                carried.push(' ');
                continue;
            }
            None if carried.is_empty() => line,
            None => {
                carried.push_str(line);
                carried.as_str()
            }
        };
        statement(line, &mut mesh).map_err(|cause| format!("line {}: {cause}", number + 1))?;
        carried.clear();
    }
    Ok(mesh)
}

fn statement(line: &str, mesh: &mut TriangleMesh) -> Result<(), String> {
    let mut words = line.split_ascii_whitespace();
    match words.next() {
        Some("v") => {
            let mut axis = || {
                let value = words.next().and_then(|word| f64::from_str(word).ok());
                value.filter(|v| v.is_finite())
            };
            let (Some(x), Some(y), Some(z)) = (axis(), axis(), axis()) else {
                return Err("a vertex has three finite coordinates".to_owned());
            };
            mesh.vertices.push(Point3::new(x, y, z));
            check_count("vertices", mesh.vertices.len())
        }
        Some("f") => {
            let corners = words
                .map(|word| corner(word, mesh.vertices.len()))
                .collect::<Result<Vec<u32>, _>>()?;
            mesh.add_face(&corners)
        }
        _ => Ok(()),
    }
}

/// The vertex of "7", "7/1", "7/1/3", "7//3" or, counted backward, "-1".
fn corner(word: &str, vertices: usize) -> Result<u32, String> {
    let number = word.split('/').next().unwrap_or_default();
    let index = i64::from_str(number).map_err(|_| format!("\"{word}\" is no vertex number"))?;
    let position = if index < 0 {
        index.saturating_add(vertices as i64)
    } else {
        index - 1
    };
    match u32::try_from(position) {
        Ok(position) if (position as usize) < vertices && index != 0 => Ok(position),
        _ => Err(format!(
            "there is no vertex {index} among the {vertices} so far"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::super::CORNERS_MAX;
    use super::*;

    #[test]
    fn polygons_and_backward_numbers_are_read() {
        let text = "# square\nv 0 0 0\nv 1 0 0\nv 1 1 0 1.0\nv 0 1 0\nvn 0 0 1\n\
                    f 1//1 2//1 \\\n 3//1 4//1\nf -4/1 -3/2 -2/3\n";
        let mesh = parse(text.as_bytes()).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    }

    #[test]
    fn a_face_of_more_corners_than_any_has_is_refused() {
        let corners = |n: usize| "v 0 0 0\n".repeat(n) + "f" + &" -1".repeat(n);
        assert!(parse(corners(CORNERS_MAX).as_bytes()).is_ok());
        let error = parse(corners(CORNERS_MAX + 1).as_bytes()).unwrap_err();
        assert!(error.contains("1001 corners"), "{error}");
    }

    #[test]
    fn a_line_among_the_faces_is_none() {
        let mesh = parse(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2\nf 1 2 3\n").unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn bad_faces_name_their_line() {
        let vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
        for bad in [
            "f 1 2 4",
            "f 0 1 2",
            "f",
            "f a b c",
            "f -4 1 2",
            "v 1 2",
            "v 1 2 inf",
        ] {
            let error = parse(format!("{vertices}{bad}\n").as_bytes()).unwrap_err();
            assert!(error.starts_with("line 4:"), "{bad}: {error}");
        }
    }
}
