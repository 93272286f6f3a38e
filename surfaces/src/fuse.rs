//! Several views of one environment → one terrain.
//!
//! Each view gives faces of its own: planes with covariances, regions. A face of two views is one
//! physical face where its regions overlap and its planes agree within what is known of them. Then
//!
//!   Σ = (Σᵢ Σᵢ⁻¹)⁻¹,   x = Σ Σᵢ Σᵢ⁻¹ xᵢ,   F = ⋃ᵢ Fᵢ
//!
//! with xᵢ = (θ_x, θ_y, z) of view i's plane in a common frame: the plane is the covariance-weighted
//! mean, and an edge at which one view ended goes on as far as another saw the face. What a later view
//! looked through is taken off first.
//!
//! Its edges have the kinds that the views saw: one that is hidden in one view is real where another
//! saw the face end there, or looked through the plane beyond it.
//!
//! Faces keep the names that they had in the first view that showed them; a face that only one view
//! showed stays as it was, bit for bit.

mod beyond;
mod edges;
mod growing;

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Matrix3x6, Matrix6, Point3, RowVector6, Vector3};

use crate::covariance;
use crate::free_space::FreeSpace;
use crate::outline::Outline;
use crate::{Face, FaceId, Obstacle, Source, Terrain};
use growing::GrowingFace;

/// Two planes lean against each other by less than this, or are not one, rad.
const TILT_MAX_RAD: f64 = 0.15;
/// Standard deviations of a view's pose by which the edges that it saw are taken back.
const EDGE_SIGMAS: f64 = 2.0;
/// An outline is simplified by at most this, from the inside, m.
const TOLERANCE_M: f64 = 0.004;

/// What one scan showed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// Its faces, with ids that no other view uses.
    pub faces: Vec<Face>,
    /// Bodies that are avoided.
    pub obstacles: Vec<Obstacle>,
    /// What it looked through.
    pub free_space: FreeSpace,
}

impl View {
    /// Puts a prefix before all ids, so that no other view has them.
    pub fn prefix_ids(&mut self, prefix: &str) {
        for face in &mut self.faces {
            face.id = FaceId::from(format!("{prefix}{}", face.id));
        }
        for body in &mut self.obstacles {
            body.id.insert_str(0, prefix);
            if let Some(face) = &mut body.surface {
                face.insert_str(0, prefix);
            }
        }
    }

    /// Moves all that the view showed.
    pub fn move_by(&mut self, X_W: &Isometry3<f64>) {
        for face in &mut self.faces {
            face.X_WF = X_W * face.X_WF;
            face.views
                .iter_mut()
                .for_each(|view| view.eye_W = X_W * view.eye_W);
        }
        let bodies = self.obstacles.iter_mut();
        let points = bodies.flat_map(|body| body.points_W.iter_mut());
        let looked = &mut self.free_space;
        let seen = looked.points.iter_mut().chain(&mut looked.beside);
        let held = looked.held.iter_mut();
        for p_W in points.chain(held).chain(seen.map(|seen| &mut seen.p_W)) {
            *p_W = X_W * *p_W;
        }
        looked.eye_W = X_W * looked.eye_W;
    }
}

impl View {
    /// Adds what is not known of the view's pose to what is not known of what it showed: `covariance` of
    /// (turn, shift) in W about `about_W`, rad, m.
    ///
    /// Planes have it in their covariance, edges along their normals in the plane, rays in all
    /// directions.
    pub fn doubt(&mut self, covariance: &Matrix6<f64>, about_W: &Point3<f64>) {
        // How (turn, shift) moves a point along a direction.
        let along = |p_W: &Point3<f64>, n_W: &Vector3<f64>| {
            let lever = (p_W - about_W).cross(n_W);
            RowVector6::new(lever.x, lever.y, lever.z, n_W.x, n_W.y, n_W.z)
        };
        let sigma = |row: RowVector6<f64>| (row * covariance).dot(&row).max(0.0).sqrt();
        for face in &mut self.faces {
            let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|a| face.X_WF * a);
            let origin = Point3::from(face.X_WF.translation.vector);
            let turn = |a: Vector3<f64>| RowVector6::new(a.x, a.y, a.z, 0.0, 0.0, 0.0);
            let J = Matrix3x6::from_rows(&[turn(x), turn(y), along(&origin, &z)]);
            let more = J * covariance * J.transpose();
            let planes = face.views.iter_mut().map(|view| &mut view.plane_covariance);
            for plane in planes.chain([&mut face.plane_covariance]).flatten() {
                let own = Matrix3::from_fn(|i, j| plane[i][j]);
                *plane = covariance::rows(&(own + more));
            }
            let X_WF = face.X_WF;
            let further: Vec<f64> = (face.region.segments())
                .map(|(_, [a, b])| {
                    let (d, middle) = (b - a, nalgebra::center(a, b));
                    let out = X_WF * Vector3::new(d.y, -d.x, 0.0).normalize();
                    EDGE_SIGMAS * sigma(along(&(X_WF * Point3::new(middle.x, middle.y, 0.0)), &out))
                })
                .collect();
            let edges = face.region.edges_mut().flatten();
            edges
                .zip(further)
                .for_each(|(edge, more)| edge.further_m += more);
        }
        let looked = &mut self.free_space;
        for seen in looked.points.iter_mut().chain(&mut looked.beside) {
            let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
            let more = axes.map(|n| sigma(along(&seen.p_W, &n)).powi(2));
            let more = more.into_iter().fold(0.0, f64::max);
            seen.sigma_m = (seen.sigma_m.powi(2) + more).sqrt();
        }
    }
}

/// What became of a face.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// Faces were found to be one; it goes by the first name.
    Joined {
        /// The name that stays.
        id: FaceId,
        /// Faces that went into it.
        with: Vec<FaceId>,
    },
    /// A later view looked through a part of it.
    Cut {
        /// The face.
        id: FaceId,
        /// Area that was taken off, m².
        area_m2: f64,
    },
    /// A later view looked through all of it that could be used.
    Dropped {
        /// The face.
        id: FaceId,
    },
}

impl std::fmt::Display for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Joined { id, with } => {
                let with: Vec<&str> = with.iter().map(FaceId::as_str).collect();
                write!(f, "{id} and {} are one face", with.join(", "))
            }
            Self::Cut { id, area_m2 } => {
                write!(
                    f,
                    "warning: a later scan looks through {area_m2:.3} m² of {id}: taken off"
                )
            }
            Self::Dropped { id } => write!(f, "warning: a later scan looks through {id}: dropped"),
        }
    }
}

/// The views in one terrain.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fused {
    /// The faces: those of the first view in its order, then what others added; and the bodies.
    pub terrain: Terrain,
    /// What was joined and refuted, in the order in which it happened.
    pub changes: Vec<Change>,
}

/// The views side by side, no face of one joined with another's.
pub fn side_by_side(views: Vec<View>) -> Fused {
    let mut fused = Fused::default();
    for view in views {
        fused.terrain.faces.extend(view.faces);
        fused.terrain.obstacles.extend(view.obstacles);
    }
    fused
}

/// Fuses views in their order in time; a single one is passed on as it is.
///
/// Faces that are no scan's ([`Source::Scan`]) or whose plane has no covariance are passed on as they
/// are. The result depends on the order of the views, not on anything else.
pub fn fuse(views: Vec<View>) -> Fused {
    if views.len() < 2 {
        return side_by_side(views);
    }
    let mut fused = Fused::default();
    let mut set: Vec<GrowingFace> = Vec::new();
    let mut free_spaces = Vec::new();
    for (number, view) in views.into_iter().enumerate() {
        let (scanned, other): (Vec<Face>, Vec<Face>) = (view.faces.into_iter())
            .partition(|f| f.source == Source::Scan && f.plane_covariance.is_some());
        fused.terrain.faces.extend(other);
        let numbered = scanned.into_iter().enumerate();
        let fresh: Vec<GrowingFace> = numbered
            .map(|(index, face)| GrowingFace::new(face, (number, index)))
            .collect();

        // 1. What this view looked through is not there any more.
        for face in &mut set {
            let area_m2 = face.cut(&view.free_space, &fresh);
            if area_m2 > 0.0 {
                let id = face.id().clone();
                fused.changes.push(if face.outline.is_empty() {
                    Change::Dropped { id }
                } else {
                    Change::Cut { id, area_m2 }
                });
            }
        }
        set.retain(|face| !face.outline.is_empty());

        // 2. Its faces, each joined to those that it is one with.
        let known = set.len();
        for new in fresh {
            join(&mut set, known, new, &mut fused.changes);
        }
        set.retain(|face| !face.outline.is_empty());
        fused.terrain.obstacles.extend(view.obstacles);
        free_spaces.push(view.free_space);
    }

    // 3. What hid how a face goes on in one view may have been looked behind in another.
    for face in &mut set {
        free_spaces
            .iter()
            .for_each(|free_space| beyond::look_beyond(face, free_space));
    }
    // 4. Faces with their regions; bodies of joined faces are bodies of the face they went into.
    let mut now: BTreeMap<FaceId, FaceId> = BTreeMap::new();
    for face in set {
        let id = face.id().clone();
        let old: Vec<FaceId> = face
            .members
            .iter()
            .map(|member| member.id.clone())
            .collect();
        let faces = face.into_faces();
        match faces.first() {
            Some(first) => now.extend(old.into_iter().map(|id| (id, first.id.clone()))),
            None => fused.changes.push(Change::Dropped { id }),
        }
        fused.terrain.faces.extend(faces);
    }
    for body in &mut fused.terrain.obstacles {
        let known = |id: &String| fused.terrain.faces.iter().any(|f| f.id.as_str() == id);
        if let Some(face) = body.surface.take_if(|id| !known(id)) {
            body.surface = now.get(&FaceId::from(face)).map(FaceId::to_string);
        }
    }
    fused
}

/// Joins a new face with those of the first `known` that it is one with, or adds it.
///
/// The one with which it shares most comes first; others must agree with the joint plane.
fn join(set: &mut Vec<GrowingFace>, known: usize, new: GrowingFace, changes: &mut Vec<Change>) {
    let mut partners: Vec<(f64, usize)> = (set.iter().take(known).enumerate())
        .filter_map(|(i, face)| Some((face.shared_with(&new)?, i)))
        .collect();
    partners.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let Some(&(_, first)) = partners.first() else {
        set.push(new);
        return;
    };
    let mut with = vec![new.id().clone()];
    let mut joint = set[first].clone().joined(new);
    let mut place = first;
    for &(_, i) in &partners[1..] {
        if joint.shared_with(&set[i]).is_none() {
            continue;
        }
        let other = set[i].clone();
        // The older one gives the name.
        let (older, younger) = if other.age < joint.age {
            (other, joint)
        } else {
            (joint, other)
        };
        with.push(younger.id().clone());
        joint = older.joined(younger);
        // An empty outline is taken out of the set.
        set[place.max(i)].outline = Outline::default();
        place = place.min(i);
    }
    let id = joint.id().clone();
    set[place] = joint;
    changes.push(Change::Joined { id, with });
}

#[cfg(test)]
mod tests;
