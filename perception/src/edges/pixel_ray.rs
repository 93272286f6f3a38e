//! Straight walks over a picture.

use nalgebra::{Point2, Vector2};

/// A direction, in steps from one pixel to the next.
pub(crate) struct PixelRay {
    pub step: Vector2<f64>,
    /// Length of a step, px.
    pub length: f64,
    /// A step in whole parts of a pixel.
    by: [i64; 2],
}

impl PixelRay {
    /// A pixel has 2 to this many parts.
    const BITS: u32 = 16;
    const PARTS: f64 = (1_u32 << Self::BITS) as f64;

    /// Along a vector that is not zero.
    pub fn new(along: &Vector2<f64>) -> Self {
        let step = along / along.x.abs().max(along.y.abs()).max(1e-9);
        Self {
            step,
            length: step.norm(),
            by: [step.x, step.y].map(|x| (x * Self::PARTS) as i64),
        }
    }

    /// The place so many steps after another.
    pub fn place(&self, from: &Point2<f64>, steps: f64) -> Point2<f64> {
        from + self.step * steps
    }

    /// The pixels (column, row) nearest to places one step after another, from `first` steps after a
    /// place on.
    pub fn pixels(&self, from: &Point2<f64>, first: f64) -> Pixels {
        let at = self.place(from, first);
        // Pixels have their middles at whole numbers. Numbers are cut off toward zero, so far from it
        // that this is downward.
        let far = 1_i64 << 40;
        let parts = |x: f64| ((x + 0.5) * Self::PARTS + far as f64) as i64 - far;
        Pixels {
            at: [parts(at.x), parts(at.y)],
            by: self.by,
        }
    }
}

/// Pixels along a [`PixelRay`], without end.
pub(crate) struct Pixels {
    at: [i64; 2],
    by: [i64; 2],
}

impl Iterator for Pixels {
    type Item = [i32; 2];

    #[inline]
    fn next(&mut self) -> Option<[i32; 2]> {
        let pixel = self.at.map(|x| (x >> PixelRay::BITS) as i32);
        let [x, y] = &mut self.at;
        *x = x.wrapping_add(self.by[0]);
        *y = y.wrapping_add(self.by[1]);
        Some(pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pixels_of_a_walk_are_those_nearest_to_its_places() {
        for along in [
            Vector2::new(3.0, 1.0),
            Vector2::new(-0.2, 0.7),
            Vector2::new(0.0, -5.0),
        ] {
            let way = PixelRay::new(&along);
            assert_eq!(way.step.amax(), 1.0);
            let from = Point2::new(1.3, 0.4);
            for (k, pixel) in (-6..40).zip(way.pixels(&from, -6.0)) {
                let place = way.place(&from, f64::from(k));
                // Half a pixel, and what whole parts lose on the way.
                let off = |x: f64, pixel: i32| (x - f64::from(pixel)).abs();
                assert!(off(place.x, pixel[0]) <= 0.501, "{place} {pixel:?}");
                assert!(off(place.y, pixel[1]) <= 0.501, "{place} {pixel:?}");
            }
        }
    }
}
