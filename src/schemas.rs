//! The JSON Schemas of the files that are read and written.

use plan::{Motion, Plan};
use scenes::SceneFile;
use scenes::contact_sets::ProblemSet;
use schemars::{Schema, schema_for};
use surfaces::Terrain;
use verify::Certificate;

use crate::batch::Record;
use crate::bench::Row;
use crate::config::Config;
use crate::extrinsics::file::Extrinsics;
use crate::report::Report;
use crate::search_file;
use crate::simulate::report::Report as Simulation;
use crate::slope::record::SlopeFile;
use crate::told::Document;

/// The schema of each file by the file's usual name, of TOML as if it were JSON.
pub fn all() -> Vec<(&'static str, Schema)> {
    vec![
        ("batch_item", schema_for!(Record)),
        ("bench_row", schema_for!(Row)),
        ("camera", schema_for!(Extrinsics)),
        ("certificate", schema_for!(Certificate)),
        ("contacts", robot_model::load::contacts_schema()),
        ("document", schema_for!(Document)),
        ("motion", schema_for!(Motion)),
        ("plan", schema_for!(Plan)),
        ("posture_problems", schema_for!(ProblemSet)),
        ("report", schema_for!(Report)),
        ("scene", schema_for!(SceneFile)),
        ("search", search_file::schema()),
        ("settings", schema_for!(Config)),
        ("simulation", schema_for!(Simulation)),
        ("slope", schema_for!(SlopeFile)),
        ("surfaces", Terrain::schema()),
    ]
}
