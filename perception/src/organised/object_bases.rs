//! Where something without a plane stands on a face.
//!
//! Away from the sensor the inverse depth of a face falls by |∇w| a pixel; that of what rises from it
//! along its normal stays about the same. k pixels from where both meet they differ by k |∇w|: the
//! last pixels of what stands there are as near to the face's plane as its own, and have its label.

use super::bits::{Bits, Three, on_left, on_right};
use super::cell::unevenness;
use super::image::{InverseImage, Lens};
use super::label_boundaries::LabelBoundaries;
use super::labelling::limit;
use super::mask::surely_off;
use super::moments::Region;
use crate::sensor::Noise;

/// Farther off it is not known where something stands, px.
const REACH_PX: f64 = 16.0;
/// What is beside a face stands on it if it has no label for so many pixels, of which one is measured,
/// and not the face's for so many: less may be outliers of the face. The former are three: one amid two.
const OFF_PX: usize = 3;
const TALL_PX: isize = 6;

/// What was seen of faces and of what has no label.
pub(super) struct ObjectBases<'a> {
    pub image: &'a InverseImage,
    pub regions: &'a [Region],
    pub labels: &'a [u16],
    pub cuts: &'a LabelBoundaries,
    /// The pixels without a label, and those of them that were not measured.
    pub none: &'a Bits,
    pub unmeasured: &'a Bits,
}

impl ObjectBases<'_> {
    /// Takes off the sure pixels those of a face down to where something stands on it, and those within
    /// `margin_px` of them.
    pub fn drop(&self, margin_px: usize, noise: &Noise, sure: &mut Bits) {
        let lens = self.image.lens();
        let slopes: Vec<Slope> = self
            .regions
            .iter()
            .map(|r| Slope::new(r, &lens, noise))
            .collect();
        for way in ImageDirection::ALL {
            if slopes.iter().all(|slope| slope.way != Some(way)) {
                continue;
            }
            self.beside(way).for_each(|u, v| {
                // From the cut's pixel to what stands there.
                let (x, y) = way.beside(0);
                let near = (u as isize + x, v as isize + y);
                self.drop_one(way, near, &slopes, margin_px, noise, sure);
            });
        }
    }

    /// The pixels amid [`OFF_PX`] of a row, or of a column, without a label, of which one is measured.
    fn off(&self, along: bool) -> Bits {
        let all = |[above, row, below]: [Three; 3]| {
            if along {
                on_left(row) & row[1] & on_right(row)
            } else {
                above[1] & row[1] & below[1]
            }
        };
        let both = [self.none, self.unmeasured];
        Bits::around(both, |[none, unmeasured]| all(none) & !all(unmeasured))
    }

    /// The pixels of the cuts beyond which, against the way, something has no label.
    fn beside(&self, way: ImageDirection) -> Bits {
        let cuts = self.cuts.toward(way.is_along()).clone();
        let (x, y) = way.beside(OFF_PX / 2);
        cuts.and_moved(&self.off(way.is_along()), x, y)
    }

    /// Takes off what one pixel says that stands there next to a face, if it does.
    fn drop_one(
        &self,
        way: ImageDirection,
        (u, v): (isize, isize),
        slopes: &[Slope],
        margin_px: usize,
        noise: &Noise,
        sure: &mut Bits,
    ) {
        let (x, y) = way.step();
        let width = self.image.width as isize;
        let at = |steps: isize| (u + x * steps, v + y * steps);
        let index = |(u, v): (isize, isize)| (v * width + u) as usize;
        let label = usize::from(self.labels[index(at(1))]);
        let Some(slope) = slopes.get(label).filter(|slope| slope.way == Some(way)) else {
            return;
        };
        let inside = |(u, v): (isize, isize)| {
            (0..width).contains(&u) && (0..self.image.height as isize).contains(&v)
        };
        let beyond = (OFF_PX as isize..TALL_PX).map(|k| at(-k));
        if beyond
            .take_while(|p| inside(*p))
            .any(|p| usize::from(self.labels[index(p)]) == label)
        {
            return;
        }
        // The nearest that is measured.
        let w = |k: &isize| self.image.w[index(at(-k))];
        let Some(back) = (0..OFF_PX as isize).find(|k| w(k) > 0.0) else {
            return;
        };
        let (u0, v0) = self.image.centre;
        let (u, v) = at(-back);
        let own = self.regions[label].plane.at(u as f64 - u0, v as f64 - v0);
        let off = f64::from(w(&back)) - own;
        // Nearer to the plane it is the face's, if out of the label's reach.
        let most = slope.most + back as f64 * slope.rise;
        if off < limit(own, slope.uneven, noise).sqrt() || off > most {
            return;
        }
        let length = (off / slope.rise).ceil() as isize - back;
        let margin = margin_px as isize;
        for k in 1..=length + margin {
            let across = (slope.across * (back + k) as f64).round() as isize;
            let (u, v) = at(k);
            if way.is_along() {
                let rows = v + across - margin..=v + across + margin;
                rows.for_each(|v| sure.clear_along(u, v, 0));
            } else {
                sure.clear_along(u + across, v, margin);
            }
        }
    }
}

/// The way along one of the image's axes that is nearest to that toward the sensor on a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
enum ImageDirection {
    Right,
    Left,
    Down,
    Up,
}

impl ImageDirection {
    const ALL: [Self; 4] = [Self::Right, Self::Left, Self::Down, Self::Up];

    fn is_along(self) -> bool {
        matches!(self, Self::Right | Self::Left)
    }

    /// One pixel that way: columns, rows.
    fn step(self) -> (isize, isize) {
        match self {
            Self::Right => (1, 0),
            Self::Left => (-1, 0),
            Self::Down => (0, 1),
            Self::Up => (0, -1),
        }
    }

    /// From a cut's pixel, which is left of it or above it, to the `k`th pixel against the way from the cut:
    /// columns, rows.
    fn beside(self, k: usize) -> (isize, isize) {
        let k = k as isize;
        match self {
            Self::Right => (-k, 0),
            Self::Left => (1 + k, 0),
            Self::Down => (0, -k),
            Self::Up => (0, 1 + k),
        }
    }
}

/// How inverse depth rises on the plane of a region.
struct Slope {
    /// None where it rises so little that it is not known where something stands.
    way: Option<ImageDirection>,
    /// By so much a step that way, with which it goes across by so many pixels.
    rise: f64,
    across: f64,
    /// How far off the plane the nearest pixel of what stands on it may be, and no farther than what the
    /// plane falls on the way to it: what is farther off hides the face from the front.
    most: f64,
    /// The [`unevenness`] of the plane.
    uneven: f64,
}

impl Slope {
    fn new(region: &Region, lens: &Lens, noise: &Noise) -> Self {
        let (a, b) = (region.plane.0.x, region.plane.0.y);
        let uneven = unevenness(lens, &region.plane, noise);
        let (way, most, other) = if a.abs() > b.abs() {
            (
                if a > 0.0 {
                    ImageDirection::Right
                } else {
                    ImageDirection::Left
                },
                a.abs(),
                b,
            )
        } else {
            (
                if b > 0.0 {
                    ImageDirection::Down
                } else {
                    ImageDirection::Up
                },
                b.abs(),
                a,
            )
        };
        let across = if most > 0.0 { other / most } else { 0.0 };
        let rise = most + other * across;
        let most = surely_off(region.moments.mean(), uneven, noise).sqrt() + rise;
        Self {
            way: (most <= REACH_PX * rise).then_some(way),
            rise,
            across,
            most,
            uneven,
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use nalgebra::Vector3;

    use super::super::moments::{InversePlane, Moments};
    use super::*;
    use crate::Sensor;
    use crate::segmentation::NONE;
    use crate::sensor::Intrinsics;

    const WIDTH: usize = 70;
    const HEIGHT: usize = 60;
    /// Where the post stands: its columns, and the row below its last one.
    const POST: std::ops::Range<usize> = 30..38;
    const END: usize = 40;

    /// The sure pixels that are taken off a face whose inverse depth rises by (a, b) a pixel, for a post
    /// in front of it, along the image's columns or its rows, that is `nearer` by so much where it ends.
    fn dropped((a, b): (f64, f64), along: bool, nearer: f64) -> Vec<(usize, usize)> {
        let noise = Sensor::named("xtion").unwrap().noise;
        let plane = InversePlane(Vector3::new(a, b, 0.4));
        let centre = (WIDTH as f64 / 2.0, HEIGHT as f64 / 2.0);
        let at = |u: usize, v: usize| plane.at(u as f64 - centre.0, v as f64 - centre.1);
        let is_post = |u: usize, v: usize| {
            if along {
                POST.contains(&v) && u < END
            } else {
                POST.contains(&u) && v < END
            }
        };
        let depth = |u: usize, v: usize| match (is_post(u, v), along) {
            (false, _) => at(u, v),
            (true, false) => at(u, END) + nearer,
            (true, true) => at(END, v) + nearer,
        };
        let all = || (0..HEIGHT).flat_map(|v| (0..WIDTH).map(move |u| (u, v)));
        let label = |(u, v): (usize, usize)| {
            let (own, w) = (at(u, v), depth(u, v));
            if (w - own).powi(2) <= limit(w, 0.0, &noise) {
                0
            } else {
                NONE
            }
        };
        let labels: Vec<u16> = all().map(label).collect();
        let image = InverseImage {
            width: WIDTH,
            height: HEIGHT,
            w: all().map(|(u, v)| depth(u, v) as f32).collect(),
            intrinsics: Intrinsics {
                fx: 500.0,
                fy: 500.0,
                cx: 0.0,
                cy: 0.0,
            },
            centre,
        };
        let moments = Moments {
            n: 1.0,
            w: 0.4,
            ..Moments::default()
        };
        let feet = ObjectBases {
            image: &image,
            regions: &[Region { moments, plane }],
            labels: &labels,
            cuts: &LabelBoundaries::new(&labels, WIDTH, HEIGHT),
            none: &Bits::of(&labels, WIDTH, |label| label == NONE),
            unmeasured: &Bits::empty(WIDTH, HEIGHT),
        };
        let mut sure = Bits::empty(WIDTH, HEIGHT).not();
        feet.drop(2, &noise, &mut sure);
        all().filter(|(u, v)| !sure.has(*u, *v)).collect()
    }

    #[test]
    fn a_post_is_taken_off_down_to_where_it_stands() {
        let rise = 1.2e-3;
        for (slope, along) in [((0.0, rise), false), ((rise, 0.0), true)] {
            let dropped = dropped(slope, along, 0.0);
            let ways = |(u, v): &(usize, usize)| if along { (*v, *u) } else { (*u, *v) };
            let across: Vec<usize> = dropped.iter().map(|p| ways(p).0).collect();
            let down: Vec<usize> = dropped.iter().map(|p| ways(p).1).collect();
            // Two pixels more on both sides, and beyond where it stands.
            assert_eq!(across.iter().min(), Some(&(POST.start - 2)));
            assert_eq!(across.iter().max(), Some(&(POST.end + 1)));
            assert!(
                (END + 2..=END + 3).contains(down.iter().max().unwrap()),
                "{down:?}"
            );
            // From where its labels are the face's: several pixels.
            assert!(*down.iter().min().unwrap() < END - 3);
        }
    }

    #[test]
    fn what_stands_before_a_face_or_hardly_off_it_takes_nothing_off() {
        // Far in front of it; on a face seen from the front; on one that rises the other way.
        let rise = 1.2e-3;
        for (slope, nearer) in [((0.0, rise), 0.2), ((0.0, 1e-4), 0.02), ((0.0, -rise), 0.0)] {
            assert_eq!(dropped(slope, false, nearer), [], "{slope:?}");
        }
    }
}
