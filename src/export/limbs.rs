//! Names of limbs: what a patch is called in a controller.

use anyhow::{Context, Result, bail};
use robot_model::Robot;

use super::Config;

/// The limb of every patch of a robot, in the order of the patches.
pub(super) struct Limbs {
    names: Vec<(String, String)>,
}

impl Limbs {
    /// The limbs by the settings, or else by the patches' names.
    ///
    /// # Errors  settings for a patch that is not there; two patches of one limb.
    pub fn new(robot: &Robot, config: &Config) -> Result<Self> {
        for patch in config.limbs.keys() {
            robot.patch(patch).context("export.limbs")?;
        }
        let mut names: Vec<(String, String)> = Vec::new();
        for patch in &robot.patches {
            let limb = config.limbs.get(&patch.name).cloned();
            let limb = limb.unwrap_or_else(|| camel_case(&patch.name));
            if let Some((other, _)) = names.iter().find(|(_, name)| *name == limb) {
                let patch = &patch.name;
                bail!("export.limbs: {other} and {patch} are both the limb {limb}");
            }
            names.push((patch.name.clone(), limb));
        }
        Ok(Self { names })
    }

    /// The limb of a patch.
    ///
    /// # Errors  a patch that the robot does not have.
    pub fn of(&self, patch: &str) -> Result<&str> {
        let found = self.names.iter().find(|(name, _)| name == patch);
        let limb = found.map(|(_, limb)| limb.as_str());
        limb.with_context(|| format!("the robot has no patch {patch}"))
    }
}

/// `left_foot` as `LeftFoot`.
fn camel_case(name: &str) -> String {
    name.split(|c: char| !c.is_alphanumeric())
        .flat_map(|word| {
            let mut letters = word.chars();
            let first = letters.next().into_iter().flat_map(char::to_uppercase);
            first.chain(letters)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::camel_case;

    #[test]
    fn names_turn_into_camel_case() {
        assert_eq!(camel_case("left_foot"), "LeftFoot");
        assert_eq!(camel_case("leg-3"), "Leg3");
        assert_eq!(camel_case("RightHand"), "RightHand");
    }
}
