//! One line of a manifest: the flags of `scandent plan` as JSON, or a drawn world.

use std::collections::BTreeMap;

use anyhow::{Context, Result, anyhow, bail};
use scenes::worlds::families::Family;
use serde_json::{Map, Value};

use crate::bench::{Row, world};
use crate::cli::Global;
use crate::command::{self, simulate};
use crate::config::Config;
use crate::provenance::Inputs;
use crate::robot_files::{BesideUrdf, RobotFiles, Robots};
use crate::scene::Scene;

/// The files of a drawn world in its item's folder.
pub const SCENE: &str = "world.toml";
/// Its mesh.
pub const MESH: &str = "world.obj";

/// Keys that are no flags.
const OWN: [&str; 5] = ["item", "family", "world_seed", "scene", "plan"];
/// Keys of drawn worlds.
const OF_WORLDS: [&str; 9] = [
    "item",
    "family",
    "world_seed",
    "robot",
    "srdf",
    "contacts",
    "set",
    "seed",
    "improve",
];

/// A line of a manifest.
#[derive(Clone, Debug)]
pub struct Item {
    /// What its folder is called: `item`, or the number of its line.
    pub name: String,
    /// The line.
    pub line: String,
    said: Result<Map<String, Value>, String>,
}

/// The files of a drawn world by name.
pub type World = Vec<(&'static str, Vec<u8>)>;

/// What an item asks for.
pub enum Asked {
    /// A plan.
    Plan {
        /// The scene.
        scene: Box<Scene>,
        /// The settings.
        global: Global,
        /// What was read so far.
        inputs: Inputs,
        /// The world, where it was drawn.
        world: Option<World>,
    },
    /// A plan, simulated.
    Simulation(Box<simulate::Args>, Global),
}

impl Item {
    /// The item of a line; what is wrong with it is told by [`Self::asked`].
    pub fn new(line: &str, number: usize) -> Self {
        let said = serde_json::from_str::<Map<String, Value>>(line);
        let mut said = said.map_err(|error| format!("no object of JSON: {error}"));
        let mut name = format!("line-{number:06}");
        if let Some(named) = said.as_ref().ok().and_then(|said| said.get("item")) {
            match named.as_str().filter(|named| is_name(named)) {
                Some(named) => name = named.to_owned(),
                None => {
                    said = Err(format!(
                        "item = {named} is no name of letters, digits, \"-\", \"_\" and \".\""
                    ));
                }
            }
        }
        let line = line.to_owned();
        Self { name, line, said }
    }

    /// What it asks for.
    ///
    /// # Errors
    /// A line that is no item, an unknown key, family or robot; files that cannot be read.
    pub fn asked(&self, robots: &Robots) -> Result<Asked> {
        let said = self.said.as_ref().map_err(|why| anyhow!("{why}"))?;
        for key in ["output", "threads", "frames", "video"] {
            if said.contains_key(key) {
                bail!("{key} belongs to the batch, not to an item");
            }
        }
        if let Some(family) = said.get("family") {
            return self.drawn(family.as_str().context("family is no name")?, said, robots);
        }
        if said.contains_key("plan") {
            let (args, global) = simulate::asked_by(&flags("simulate", "plan", said)?)?;
            return Ok(Asked::Simulation(args, global));
        }
        let mut inputs = Inputs::default();
        let flags = flags("plan", "scene", said)?;
        let (scene, global) = command::plan::asked_by(&flags, &mut inputs)?;
        Ok(Asked::Plan {
            scene: Box::new(scene),
            global,
            inputs,
            world: None,
        })
    }

    fn drawn(&self, family: &str, said: &Map<String, Value>, robots: &Robots) -> Result<Asked> {
        if let Some(key) = said.keys().find(|key| !OF_WORLDS.contains(&key.as_str())) {
            bail!(
                "{key} does not go with family; what does: {}",
                OF_WORLDS.join(", ")
            );
        }
        let family = world::family(family)?;
        let text = |key: &str| said.get(key).and_then(Value::as_str);
        let seed = said.get("world_seed").and_then(Value::as_u64);
        let seed = seed.context("a drawn world needs world_seed, a whole number")?;
        let files = RobotFiles {
            urdf: text("robot").unwrap_or("builtin:hrp2").to_owned(),
            beside: BesideUrdf {
                srdf: text("srdf").map(Into::into),
                contacts: text("contacts").map(Into::into),
                packages: Vec::new(),
            },
        };
        let global = command::plan::global_of(&flags("plan", "scene", said)?)?;
        let config = Config::layered(None, &global)?;
        let robot = robots.load(&files, &config.robot_model, &mut Inputs::default())?;
        let build = world::build(&robot, &config.posture)?;
        if family.hands > build.hands {
            let (wants, has) = (family.hands, build.hands);
            bail!(
                "{} needs {wants} hands, {} has {has}",
                family.name,
                robot.name
            );
        }
        let drawn = family.draw(&build, seed);
        let name = format!("{}-{}-{seed}", family.name, robot.name);
        let mesh = world::mesh(&drawn)?;
        let toml = world::scene(&name, MESH, &drawn, &files, &robot)?;
        let world = vec![(SCENE, toml.into_bytes()), (MESH, mesh.into_bytes())];
        let mut inputs = Inputs::default();
        let at_hand = world
            .iter()
            .map(|(name, bytes)| ((*name).to_owned(), bytes.clone()));
        let scene = Scene::at_hand(SCENE, at_hand.collect::<BTreeMap<_, _>>(), &mut inputs)?;
        Ok(Asked::Plan {
            scene: Box::new(scene),
            global,
            inputs,
            world: Some(world),
        })
    }

    /// A row that knows nothing but the item.
    pub fn row(&self) -> Row {
        let said = self.said.as_ref().ok();
        let get = |key: &str| said.and_then(|said| said.get(key));
        let text = |key: &str| get(key).and_then(Value::as_str).unwrap_or("").to_owned();
        let of = ["family", "scene", "plan"].map(text);
        let family = of
            .into_iter()
            .find(|name| !name.is_empty())
            .unwrap_or_default();
        Row {
            likely: Family::named(&family).map(|f| f.likely),
            seed: get("world_seed").and_then(Value::as_u64),
            ..Row::of(&self.name, &family, &text("robot"))
        }
    }
}

fn is_name(name: &str) -> bool {
    let fits = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    !name.is_empty() && !name.starts_with('.') && name.len() <= 200 && name.chars().all(fits)
}

/// The item as flags of a command, which takes the value of `first` without a flag: lists of numbers are joined by commas, other lists repeat the flag, and `set`
/// holds settings by name.
fn flags(command: &str, first: &str, said: &Map<String, Value>) -> Result<Vec<String>> {
    let mut flags = vec![command.to_owned()];
    if let Some(named) = said.get(first) {
        let named = named.as_str();
        flags.push(
            named
                .with_context(|| format!("{first} is no name"))?
                .to_owned(),
        );
    }
    for (key, value) in said.iter().filter(|(key, _)| !OWN.contains(&key.as_str())) {
        if key == "set" {
            let settings = value.as_object().context("set is no object")?;
            for (name, value) in settings {
                flags.extend(["--set".to_owned(), format!("{name}={value}")]);
            }
            continue;
        }
        let flag = key.replace('_', "-");
        let one = |value: &Value| -> Result<String> {
            let text = |part: &Value| match part {
                Value::String(text) => Ok(text.clone()),
                Value::Number(number) => Ok(number.to_string()),
                _ => bail!("{key} holds {part}, which is no value"),
            };
            match value {
                Value::Bool(true) => Ok(format!("--{flag}")),
                Value::Array(parts) => {
                    let parts = parts.iter().map(text).collect::<Result<Vec<_>>>()?;
                    Ok(format!("--{flag}={}", parts.join(",")))
                }
                value => Ok(format!("--{flag}={}", text(value)?)),
            }
        };
        match value {
            Value::Bool(false) | Value::Null => {}
            Value::Array(many) if !many.iter().all(Value::is_number) => {
                let many = many.iter().map(one).collect::<Result<Vec<_>>>()?;
                flags.extend(many);
            }
            value => flags.push(one(value)?),
        }
    }
    Ok(flags)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_become_flags() {
        let said = serde_json::json!({
            "item": "a", "scene": "s.toml", "goal": [2.0, -0.5], "guide": [[1, 0, 0.6], [2, 0, 0.6]],
            "scan": ["a.png", "b.png"], "level": true, "set": {"planner.nodes_max": 20}, "seed": 3
        });
        let flags = flags("plan", "scene", said.as_object().unwrap())
            .unwrap()
            .join(" ");
        assert_eq!(
            flags,
            "plan s.toml --goal=2.0,-0.5 --guide=1,0,0.6 --guide=2,0,0.6 --level --scan=a.png \
             --scan=b.png --seed=3 --set planner.nodes_max=20"
        );
    }

    #[test]
    fn what_is_no_item_is_an_error_with_a_name() {
        for (line, word) in [
            ("[1]", "no object"),
            (r#"{"item": "../up"}"#, "no name"),
            (r#"{"family": "none", "world_seed": 1}"#, "stairs-up"),
            (r#"{"family": "stairs-up"}"#, "world_seed"),
            (
                r#"{"family": "stairs-up", "world_seed": 1, "goal": [1, 0]}"#,
                "goal",
            ),
            (r#"{"output": "elsewhere"}"#, "belongs to the batch"),
            (r#"{"gaol": [1, 0]}"#, "--gaol"),
            (r#"{"plan": "plan.json", "goal": [1, 0]}"#, "--goal"),
            (
                r#"{"plan": "plan.json", "video": "a.mp4"}"#,
                "belongs to the batch",
            ),
        ] {
            let item = Item::new(line, 7);
            assert_eq!(item.name, "line-000007");
            let said = format!("{:#}", item.asked(&Robots::default()).err().unwrap());
            assert!(said.contains(word), "{line}: {said}");
        }
    }
}
