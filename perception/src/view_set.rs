//! ViewSet scans of one environment: their poses refined where asked for, their surfaces one set.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Point3};
use surfaces::Surface;
use surfaces::merge::{self, Merged, Seen, Sight, View};

use crate::config::Config;
use crate::registration::{Registration, RegistrationConfig, register};
use crate::scan::Scan;
use crate::{Error, extract};

/// Scans one after the other, each in W.
#[derive(Debug, Clone, Default)]
pub struct ViewSet {
    views: Vec<View>,
}

impl ViewSet {
    /// Adds what a scan showed; ids and face names of all scans but the first get a prefix with the
    /// scan's number. Where `config` asks for it, the view is first registered with all before it.
    ///
    /// What comes back says how the view was moved, or why it stays where it was; `None` where
    /// nothing was asked for or nothing is known yet.
    pub fn add(
        &mut self,
        mut view: View,
        config: &RegistrationConfig,
    ) -> Option<Result<Registration, Error>> {
        let number = self.views.len();
        if number > 0 {
            view.name(&format!("scan{number}-"));
        }
        let registration = (config.refine && number > 0).then(|| {
            let known: Vec<Surface> =
                (self.views.iter().flat_map(|v| &v.surfaces).cloned()).collect();
            register(&known, &view.surfaces)
        });
        if let Some(Ok(found)) = &registration {
            view.move_by(&found.X_W);
        }
        self.views.push(view);
        registration
    }

    /// The surfaces as one set ([`merge::merge`]).
    pub fn merged(self, config: &merge::Config) -> Merged {
        merge::merge(self.views, config)
    }
}

/// What a scan taken from `X_WV` looked through: every `step`-th of its points.
pub fn sight(scan: &Scan, X_WV: &Isometry3<f64>, range_max_m: f64, step: usize) -> Sight {
    let eye_W = X_WV * Point3::from(scan.eye_V);
    let seen = |p: &[f32; 3]| {
        let p_V = Point3::from(p.map(f64::from));
        let range = (p_V.coords - scan.eye_V).norm();
        let sigma = scan.noise.sigma_z_m(range);
        (range <= range_max_m).then(|| Seen {
            p_W: X_WV * p_V,
            sigma_m: sigma.hypot(scan.noise.systematic_ratio * range),
        })
    };
    Sight {
        eye_W,
        points: (scan.cloud.finite().step_by(step.max(1)))
            .filter_map(seen)
            .collect(),
    }
}

/// One in so many points of a scan is enough to tell what it looked through.
pub const SIGHT_STEP: usize = 4;

/// The surfaces of several scans, each taken from its own pose, as one set: faces that more than one
/// shows are one and keep the id that they have in the first ([`merge::merge`]).
///
/// # Errors
/// As [`extract`]; where poses are to be refined, why one could not be.
pub fn extract_all(
    scans: &[(&Scan, Isometry3<f64>)],
    config: &Config,
    merging: &merge::Config,
) -> Result<Merged, Error> {
    let mut several = ViewSet::default();
    for (scan, X_WV) in scans {
        let found = extract(scan, X_WV, config)?;
        let view = View {
            surfaces: found.surfaces,
            obstacles: found.obstacles,
            sight: sight(scan, X_WV, config.range_max_m, SIGHT_STEP),
        };
        if let Some(registered) = several.add(view, &config.registration) {
            registered?;
        }
    }
    Ok(several.merged(merging))
}
