//! A face while views are fused: one plane, an outline of any number of parts.

use nalgebra::{Isometry3, Matrix3, Point2, Point3, Translation3, UnitQuaternion, Vector3};

use super::edges::Trace;
use super::{TILT_MAX_RAD, TOLERANCE_M};
use crate::config::FACE_AREA_MIN_M2;
use crate::covariance::{self, rows};
use crate::free_space::{CELL_M, Carved, FreeSpace};
use crate::outline::Outline;
use crate::{Edge, EdgeView, Face, FaceId, Fit, Region};

/// Planes are one where they differ by no more than this many standard deviations.
const GATE_SIGMAS: f64 = 3.5;
/// Planes are two where they are farther apart than this in the middle of the common part, m.
const OFFSET_MAX_M: f64 = 0.05;
/// Standard deviations of a view's position, m, and of its direction about each axis, rad.
const POSITION_SIGMA_M: f64 = 0.003;
const DIRECTION_SIGMA_RAD: f64 = 0.002;
/// Area that two faces share if they are one, m².
const OVERLAP_MIN_M2: f64 = 0.001;
/// A connected part of a face is gone as a whole where rays went through this part of it, and hardly
/// any ended on the rest.
const GONE_MIN: f64 = 0.5;
/// The rest of a part that was looked through is still there where this much of it was seen.
const SEEN_MIN: f64 = 0.3;
/// Cosine of the angle from which on two faces look elsewhere, 60°.
const ELSEWHERE: f64 = 0.5;
/// Points this near to a face are on it, m.
const ON_M: f64 = 0.02;
/// Within its outline a plane is known at least this many times as well as in the middle of it.
const SPREAD_MAX: f64 = 1.5;

/// One face: all that was seen of it in one view or more.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GrowingFace {
    /// Frame P on the plane, z out of the body.
    pub X_WP: Isometry3<f64>,
    /// Covariance of (rotation about x_P, rotation about y_P, offset along z_P).
    covariance: Matrix3<f64>,
    /// What was seen of it, in P.
    pub outline: Outline,
    /// The edges of the regions that went into it, in P.
    pub traces: Vec<Trace>,
    /// How the traces were seen, their planes' covariances in P.
    views: Vec<EdgeView>,
    /// The faces that it was made of, those of the first view first.
    pub members: Vec<Face>,
    /// Whether its plane or its outline is another than that of its only member.
    pub changed: bool,
    /// Number of the first view that showed it, and of the face in that view.
    pub age: (usize, usize),
}

impl GrowingFace {
    /// A face as one view shows it.
    pub fn new(face: Face, age: (usize, usize)) -> Self {
        let own = face.plane_covariance.unwrap_or_default();
        let view = |view: &EdgeView| EdgeView {
            plane_covariance: view.plane_covariance.or(face.plane_covariance),
            ..*view
        };
        Self {
            X_WP: face.X_WF,
            covariance: Matrix3::from_fn(|i, j| own[i][j]),
            outline: Outline::from(&face.region),
            traces: Trace::all(&face),
            views: face.views.iter().map(view).collect(),
            members: vec![face],
            changed: false,
            age,
        }
    }

    /// The name of its first member.
    pub fn id(&self) -> &FaceId {
        &self.members[0].id
    }

    /// The unit outward normal in W.
    pub fn normal_W(&self) -> Vector3<f64> {
        self.X_WP.rotation * Vector3::z()
    }

    /// A point of W in P.
    pub fn in_P(&self, p_W: &Point3<f64>) -> Point3<f64> {
        self.X_WP.inverse_transform_point(p_W)
    }

    /// Takes off what a view looked through; returns that area, m².
    ///
    /// What is left of a part that was mostly looked through goes too, unless it was seen itself: the
    /// foot of a wall is too near to the floor behind it to be looked through. `fresh` are the faces
    /// that the view showed; what is on one that looks elsewhere is not on this one.
    pub fn cut(&mut self, free_space: &FreeSpace, fresh: &[Self]) -> f64 {
        let carved = self.carved(free_space, &self.outline);
        if carved.through.is_empty() {
            return 0.0;
        }
        let before = self.outline.area();
        let mut kept = Outline::default();
        for part in self.outline.parts() {
            let left = part.minus(&carved.through);
            let gone = part.area() - left.area();
            let seen_m2 = || {
                let other = |p_W: &Point3<f64>| fresh.iter().any(|face| face.explains(p_W, self));
                let on = |(p, p_W): &&(Point2<f64>, Point3<f64>)| left.contains(p) && !other(p_W);
                carved.on.iter().filter(on).count() as f64 * CELL_M.powi(2)
            };
            if gone < GONE_MIN * part.area() || seen_m2() > SEEN_MIN * left.area() {
                kept = kept.union(&left);
            }
        }
        self.outline = kept.without_specks(FACE_AREA_MIN_M2);
        self.changed = true;
        before - self.outline.area()
    }

    /// What a view makes of a part of the plane.
    pub fn carved(&self, free_space: &FreeSpace, part: &Outline) -> Carved {
        let rows = rows(&self.covariance);
        let sigma_at = |p: &Point2<f64>| covariance::sigma_at(&rows, p);
        // Points of the face itself were where it is: within its outline the plane is not as far off
        // as its tilt alone would let it be.
        let most = SPREAD_MAX * sigma_at(&self.outline.middle().unwrap_or_default());
        free_space.carved(&self.X_WP, part, &|p| sigma_at(p).min(most))
    }

    /// Whether a point is on this face, which looks elsewhere than the other.
    fn explains(&self, p_W: &Point3<f64>, other: &Self) -> bool {
        let p = self.in_P(p_W);
        let elsewhere = self.normal_W().dot(&other.normal_W()).abs() < ELSEWHERE;
        elsewhere && p.z.abs() < ON_M && self.outline.contains(&p.xy())
    }

    /// The area that both show, m², if they are one face: outlines overlap, planes agree there.
    ///
    ///   dᵀ (Σ_A + Σ_B + Σ_pose)⁻¹ d ≤ k²,   d = (θ_x, θ_y, z)
    ///
    /// in a frame at the middle of the common part.
    pub fn shared_with(&self, other: &Self) -> Option<f64> {
        if self.normal_W().dot(&other.normal_W()) < TILT_MAX_RAD.cos() {
            return None;
        }
        let X_PQ = self.X_WP.inverse() * other.X_WP;
        let common = self.outline.common(&other.outline.moved(&X_PQ));
        let shared_m2 = common.area();
        let middle = common.middle().filter(|_| shared_m2 >= OVERLAP_MIN_M2)?;
        // Both planes in a frame C at the middle of what they share.
        let X_WC = self.X_WP * Translation3::new(middle.x, middle.y, 0.0);
        let (a, own) = self.seen_from(&X_WC)?;
        let (b, its) = other.seen_from(&X_WC)?;
        let d = b - a;
        if d.z.abs() > OFFSET_MAX_M {
            return None;
        }
        let (turn, shift) = (DIRECTION_SIGMA_RAD.powi(2), POSITION_SIGMA_M.powi(2));
        let pose = Matrix3::from_diagonal(&Vector3::new(turn, turn, shift)) * 2.0;
        let inverse = (own + its + pose).try_inverse()?;
        (d.dot(&(inverse * d)) <= GATE_SIGMAS.powi(2)).then_some(shared_m2)
    }

    /// The plane in a frame C near it ([`covariance::plane_in`]).
    fn seen_from(&self, X_WC: &Isometry3<f64>) -> Option<(Vector3<f64>, Matrix3<f64>)> {
        covariance::plane_in(&(X_WC.inverse() * self.X_WP), &self.covariance)
    }

    /// Both as one: weighted plane, union of the outlines.
    pub fn joined(mut self, other: Self) -> Self {
        let X_PQ = self.X_WP.inverse() * other.X_WP;
        // The frame at the middle of both: there the planes' errors are smallest.
        let whole = self.outline.union(&other.outline.moved(&X_PQ));
        let middle = whole.middle().unwrap_or_default();
        let X_WC = self.X_WP * Translation3::new(middle.x, middle.y, 0.0);
        let (mut X_WM, mut joint) = (X_WC, self.covariance);
        if let (Some((a, own)), Some((b, its))) = (self.seen_from(&X_WC), other.seen_from(&X_WC))
            && let (Some(wa), Some(wb)) = (own.try_inverse(), its.try_inverse())
            && let Some(sigma) = (wa + wb).try_inverse()
        {
            let x = sigma * (wa * a + wb * b);
            let turn = UnitQuaternion::from_scaled_axis(Vector3::new(x.x, x.y, 0.0));
            X_WM = X_WC * Isometry3::from_parts(Translation3::new(0.0, 0.0, x.z), turn);
            joint = (sigma + sigma.transpose()) * 0.5;
        }
        let other = other.seen_in(X_WM);
        self = self.seen_in(X_WM);
        let shift = self.views.len();
        self.views.extend(other.views);
        self.traces
            .extend(other.traces.into_iter().map(|mut trace| {
                trace.edge.view = trace.edge.view.map(|view| view + shift);
                trace
            }));
        self.outline = self.outline.union(&other.outline);
        self.members.extend(other.members);
        self.covariance = joint;
        self.changed = true;
        self
    }

    /// The same in another frame M near its plane.
    fn seen_in(mut self, X_WM: Isometry3<f64>) -> Self {
        let X_MP = X_WM.inverse() * self.X_WP;
        let carried = |sigma: &Matrix3<f64>| covariance::plane_in(&X_MP, sigma).map(|(_, c)| c);
        self.covariance = carried(&self.covariance).unwrap_or(self.covariance);
        for view in &mut self.views {
            if let Some(own) = &mut view.plane_covariance {
                let sigma = Matrix3::from_fn(|i, j| own[i][j]);
                *own = carried(&sigma).map_or(*own, |sigma| rows(&sigma));
            }
        }
        self.traces
            .iter_mut()
            .for_each(|trace| trace.move_by(&X_MP));
        self.outline = self.outline.moved(&X_MP);
        self.X_WP = X_WM;
        self
    }

    /// The face, or one for each connected part of its outline, the oldest name first.
    pub fn into_faces(mut self) -> Vec<Face> {
        if !self.changed {
            let mut face = self.members.swap_remove(0);
            let edges = face.region.edges_mut().flatten();
            edges
                .zip(&self.traces)
                .for_each(|(edge, trace)| edge.kind = trace.edge.kind);
            return vec![face];
        }
        let simple = self.outline.simplified_inside(TOLERANCE_M);
        let regions = simple.without_specks(FACE_AREA_MIN_M2).regions();
        let ids = self.ids(&regions);
        let mut faces: Vec<(bool, Face)> = Vec::with_capacity(regions.len());
        for (id, region) in ids.into_iter().zip(regions) {
            faces.push((id != *self.id(), self.face(id, region)));
        }
        // Stable: the largest part first among those of other names.
        faces.sort_by_key(|(later, _)| *later);
        faces.into_iter().map(|(_, face)| face).collect()
    }

    /// A part of it as a face with its origin at the part's centroid.
    fn face(&self, id: FaceId, mut region: Region) -> Face {
        let shift = region.centroid().coords;
        let carried = |rows: &[[f64; 3]; 3]| covariance::carried(rows, &shift);
        let view = |view: &EdgeView| EdgeView {
            plane_covariance: view.plane_covariance.as_ref().map(carried),
            ..*view
        };
        let edges = region
            .segments()
            .map(|(_, ends)| Trace::along(&self.traces, ends));
        let edges: Vec<Edge> = edges.collect();
        region
            .edges_mut()
            .flatten()
            .zip(edges)
            .for_each(|(edge, known)| *edge = known);
        Face {
            plane_covariance: Some(carried(&rows(&self.covariance))),
            fit: self.fit(),
            views: self.views.iter().map(view).collect(),
            depth_m: self
                .members
                .iter()
                .map(|member| member.depth_m)
                .fold(0.0, f64::max),
            source: self.members[0].source,
            ..Face::new(
                id,
                self.X_WP * Translation3::new(shift.x, shift.y, 0.0),
                region.moved(&-shift),
            )
        }
    }

    /// A name for every part: that of the oldest member that it shares an area with, the one it shares
    /// most with first; where none is left, the first member's with a number.
    fn ids(&self, parts: &[Region]) -> Vec<FaceId> {
        let outlines: Vec<Outline> = parts.iter().map(Outline::from).collect();
        let mut ids: Vec<Option<FaceId>> = vec![None; parts.len()];
        for member in &self.members {
            let X_PF = self.X_WP.inverse() * member.X_WF;
            let seen = Outline::from(&member.region).moved(&X_PF);
            let unnamed = (0..parts.len()).filter(|&i| ids[i].is_none());
            let shared = unnamed.map(|i| (seen.common(&outlines[i]).area(), i));
            let most = shared.reduce(|a, b| if b.0 > a.0 { b } else { a });
            if let Some((_, i)) = most.filter(|(area, _)| *area > 0.0) {
                ids[i] = Some(member.id.clone());
            }
        }
        let mut number = 1;
        let named = ids.into_iter().map(|id| {
            id.unwrap_or_else(|| {
                number += 1;
                FaceId::from(format!("{}.{number}", self.id()))
            })
        });
        named.collect()
    }

    /// Number of points and root mean square distance from the joint plane of all of them.
    fn fit(&self) -> Option<Fit> {
        let (mut points, mut square) = (0, 0.0);
        for (member, fit) in self
            .members
            .iter()
            .filter_map(|face| Some((face, face.fit?)))
        {
            let off = self.in_P(&Point3::from(member.X_WF.translation.vector)).z;
            points += fit.points;
            square += fit.points as f64 * (fit.rms_m.powi(2) + off * off);
        }
        let rms_m = (square / points.max(1) as f64).sqrt();
        (points > 0).then_some(Fit { points, rms_m })
    }
}
