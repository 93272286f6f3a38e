//! Several views of one environment → one set of surfaces.
//!
//! Each view gives faces of its own: planes with covariances, outlines, convex pieces. A face of two
//! views is one physical face where its outlines overlap and its planes agree within what is known of
//! them. Then
//!
//!   Σ = (Σᵢ Σᵢ⁻¹)⁻¹,   x = Σ Σᵢ Σᵢ⁻¹ xᵢ,   F = ⋃ᵢ Fᵢ
//!
//! with xᵢ = (θ_x, θ_y, z) of view i's plane in a common frame: the plane is the covariance-weighted
//! mean, and an edge at which one view ended goes on as far as another saw the face. The union is
//! covered by convex pieces anew. What a later view looked through is taken off first.
//!
//! Its edges have the kinds that the views saw: one that is hidden in one view is real where another
//! saw the face end there, or looked through the plane beyond it.
//!
//! Faces keep the names that they had in the first view that showed them; a face that only one view
//! showed stays as it was, bit for bit.

mod assumed;
mod edges;
mod emit;
mod sheet;
mod sight;

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Vector3};
use serde::{Deserialize, Serialize};

use crate::{Obstacle, Source, Surface, cover};
use sheet::Sheet;
pub use sight::{Looked, Seen, Sight, SightConfig};

/// When faces of several views are one, and how it is covered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Whether faces are merged at all; if not, the views' surfaces stand side by side.
    pub enabled: bool,
    /// Planes are one where they differ by no more than this many standard deviations.
    pub gate_sigmas: f64,
    /// Planes are two where they are farther apart than this in the middle of the common part, m.
    pub offset_max_m: f64,
    /// Planes are two where they lean against each other by more than this, rad.
    pub tilt_max_rad: f64,
    /// Standard deviation of a view's position, m.
    pub position_sigma_m: f64,
    /// Standard deviation of a view's direction about each axis, rad.
    pub direction_sigma_rad: f64,
    /// Area that two faces must share to be one, m².
    pub overlap_min_m2: f64,
    /// An edge of the union lies along edges of the views' outlines that are this near to it, m.
    pub edge_near_m: f64,
    /// How far a simplified outline may stay inside the union, m.
    pub tolerance_m: f64,
    /// A further piece must add this part of the face, or `piece_gain_m2`.
    pub piece_gain: f64,
    /// A further piece that adds this much is worth it on a face of any size, m².
    pub piece_gain_m2: f64,
    /// Smallest piece, m².
    pub piece_min_m2: f64,
    /// Smallest width of a piece (diameter of the largest inscribed circle), m.
    pub piece_width_min_m: f64,
    /// How a merged face is covered; its `gain_min_m2` is the least that any piece adds.
    pub cover: cover::Config,
    /// What a view must see to refute a face.
    pub sight: SightConfig,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            enabled: true,
            gate_sigmas: 3.5,
            offset_max_m: 0.05,
            tilt_max_rad: 0.15,
            position_sigma_m: 0.003,
            direction_sigma_rad: 0.002,
            overlap_min_m2: 0.001,
            edge_near_m: 0.03,
            tolerance_m: 0.004,
            piece_gain: 0.03,
            piece_gain_m2: 0.06,
            piece_min_m2: 0.005,
            piece_width_min_m: 0.04,
            cover: cover::Config {
                coverage: 0.95,
                gain_min_m2: 0.005,
                pieces_max: 12,
                vertices_max: 12,
                seeds_max: 12,
            },
            sight: SightConfig::default(),
        }
    }
}

/// What one scan showed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// Its surfaces, with ids and face names that no other view uses.
    pub surfaces: Vec<Surface>,
    /// Bodies that are avoided; assumed ones are dropped where another view saw what is there.
    pub obstacles: Vec<Obstacle>,
    /// What it looked through.
    pub sight: Sight,
}

impl View {
    /// Puts a prefix before all ids and names of faces, so that no other view has them.
    pub fn name(&mut self, prefix: &str) {
        for surface in &mut self.surfaces {
            surface.id.insert_str(0, prefix);
            if let Some(face) = &mut surface.face {
                face.insert_str(0, prefix);
            }
        }
        for body in &mut self.obstacles {
            body.id.insert_str(0, prefix);
            if let Some(surface) = &mut body.surface {
                surface.insert_str(0, prefix);
            }
        }
    }

    /// Moves all that the view showed.
    #[allow(non_snake_case)]
    pub fn move_by(&mut self, X_W: &Isometry3<f64>) {
        for surface in &mut self.surfaces {
            surface.X_WS = X_W * surface.X_WS;
        }
        let bodies = self.obstacles.iter_mut();
        let points = bodies.flat_map(|body| body.points_W.iter_mut());
        for p_W in points.chain(self.sight.points.iter_mut().map(|seen| &mut seen.p_W)) {
            *p_W = X_W * *p_W;
        }
        self.sight.eye_W = X_W * self.sight.eye_W;
    }
}

/// What became of a face.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// Faces were found to be one; it goes by the first name.
    Joined {
        /// The name that stays: that of the first surface.
        id: String,
        /// First surfaces of the faces that went into it.
        with: Vec<String>,
    },
    /// A later view looked through a part of it.
    Cut {
        /// Its first surface.
        id: String,
        /// Area that was taken off, m².
        area_m2: f64,
    },
    /// A later view looked through all of it that could be used.
    Dropped {
        /// Its first surface.
        id: String,
    },
}

/// The views in one set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Merged {
    /// The surfaces: those of the first view in its order, then what others added.
    pub surfaces: Vec<Surface>,
    /// The bodies.
    pub obstacles: Vec<Obstacle>,
    /// What was merged and refuted, in the order in which it happened.
    pub changes: Vec<Change>,
}

/// Merges views in their order in time; a single one is passed on as it is.
///
/// Surfaces that are no scan's ([`Source::Scan`]) or whose plane has no covariance are passed on
/// unmerged. The result depends on the order of the views, not on anything else.
pub fn merge(views: Vec<View>, config: &Config) -> Merged {
    let mut merged = Merged::default();
    if views.len() < 2 || !config.enabled {
        for view in views {
            merged.surfaces.extend(view.surfaces);
            merged.obstacles.extend(view.obstacles);
        }
        return merged;
    }
    let mut set: Vec<Sheet> = Vec::new();
    let mut sights = Vec::new();
    let mut bodies = Vec::new();
    for (number, view) in views.into_iter().enumerate() {
        let (scanned, other) = (view.surfaces.into_iter())
            .partition(|s: &Surface| s.source == Source::Scan && s.plane_covariance.is_some());
        merged.surfaces.extend::<Vec<Surface>>(other);
        let fresh = Sheet::of_view(scanned, number);

        // 1. What this view looked through is not there any more.
        for sheet in &mut set {
            let cut_m2 = sheet.cut(&view.sight, &fresh, config);
            if cut_m2 > 0.0 {
                let id = sheet.id().to_owned();
                merged.changes.push(if sheet.outline.is_empty() {
                    Change::Dropped { id }
                } else {
                    let area_m2 = cut_m2;
                    Change::Cut { id, area_m2 }
                });
            }
        }
        set.retain(|sheet| !sheet.outline.is_empty());

        // 2. Its faces, each to those that it is one with.
        let known = set.len();
        for new in fresh {
            join(&mut set, known, new, config, &mut merged.changes);
        }
        set.retain(|sheet| !sheet.outline.is_empty());
        bodies.extend(view.obstacles.into_iter().map(|body| (number, body)));
        sights.push(view.sight);
    }

    // 3. What hid how a face goes on in one view may have been looked behind in another.
    for sheet in &mut set {
        for sight in &sights {
            edges::look_beyond(sheet, sight, config);
        }
    }
    // 4. Assumed bodies give way to what was seen.
    merged.obstacles = assumed::refuted(bodies, &sights, &set, config);
    // 5. Faces that changed are covered anew; bodies of their old pieces are bodies of the new ones.
    let mut now: BTreeMap<String, String> = BTreeMap::new();
    for sheet in set {
        let id = sheet.id().to_owned();
        let old: Vec<String> = sheet.members.iter().map(|s| s.id.clone()).collect();
        let surfaces = emit::surfaces(sheet, config);
        match surfaces.first() {
            Some(first) => now.extend(old.into_iter().map(|id| (id, first.id.clone()))),
            None => merged.changes.push(Change::Dropped { id }),
        }
        merged.surfaces.extend(surfaces);
    }
    for body in &mut merged.obstacles {
        if let Some(surface) = &body.surface
            && !merged.surfaces.iter().any(|s| s.id == *surface)
        {
            body.surface = now.get(surface).cloned();
        }
    }
    merged
}

/// Joins a new face with those of the first `known` that it is one with, or adds it.
///
/// The one with which it shares most comes first; others must agree with the joint plane.
fn join(
    set: &mut Vec<Sheet>,
    known: usize,
    new: Sheet,
    config: &Config,
    changes: &mut Vec<Change>,
) {
    let mut partners: Vec<(f64, usize)> = (set.iter().take(known).enumerate())
        .filter_map(|(i, sheet)| Some((sheet.is_one_with(&new, config)?, i)))
        .collect();
    partners.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let Some(&(_, first)) = partners.first() else {
        set.push(new);
        return;
    };
    let mut with = vec![new.id().to_owned()];
    let mut joint = set[first].clone();
    joint.absorb(new);
    let mut gone = Vec::new();
    for &(_, i) in &partners[1..] {
        if joint.is_one_with(&set[i], config).is_some() {
            let other = std::mem::take(&mut set[i]);
            // The older one gives the name.
            if other.age() < joint.age() {
                with.push(joint.id().to_owned());
                joint = other.absorbing(joint);
            } else {
                with.push(other.id().to_owned());
                joint.absorb(other);
            }
            gone.push(i);
        }
    }
    let id = joint.id().to_owned();
    let place = gone.iter().copied().chain([first]).min().unwrap_or(first);
    set[first] = Sheet::default();
    set[place] = joint;
    with.retain(|name| *name != id);
    changes.push(Change::Joined { id, with });
}

/// Whether two unit normals look the same way, to `tilt_max_rad`.
fn alike(a: &Vector3<f64>, b: &Vector3<f64>, tilt_max_rad: f64) -> bool {
    a.dot(b) >= tilt_max_rad.cos()
}

#[cfg(test)]
mod tests;
