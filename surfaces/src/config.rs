//! The settings of this crate.

use serde::{Deserialize, Serialize};

use crate::{level, merge, mesh, rim, role, thin_body};

/// Every setting of the crate; the defaults work.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// How deep the bodies behind surfaces are.
    pub body: thin_body::Config,
    /// How strongly scanned faces that may be level are taken to be.
    pub level: level::Config,
    /// How faces of several scans are made one.
    pub merge: merge::Config,
    /// How a mesh is taken apart.
    pub mesh: mesh::Config,
    /// How far the bodies of scanned faces go beyond what can be touched.
    pub rim: rim::Config,
    /// Which surfaces serve which role.
    pub roles: role::Config,
}
