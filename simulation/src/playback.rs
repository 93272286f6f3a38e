//! The motion of a plan as a reference.

use motion::Interpolation;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
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
    /// Prepares a motion.
    ///
    /// # Errors
    /// [`Error::Reference`] for a motion that contradicts itself or is not this robot's.
    pub fn new(robot: &Robot, motion: Motion) -> Result<Self, Error> {
        let refuse = |what: String, cause: String| Error::Reference { what, cause };
        let refused = |cause: String| refuse("motion".to_owned(), cause);
        let curve = Interpolation::new(&motion).map_err(|e| refused(e.to_string()))?;
        if motion.robot != robot.name {
            let (is, wanted) = (&motion.robot, &robot.name);
            return Err(refused(format!("it is of \"{is}\", not \"{wanted}\"")));
        }
        if let Some(sample) = motion.samples.first() {
            let fits = robot.configuration(&sample.q);
            fits.map_err(|e| refused(e.to_string()))?;
        }
        let mut phases = Vec::with_capacity(motion.phases.len());
        for (index, phase) in motion.phases.iter().enumerate() {
            let unknown = |e| refuse(format!("motion, phase {index}"), format!("{e}"));
            let named = |name: &str| robot.patch_index(name).map_err(unknown);
            let mut contacts = Vec::with_capacity(phase.contacts.len());
            for contact in &phase.contacts {
                let patch = named(&contact.patch)?;
                let rotation = UnitQuaternion::new_normalize(contact.X_WC.quat_xyzw.into());
                let X_WC = Isometry3::from_parts(contact.X_WC.p.into(), rotation);
                contacts.push(PlayedContact {
                    patch,
                    X_WC,
                    friction: contact.friction,
                    points_W: contact.force_points_W.iter().map(|p| (*p).into()).collect(),
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

    /// Force at a point of a contact of a phase, between the samples around a time that belong to
    /// the phase.
    fn force_W(&self, phase: usize, contact: usize, point: usize, t_s: f64) -> Vector3<f64> {
        let samples = &self.motion.samples;
        let place = t_s / self.motion.dt_s;
        let before = (place.floor().max(0.0) as usize).min(samples.len() - 1);
        let after = (before + 1).min(samples.len() - 1);
        let at = |sample: usize| {
            let same = self.motion.phase_at(samples[sample].t_s) == Some(phase);
            let force = samples[sample].forces_W.get(contact)?.get(point)?;
            same.then(|| Vector3::from(*force))
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
            let PlayedContact {
                patch,
                X_WC,
                friction,
                ref points_W,
            } = *contact;
            let at = |point| self.force_W(index, number, point, time);
            let forces: Vec<_> = (0..points_W.len()).map(at).collect();
            let contact = ReferenceContact::new(patch, X_WC, friction, points_W, &forces);
            wanted.contacts.push(contact);
        }
    }
}
