//! A face on its way through the merge: one plane, one outline of any number of parts.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Matrix3, Point2, Point3, Translation3, UnitQuaternion, Vector3};

use super::edges::{self, Trace};
use super::sight::{Looked, Sight};
use super::{Config, alike};
use crate::outline::Outline;
use crate::{Surface, covariance};

/// The rest of a part that was looked through is still there where this much of it was seen.
const SEEN_MIN: f64 = 0.3;

/// Cosine of the angle from which on two faces look elsewhere, 60°.
const ELSEWHERE: f64 = 0.5;
/// Points this near to a face are on it, m.
const ON_M: f64 = 0.02;

/// Within its outline a plane is known at least this many times as well as in the middle of it.
const SPREAD_MAX: f64 = 1.5;

/// One face: all that was seen in one plane and named as one, of one view or more.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Sheet {
    /// Frame on the plane, z out of the body.
    pub X_WP: Isometry3<f64>,
    /// Covariance of (rotation about x_P, rotation about y_P, offset along z_P).
    pub covariance: Matrix3<f64>,
    /// What was seen of it, in P.
    pub outline: Outline,
    /// The edges of the outlines that went into it, in P.
    pub traces: Vec<Trace>,
    /// The surfaces that it was made of, those of the first view first.
    pub members: Vec<Surface>,
    /// Whether it is anything else than its members.
    pub changed: bool,
    /// Number of the first view that showed it, and of the face in that view.
    age: (usize, usize),
}

impl Sheet {
    /// The faces of one view: surfaces that name the same face are one.
    pub fn of_view(surfaces: Vec<Surface>, view: usize) -> Vec<Self> {
        let mut groups: Vec<Vec<Surface>> = Vec::new();
        for surface in surfaces {
            let same =
                |group: &&mut Vec<Surface>| surface.face.is_some() && group[0].face == surface.face;
            match groups.iter_mut().find(same) {
                Some(group) => group.push(surface),
                None => groups.push(vec![surface]),
            }
        }
        let numbered = groups.into_iter().enumerate();
        numbered
            .map(|(number, members)| Self::new(members, (view, number)))
            .collect()
    }

    /// A face of these pieces, of which there is at least one.
    fn new(members: Vec<Surface>, age: (usize, usize)) -> Self {
        // The plane is that of the piece of which it is known best.
        let spread = |s: &&Surface| {
            let rows = s.plane_covariance.as_ref();
            rows.map_or(f64::INFINITY, |c| covariance::sigma_max(c, &s.polygon))
        };
        let best = members
            .iter()
            .min_by(|a, b| spread(a).total_cmp(&spread(b)))
            .unwrap_or(&members[0]);
        let rows = best.plane_covariance.unwrap_or_default();
        let X_WP = best.X_WS;
        let mut outline = Outline::default();
        let mut traces = Vec::new();
        for (i, piece) in members.iter().enumerate() {
            if members[..i].iter().any(|other| other.shares_outline(piece)) {
                continue;
            }
            let mut own = Outline::from_rings(&piece.outline);
            if own.is_empty() {
                own = Outline::from_polygon(&piece.polygon);
            }
            let X_PS = X_WP.inverse() * piece.X_WS;
            outline = outline.union(&own.moved(&X_PS));
            let of_part = members[i..].iter();
            let of_part: Vec<&Surface> = of_part
                .filter(|other| std::ptr::eq(*other, piece) || other.shares_outline(piece))
                .collect();
            traces.extend(edges::traces(i, piece, &of_part, &X_PS));
        }
        Self {
            X_WP,
            covariance: Matrix3::from_fn(|i, j| rows[i][j]),
            outline,
            traces,
            members,
            changed: false,
            age,
        }
    }

    /// The name of its first surface.
    pub fn id(&self) -> &str {
        self.members.first().map_or("", |s| &s.id)
    }

    /// Order in time.
    pub fn age(&self) -> (usize, usize) {
        self.age
    }

    /// The unit outward normal in W.
    pub fn normal_W(&self) -> Vector3<f64> {
        self.X_WP.rotation * Vector3::z()
    }

    /// Standard deviation along the normal at a point of P, m.
    pub fn sigma_at(&self, p: &Point2<f64>) -> f64 {
        let rows: [[f64; 3]; 3] =
            std::array::from_fn(|i| std::array::from_fn(|j| self.covariance[(i, j)]));
        covariance::sigma_at(&rows, p)
    }

    /// Takes off what a view looked through; returns that area, m².
    ///
    /// What is left of a part that was mostly looked through goes too, unless it was seen itself: the
    /// foot of a wall is too near to the floor behind it to be looked through. `fresh` are the faces
    /// that the view showed; what is on one that looks elsewhere is not on this one.
    pub fn cut(&mut self, sight: &Sight, fresh: &[Self], config: &Config) -> f64 {
        let looked = self.looked(sight, &self.outline, config);
        if looked.through.is_empty() {
            return 0.0;
        }
        let before = self.outline.area();
        let mut kept = Outline::default();
        for part in self.outline.parts() {
            let left = part.minus(&looked.through);
            let gone = part.area() - left.area();
            let seen_m2 = || {
                let other = |p_W: &Point3<f64>| fresh.iter().any(|face| face.explains(p_W, self));
                let on = |(p, p_W): &&(Point2<f64>, Point3<f64>)| left.contains(p) && !other(p_W);
                looked.on.iter().filter(on).count() as f64 * config.sight.cell_m.powi(2)
            };
            let mostly = gone >= config.sight.gone_ratio * part.area();
            if !mostly || seen_m2() > SEEN_MIN * left.area() {
                kept = kept.union(&left);
            }
        }
        self.outline = kept.without_specks(config.piece_min_m2);
        self.changed = true;
        before - self.outline.area()
    }

    /// What a view makes of a part of the plane.
    pub fn looked(&self, sight: &Sight, part: &Outline, config: &Config) -> Looked {
        // Points of the face itself were where it is: within its outline the plane is not as far off
        // as its tilt alone would let it be.
        let most = SPREAD_MAX * self.sigma_at(&self.outline.middle().unwrap_or_default());
        let sigma_at = |p: &Point2<f64>| self.sigma_at(p).min(most);
        sight.through(&self.X_WP, part, &sigma_at, config)
    }

    /// Whether a point is on this face, which looks elsewhere than the other.
    fn explains(&self, p_W: &Point3<f64>, other: &Self) -> bool {
        let p = self.in_P(p_W);
        let elsewhere = self.normal_W().dot(&other.normal_W()).abs() < ELSEWHERE;
        elsewhere && p.z.abs() < ON_M && self.outline.contains(&p.xy())
    }

    /// The area that both show, if they are one face: outlines overlap, planes agree there.
    ///
    ///   dᵀ (Σ_A + Σ_B + Σ_pose)⁻¹ d ≤ k²,   d = (θ_x, θ_y, z)
    ///
    /// in a frame at the middle of the common part.
    pub fn is_one_with(&self, other: &Self, config: &Config) -> Option<f64> {
        let near = alike(&self.normal_W(), &other.normal_W(), config.tilt_max_rad);
        if !near || self.outline.is_empty() || other.outline.is_empty() {
            return None;
        }
        let X_PQ = self.X_WP.inverse() * other.X_WP;
        let common = self.outline.common(&other.outline.moved(&X_PQ));
        let shared_m2 = common.area();
        let middle = common
            .middle()
            .filter(|_| shared_m2 >= config.overlap_min_m2)?;
        // Both planes in a frame C at the middle of what they share.
        let X_WC = self.X_WP * Translation3::new(middle.x, middle.y, 0.0);
        let (a, own) = self.seen_from(&X_WC)?;
        let (b, its) = other.seen_from(&X_WC)?;
        let d = b - a;
        if d.z.abs() > config.offset_max_m {
            return None;
        }
        let (turn, shift) = (
            config.direction_sigma_rad.powi(2),
            config.position_sigma_m.powi(2),
        );
        let pose = Matrix3::from_diagonal(&Vector3::new(turn, turn, shift)) * 2.0;
        let inverse = (own + its + pose).try_inverse()?;
        let square = d.dot(&(inverse * d));
        (square <= config.gate_sigmas.powi(2)).then_some(shared_m2)
    }

    /// The plane in a frame C near it ([`covariance::plane_in`]).
    fn seen_from(&self, X_WC: &Isometry3<f64>) -> Option<(Vector3<f64>, Matrix3<f64>)> {
        covariance::plane_in(&(X_WC.inverse() * self.X_WP), &self.covariance)
    }

    /// Makes `other` a part of this one: weighted plane, union of the outlines.
    pub fn absorb(&mut self, other: Self) {
        let X_PQ = self.X_WP.inverse() * other.X_WP;
        let theirs = other.outline.moved(&X_PQ);
        // The frame at the middle of both: there the planes' errors are smallest.
        let whole = self.outline.union(&theirs);
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
        let X_MW = X_WM.inverse();
        let own = (self.traces.drain(..)).map(|t| t.moved(&(X_MW * self.X_WP)));
        let its = (other.traces.into_iter()).map(|t| t.moved(&(X_MW * other.X_WP)));
        let traces = own.chain(its).collect();
        self.traces = traces;
        self.outline = (self.outline.moved(&(X_MW * self.X_WP)))
            .union(&other.outline.moved(&(X_MW * other.X_WP)));
        self.X_WP = X_WM;
        self.covariance = joint;
        self.members.extend(other.members);
        self.changed = true;
    }

    /// [`Self::absorb`], for a chain.
    pub fn absorbing(mut self, other: Self) -> Self {
        self.absorb(other);
        self
    }

    /// A point of W in P.
    pub fn in_P(&self, p_W: &Point3<f64>) -> Point3<f64> {
        self.X_WP.inverse_transform_point(p_W)
    }
}
