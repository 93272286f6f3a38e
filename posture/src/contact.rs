//! A contact: which patch of the robot touches which face, where, and what it may bear.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector2, Vector3};
use robot_model::{PatchId, Robot};
use surfaces::ConvexPolygon;

use crate::Error;
use crate::environment::{Environment, FaceIndex};
use crate::rolling::Rolling;

/// A contact, at its place or free to find one.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// The robot's contact patch.
    pub patch: PatchId,
    /// The face that it touches, where there is one: what lies behind it is excepted from
    /// collision.
    pub face: Option<FaceIndex>,
    /// Pose of the patch frame C in W, z outward from the environment. Of a point patch the origin
    /// is the ball's centre and z the touched face's normal; the ball may turn. Of a contact that
    /// may move within an area z is the face's, and the origin a place to begin with.
    pub X_WC: Isometry3<f64>,
    /// How the contact may differ from that pose.
    pub freedom: Freedom,
    /// Of a ball at a fixed place: the orientation in W in which its link stood there. From then on it rolls. Without one
    /// its centre stays.
    pub stood_WB: Option<UnitQuaternion<f64>>,
    /// Whether it may carry load; an unloaded contact touches and nothing more.
    pub loaded: bool,
    /// Coefficient of friction of the pair.
    pub friction: f64,
}

/// How a contact may differ from its pose.
#[derive(Clone, Debug, PartialEq)]
pub enum Freedom {
    /// Not at all.
    Fixed,
    /// The patch may turn about its z.
    Yaw,
    /// The patch may slide and turn, as long as all of it is inside an area.
    Within(Box<Area>),
}

/// Where on a face a contact may be, and where it is wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct Area {
    /// Pose of the face's frame F in W.
    pub X_WF: Isometry3<f64>,
    /// The area, in F, m.
    pub polygon: ConvexPolygon,
    /// The place that is wanted most, in W: of C's origin, or of the point that a ball touches.
    pub toward: Option<Point3<f64>>,
    /// The heading of C's x axis about the face's normal that is wanted most, rad; of no meaning
    /// for a ball.
    pub yaw_rad: Option<f64>,
}

impl Area {
    /// How far a point of W is from the area: beside its edge (0 inside) and over its plane, m.
    pub(crate) fn distances_m(&self, p_W: &Vector3<f64>) -> (f64, f64) {
        let p = self.X_WF.inverse_transform_point(&Point3::from(*p_W));
        (self.polygon.signed_distance(&p.xy()).max(0.0), p.z)
    }
}

impl Contact {
    /// A loaded contact at a pose of the patch frame, with the friction of the patch.
    pub fn at(robot: &Robot, patch: PatchId, X_WC: Isometry3<f64>) -> Self {
        Self {
            patch,
            face: None,
            X_WC,
            freedom: Freedom::Fixed,
            stood_WB: None,
            loaded: true,
            friction: robot.patches[patch].friction,
        }
    }

    /// A contact of a patch anywhere on a face, with the friction of both: within a large
    /// convex part about the face's middle.
    ///
    /// # Errors
    /// [`Error::EmptyFace`] where the face's insets leave nothing of it.
    pub fn anywhere_on(
        environment: &Environment,
        face: FaceIndex,
        robot: &Robot,
        patch: PatchId,
    ) -> Result<Self, Error> {
        let touched = &environment[face];
        let (X_WF, middle_F) = (touched.X_WF, touched.region.centroid());
        let outline = environment.outline(face, 0.0);
        let polygon = outline.convex_around(&middle_F, &Vector2::x());
        let polygon = polygon.ok_or_else(|| Error::EmptyFace {
            face: touched.id.to_string(),
        })?;
        let at = Isometry3::from_parts(touched.point_W(&polygon.centroid()).into(), X_WF.rotation);
        let area = Area {
            X_WF,
            polygon,
            toward: None,
            yaw_rad: None,
        };
        Ok(Self {
            freedom: Freedom::Within(Box::new(area)),
            ..Self::at(robot, patch, robot.patches[patch].touching(&at)).on(face, environment)
        })
    }

    /// The same contact, resting on a face, with no more friction than that has.
    pub fn on(self, face: FaceIndex, environment: &Environment) -> Self {
        Self {
            face: Some(face),
            friction: environment[face].friction_with(self.friction),
            ..self
        }
    }

    /// The same contact, allowed to carry load or not.
    pub fn loaded(self, loaded: bool) -> Self {
        Self { loaded, ..self }
    }

    /// How its ball rolls, where it does.
    pub fn rolling(&self, robot: &Robot) -> Option<Rolling> {
        Some(Rolling {
            from_WB: self.stood_WB?,
            normal_W: self.normal_W(),
            radius_m: robot.patches[self.patch].point_radius_m()?,
        })
    }

    /// Where its ball stood, the centre and how the link was turned, where it rolls.
    pub fn rolls_from_W(&self) -> Option<Isometry3<f64>> {
        let stood_WB = self.stood_WB?;
        Some(Isometry3::from_parts(self.X_WC.translation, stood_WB))
    }

    /// The same contact at the place where a posture has it: a ball that rolls keeps the place that it rolls from.
    pub fn placed(&self, X_WC: Isometry3<f64>) -> Self {
        let X_WC = match self.stood_WB {
            Some(_) => self.X_WC,
            None => X_WC,
        };
        Self {
            X_WC,
            freedom: Freedom::Fixed,
            ..self.clone()
        }
    }

    /// The normal of what is touched, in W.
    pub fn normal_W(&self) -> Vector3<f64> {
        self.X_WC.rotation * Vector3::z()
    }

    /// Where it may be on its face, where that is not settled.
    pub fn area(&self) -> Option<&Area> {
        match &self.freedom {
            Freedom::Within(area) => Some(area),
            _ => None,
        }
    }

    /// The contact in words: `patch on face`, or the patch alone.
    pub fn describe(&self, robot: &Robot, environment: &Environment) -> String {
        let patch = &robot.patches[self.patch].name;
        match self.face {
            Some(face) => format!("{patch} on {}", environment[face].id),
            None => patch.clone(),
        }
    }
}
