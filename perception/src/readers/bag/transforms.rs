//! tf: the pose of a frame in another one at a time.

use std::collections::BTreeMap;

use nalgebra::Isometry3;

use super::super::stated_pose;
use super::messages::TransformStamped;

/// Frames that do not move with the robot (REP 105), the one to be preferred first.
const FIXED: [&str; 3] = ["map", "odom", "world"];
/// No robot has more frames.
const FRAMES_MAX: usize = 10_000;

/// Every frame's pose in its parent about one time.
pub(super) struct Transforms {
    at_ns: i64,
    frames: BTreeMap<String, About>,
}

/// The samples next to the time, before (or at) it and after it; a fixed one is both.
#[derive(Default)]
struct About {
    before: Option<Sample>,
    after: Option<Sample>,
}

#[derive(Clone)]
struct Sample {
    ns: i64,
    parent: String,
    translation: [f64; 3],
    rotation: [f64; 4],
}

impl Transforms {
    pub fn at(at_ns: i64) -> Self {
        Self {
            at_ns,
            frames: BTreeMap::new(),
        }
    }

    /// Takes note of a transform; a `fixed` one holds at all times.
    ///
    /// # Errors
    /// More frames than any robot has.
    pub fn add(&mut self, transform: TransformStamped, fixed: bool) -> Result<(), String> {
        let name = |id: &str| id.trim_start_matches('/').to_owned();
        let sample = Sample {
            ns: if fixed {
                self.at_ns
            } else {
                transform.header.stamp.ns()
            },
            parent: name(&transform.header.frame_id),
            translation: transform.translation,
            rotation: transform.rotation,
        };
        let about = self.frames.entry(name(&transform.child_frame_id));
        let about = about.or_default();
        if sample.ns <= self.at_ns && about.before.as_ref().is_none_or(|b| b.ns <= sample.ns) {
            about.before = Some(sample.clone());
        }
        if sample.ns >= self.at_ns && about.after.as_ref().is_none_or(|a| a.ns >= sample.ns) {
            about.after = Some(sample);
        }
        if self.frames.len() > FRAMES_MAX {
            return Err(format!("more than {FRAMES_MAX} frames"));
        }
        Ok(())
    }

    /// The pose of `frame` in `fixed`, or in the frame that does not move where none is named, with the
    /// name of that one.
    ///
    /// # Errors
    /// Why there is none.
    pub fn pose(
        &self,
        frame: &str,
        fixed: Option<&str>,
    ) -> Result<(String, Isometry3<f64>), String> {
        let frame = frame.trim_start_matches('/');
        let (chain, end) = self.chain(frame);
        let above = |chain: &[(String, Isometry3<f64>)], name: &str| {
            let found = chain.iter().find(|(above, _)| above == name);
            found.map(|(_, X)| *X)
        };
        let why = |sought: &str| match &end {
            Some(cause) => format!("no pose of {frame:?} in {sought}: {cause}"),
            None => {
                let known: Vec<_> = chain.iter().map(|(name, _)| name.as_str()).collect();
                format!(
                    "no pose of {frame:?} in {sought}: tf knows it in {}",
                    known.join(", ")
                )
            }
        };
        if let Some(fixed) = fixed {
            let fixed = fixed.trim_start_matches('/');
            let (theirs, _) = self.chain(fixed);
            // The nearest frame above both.
            let found = chain.iter().find_map(|(name, X_AV)| {
                let X_AF = above(&theirs, name)?;
                Some((fixed.to_owned(), X_AF.inverse() * X_AV))
            });
            return found.ok_or_else(|| why(&format!("{fixed:?}")));
        }
        let last = |name: &str| name.rsplit('/').next().map(str::to_owned);
        let found = FIXED.iter().find_map(|fixed| {
            let mut chain = chain.iter().skip(1);
            chain
                .find(|(name, _)| last(name).as_deref() == Some(fixed))
                .cloned()
        });
        found.ok_or_else(|| why(&FIXED.join(", ")))
    }

    /// The frames from one up, each with the one's pose in it, and why it ends there, unless that one has
    /// no parent.
    fn chain(&self, frame: &str) -> (Vec<(String, Isometry3<f64>)>, Option<String>) {
        let mut chain = vec![(frame.to_owned(), Isometry3::identity())];
        loop {
            let (name, X_AV) = &chain[chain.len() - 1];
            let Some(about) = self.frames.get(name) else {
                return (chain, None);
            };
            match about.pose(self.at_ns) {
                Ok((parent, _)) if chain.iter().any(|(above, _)| above == parent) => {
                    let cause = format!("{parent:?} is above itself");
                    return (chain, Some(cause));
                }
                Ok((parent, X_PA)) => {
                    let above = (parent.to_owned(), X_PA * X_AV);
                    chain.push(above);
                }
                Err(cause) => {
                    let cause = format!("of {name:?} {cause}");
                    return (chain, Some(cause));
                }
            }
        }
    }
}

impl About {
    /// The parent and the pose in it, between the two samples.
    fn pose(&self, at_ns: i64) -> Result<(&str, Isometry3<f64>), String> {
        let (before, after) = match (&self.before, &self.after) {
            (Some(before), Some(after)) if before.parent == after.parent => (before, after),
            (Some(_), Some(_)) => return Err("the parent changes about then".to_owned()),
            (Some(last), None) => {
                let late = at_ns.saturating_sub(last.ns) as f64 * 1e-9;
                return Err(format!("the last transform is {late:.3} s older"));
            }
            (None, Some(first)) => {
                let early = first.ns.saturating_sub(at_ns) as f64 * 1e-9;
                return Err(format!("the first transform is {early:.3} s later"));
            }
            (None, None) => return Err("there is no transform".to_owned()),
        };
        let (X_a, X_b) = (before.pose()?, after.pose()?);
        let span = after.ns.saturating_sub(before.ns) as f64;
        let part = if span > 0.0 {
            at_ns.saturating_sub(before.ns) as f64 / span
        } else {
            0.0
        };
        let X = X_a.try_lerp_slerp(&X_b, part, 1e-9).unwrap_or(X_a);
        Ok((&before.parent, X))
    }
}

impl Sample {
    fn pose(&self) -> Result<Isometry3<f64>, String> {
        stated_pose(self.translation, self.rotation).ok_or_else(|| {
            "a transform is not a position within the world and a unit quaternion".to_owned()
        })
    }
}
