//! One posture problem: a contact set in an environment, with a reference and a guess.

use nalgebra::{Isometry3, Point3};
use robot_model::collision::World;
use robot_model::{Configuration, Robot};
use surfaces::{ConvexPolygon, Surface};

use crate::Error;

/// What the robot may touch and must not hit.
pub struct Environment {
    /// The surfaces.
    pub surfaces: Vec<Surface>,
    /// For each surface its polygon after the inset, in S; `None` where nothing is left.
    pub effective: Vec<Option<ConvexPolygon>>,
    /// The convex bodies to keep away from: first one body a surface, then the obstacles.
    pub world: World,
    /// Names of the bodies in `world`.
    pub body_names: Vec<String>,
    /// Whether a body lies wholly behind a surface's plane: `behind[surface][body]`. A link whose
    /// patch rests on the surface cannot meet it.
    pub behind: Vec<Vec<bool>>,
}

/// How far a body may rise over a plane and still count as behind it, m: two scanned planes of one
/// floor differ by as much.
const BEHIND_M: f64 = 0.015;

impl Environment {
    /// The environment of a surface set: a body of `thickness_m` behind every surface, and the
    /// set's obstacles.
    ///
    /// # Errors
    /// [`Error::Body`] where a body is degenerate.
    pub fn new(set: &surfaces::SurfaceSet, thickness_m: f64) -> Result<Self, Error> {
        let mut bodies: Vec<Vec<Point3<f64>>> = Vec::new();
        let mut body_names = Vec::new();
        for surface in &set.surfaces {
            bodies.push(surface.thin_body(thickness_m).points_W);
            body_names.push(surface.id.clone());
        }
        for obstacle in &set.obstacles {
            bodies.push(obstacle.points_W.clone());
            body_names.push(obstacle.id.clone());
        }
        let behind = set
            .surfaces
            .iter()
            .map(|s| bodies.iter().map(|b| s.is_behind(b, BEHIND_M)).collect())
            .collect();
        let world = World::new(&bodies).map_err(|(i, cause)| Error::Body {
            body: body_names[i].clone(),
            cause: cause.to_string(),
        })?;
        Ok(Self {
            surfaces: set.surfaces.clone(),
            effective: set
                .surfaces
                .iter()
                .map(Surface::effective_polygon)
                .collect(),
            world,
            body_names,
            behind,
        })
    }

    /// An environment with nothing in it.
    pub fn empty() -> Self {
        Self {
            surfaces: Vec::new(),
            effective: Vec::new(),
            world: World::default(),
            body_names: Vec::new(),
            behind: Vec::new(),
        }
    }
}

/// One contact of the set.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Index of the robot's contact patch.
    pub patch: usize,
    /// Where it touches.
    pub place: Place,
    /// Whether it may carry load; an unloaded contact touches and nothing more.
    pub loaded: bool,
    /// Coefficient of friction of the pair.
    pub friction: f64,
}

/// Where a contact touches.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub enum Place {
    /// At a pose.
    Fixed {
        /// Pose of the patch frame C in W, z outward from the environment. Of a point patch the
        /// origin is the ball's centre and z the touched surface's normal; the ball may turn.
        X_WC: Isometry3<f64>,
        /// The patch may turn about its z. A ball always may.
        yaw_free: bool,
        /// The surface it lies on, where there is one: its body is excepted from collision.
        surface: Option<usize>,
    },
    /// Anywhere on a surface, the whole patch inside its effective polygon.
    OnSurface {
        /// Index of the surface.
        surface: usize,
        /// The place that is wanted most, in W: of C's origin, or of the point that a ball touches.
        toward: Option<Point3<f64>>,
        /// The heading of C's x axis about the surface's normal that is wanted most, rad; of no
        /// meaning for a ball.
        yaw_rad: Option<f64>,
    },
}

impl Place {
    /// The surface that is touched, where it is known.
    pub fn surface(&self) -> Option<usize> {
        match self {
            Place::Fixed { surface, .. } => *surface,
            Place::OnSurface { surface, .. } => Some(*surface),
        }
    }
}

/// Where the base must be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BaseGoal {
    /// Position in W, m; a coordinate without a value is free.
    pub position_m: [Option<f64>; 3],
    /// Largest distance from it, coordinate by coordinate, m.
    pub tolerance_m: f64,
    /// Heading, rad.
    pub yaw_rad: Option<f64>,
    /// Largest distance from that heading, rad.
    pub yaw_tolerance_rad: f64,
}

/// A contact set for which a posture is wanted.
pub struct Problem<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// What it may touch and must not hit.
    pub environment: &'a Environment,
    /// The contacts.
    pub contacts: Vec<Contact>,
    /// Where the base must be, if it matters.
    pub base_goal: Option<BaseGoal>,
    /// The comfortable posture; its base heading is the one to prefer.
    pub reference: &'a Configuration,
    /// Where the search for the posture starts.
    pub guess: &'a Configuration,
}

impl Problem<'_> {
    /// Refuses what cannot be posed.
    ///
    /// # Errors
    /// [`Error`] naming the contact and the cause.
    pub fn validate(&self) -> Result<(), Error> {
        for (i, contact) in self.contacts.iter().enumerate() {
            if contact.patch >= self.robot.patches.len() {
                return Err(Error::Missing {
                    contact: i,
                    what: "patch",
                    index: contact.patch,
                    count: self.robot.patches.len(),
                });
            }
            if !(contact.friction > 0.0 && contact.friction.is_finite()) {
                return Err(Error::Value {
                    what: format!("friction of contact {i}"),
                    value: contact.friction,
                });
            }
            if let Some(surface) = contact.place.surface()
                && surface >= self.environment.surfaces.len()
            {
                return Err(Error::Missing {
                    contact: i,
                    what: "surface",
                    index: surface,
                    count: self.environment.surfaces.len(),
                });
            }
            if let Place::OnSurface { surface, .. } = contact.place
                && self.environment.effective[surface].is_none()
            {
                let s = &self.environment.surfaces[surface];
                return Err(Error::EmptySurface {
                    surface: s.id.clone(),
                    inset_m: s.inset_m,
                });
            }
            if let Place::Fixed { X_WC, .. } = &contact.place
                && !X_WC.translation.vector.iter().all(|x| x.is_finite())
            {
                return Err(Error::Value {
                    what: format!("position of contact {i}"),
                    value: f64::NAN,
                });
            }
        }
        if !self.contacts.iter().any(|c| c.loaded) {
            return Err(Error::Unsupported);
        }
        Ok(())
    }
}
