//! RSDF: the contact surfaces that robots of mc_rtc ship with.

use nalgebra::{Isometry3, Point2, UnitQuaternion, Vector3};

use crate::Error;
use crate::xml::{Source, child, children};

/// A planar surface of a link.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Its name.
    pub name: String,
    /// The file it is in.
    pub file: String,
    /// The link.
    pub link: String,
    /// Pose of its frame in the link: z out of what it touches.
    pub X_LC: Isometry3<f64>,
    /// Its outline, counter-clockwise, m.
    pub polygon: Vec<Point2<f64>>,
}

/// The planar surfaces of an RSDF; of grippers and cylinders it holds no outline.
///
/// # Errors
/// [`Error::File`] with the line.
pub fn surfaces(file: &str, text: &str) -> Result<Vec<Surface>, Error> {
    let source = Source::parse(file, text)?;
    let root = source.robot()?;
    let mut found = Vec::new();
    for node in children(root, "planar_surface") {
        let three = |name: &str| -> Result<[f64; 3], Error> {
            let Some(origin) = child(node, "origin") else {
                return Ok([0.0; 3]);
            };
            let text = source.numbers(origin, name, 3)?.unwrap_or("0 0 0");
            let mut numbers = text.split_whitespace().filter_map(|w| w.parse().ok());
            Ok([0; 3].map(|_| numbers.next().unwrap_or(0.0)))
        };
        let [roll, pitch, yaw] = three("rpy")?;
        let mut polygon = Vec::new();
        for point in child(node, "points")
            .into_iter()
            .flat_map(|p| children(p, "point"))
        {
            let text = source.numbers(point, "xy", 2)?.unwrap_or("0 0");
            let mut numbers = text.split_whitespace().filter_map(|w| w.parse().ok());
            polygon.push(Point2::new(
                numbers.next().unwrap_or(0.0),
                numbers.next().unwrap_or(0.0),
            ));
        }
        if super::flat::doubled_area(&polygon) < 0.0 {
            polygon.reverse();
        }
        found.push(Surface {
            name: source.text(node, "name")?.to_owned(),
            file: file.rsplit('/').next().unwrap_or(file).to_owned(),
            link: source.text(node, "link")?.to_owned(),
            X_LC: Isometry3::from_parts(
                Vector3::from(three("xyz")?).into(),
                UnitQuaternion::from_euler_angles(roll, pitch, yaw),
            ),
            polygon,
        });
    }
    Ok(found)
}
