//! Lines of numbers → points: XYZ, CSV, ASC, PTS and what else begins each line with x, y and z.
//!
//! Columns are parted by commas, semicolons, tabs or spaces. Where a line of names stands before the numbers, as
//! CloudCompare and pandas write it, x, y and z are the columns of these names; else the first three.

use std::path::Path;

use crate::Error;

/// Whether files of this extension, in lower case, are lines of numbers.
pub(super) fn is_text(extension: &str) -> bool {
    ["xyz", "csv", "txt", "asc", "pts"].contains(&extension)
}

/// The points, m or what the file's coordinates are in.
///
/// # Errors
/// [`Error::File`] naming the line that has no three numbers; no text; a header without x, y and z.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Vec<[f64; 3]>, Error> {
    let text = std::str::from_utf8(bytes);
    let text = text.map_err(|cause| Error::file(path, format!("is no text: {cause}")))?;
    let text = text.trim_start_matches('\u{feff}');
    let mut columns = [0, 1, 2];
    let mut points = Vec::with_capacity(text.len() / 32);
    let mut is_header = true;
    for (line, number) in text.lines().zip(1_usize..) {
        let fields = || {
            line.split([',', ';', ' ', '\t', '\r'])
                .filter(|field| !field.is_empty())
        };
        let values: [Option<f64>; 3] = columns.map(|k| fields().nth(k)?.parse().ok());
        if let [Some(x), Some(y), Some(z)] = values {
            points.push([x, y, z]);
            is_header = false;
            continue;
        }
        // A comment, nothing, or the number of points that PTS begins with.
        let mut all = fields();
        let is_count = all.next().is_some_and(|n| n.parse::<u64>().is_ok()) && all.next().is_none();
        let named = ["x", "y", "z"].map(|name| names(line).position(|field| field == name));
        if let ([Some(x), Some(y), Some(z)], true) = (named, is_header) {
            (columns, is_header) = ([x, y, z], false);
        } else if !(is_count || line.trim().is_empty() || line.starts_with(['#', '/'])) {
            let cause =
                "has no three numbers x, y, z; their columns may be named in the first line";
            return Err(Error::field(path, format_args!("line {number}"), cause));
        }
    }
    Ok(points)
}

/// The names of columns in a line, in lower case, without quotes and the marks of a comment.
fn names(line: &str) -> impl Iterator<Item = String> {
    let line = line.trim_start_matches(['#', '/', ' ']);
    let fields = line
        .split([',', ';', ' ', '\t', '\r'])
        .filter(|field| !field.is_empty());
    fields.map(|field| field.trim_matches('"').to_ascii_lowercase())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Vec<[f64; 3]>, String> {
        parse(Path::new("a.xyz"), text.as_bytes()).map_err(|error| error.to_string())
    }

    #[test]
    fn lines_of_numbers_are_points_however_columns_are_parted_and_named() {
        let expected = vec![[1.0, -2.0, 0.5], [0.25, 3.0, 0.0]];
        for text in [
            "1 -2 0.5\n0.25 3 0\n",
            "1,-2,0.5\r\n0.25,3,0\r\n",
            "2\n1 -2 .5 120 10 20 30\n.25 3 0 90 1 2 3",
            "# made by\n\n1;-2;5e-1\n0.25;3;0",
            "//X Y Z R\n1 -2 0.5 7\n0.25 3 0 8\n",
            "\u{feff}\"i\",\"z\",\"x\",\"y\"\n0,0.5,1,-2\n1,0,0.25,3\n",
        ] {
            assert_eq!(of(text).unwrap(), expected, "{text}");
        }
    }

    #[test]
    fn a_line_that_is_no_point_is_named() {
        for (text, line) in [
            ("1 2 3\n4 5\n", 2),
            ("a b c\n1 2 3", 1),
            ("1 2 3\nx y z\n", 2),
        ] {
            let said = of(text).unwrap_err();
            assert!(said.contains(&format!("line {line}")), "{said}");
        }
        assert!(parse(Path::new("a.xyz"), &[0xff, 0xfe, 0]).is_err());
    }
}
