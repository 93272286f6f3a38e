//! Scenes that ship, planned by the program once a run of the tests.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock};

use plan::{Motion, Plan};

use super::program::{read, succeeds};

/// What `scandent run SCENE` left and said.
pub struct Shipped {
    /// The folder of the results.
    pub results: PathBuf,
    pub said: String,
    pub plan: Plan,
    pub motion: Motion,
}

static PLANNED: Mutex<BTreeMap<&str, &OnceLock<Shipped>>> = Mutex::new(BTreeMap::new());

/// The results of a scene, made on two threads by the first who asks.
pub fn shipped(scene: &'static str) -> &'static Shipped {
    let mut all = PLANNED.lock().expect("nothing panics with it");
    let once: &'static OnceLock<Shipped> = all
        .entry(scene)
        .or_insert_with(|| Box::leak(Box::default()));
    drop(all);
    once.get_or_init(|| Shipped::new(scene))
}

impl Shipped {
    fn new(scene: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("shipped");
        let said = succeeds(&format!("run {scene} --threads 2 -o @"), &[&folder]);
        let results = folder.join(scene);
        let plan = serde_json::from_str(&read(results.join("plan.json"))).expect("a plan");
        let motion = serde_json::from_str(&read(results.join("motion.json"))).expect("a motion");
        Self {
            results,
            said,
            plan,
            motion,
        }
    }
}
