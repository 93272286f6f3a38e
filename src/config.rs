//! The settings: one table a crate, laid over each other from the defaults to the command line.
//!
//!   defaults ← scene.toml ← --config FILE ← --set TABLE.KEY=VALUE

mod differing;
mod documented;
mod ranges;
mod schema;

use std::path::Path;

use anyhow::{Context, Error, Result, anyhow};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use crate::cli::Global;
use crate::mistakes;
use crate::provenance;
use crate::status::UsageError;

pub use differing::differing;
pub use documented::documented;

/// So many settings of a table that does not fit are tried alone; of more mistakes the first are told.
const TRIED_MAX: usize = 100;

/// Every setting of the program, one table a crate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Seed of every random stream.
    #[schemars(range(min = 0, max = 9_007_199_254_740_991_i64))]
    pub seed: u64,
    /// From a scan to planar patches.
    pub perception: perception::Config,
    /// Where a sensor sits on a robot.
    pub calibration: calibration::Config,
    /// Bodies behind surfaces, meshes, and which surface may carry which role.
    pub surfaces: surfaces::Config,
    /// The ground under the feet at the start.
    pub ground: crate::start::ground::Config,
    /// How strictly robots are read.
    pub robot_model: robot_model::Config,
    /// From a contact set to a posture.
    pub posture: posture::Config,
    /// The motion between stances.
    pub motion: motion::Config,
    /// The search.
    pub planner: planner::Config,
    /// The physics simulation, its controllers and criteria.
    pub simulation: simulation::Config,
    /// Times and names of the exported files.
    pub export: crate::export::Config,
}

/// Settings in the making: the defaults and what was laid over them so far.
pub struct Layers {
    table: Table,
}

impl Layers {
    /// The defaults.
    pub fn new() -> Result<Self> {
        Ok(Self {
            table: Table::try_from(Config::default())?,
        })
    }

    /// Lays `table` over what is there; `source` names it in errors.
    ///
    /// # Errors
    /// An unknown table or key with the names that there are, a value of the wrong type or beyond its
    /// range.
    pub fn lay(&mut self, source: &str, table: &Table) -> Result<()> {
        let mut merged = self.table.clone();
        merge(&mut merged, table);
        let mut mistakes = ranges::mistakes(table);
        if let Err(first) = resolve(&merged) {
            mistakes.extend(self.unfit(table, first));
        }
        if !mistakes.is_empty() {
            return Err(mistakes::several(mistakes).context(source.to_owned()));
        }
        self.table = merged;
        Ok(())
    }

    /// Why settings do not fit: each of those that do not even alone, else the first mistake of all.
    fn unfit(&self, table: &Table, first: Error) -> Vec<Error> {
        let mut settings = Vec::new();
        leaves(table, &mut Vec::new(), &mut settings);
        let mut found: Vec<Error> = Vec::new();
        for alone in settings.into_iter().take(TRIED_MAX) {
            let mut merged = self.table.clone();
            merge(&mut merged, &alone);
            // An unknown table is one mistake, whatever is in it.
            if let Err(error) = resolve(&merged)
                && found
                    .iter()
                    .all(|other| other.to_string() != error.to_string())
            {
                found.push(error);
            }
        }
        match found.is_empty() {
            true => vec![first],
            false => found,
        }
    }

    /// Lays a file over what is there.
    ///
    /// # Errors
    /// As [`Self::lay`]; a file that cannot be read or is no TOML, with the line.
    pub fn lay_file(&mut self, path: &Path) -> Result<()> {
        let name = path.display();
        let text = provenance::text(&name, provenance::read("config", path)?)?;
        let table = text.parse::<Table>();
        let table = table.with_context(|| format!("{name}: not valid TOML"))?;
        self.lay(&name.to_string(), &table)
    }

    /// Lays one `table.key=value` over what is there. The value is TOML; text that is no TOML
    /// value is taken as a string, so that names need no quotes.
    ///
    /// # Errors
    /// [`UsageError`] where the assignment is malformed, the key unknown or the type wrong.
    pub fn set(&mut self, assignment: &str) -> Result<()> {
        let usage = |cause: String| anyhow!(UsageError(format!("--set {assignment}: {cause}")));
        let (path, value) = assignment
            .split_once('=')
            .ok_or_else(|| usage("no \"=\" in it; the form is table.key=value".to_owned()))?;
        let keys: Vec<&str> = path.trim().split('.').map(str::trim).collect();
        if keys.iter().any(|key| key.is_empty()) {
            return Err(usage("the form is table.key=value".to_owned()));
        }
        let table = nest(&keys, value_of(value.trim()));
        self.lay("", &table)
            .map_err(|error| usage(format!("{:#}", error.root_cause())))
    }

    /// The settings.
    ///
    /// # Errors
    /// Never after successful layers; kept a result so that no panic can hide here.
    pub fn resolve(self) -> Result<Config> {
        resolve(&self.table)
    }
}

impl Config {
    /// The settings of a command: the defaults, the scene's tables, then the command line's.
    ///
    /// # Errors
    /// As [`Layers::lay`], [`Layers::lay_file`] and [`Layers::set`].
    pub fn layered(scene: Option<(&str, &Table)>, global: &Global) -> Result<Self> {
        let mut layers = Layers::new()?;
        if let Some((name, table)) = scene {
            layers.lay(name, table)?;
        }
        if let Some(path) = &global.config {
            layers.lay_file(path)?;
        }
        let wrong = global.set.iter().filter_map(|set| layers.set(set).err());
        let wrong: Vec<String> = wrong.map(|error| error.to_string()).collect();
        if !wrong.is_empty() {
            return Err(UsageError(wrong.join("\n")).into());
        }
        let mut config = layers.resolve()?;
        if let Some(seed) = global.seed {
            config.seed = seed;
        }
        config.planner.improve = global.improve.unwrap_or(config.planner.improve);
        let seed = config.seed;
        config.perception.brossette2013.seed = seed;
        config.perception.lidar.seed = seed;
        config.calibration.ground.seed = seed;
        Ok(config)
    }
}

/// The typed settings of a table.
fn resolve(table: &Table) -> Result<Config> {
    // toml ends its messages with a line break after the path of the key.
    Config::deserialize(Value::Table(table.clone()))
        .map_err(|error| anyhow!("{}", error.to_string().trim().replace('\n', " ")))
}

/// Lays `over` on `base`: tables are merged key by key, everything else is replaced.
fn merge(base: &mut Table, over: &Table) {
    for (key, value) in over {
        match (base.get_mut(key), value) {
            (Some(Value::Table(below)), Value::Table(above)) => merge(below, above),
            _ => {
                base.insert(key.clone(), value.clone());
            }
        }
    }
}

/// The settings of a table, each as a table of it alone.
fn leaves<'a>(table: &'a Table, path: &mut Vec<&'a str>, found: &mut Vec<Table>) {
    for (key, value) in table {
        path.push(key);
        match value {
            Value::Table(table) if !table.is_empty() => leaves(table, path, found),
            value => found.push(nest(path, value.clone())),
        }
        path.pop();
    }
}

/// `a.b.c` and a value as nested tables.
fn nest(keys: &[&str], value: Value) -> Table {
    let nested = keys.iter().rev().fold(value, |value, key| {
        Value::Table(Table::from_iter([((*key).to_owned(), value)]))
    });
    match nested {
        Value::Table(table) => table,
        _ => Table::new(),
    }
}

/// A TOML value, or the text itself where it is none.
fn value_of(text: &str) -> Value {
    format!("v = {text}")
        .parse::<Table>()
        .ok()
        .filter(|table| table.len() == 1)
        .and_then(|mut table| table.remove("v"))
        .unwrap_or_else(|| Value::String(text.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn global(set: &[&str]) -> Global {
        Global {
            set: set.iter().map(|s| (*s).to_owned()).collect(),
            ..Global::default()
        }
    }

    #[test]
    fn the_defaults_survive_the_way_through_toml() {
        let config = Config::layered(None, &Global::default()).unwrap();
        assert_eq!(config, Config::default());
    }

    #[test]
    fn later_layers_win_and_leave_the_rest() {
        let scene = "[posture]\nclearance_m = 0.02\ntorque_use = 0.7";
        let scene: Table = scene.parse().unwrap();
        let set = global(&["posture.clearance_m=0.03", "posture.restarts=5"]);
        let config = Config::layered(Some(("scene.toml", &scene)), &set).unwrap();
        let mut expected = Config::default();
        expected.posture.torque_use = 0.7;
        expected.posture.clearance_m = 0.03;
        expected.posture.restarts = 5;
        assert_eq!(config, expected);
    }

    #[test]
    fn the_seed_reaches_every_stage_that_draws() {
        let flag = Global {
            seed: Some(7),
            ..Global::default()
        };
        for seeded in [flag, global(&["seed=7"])] {
            let config = Config::layered(None, &seeded).unwrap();
            assert_eq!(config.seed, 7);
            assert_eq!(config.perception.brossette2013.seed, 7);
            assert_eq!(config.perception.lidar.seed, 7);
            assert_eq!(config.calibration.ground.seed, 7);
        }
    }

    #[test]
    fn a_whole_number_does_for_a_length() {
        let config = Config::layered(None, &global(&["posture.patch_margin_m=1"])).unwrap();
        assert_eq!(config.posture.patch_margin_m, 1.0);
    }

    #[test]
    fn an_unknown_key_or_table_lists_the_known_ones() {
        for (set, unknown, known) in [
            ("posture.clearence_m=1", "clearence_m", "`clearance_m`"),
            ("postures.clearance_m=1", "postures", "`posture`"),
        ] {
            let error = Config::layered(None, &global(&[set])).unwrap_err();
            assert!(error.is::<UsageError>());
            let text = error.to_string();
            assert!(text.contains(unknown) && text.contains(known), "{text}");
        }
    }

    #[test]
    fn a_wrong_type_or_form_is_refused_with_the_assignment() {
        let sets = "posture.clearance_m=far clearance_m=1 posture.clearance_m =1 .=1";
        for set in sets.split(' ') {
            let error = Config::layered(None, &global(&[set])).unwrap_err();
            assert!(error.is::<UsageError>(), "{set}");
            assert!(error.to_string().contains(set), "{error}");
        }
    }

    #[test]
    fn what_is_no_number_or_beyond_its_range_is_refused() {
        for set in [
            "posture.clearance_m=nan",
            "posture.clearance_m=inf",
            "posture.clearance_m=-0.001",
            "motion.dt_s=0",
            "planner.nodes_max=1000001",
            "surfaces.roles.foot.tilt_max_rad=4",
            "surfaces.roles.foot.facing_W=[0, nan, 1]",
        ] {
            let error = Config::layered(None, &global(&[set]))
                .unwrap_err()
                .to_string();
            let (key, _) = set.split_once('=').unwrap();
            let named = error.contains(&format!("{key} is")) && error.contains("it goes from");
            assert!(named, "{error}");
        }
    }

    #[test]
    fn a_scenes_mistake_names_the_scene() {
        let scene: Table = "[planner]\nmax_nodez = 3".parse().unwrap();
        let error = Config::layered(Some(("my/scene.toml", &scene)), &Global::default());
        let text = format!("{:#}", error.unwrap_err());
        let named = text.contains("my/scene.toml") && text.contains("max_nodez");
        assert!(named, "{text}");
    }
}
