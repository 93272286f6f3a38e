//! A merged face → convex pieces under the names that its parts had.
#![allow(non_snake_case)]

use nalgebra::{Matrix3, Point2, Point3, Translation3};

use super::sheet::Sheet;
use super::{Config, edges};
use crate::outline::Outline;
use crate::{ConvexPolygon, Surface, cover};

/// The surfaces of a face: its members where nothing changed, else pieces of its outline.
pub(super) fn surfaces(sheet: Sheet, config: &Config) -> Vec<Surface> {
    if !sheet.changed {
        let mut members = sheet.members;
        edges::relabel(&mut members, &sheet.traces);
        return members;
    }
    let simple = sheet.outline.simplified_inside(config.tolerance_m);
    let outline = simple.without_specks(config.piece_min_m2);
    let gain = (config.piece_gain * outline.area()).min(config.piece_gain_m2);
    let covering = cover::Config {
        gain_min_m2: config.cover.gain_min_m2.max(gain),
        ..config.cover.clone()
    };
    let mut pieces: Vec<(ConvexPolygon, Outline)> = Vec::new();
    for part in outline.parts() {
        let found = part.pieces(&covering).into_iter();
        let found = found.filter(|piece| is_large(piece, config));
        pieces.extend(found.map(|piece| (piece, part.clone())));
    }
    let ids = ids(&sheet, &pieces);
    let (inliers, rms_m) = fit(&sheet);
    let face = (pieces.len() > 1)
        .then(|| sheet.id().to_owned())
        .map(|id| {
            sheet
                .members
                .iter()
                .find_map(|s| s.face.clone())
                .unwrap_or(id)
        })
        .or_else(|| sheet.members.first().and_then(|s| s.face.clone()));
    let largest = |field: fn(&Surface) -> f64| sheet.members.iter().map(field).fold(0.0, f64::max);
    let (inset_m, edge_m, depth_m) = (
        largest(|s| s.inset_m),
        largest(|s| s.edge_m),
        largest(|s| s.depth_m),
    );
    let of_piece = |(id, (polygon, part)): (String, (ConvexPolygon, Outline))| {
        let c = polygon.centroid().coords;
        let in_P = polygon.clone();
        let corners: Vec<_> = polygon.vertices().iter().map(|v| v - c).collect();
        let polygon = ConvexPolygon::new(corners.into_iter().collect()).ok()?;
        let rings = part.rings();
        let kinds = edges::kinds(&sheet.traces, &rings, config);
        let rings = rings.iter();
        let rings = rings.map(|ring| ring.iter().map(|p| [p[0] - c.x, p[1] - c.y]).collect());
        // The offset at the piece's own origin.
        let carry = Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, c.y, -c.x, 1.0);
        let sigma = carry * sheet.covariance * carry.transpose();
        let sigma = (sigma + sigma.transpose()) * 0.5;
        let mut surface = Surface {
            outline: rings.collect(),
            edge_m,
            depth_m,
            inliers,
            rms_m,
            plane_covariance: Some([0, 1, 2].map(|i| [0, 1, 2].map(|j| sigma[(i, j)]))),
            source: sheet.members[0].source,
            face: face.clone(),
            ..Surface::new(id, sheet.X_WP * Translation3::new(c.x, c.y, 0.0), polygon)
        };
        surface.set_outline_edges(kinds);
        let kinds = &surface.polygon_edges;
        let insets = edges::insets_m(&sheet.traces, &in_P, kinds, inset_m, config);
        surface.set_insets(insets);
        Some(surface)
    };
    ids.into_iter().zip(pieces).filter_map(of_piece).collect()
}

fn is_large(piece: &ConvexPolygon, config: &Config) -> bool {
    piece.area() >= config.piece_min_m2
        && 2.0 * piece.inscribed_circle().1 >= config.piece_width_min_m
}

/// A name for every piece: that of the oldest member that it shares an area with, the one it shares
/// most with first; where none is left, the face's own with a number.
fn ids(sheet: &Sheet, pieces: &[(ConvexPolygon, Outline)]) -> Vec<String> {
    let seen: Vec<Option<ConvexPolygon>> = sheet
        .members
        .iter()
        .map(|member| {
            let ring: Vec<Point2<f64>> = (member.vertices_W().iter())
                .map(|p: &Point3<f64>| sheet.in_P(p).xy())
                .collect();
            ConvexPolygon::hull(&ring).ok()
        })
        .collect();
    let mut ids: Vec<Option<String>> = vec![None; pieces.len()];
    for (member, seen) in sheet.members.iter().zip(&seen) {
        let shared = |i: usize| {
            let both = seen
                .as_ref()
                .and_then(|seen| seen.intersection(&pieces[i].0));
            both.map_or(0.0, |both| both.area())
        };
        let best = (0..pieces.len())
            .filter(|&i| ids[i].is_none())
            .map(|i| (shared(i), i))
            .reduce(|a, b| if b.0 > a.0 { b } else { a });
        if let Some((area, i)) = best
            && area > 0.0
        {
            ids[i] = Some(member.id.clone());
        }
    }
    let mut number = 1;
    let fresh = |id: Option<String>| {
        id.unwrap_or_else(|| {
            number += 1;
            format!("{}.{number}", sheet.id())
        })
    };
    ids.into_iter().map(fresh).collect()
}

/// Number of points and root mean square distance from the joint plane of all of them.
fn fit(sheet: &Sheet) -> (usize, f64) {
    let mut parts: Vec<&Surface> = Vec::new();
    for member in &sheet.members {
        // Pieces of one face were fitted once.
        let known = |s: &&Surface| s.face.is_some() && s.face == member.face;
        if !parts.iter().any(known) {
            parts.push(member);
        }
    }
    let inliers: usize = parts.iter().map(|s| s.inliers).sum();
    let square: f64 = parts
        .iter()
        .map(|s| {
            let off = sheet.in_P(&Point3::from(s.X_WS.translation.vector)).z;
            s.inliers as f64 * (s.rms_m.powi(2) + off * off)
        })
        .sum();
    (inliers, (square / inliers.max(1) as f64).sqrt())
}
