//! Where feet may land, as heights on a raster of the level plane, computed tile by tile.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use nalgebra::{Point3, Vector2};
use posture::FaceIndex;
use robot_model::PatchId;

use crate::context::SearchContext;

/// No face is as high, m.
const HIGH_M: f64 = 1e12;
/// Cells of a tile along each side.
const SIDE: usize = 20;
/// Cells between neighbouring places of the base.
const CELLS: f64 = 2.0;

/// The heights of one tile's cells.
type Heights = Rc<Vec<Vec<f64>>>;

/// The tiles that are known, by patch and place.
type Rasters = BTreeMap<(PatchId, (i64, i64)), Heights>;

/// Whether a patch may stand on a face.
pub(crate) type Stands = fn(&SearchContext, PatchId, FaceIndex) -> bool;

/// Where feet may land.
pub(crate) struct Ground<'a> {
    context: &'a SearchContext<'a>,
    /// For each patch the one whose raster it shares.
    like: Vec<PatchId>,
    /// The faces that it may stand on, for each patch that has a raster of its own.
    faces: BTreeMap<PatchId, BTreeSet<FaceIndex>>,
    known: RefCell<Rasters>,
    /// Width of a cell, m.
    pub cell_m: f64,
}

impl<'a> Ground<'a> {
    /// Of the faces on which feet may stand.
    pub fn new(context: &'a SearchContext<'a>, stands: Stands) -> Self {
        let robot = context.request.robot;
        let mut faces: BTreeMap<PatchId, BTreeSet<FaceIndex>> = BTreeMap::new();
        let mut like: Vec<PatchId> = robot.patch_ids().collect();
        for &foot in &context.feet {
            let friction = |patch: PatchId| robot.patches[patch].friction;
            let is_twin = |other: &&PatchId| {
                context.land_alike(**other, foot) && friction(**other) == friction(foot)
            };
            let twin = faces.keys().find(is_twin);
            if let Some(&twin) = twin {
                like[foot.index()] = twin;
                continue;
            }
            let usable = context.request.usable[foot.index()].iter().copied();
            let of = usable.filter(|face| stands(context, foot, *face));
            faces.insert(foot, of.collect());
        }
        Self {
            context,
            like,
            faces,
            known: RefCell::default(),
            cell_m: context.places_m() / CELLS,
        }
    }

    /// Width of a tile, m.
    fn tile_m(&self) -> f64 {
        SIDE as f64 * self.cell_m
    }

    /// The heights at which a foot may land at a place, m.
    pub fn at<T>(&self, foot: PatchId, p: &Vector2<f64>, of: impl FnOnce(&[f64]) -> T) -> T {
        let p = p / self.tile_m();
        let tile = (p.x.floor() as i64, p.y.floor() as i64);
        let foot = self.like[foot.index()];
        let key = (foot, tile);
        let known = self.known.borrow().get(&key).cloned();
        let heights = known.unwrap_or_else(|| {
            let heights = Rc::new(self.raster(foot, tile));
            self.known.borrow_mut().insert(key, heights.clone());
            heights
        });
        let cell = |x: f64| (((x - x.floor()) * SIDE as f64) as usize).min(SIDE - 1);
        of(&heights[cell(p.x) * SIDE + cell(p.y)])
    }

    fn raster(&self, foot: PatchId, tile: (i64, i64)) -> Vec<Vec<f64>> {
        let mut heights = vec![Vec::new(); SIDE * SIDE];
        let tile_m = self.tile_m();
        let corner_m = |k: i64| [tile.0 + k, tile.1 + k].map(|x| x as f64 * tile_m);
        let corner = |k: i64, z: f64| Point3::new(corner_m(k)[0], corner_m(k)[1], z);
        let first_m = corner_m(0);
        let environment = self.context.request.environment;
        let (low, high) = (corner(0, -HIGH_M), corner(1, HIGH_M));
        let near = environment.faces_near(&low, &high).into_iter();
        let stands = |face: &FaceIndex| self.faces.get(&foot).is_some_and(|of| of.contains(face));
        for face in near.filter(stands) {
            let Some(landing) = self.context.landing(foot, face) else {
                continue;
            };
            let X_WF = environment[face].X_WF;
            let (o, n) = (
                X_WF.translation.vector,
                X_WF.rotation * nalgebra::Vector3::z(),
            );
            if n.z < 1e-3 {
                continue;
            }
            // What is smaller than a cell may hold no cell's middle.
            let inside = landing.inside().filter_map(|p_F| {
                let p = environment[face].point_W(&p_F);
                let at = [p.x - first_m[0], p.y - first_m[1]].map(|x| x / self.cell_m);
                let is_here = at.iter().all(|at| (0.0..SIDE as f64).contains(at));
                is_here.then(|| at[0] as usize * SIDE + at[1] as usize)
            });
            let inside: Vec<usize> = inside.collect();
            for (k, cell) in heights.iter_mut().enumerate() {
                let at = |k: usize| (k as f64 + 0.5) * self.cell_m;
                let (x, y) = (first_m[0] + at(k / SIDE), first_m[1] + at(k % SIDE));
                let z = o.z - (n.x * (x - o.x) + n.y * (y - o.y)) / n.z;
                let p_F = X_WF.inverse_transform_point(&Point3::new(x, y, z)).xy();
                if landing.contains(&p_F) || inside.contains(&k) {
                    cell.push(z);
                }
            }
        }
        heights
    }
}
