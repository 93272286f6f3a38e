//! All that is done to scans before a robot is planned for: faces, obstacles and what was noticed.

use std::fmt;

use nalgebra::{Isometry3, Point3, Vector3};
use surfaces::free_space::{FreeSpace, RayEnd};
use surfaces::fuse::{self, View};
use surfaces::level::apply_level_prior;
use surfaces::loose::{is_loose, loose};
use surfaces::{Continued, Face, LookedThrough, Terrain, continue_under_steps, fill_unseen};

use crate::extraction::Statistics;
use crate::lidar::{LidarCalibration, LidarCloud, LidarCounts, segment_cloud};
use crate::looked::{Asked, looked};
use crate::registration::{Registration, register};
use crate::{Config, Error, Method, Scan, extract, plausible};

/// A scan and where it was taken from.
pub enum PosedScan<'a> {
    /// Of a camera, or a bare cloud, with the pose of its frame V in W.
    Scan {
        /// What notices call it.
        name: &'a str,
        /// The scan.
        scan: &'a Scan,
        /// Pose of V in W.
        X_WV: Isometry3<f64>,
    },
    /// Of a spinning LiDAR, with what is known of its mount.
    Lidar {
        /// What notices call it.
        name: &'a str,
        /// The sweep.
        cloud: &'a LidarCloud,
        /// Pose over the ground, ring errors, and how well both are known.
        mount: &'a LidarCalibration,
    },
}

impl PosedScan<'_> {
    /// Where the sensor was, in W after the scan was moved, m.
    pub fn eye_W(&self, moved_W: &Isometry3<f64>) -> Point3<f64> {
        match self {
            PosedScan::Scan { scan, X_WV, .. } => moved_W * X_WV * Point3::from(scan.eye_V),
            PosedScan::Lidar { mount, .. } => {
                moved_W * Point3::from(mount.X_WV().translation.vector)
            }
        }
    }

    /// What was looked through up to the measured points, in W after the scan was moved.
    pub fn looked_through(&self, moved_W: &Isometry3<f64>) -> LookedThrough {
        let count = match self {
            PosedScan::Scan { scan, .. } => scan.cloud.points.len(),
            PosedScan::Lidar { cloud, .. } => cloud.points_V.len(),
        };
        // An odd step goes through all columns of most images.
        let ends: Vec<[f32; 3]> = self.points_W(moved_W, (count / RAYS) | 1).collect();
        LookedThrough::new(self.eye_W(moved_W), &ends)
    }

    /// Every `step`th of the measured points, in W after the scan was moved, m.
    pub fn points_W(
        &self,
        moved_W: &Isometry3<f64>,
        step: usize,
    ) -> impl Iterator<Item = [f32; 3]> {
        let (points, X_WV) = match self {
            PosedScan::Scan { scan, X_WV, .. } => (&scan.cloud.points, *X_WV),
            PosedScan::Lidar { cloud, mount, .. } => (&cloud.points_V, mount.X_WV()),
        };
        // By a matrix, which takes half of what a quaternion does.
        let X = moved_W * X_WV;
        let (turn, shift) = (X.rotation.to_rotation_matrix(), X.translation.vector);
        let measured = |p: &&[f32; 3]| p.iter().all(|c| c.is_finite());
        let in_W = move |p: &[f32; 3]| {
            (turn * Vector3::from(p.map(f64::from)) + shift)
                .map(|x| x as f32)
                .into()
        };
        points.iter().step_by(step).filter(measured).map(in_W)
    }
}

/// So many rays tell what was looked through.
const RAYS: usize = 45_000;

/// What scans show.
#[derive(Debug, Clone, Default)]
pub struct Perception {
    /// Faces and obstacles in W.
    pub terrain: Terrain,
    /// By how much each scan was moved from the pose given.
    pub moved_W: Vec<Isometry3<f64>>,
    /// What was noticed, in the order in which it happened.
    pub notices: Vec<Notice>,
}

/// Something that a user should know of.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Notice {
    /// How many points of a scan lie on planes.
    Extracted {
        /// The scan.
        scan: String,
        /// Counts along the way.
        counts: Statistics,
    },
    /// An image with so many pixels missing that it is taken as a cloud.
    Sparse {
        /// The scan.
        scan: String,
    },
    /// Something in a scan that is likely a mistake.
    Doubt {
        /// The scan.
        scan: String,
        /// What it is.
        cause: String,
    },
    /// A face of a scan is left out.
    Refused {
        /// The scan.
        scan: String,
        /// What is wrong with its outline.
        cause: surfaces::Error,
    },
    /// How many points of a sweep were used.
    Sweep {
        /// The scan.
        scan: String,
        /// Counts along the way.
        counts: LidarCounts,
    },
    /// A slope of a sweep.
    Slope {
        /// Which.
        number: usize,
        /// Its angle to the ground and the standard deviation of that, rad.
        delta_rad: [f64; 2],
        /// Where its foot begins and ends, m.
        foot_W: [Point3<f64>; 2],
    },
    /// What stands around a LiDAR beside ground and slopes.
    Surroundings {
        /// Parts of walls.
        walls: usize,
        /// Upright bodies.
        obstacles: usize,
    },
    /// A scan was moved onto those before it.
    Registered(Box<Registration>),
    /// What became of a face as views were fused.
    Fused(fuse::Change),
    /// Bodies of what lies on no face.
    Loose(usize),
    /// Treads that are taken to go on under the steps before them.
    UnderSteps(Vec<Continued>),
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Extracted { scan, counts } => write!(
                f,
                "{scan}: {} of {} points measured, {} in range, {} on {} planes",
                counts.valid, counts.points, counts.used, counts.assigned, counts.planes
            ),
            Self::Sparse { scan } => write!(
                f,
                "warning: {scan}: too many pixels are missing: taken as a cloud (method voxels)"
            ),
            Self::Doubt { scan, cause } => write!(f, "warning: {scan}: {cause}"),
            Self::Refused { scan, cause } => {
                write!(f, "warning: {scan}: a face is left out: {cause}")
            }
            Self::Sweep { scan, counts } => write!(
                f,
                "{scan}: {} points, {} in view, {} not isolated, {} on the ground",
                counts.points, counts.in_view, counts.kept, counts.ground
            ),
            Self::Slope {
                number,
                delta_rad: [delta, sigma],
                foot_W: [a, b],
            } => write!(
                f,
                "slope {number}: {:.2}° ± {:.2}°, from ({:.3}, {:.3}) to ({:.3}, {:.3}) m",
                delta.to_degrees(),
                sigma.to_degrees(),
                a.x,
                a.y,
                b.x,
                b.y
            ),
            Self::Surroundings { walls, obstacles } => {
                write!(
                    f,
                    "{walls} parts of walls, {obstacles} clusters of obstacles around"
                )
            }
            Self::Registered(found) => {
                let shift = (found.X_W * found.about_W - found.about_W).norm();
                let (before, after) = found.offset_rms_m;
                write!(
                    f,
                    "    registered by {} planes: moved by {:.1} mm and {:.2}°; they lay {:.1} mm \
                     apart, now {:.1} mm (χ² per degree of freedom {:.2})",
                    found.pairs.len(),
                    1e3 * shift,
                    found.X_W.rotation.angle().to_degrees(),
                    1e3 * before,
                    1e3 * after,
                    found.misfit
                )?;
                match found.open.is_empty() {
                    true => Ok(()),
                    false => write!(f, "; as given stay {}", found.open.join(", ")),
                }
            }
            Self::Fused(change) => change.fmt(f),
            Self::Loose(bodies) => write!(
                f,
                "{bodies} bodies of what was seen and lies on no face: only kept away from"
            ),
            Self::UnderSteps(treads) => {
                f.write_str("taken to go on to below the edges of the steps that hide them:")?;
                treads.iter().enumerate().try_for_each(|(k, tread)| {
                    let Continued {
                        face, under, by_m, ..
                    } = tread;
                    let comma = if k > 0 { "," } else { "" };
                    write!(f, "{comma} {face} by {by_m:.2} m under {under}")
                })
            }
        }
    }
}

/// Standard deviation of a LiDAR's range where its rings are not calibrated, m.
const LIDAR_SIGMA_M: f64 = 0.015;

/// Faces and obstacles of scans, later ones after earlier ones in time.
///
/// Each scan is extracted; where [`Config::registration`] asks for it, it is moved onto those before it; faces that
/// may be level are taken to be; faces that more than one scan shows are made one, and
/// what a later scan looks through is taken off; what lies on no face is kept away from; where nothing was seen
/// things go on.
///
/// # Errors
/// As [`extract`] and [`segment_cloud`], [`Error::OutOfRange`] of a scan with hardly a point in range, and
/// [`Error::NoGround`] of a sweep without ground.
pub fn perceive(scans: &[PosedScan], config: &Config) -> Result<Perception, Error> {
    let mut found = Perception::default();
    let mut views: Vec<View> = Vec::new();
    let several = scans.len() > 1;
    for (number, scan) in scans.iter().enumerate() {
        // 1. What the scan shows by itself.
        let mut view = match scan {
            PosedScan::Scan { name, scan, X_WV } => {
                let (mut view, on_face) = of_scan(name, scan, X_WV, config, &mut found.notices)?;
                let of = Asked {
                    through: several,
                    beside: config.avoid_loose,
                };
                view.free_space = looked(scan, X_WV, config.range_max_m, &on_face, of);
                view
            }
            PosedScan::Lidar { name, cloud, mount } => {
                of_sweep(name, cloud, mount, config, &mut found.notices)?
            }
        };
        // 2. In its place among those before it.
        if number > 0 {
            view.prefix_ids(&format!("scan{number}-"));
        }
        let mut moved_W = Isometry3::identity();
        if number > 0 && config.registration.refine {
            let known = views.iter().flat_map(|view: &View| &view.faces);
            let faces: Vec<Face> = known.cloned().collect();
            let eye_W = &view.free_space.eye_W;
            let registration = register(&faces, &view.faces, eye_W, &config.registration)?;
            view.move_by(&registration.X_W);
            view.doubt(&registration.covariance, &registration.about_W);
            moved_W = registration.X_W;
            let notice = Notice::Registered(Box::new(registration));
            found.notices.push(notice);
        }
        found.moved_W.push(moved_W);
        // 3. Level as the scan's pose has it by now: with the one given its tilt would go into the faces.
        if config.assume_level && matches!(scan, PosedScan::Scan { .. }) {
            view.faces.iter_mut().for_each(apply_level_prior);
        }
        views.push(view);
    }
    // 4. Faces that more than one scan shows are one.
    let seen: Vec<FreeSpace> = (views.iter_mut())
        .map(|view| match several {
            true => view.free_space.clone(),
            false => std::mem::take(&mut view.free_space),
        })
        .collect();
    let fused = if config.fuse_views {
        fuse::fuse(views)
    } else {
        fuse::side_by_side(views)
    };
    found
        .notices
        .extend(fused.changes.into_iter().map(Notice::Fused));
    found.terrain = fused.terrain;
    // 5. What a camera shows beside the faces: a sweep's things are known by now.
    if config.avoid_loose {
        let cameras = scans.iter().zip(&seen);
        let cameras = cameras.filter(|(scan, _)| matches!(scan, PosedScan::Scan { .. }));
        let cameras: Vec<&FreeSpace> = cameras.map(|(_, seen)| seen).collect();
        let loose = loose(&found.terrain.faces, &cameras);
        let things = loose.iter().filter(|body| is_loose(body)).count();
        if things > 0 {
            found.notices.push(Notice::Loose(things));
        }
        found.terrain.obstacles.extend(loose);
    }
    // 6. Where things may go on that no view showed.
    let (depth_m, reach_m) = (config.unseen_depth_m, config.unseen_reach_m);
    let others = if several { &seen[..] } else { &[] };
    let unseen = fill_unseen(&mut found.terrain.faces, others, depth_m, reach_m);
    found.terrain.obstacles.extend(unseen);
    // 7. Treads whose backs the steps before them hide.
    let faces = &mut found.terrain.faces;
    let (treads, columns) = continue_under_steps(faces, config.under_steps_m);
    found.terrain.obstacles.extend(columns);
    if !treads.is_empty() {
        found.notices.push(Notice::UnderSteps(treads));
    }
    Ok(found)
}

/// A scan with less than this part of its points in range shows nothing.
const IN_RANGE_MIN: f64 = 0.01;
/// The view of a camera or a bare cloud, and which of its points a face surely holds.
fn of_scan(
    name: &str,
    scan: &Scan,
    X_WV: &Isometry3<f64>,
    config: &Config,
    notices: &mut Vec<Notice>,
) -> Result<(View, Vec<bool>), Error> {
    let extraction = extract(scan, X_WV, config)?;
    let Statistics { valid, used, .. } = extraction.statistics;
    let doubts = plausible::doubts(scan, config.range_max_m);
    // Of a wrong model nothing may be in range either.
    if (used as f64) < IN_RANGE_MIN * valid as f64 && doubts.is_empty() {
        let away = |p: &[f32; 3]| (Vector3::from(p.map(f64::from)) - scan.eye_V).norm();
        let mut away_m: Vec<f64> = scan.cloud.finite().map(away).collect();
        let middle = away_m.len() / 2;
        return Err(Error::OutOfRange {
            scan: name.to_owned(),
            used,
            points: valid,
            median_m: *away_m.select_nth_unstable_by(middle, f64::total_cmp).1,
            range_max_m: config.range_max_m,
        });
    }
    for cause in doubts {
        let scan = name.to_owned();
        notices.push(Notice::Doubt { scan, cause });
    }
    notices.push(Notice::Extracted {
        scan: name.to_owned(),
        counts: extraction.statistics,
    });
    if config.method == Method::Auto && scan.depth.is_some() && extraction.method == Method::Voxels
    {
        notices.push(Notice::Sparse {
            scan: name.to_owned(),
        });
    }
    notices.extend(extraction.refused.into_iter().map(|cause| Notice::Refused {
        scan: name.to_owned(),
        cause,
    }));
    let view = View {
        faces: extraction.faces,
        ..View::default()
    };
    Ok((view, extraction.on_face))
}

/// The view of a LiDAR.
fn of_sweep(
    name: &str,
    cloud: &LidarCloud,
    mount: &LidarCalibration,
    config: &Config,
    notices: &mut Vec<Notice>,
) -> Result<View, Error> {
    let seen = segment_cloud(cloud, Some(mount), &config.lidar)?;
    let points = seen.counts.kept;
    let scan = seen.scan.ok_or(Error::NoGround { points })?;
    notices.push(Notice::Sweep {
        scan: name.to_owned(),
        counts: scan.counts,
    });
    for (number, slope) in scan.slopes.iter().enumerate() {
        let d = &slope.description;
        notices.push(Notice::Slope {
            number,
            delta_rad: [d.delta_rad, slope.delta_sigma_rad],
            foot_W: [d.p1_W, d.p2_W],
        });
    }
    notices.push(Notice::Surroundings {
        walls: seen.around.walls.len(),
        obstacles: seen.around.things.len(),
    });
    let mut faces = scan.faces();
    faces.extend(seen.around.faces().cloned());
    let end = |p: &[f32; 3]| RayEnd {
        p_W: Point3::from(p.map(f64::from)),
        sigma_m: LIDAR_SIGMA_M,
    };
    Ok(View {
        faces,
        obstacles: seen.around.obstacles().cloned().collect(),
        free_space: FreeSpace {
            eye_W: Point3::from(mount.X_WV().translation.vector),
            points: scan.points_W.iter().map(end).collect(),
            ..FreeSpace::default()
        },
    })
}
