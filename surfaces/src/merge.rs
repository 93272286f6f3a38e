//! Several views of one environment as one set of convex surfaces: [`crate::fuse`] for views whose faces
//! come in pieces.

use std::collections::BTreeMap;

use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

pub use crate::free_space::{FreeSpace as Sight, RayEnd as Seen};
use crate::fuse::{self, fuse};
use crate::{Face, FaceId, Obstacle, Surface, SurfaceSet, Terrain};

/// Insets of edges are taken with this many standard deviations.
const SIGMAS: f64 = 2.0;

/// Whether faces of several views are one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Whether faces are merged at all; if not, the views' surfaces stand side by side.
    pub enabled: bool,
}

impl Default for Config {
    fn default() -> Self {
        Self { enabled: true }
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

/// Merges views in their order in time ([`fuse()`]); a single one is passed on as it is, and so are faces
/// that only one view showed.
pub fn merge(views: Vec<View>, config: &Config) -> Merged {
    let mut merged = Merged::default();
    if views.len() < 2 || !config.enabled {
        for view in views {
            merged.surfaces.extend(view.surfaces);
            merged.obstacles.extend(view.obstacles);
        }
        return merged;
    }
    let mut known: BTreeMap<FaceId, (Face, Vec<Surface>)> = BTreeMap::new();
    let mut whole = Vec::new();
    for view in views {
        let set = SurfaceSet {
            surfaces: view.surfaces,
            obstacles: view.obstacles,
        };
        // What cannot be read as faces stands beside those that can.
        let Ok(terrain) = Terrain::try_from(set.clone()) else {
            merged.surfaces.extend(set.surfaces);
            merged.obstacles.extend(set.obstacles);
            continue;
        };
        for face in &terrain.faces {
            let of_face = |s: &&Surface| {
                s.id == face.id.as_str() || s.face.as_deref() == Some(face.id.as_str())
            };
            let pieces = set.surfaces.iter().filter(of_face).cloned().collect();
            known.insert(face.id.clone(), (face.clone(), pieces));
        }
        whole.push(fuse::View {
            faces: terrain.faces,
            obstacles: terrain.obstacles,
            free_space: view.sight,
        });
    }
    let fused = fuse(whole);
    merged.changes = fused.changes.into_iter().map(Change::from).collect();
    let mut obstacles = fused.terrain.obstacles;
    for face in fused.terrain.faces {
        let pieces = match known.get(&face.id) {
            Some((before, pieces)) if unchanged(before, &face) => relabelled(pieces, &face),
            before => {
                let mut pieces = face.pieces(SIGMAS);
                // A face that was one surface keeps its name for the piece that adds most.
                if before.is_none_or(|(_, pieces)| pieces.len() < 2)
                    && let Some(first) = pieces.first_mut()
                {
                    first.id = face.id.to_string();
                }
                pieces
            }
        };
        for body in &mut obstacles {
            if body.surface.as_deref() == Some(face.id.as_str()) {
                body.surface = pieces.first().map(|piece| piece.id.clone());
            }
        }
        merged.surfaces.extend(pieces);
    }
    merged.obstacles.extend(obstacles);
    merged
}

/// Whether two faces differ in the kinds of their edges at most.
fn unchanged(before: &Face, now: &Face) -> bool {
    let vertices = |face: &Face| {
        let rings = face.region.rings().iter();
        rings
            .flat_map(|ring| ring.vertices.clone())
            .collect::<Vec<_>>()
    };
    before.X_WF == now.X_WF && vertices(before) == vertices(now)
}

/// The pieces of a face with the kinds that its edges have now.
fn relabelled(pieces: &[Surface], face: &Face) -> Vec<Surface> {
    let rings = face.region.rings().iter();
    let kinds = rings.map(|ring| ring.edges.iter().map(|edge| edge.kind).collect());
    let kinds: Vec<Vec<_>> = kinds.collect();
    let mut pieces = pieces.to_vec();
    for piece in &mut pieces {
        let differ = !piece.outline_edges.is_empty()
            || kinds.iter().flatten().any(|k| *k != Default::default());
        if differ && !piece.outline.is_empty() && piece.outline_edges != kinds {
            piece.set_outline_edges(kinds.clone());
        }
    }
    pieces
}

impl From<fuse::Change> for Change {
    fn from(change: fuse::Change) -> Self {
        let name = |id: FaceId| id.to_string();
        match change {
            fuse::Change::Joined { id, with } => Self::Joined {
                id: name(id),
                with: with.into_iter().map(name).collect(),
            },
            fuse::Change::Cut { id, area_m2 } => Self::Cut {
                id: name(id),
                area_m2,
            },
            fuse::Change::Dropped { id } => Self::Dropped { id: name(id) },
        }
    }
}
