//! Faces that were found in a frame against those that stand there.
//!
//! The definitions of `benches/peers/surfaces/score.py`: a face of the world is found where its
//! pixels and those of a found plane overlap by half of their union (or four fifths), and a found
//! plane is right where it is some face's. Faces count from 500 pixels within 5 m on. As the command
//! line tells of no pixels, one belongs to the plane in whose outline it meets it nearest to what was
//! measured there, within the noise.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Point2, Point3, UnitQuaternion, Vector3};
use scenes::Face;
use scenes::simulator::DepthNoise;
use surfaces::outline::Outline;

use crate::found::Found;
use crate::frames::{Frame, groups, ray};

const RANGE_M: f64 = 5.0;
const PIXELS_MIN: usize = 500;
/// Cells in which what was seen of a face is counted, m.
const PITCH_M: f64 = 0.01;

/// Counts over any number of frames.
#[derive(Clone, Debug, Default)]
pub struct Score {
    /// Faces that stand there.
    pub faces: usize,
    /// Of them found, by half of the union and by four fifths.
    pub found: [usize; 2],
    /// Of them upward ones, and those found by half.
    pub tops: [usize; 2],
    /// Planes that the program found, and those that are some face's.
    pub planes: [usize; 2],
    /// Of every face found, how far its true points are from the plane: RMS, m.
    pub rms_m: Vec<f64>,
    /// Of upward faces found, after the insets: the area, and what of it is off the face, m².
    pub area_m2: [f64; 2],
    /// Of every upward face found, the part of what was seen of it that is touchable.
    pub cover: Vec<f64>,
}

/// A face of the world with the coplanar ones that it touches.
struct True<'a> {
    members: Vec<&'a Face>,
    pixels: Vec<usize>,
}

impl Score {
    /// Counts what was found in a frame.
    pub fn add(&mut self, frame: &Frame, found: &[Found]) {
        let points = points(frame);
        let label = labels(frame, &points, found);
        let mut size = vec![0; found.len()];
        label.iter().flatten().for_each(|k| size[*k] += 1);
        let counted: Vec<usize> = (0..found.len())
            .filter(|&k| size[k] >= PIXELS_MIN / 2)
            .collect();
        let mut right = BTreeSet::new();
        let all = frame.truth.faces();
        for truth in true_faces(frame, &all, &points) {
            let mut both = vec![0; found.len()];
            for &pixel in &truth.pixels {
                if let Some(k) = label[pixel] {
                    both[k] += 1;
                }
            }
            let overlap =
                |k: usize| both[k] as f64 / (truth.pixels.len() + size[k] - both[k]) as f64;
            let best = (counted.iter()).max_by(|a, b| overlap(**a).total_cmp(&overlap(**b)));
            let best = best.map_or((0.0, None), |&k| (overlap(k), Some(k)));
            let top = truth.members[0].normal_W.z > 0.9;
            self.faces += 1;
            self.found[1] += usize::from(best.0 >= 0.8);
            self.tops[0] += usize::from(top);
            if let (0.5.., Some(k)) = best {
                self.found[0] += 1;
                self.tops[1] += usize::from(top);
                right.insert(k);
                self.rms_m.push(rms(frame, &truth, &found[k]));
                if top {
                    self.touchable(frame, &truth, &found[k]);
                }
            }
        }
        self.planes[0] += counted.len();
        self.planes[1] += right.len();
    }

    /// Counts the area of what may be touched, what of it is off the face, and what of the seen it is.
    fn touchable(&mut self, frame: &Frame, truth: &True, found: &Found) {
        let X_GW = frame_of(truth.members[0]).inverse();
        let flat = |points: &[Point3<f64>]| {
            let ring = points.iter().map(|p| X_GW * p).map(|p| [p.x, p.y]);
            Outline::from_rings(&[ring.collect()])
        };
        let touchable = found.touchable.moved(&(X_GW * found.X_WF));
        let mut off = touchable.clone();
        for face in &truth.members {
            off = off.minus(&flat(&face.vertices_W));
        }
        // What stands on the face covers it.
        for body in frame.truth.boxes.iter() {
            let foot = |f: &Face| f.vertices_W.iter().all(|p| (X_GW * p).z.abs() < 1e-6);
            let stands = |f: &&Face| f.normal_W.dot(&truth.members[0].normal_W) < 0.0 && foot(f);
            if let Some(bottom) = body.faces().iter().find(stands) {
                let mut corners = bottom.vertices_W.clone();
                corners.reverse();
                off = off.union(&touchable.common(&flat(&corners)));
            }
        }
        self.area_m2[0] += touchable.area();
        self.area_m2[1] += off.area();
        let cell = |pixel: &usize| {
            let p = X_GW * exact(frame, *pixel);
            let at = |x: f64| (x / PITCH_M).floor() as i64;
            (at(p.x), at(p.y))
        };
        let seen: BTreeSet<(i64, i64)> = truth.pixels.iter().map(cell).collect();
        let middle = |k: i64| (k as f64 + 0.5) * PITCH_M;
        let within =
            |(i, j): &&(i64, i64)| touchable.contains(&Point2::new(middle(*i), middle(*j)));
        self.cover
            .push(seen.iter().filter(within).count() as f64 / seen.len() as f64);
    }
}

/// Of every pixel what was measured within range, in W.
fn points(frame: &Frame) -> Vec<Option<Point3<f64>>> {
    let point = |(i, mm): (usize, &u16)| {
        let p = ray(&frame.scan, i) * (f64::from(*mm) / 1000.0);
        (*mm > 0 && p.norm() <= RANGE_M).then(|| frame.X_WV * Point3::from(p))
    };
    frame.scan.depth_mm.iter().enumerate().map(point).collect()
}

/// The point that a pixel's own ray meets, in W.
fn exact(frame: &Frame, pixel: usize) -> Point3<f64> {
    let p = ray(&frame.scan, pixel) * frame.scan.true_depth_m[pixel];
    frame.X_WV * Point3::from(p)
}

/// Of every pixel the plane that it belongs to.
fn labels(frame: &Frame, points: &[Option<Point3<f64>>], found: &[Found]) -> Vec<Option<usize>> {
    let noise = DepthNoise::default();
    let eye = Point3::from(frame.X_WV.translation.vector);
    let label = |(pixel, point): (usize, &Option<Point3<f64>>)| {
        (*point)?;
        let z = f64::from(frame.scan.depth_mm[pixel]) / 1000.0;
        let direction = frame.X_WV * ray(&frame.scan, pixel);
        let limit = 0.01 + 4.0 * noise.sigma_m(z) + 3.0 * noise.distortion * z;
        let mut nearest = (limit, None);
        for (k, face) in found.iter().enumerate() {
            let n = face.normal();
            let height = n.dot(&(face.X_WF.translation.vector - eye.coords));
            let depth = height / n.dot(&direction);
            let off = (depth - z).abs();
            let p = face
                .X_WF
                .inverse_transform_point(&(eye + direction * depth));
            if off < nearest.0 && face.outline.contains(&p.xy()) {
                nearest = (off, Some(k));
            }
        }
        nearest.1
    };
    points.iter().enumerate().map(label).collect()
}

/// The faces of which enough was measured.
fn true_faces<'a>(
    frame: &Frame,
    faces: &'a [Face],
    points: &[Option<Point3<f64>>],
) -> Vec<True<'a>> {
    let group = groups(faces);
    let mut pixels = vec![Vec::new(); faces.len()];
    for (pixel, face) in frame.scan.face.iter().enumerate() {
        if let (Some(face), Some(_)) = (face, points[pixel]) {
            pixels[group[*face]].push(pixel);
        }
    }
    let seen = |(g, pixels): (usize, Vec<usize>)| {
        let members = (faces.iter().zip(&group)).filter(|(_, k)| **k == g);
        (pixels.len() >= PIXELS_MIN).then(|| True {
            members: members.map(|(face, _)| face).collect(),
            pixels,
        })
    };
    pixels.into_iter().enumerate().filter_map(seen).collect()
}

/// How far a face's true points are from the plane found for it, RMS, m.
fn rms(frame: &Frame, truth: &True, found: &Found) -> f64 {
    let (n, origin) = (found.normal(), found.X_WF.translation.vector);
    let square = |pixel: &usize| n.dot(&(exact(frame, *pixel).coords - origin)).powi(2);
    (truth.pixels.iter().map(square).sum::<f64>() / truth.pixels.len() as f64).sqrt()
}

/// A frame of a face: origin in a corner, x along an edge, z outward.
fn frame_of(face: &Face) -> Isometry3<f64> {
    let v = &face.vertices_W;
    let x = (v[1] - v[0]).normalize();
    let z: Vector3<f64> = face.normal_W;
    let turn = UnitQuaternion::from_basis_unchecked(&[x, z.cross(&x), z]);
    Isometry3::from_parts(v[0].coords.into(), turn)
}
