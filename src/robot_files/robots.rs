//! Robots that are read once.

use std::sync::{Mutex, PoisonError};

use anyhow::Result;
use robot_model::Robot;

use super::RobotFiles;
use crate::provenance::Inputs;

/// Robots that were read, for work that asks for the same again and again: each is read once.
#[derive(Debug, Default)]
pub struct Robots(Mutex<Vec<Kept>>);

/// No more robots are kept at a time.
const KEPT_MAX: usize = 8;

#[derive(Debug)]
struct Kept {
    files: RobotFiles,
    config: robot_model::Config,
    robot: Robot,
    inputs: Inputs,
}

impl Robots {
    /// As [`RobotFiles::load`]; files that change after they were read first do not count.
    ///
    /// # Errors
    /// As there.
    pub fn load(
        &self,
        files: &RobotFiles,
        config: &robot_model::Config,
        inputs: &mut Inputs,
    ) -> Result<Robot> {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let same = |kept: &Kept| kept.files == *files && kept.config == *config;
        let at = match all.iter().position(same) {
            Some(at) => at,
            None => {
                let mut inputs = Inputs::default();
                let robot = files.load(config, &mut inputs)?;
                if all.len() == KEPT_MAX {
                    all.remove(0);
                }
                all.push(Kept {
                    files: files.clone(),
                    config: config.clone(),
                    robot,
                    inputs,
                });
                all.len() - 1
            }
        };
        inputs.add(&all[at].inputs);
        Ok(all[at].robot.clone())
    }
}
