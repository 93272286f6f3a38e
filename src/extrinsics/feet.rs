//! The feet of a robot as points of a link's frame.

use std::collections::BTreeMap;

use anyhow::{Context, Result, bail};
use nalgebra::{Isometry3, Point3, Vector3};
use robot_model::{Configuration, ContactPatch, Kinematics, PatchId, PatchKind, Robot};

use crate::start;

/// The patches that stand on the ground and the link that the sensor is on.
#[derive(Clone, Debug)]
pub struct Feet {
    patches: Vec<PatchId>,
    /// The link of which the frame is R.
    pub link: String,
}

impl Feet {
    /// The named patches, or all with the role "foot"; the named link, or the floating base.
    ///
    /// # Errors
    /// A name that the robot does not have, with those it has; no foot at all.
    pub fn of(robot: &Robot, patches: &[String], link: Option<&str>) -> Result<Self> {
        let base = robot.bodies.first().map(|body| body.name.as_str());
        let link = link.or(base);
        let link = link.with_context(|| format!("robot {:?} has no body", robot.name))?;
        Ok(Self {
            patches: start::patches(robot, patches)?,
            link: robot.frame(link)?.name.clone(),
        })
    }

    /// The feet's points in R, m: the middle of a ball, the vertices of a sole.
    ///
    /// # Errors
    /// When the link is not the robot's.
    pub fn in_R(&self, robot: &Robot, configuration: &Configuration) -> Result<Vec<Point3<f64>>> {
        let kinematics = Kinematics::new(robot, configuration);
        let X_RW = kinematics.X_WL(robot, &self.link)?.inverse();
        let in_R = |patch| points(patch, &(X_RW * kinematics.X_WC(patch)));
        Ok(self.all(robot).flat_map(in_R).collect())
    }

    /// Height of each of these points over the ground, m: a ball's radius, 0 for a sole.
    pub fn heights_m(&self, robot: &Robot) -> Vec<f64> {
        let heights = |p: &ContactPatch| vec![p.point_radius_m().unwrap_or(0.0); p.polygon.len()];
        self.all(robot).flat_map(heights).collect()
    }

    /// The same points as points of bodies: the body, and the place in it, m.
    pub fn points(&self, robot: &Robot) -> Vec<(usize, Vector3<f64>)> {
        let of = |patch: &ContactPatch| {
            let (body, points) = (patch.body, points(patch, &patch.X_BC).into_iter());
            points.map(move |p_B| (body, p_B.coords))
        };
        self.all(robot).flat_map(of).collect()
    }

    fn all<'a>(&'a self, robot: &'a Robot) -> impl Iterator<Item = &'a ContactPatch> {
        self.patches.iter().map(|i| &robot.patches[*i])
    }

    /// Joints between the feet and R that `values` does not have.
    fn missing(&self, robot: &Robot, values: &BTreeMap<String, f64>) -> Vec<String> {
        let link = robot.frame(&self.link).map_or(0, |frame| frame.body);
        let moves = |joint_body: usize| {
            let mut ends = self.all(robot).map(|patch| patch.body).chain([link]);
            ends.any(|body| robot.supports(joint_body, body))
        };
        let joints = robot.joint_bodies().iter().enumerate();
        let missing = joints.filter(|(j, b)| moves(j + 1) && !values.contains_key(&b.joint));
        missing.map(|(_, body)| body.joint.clone()).collect()
    }

    /// The configuration with these joint readings, other joints at rest, the base at the origin.
    ///
    /// # Errors
    /// The joints between the feet and the link that have no reading.
    pub fn configuration(
        &self,
        robot: &Robot,
        values: &BTreeMap<String, f64>,
    ) -> Result<Configuration> {
        let missing = self.missing(robot, values);
        if !missing.is_empty() {
            let (missing, link) = (missing.join(", "), &self.link);
            bail!("no reading of {missing}, which stand between the feet and {link:?}");
        }
        let mut configuration = robot.neutral();
        for (value, body) in configuration.joints.iter_mut().zip(robot.joint_bodies()) {
            if let Some(reading) = values.get(&body.joint) {
                *value = *reading;
            }
        }
        Ok(configuration)
    }
}

/// The points of a patch with frame C at `X_RC`.
fn points(patch: &ContactPatch, X_RC: &Isometry3<f64>) -> Vec<Point3<f64>> {
    match patch.kind {
        PatchKind::Point { .. } => vec![Point3::from(X_RC.translation.vector)],
        PatchKind::Area => {
            let vertices = patch.polygon.iter();
            vertices
                .map(|p| X_RC * Point3::new(p.x, p.y, 0.0))
                .collect()
        }
    }
}
