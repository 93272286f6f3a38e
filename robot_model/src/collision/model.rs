//! A robot's shapes, the pairs of them to watch, and the distances at a configuration.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Point3, Vector3};

use super::ball::ends_as;
use super::broad::Bounds;
use super::closest::Closest;
use super::narrow::closest;
use super::{ShapeGeometry, World};
use crate::{Body, Configuration, ContactPatch, Kinematics, Robot};

/// A collision shape on a link.
#[derive(Clone, Debug)]
pub struct Shape {
    /// The link it belongs to (one fixed to the body's link, maybe).
    pub link: String,
    /// The body it moves with.
    pub body: usize,
    /// Pose of the shape's frame G in that body.
    pub X_BG: Isometry3<f64>,
    /// The shape in G.
    pub geometry: ShapeGeometry,
    /// Whether it may be a part of what touches: its body has a flat patch, or it holds the centre of a ball that
    /// its body touches with, or ends as that ball does, or no shape of the body does. A shank beside its ball is none.
    pub is_pad: bool,
}

/// One shape of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BodyShape {
    /// Index in [`CollisionModel::shapes`].
    pub shape: usize,
    /// The body it moves with.
    pub body: usize,
}

/// What a shape is near to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Other {
    /// Another shape of the robot.
    Shape(BodyShape),
    /// A body of the world, by index.
    Obstacle(usize),
}

/// How near a shape is to another, or to a body of the world.
///
/// Units: m.  Frames: W.
#[derive(Clone, Copy, Debug)]
pub struct Proximity {
    /// The robot's shape.
    pub a: BodyShape,
    /// The other one.
    pub b: Other,
    /// Signed distance; negative on overlap.
    pub distance: f64,
    /// Unit normal from b toward a: ḋ = n·(v_pa − v_pb).
    pub normal_W: Vector3<f64>,
    /// Witness point on a.
    pub p_a_W: Vector3<f64>,
    /// Witness point on b.
    pub p_b_W: Vector3<f64>,
}

/// A pair of links that overlap.
#[derive(Clone, Debug, PartialEq)]
pub struct CollidingPair {
    /// The one link.
    pub link_a: String,
    /// The other.
    pub link_b: String,
    /// Signed distance, negative; m.
    pub distance: f64,
}

impl CollidingPair {
    /// Whether it is that of two links, in either order.
    pub fn is_of(&self, a: &str, b: &str) -> bool {
        let links = [self.link_a.as_str(), self.link_b.as_str()];
        links == [a, b] || links == [b, a]
    }
}

/// The shapes of a robot and the pairs of them that may collide.
#[derive(Clone, Debug, Default)]
pub struct CollisionModel {
    shapes: Vec<Shape>,
    bounds: Vec<(Point3<f64>, Vector3<f64>)>,
    pairs: Vec<(usize, usize)>,
    /// Pairs joined by bodies that have no shape.
    joined: Vec<(usize, usize)>,
}

impl CollisionModel {
    /// The shapes on `bodies`, watching each pair of them but those of one body and those of
    /// parent and child.
    pub fn new(shapes: Vec<Shape>, bodies: &[Body]) -> Self {
        let mut has_shape = vec![false; bodies.len()];
        for shape in &shapes {
            if let Some(has) = has_shape.get_mut(shape.body) {
                *has = true;
            }
        }
        // The nearest ancestor with a shape, by body; parents come first.
        let mut above: Vec<Option<usize>> = vec![None; bodies.len()];
        for (i, body) in bodies.iter().enumerate() {
            let parent = body.parent.filter(|p| *p < i);
            above[i] = parent.and_then(|p| if has_shape[p] { Some(p) } else { above[p] });
        }
        let above = |body: usize| above.get(body).copied().flatten();
        let parent = |body: usize| bodies.get(body).and_then(|b| b.parent);
        let either = |of: &dyn Fn(usize) -> Option<usize>, a: usize, b: usize| {
            of(a) == Some(b) || of(b) == Some(a)
        };
        let (mut pairs, mut joined) = (Vec::new(), Vec::new());
        for (i, first) in shapes.iter().enumerate() {
            for (j, second) in shapes.iter().enumerate().skip(i + 1) {
                let (a, b) = (first.body, second.body);
                if a != b && !either(&parent, a, b) {
                    pairs.push((i, j));
                    if either(&above, a, b) {
                        joined.push((i, j));
                    }
                }
            }
        }
        let bounds = shapes.iter().map(|s| s.geometry.bounds()).collect();
        CollisionModel {
            shapes,
            bounds,
            pairs,
            joined,
        }
    }

    /// Tells the shapes that may be a part of what touches from those that may not.
    pub(crate) fn find_pads(&mut self, patches: &[ContactPatch]) {
        self.shapes
            .iter_mut()
            .for_each(|shape| shape.is_pad = false);
        for patch in patches {
            let centre = ShapeGeometry::Sphere { radius_m: 0.0 };
            let holds = |shape: &Shape| {
                let Some(radius_m) = patch.point_radius_m() else {
                    return true;
                };
                let (X_BG, middle_B) = (&shape.X_BG, patch.X_BC.translation.vector.into());
                let support_B = |u: &Vector3<f64>| {
                    X_BG * shape.geometry.support(&(X_BG.rotation.inverse() * u))
                };
                // Of a foot that is round below alone the middle of its ball may lie over it, in the shank.
                closest(&shape.geometry, X_BG, &centre, &patch.X_BC, 0.0).is_some()
                    || ends_as(&support_B, &middle_B, radius_m)
            };
            let own = |shape: &&mut Shape| shape.body == patch.body;
            // A ball in none of them is of all.
            let in_one = self.shapes.iter().any(|s| s.body == patch.body && holds(s));
            for shape in self.shapes.iter_mut().filter(own) {
                shape.is_pad |= !in_one || holds(shape);
            }
        }
    }

    /// The shapes.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// The pairs of shapes that are watched for self-collision, smaller index first.
    pub fn pairs(&self) -> &[(usize, usize)] {
        &self.pairs
    }

    /// Stops watching the pairs of links for which `disabled(link_a, link_b)` holds in either
    /// order.
    pub fn disable(&mut self, disabled: impl Fn(&str, &str) -> bool) {
        let shapes = &self.shapes;
        self.pairs.retain(|&(i, j)| {
            let (a, b) = (&shapes[i].link, &shapes[j].link);
            !(disabled(a, b) || disabled(b, a))
        });
    }

    /// Stops watching the pairs that are joined by nothing but bodies without shape (the inner
    /// links of a universal joint) and overlap all the same: they are neighbours.
    pub(crate) fn disable_overlapping_neighbours(&mut self, kinematics: &Kinematics) {
        let mut near = Vec::new();
        self.near(kinematics, 0.0, &self.joined, &mut near);
        let pair = |p: &Proximity| match p.b {
            Other::Shape(b) => Some((p.a.shape, b.shape)),
            Other::Obstacle(_) => None,
        };
        let overlapping: Vec<(usize, usize)> = near.iter().filter_map(pair).collect();
        self.pairs.retain(|pair| !overlapping.contains(pair));
    }

    /// Pose of a shape's frame.
    pub fn X_WG(&self, kinematics: &Kinematics, shape: usize) -> Isometry3<f64> {
        kinematics.X_WB[self.shapes[shape].body] * self.shapes[shape].X_BG
    }

    /// Appends every watched pair that is within `prediction_m`, in the order of
    /// [`Self::pairs`].
    pub fn self_proximities(
        &self,
        kinematics: &Kinematics,
        prediction_m: f64,
        out: &mut Vec<Proximity>,
    ) {
        self.near(kinematics, prediction_m, &self.pairs, out);
    }

    fn near(
        &self,
        kinematics: &Kinematics,
        prediction_m: f64,
        pairs: &[(usize, usize)],
        out: &mut Vec<Proximity>,
    ) {
        let placed = self.place(kinematics);
        for &(i, j) in pairs {
            let ((X_WA, box_a), (X_WB, box_b)) = (&placed[i], &placed[j]);
            if box_a.is_farther_than(box_b, prediction_m) {
                continue;
            }
            let (a, b) = (&self.shapes[i].geometry, &self.shapes[j].geometry);
            if let Some(found) = closest(a, X_WA, b, X_WB, prediction_m) {
                let other = Other::Shape(self.body_shape(j));
                out.push(proximity(self.body_shape(i), other, found));
            }
        }
    }

    /// Appends every shape and body of the world within `prediction_m` of each other, those
    /// excepted for which `skip` holds; by shape, then by obstacle.
    pub fn world_proximities(
        &self,
        kinematics: &Kinematics,
        world: &World,
        prediction_m: f64,
        skip: &dyn Fn(BodyShape, usize) -> bool,
        out: &mut Vec<Proximity>,
    ) {
        let placed = self.place(kinematics);
        let corners = placed.iter().map(|(_, bounds)| bounds.corners());
        let Some((low, high)) = corners.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1))) else {
            return;
        };
        let near = world.near(&low, &high, prediction_m.max(0.0));
        for (i, (X_WG, bounds)) in placed.iter().enumerate() {
            let a = self.body_shape(i);
            for &k in &near {
                let obstacle = &world.obstacles()[k];
                if bounds.is_farther_than(&obstacle.bounds, prediction_m) || skip(a, k) {
                    continue;
                }
                let geometry = &self.shapes[i].geometry;
                let (b, X_WO) = (&obstacle.geometry, &obstacle.pose);
                if let Some(found) = closest(geometry, X_WG, b, X_WO, prediction_m) {
                    out.push(proximity(a, Other::Obstacle(k), found));
                }
            }
        }
    }

    /// Pose and bounding box of each shape.
    fn place(&self, kinematics: &Kinematics) -> Vec<(Isometry3<f64>, Bounds)> {
        let shapes = self.bounds.iter().enumerate();
        let placed = shapes.map(|(i, bounds)| {
            let X_WG = self.X_WG(kinematics, i);
            (X_WG, Bounds::around(bounds, &X_WG))
        });
        placed.collect()
    }

    fn body_shape(&self, shape: usize) -> BodyShape {
        BodyShape {
            shape,
            body: self.shapes[shape].body,
        }
    }
}

impl Robot {
    /// The watched pairs of links that overlap at a configuration, deepest overlap of each, in
    /// alphabetical order. They are to be disabled by the SRDF or by the user, or not at all.
    pub fn colliding_pairs(&self, configuration: &Configuration) -> Vec<CollidingPair> {
        self.pairs_within(configuration, 0.0)
    }

    /// The watched pairs of links that are nearer than `distance_m`, in the same way.
    pub(crate) fn pairs_within(
        &self,
        configuration: &Configuration,
        distance_m: f64,
    ) -> Vec<CollidingPair> {
        let kinematics = Kinematics::new(self, configuration);
        let mut near = Vec::new();
        self.collision
            .self_proximities(&kinematics, distance_m, &mut near);
        near.sort_by(|p, q| p.distance.total_cmp(&q.distance));
        let mut seen = BTreeSet::new();
        let deepest = near.iter().filter_map(|p| {
            let Other::Shape(b) = p.b else { return None };
            let mut links = [p.a.shape, b.shape].map(|k| self.collision.shapes[k].link.clone());
            links.sort();
            let is_new = p.distance < distance_m && seen.insert(links.clone());
            let [link_a, link_b] = links;
            is_new.then_some(CollidingPair {
                link_a,
                link_b,
                distance: p.distance,
            })
        });
        let mut pairs: Vec<CollidingPair> = deepest.collect();
        pairs.sort_by(|p, q| (&p.link_a, &p.link_b).cmp(&(&q.link_a, &q.link_b)));
        pairs
    }
}

fn proximity(a: BodyShape, b: Other, found: Closest) -> Proximity {
    Proximity {
        a,
        b,
        distance: found.distance,
        normal_W: found.normal_W,
        p_a_W: found.p_a_W.coords,
        p_b_W: found.p_b_W.coords,
    }
}
