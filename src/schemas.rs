//! The JSON Schemas of the files that are read and written.

use plan::{Motion, Plan};
use scenes::SceneFile;
use scenes::contact_sets::ProblemSet;
use schemars::{Schema, schema_for};
use surfaces::Terrain;
use verify::Certificate;

use crate::config::Config;
use crate::extrinsics::file::Extrinsics;
use crate::report::Report;
use crate::search_file;
use crate::slope::record::SlopeFile;

/// The schema of each file by the file's usual name, of TOML as if it were JSON.
pub fn all() -> Vec<(&'static str, Schema)> {
    vec![
        ("camera", schema_for!(Extrinsics)),
        ("certificate", schema_for!(Certificate)),
        ("contacts", robot_model::load::contacts_schema()),
        ("motion", schema_for!(Motion)),
        ("plan", schema_for!(Plan)),
        ("posture_problems", schema_for!(ProblemSet)),
        ("report", schema_for!(Report)),
        ("scene", schema_for!(SceneFile)),
        ("search", search_file::schema()),
        ("settings", schema_for!(Config)),
        ("slope", schema_for!(SlopeFile)),
        ("surfaces", Terrain::schema()),
    ]
}
