//! The motion of a plan as a reference.
#![allow(non_snake_case)]

use motion::Interpolation;
use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};
use plan::Motion;
use robot_model::Robot;

use crate::Error;
use crate::reference::{Reference, ReferenceContact, ReferenceState};

/// A motion that is played.
#[derive(Clone, Debug)]
pub struct Playback {
    curve: Interpolation,
    motion: Motion,
    phases: Vec<PlayedPhase>,
}

#[derive(Clone, Debug)]
struct PlayedPhase {
    contacts: Vec<PlayedContact>,
    swing: Option<usize>,
    landing: Option<ReferenceContact>,
}

#[derive(Clone, Debug)]
struct PlayedContact {
    patch: usize,
    X_WC: Isometry3<f64>,
    friction: f64,
    points_W: Vec<Vector3<f64>>,
}

impl Playback {
    /// Prepares a motion; its forces act at the patches' polygons shrunk by `com_margin_m`.
    ///
    /// # Errors
    /// [`Error::Reference`] for a motion that contradicts itself or is not this robot's.
    pub fn new(robot: &Robot, motion: Motion, com_margin_m: f64) -> Result<Self, Error> {
        let refuse = |what: String, cause: String| Error::Reference { what, cause };
        let curve =
            Interpolation::new(&motion).map_err(|e| refuse("motion".to_owned(), e.to_string()))?;
        if motion.robot != robot.name {
            return Err(refuse(
                "motion".to_owned(),
                format!("it is of \"{}\", not \"{}\"", motion.robot, robot.name),
            ));
        }
        if let Some(sample) = motion.samples.first() {
            robot
                .configuration(&sample.q)
                .map_err(|e| refuse("motion".to_owned(), e.to_string()))?;
        }
        let mut phases = Vec::with_capacity(motion.phases.len());
        for (index, phase) in motion.phases.iter().enumerate() {
            let named = |name: &str| {
                robot
                    .patch_index(name)
                    .map_err(|e| refuse(format!("motion, phase {index}"), e.to_string()))
            };
            let mut contacts = Vec::with_capacity(phase.contacts.len());
            for contact in &phase.contacts {
                let patch = named(&contact.patch)?;
                let [x, y, z, w] = contact.X_WC.quat_xyzw;
                let X_WC = Isometry3::from_parts(
                    Vector3::from(contact.X_WC.p).into(),
                    UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
                );
                let shape = &robot.patches[patch];
                // On the plane that is touched: of a ball, a radius below its centre.
                let touched = shape.touched_W(&X_WC);
                let points_W = motion::force_points(&shape.polygon, com_margin_m)
                    .iter()
                    .map(|p| X_WC.rotation * Vector3::new(p.x, p.y, 0.0) + touched)
                    .collect();
                contacts.push(PlayedContact {
                    patch,
                    X_WC,
                    friction: contact.friction,
                    points_W,
                });
            }
            let swing = phase.swing.as_deref().map(named).transpose()?;
            phases.push(PlayedPhase {
                contacts,
                swing,
                landing: None,
            });
        }
        for index in 1..phases.len() {
            let (before, after) = phases.split_at_mut(index);
            let swing = before[index - 1].swing;
            let lands = after[0].contacts.iter().find(|c| Some(c.patch) == swing);
            before[index - 1].landing =
                lands.map(|c| ReferenceContact::new(c.patch, c.X_WC, c.friction, &[], &[]));
        }
        Ok(Self {
            curve,
            motion,
            phases,
        })
    }

    /// The motion that is played.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Force at a point of a contact of a phase, between the samples around a time that belong to
    /// the phase.
    fn force_W(&self, phase: usize, contact: usize, point: usize, t_s: f64) -> Vector3<f64> {
        let samples = &self.motion.samples;
        let place = t_s / self.motion.dt_s;
        let before = (place.floor().max(0.0) as usize).min(samples.len() - 1);
        let after = (before + 1).min(samples.len() - 1);
        let at = |sample: usize| {
            let same = self.motion.phase_at(samples[sample].t_s) == Some(phase);
            samples[sample]
                .forces_W
                .get(contact)
                .and_then(|forces| forces.get(point))
                .filter(|_| same)
                .map(|f| Vector3::from(*f))
        };
        let part = (place - before as f64).clamp(0.0, 1.0);
        match (at(before), at(after)) {
            (Some(a), Some(b)) => a * (1.0 - part) + b * part,
            // The last sample of a phase belongs to the next one.
            (Some(only), None) | (None, Some(only)) => only,
            (None, None) => Vector3::zeros(),
        }
    }
}

impl Reference for Playback {
    fn duration_s(&self) -> f64 {
        self.curve.duration_s()
    }

    fn at(&self, t_s: f64, wanted: &mut ReferenceState) {
        let instant = self.curve.at(t_s);
        wanted.configuration = instant.q;
        wanted.v = instant.v;
        wanted.a = instant.a;
        wanted.contacts.clear();
        wanted.swing = None;
        wanted.landing = None;
        let time = t_s.clamp(0.0, self.duration_s());
        let Some(index) = self.motion.phase_at(time) else {
            return;
        };
        let phase = &self.phases[index];
        wanted.swing = phase.swing;
        wanted.landing.clone_from(&phase.landing);
        for (number, contact) in phase.contacts.iter().enumerate() {
            let forces: Vec<Vector3<f64>> = (0..contact.points_W.len())
                .map(|point| self.force_W(index, number, point, time))
                .collect();
            wanted.contacts.push(ReferenceContact::new(
                contact.patch,
                contact.X_WC,
                contact.friction,
                &contact.points_W,
                &forces,
            ));
        }
    }
}
