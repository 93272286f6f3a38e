use super::*;
use crate::segmentation::NONE;

/// The labels of the pixels in it, and NONE for all others.
pub fn kept(bits: &Bits, labels: &[u16]) -> Vec<u16> {
    let kept = |(i, &label): (usize, &u16)| match bits.has(i % bits.width, i / bits.width) {
        true => label,
        false => NONE,
    };
    labels.iter().enumerate().map(kept).collect()
}

/// Whether (u, v) is in it, counting what lies beyond the image as `beyond`.
pub fn at(bits: &Bits, u: i64, v: i64, beyond: bool) -> bool {
    if u < 0 || v < 0 || u >= bits.width as i64 || v >= bits.height as i64 {
        return beyond;
    }
    bits.has(u as usize, v as usize)
}

fn picture(width: usize, height: usize, odds: usize) -> Bits {
    Bits::new(width, height, |v, words| {
        for u in 0..width {
            // A fixed pattern without a period in either direction.
            let x = (u * 2654435761 + v * 40503 + (u * v) % 97) % 101;
            words[u / 64] |= u64::from(x >= odds) << (u % 64);
        }
    })
}

#[test]
fn what_is_kept_has_a_pixel_of_the_other_so_far_away() {
    for (width, height) in [(70, 9), (64, 6), (130, 4)] {
        let (bits, other) = (picture(width, height, 40), picture(width, height, 60));
        for (x, y) in [
            (0, 0),
            (1, 0),
            (-3, 0),
            (0, 2),
            (0, -1),
            (63, 1),
            (-63, -2),
            (0, 20),
        ] {
            let got = bits.clone().and_moved(&other, x, y);
            for (v, u) in (0..height).flat_map(|v| (0..width).map(move |u| (v, u))) {
                let (u, v) = (u as i64, v as i64);
                let there = at(&other, u + x as i64, v + y as i64, false);
                let expected = at(&bits, u, v, false) && there;
                assert_eq!(at(&got, u, v, false), expected, "({u}, {v}) by {x}, {y}");
            }
        }
    }
}

#[test]
fn what_is_cleared_is_beside_the_pixel_and_in_the_image() {
    for (u, v, r) in [
        (3, 1, 0),
        (66, 2, 3),
        (0, 0, 2),
        (-2, 1, 3),
        (90, 1, 2),
        (5, -1, 2),
        (5, 4, 2),
    ] {
        let mut bits = Bits::empty(70, 4).not();
        bits.clear_along(u, v, r);
        for (y, x) in (0..4).flat_map(|y| (0..70).map(move |x| (y, x))) {
            let cleared = y == v && (x - u).abs() <= r;
            assert_eq!(
                bits.has(x as usize, y as usize),
                !cleared,
                "({x}, {y}) by {u}, {v}"
            );
        }
    }
}

#[test]
fn erosion_and_dilation_are_those_of_the_definition() {
    for (width, height, r) in [(70, 9, 1), (64, 11, 2), (130, 12, 3), (5, 4, 2)] {
        for (odds, erode) in [(2, true), (97, false)] {
            let bits = picture(width, height, odds);
            let got = if erode {
                bits.clone().eroded(r)
            } else {
                bits.clone().dilated(r)
            };
            let r = r as i64;
            for (v, u) in (0..height as i64).flat_map(|v| (0..width as i64).map(move |u| (v, u))) {
                let mut around = (-r..=r).flat_map(|y| (-r..=r).map(move |x| (x, y)));
                let expected = if erode {
                    around.all(|(x, y)| at(&bits, u + x, v + y, true))
                } else {
                    around.any(|(x, y)| at(&bits, u + x, v + y, false))
                };
                assert_eq!(at(&got, u, v, true), expected, "({u}, {v})");
            }
        }
    }
}
