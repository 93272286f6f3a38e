//! A search, and what is told of its answer: plan, file of the motion, verdict.

use anyhow::{Context, Result};
use plan::{Input, MotionFile, PLAN_FORMAT, Plan, RequiredMargins};
use planner::{Guide, Progress, Request, SearchResult, Status, Tree};
use posture::{Environment, FaceIndex};
use verify::Certificate;

use super::{MOTION_FILE, RunOptions};
use crate::config::Config;
use crate::posed::{self, Posed};
use crate::report::{Clock, Stages};
use crate::scene::Scene;
use crate::unseen::{self, Unseen, Wall};
use crate::{goal, provenance};

/// What is planned for, and how.
pub(super) struct Run<'a> {
    pub scene: &'a Scene,
    pub config: &'a Config,
    pub options: &'a RunOptions<'a>,
    pub pool: &'a rayon::ThreadPool,
    pub posed: &'a Posed,
    pub guide: Guide,
    pub usable: Vec<Vec<FaceIndex>>,
    pub inputs: Vec<Input>,
    pub stages: Stages,
}

/// An answer of the search with all that is told of it.
pub(super) struct Told {
    pub answer: SearchResult,
    pub plan: Plan,
    pub motion_json: Vec<u8>,
    pub through: Option<Unseen>,
    pub certificate: Certificate,
}

impl Told {
    /// Walls that would be met if they went straight on.
    pub fn walls(&self) -> &[Wall] {
        self.through.as_ref().map_or(&[], |through| &through.walls)
    }

    pub fn is_verified(&self) -> bool {
        self.answer.status == Status::Found && self.certificate.pass
    }
}

impl<'a> Run<'a> {
    /// What is asked of the planner in an environment with the faces of the scene's.
    fn request<'e>(&self, environment: &'e Environment) -> Request<'e>
    where
        'a: 'e,
    {
        let posed = self.posed;
        Request {
            robot: &posed.robot,
            environment,
            start: posed.start.clone(),
            goal: posed.goal.clone(),
            guide: self.guide.clone(),
            usable: self.usable.clone(),
            reference: posed.stand.nominal.clone(),
        }
    }

    /// Searches in an environment with the faces of the scene's; on from what was grown in one with fewer bodies, where
    /// there is such a tree.
    pub fn search(
        &mut self,
        environment: &Environment,
        planner: &planner::Config,
        tree: Option<Tree>,
    ) -> Result<(SearchResult, Option<Tree>), planner::Error> {
        let (config, options) = (self.config, self.options);
        let clock = Clock::default();
        let request = self.request(environment);
        let progress = |progress: Progress| {
            clock.note(progress.stage);
            (options.progress)(&progress);
        };
        let (posture, motion) = (&config.posture, &config.motion);
        let cancel = options.cancel;
        let search = || match tree {
            Some(tree) => {
                planner::search_on(tree, &request, planner, posture, motion, &progress, cancel)
            }
            None => planner::grow(&request, planner, posture, motion, &progress, cancel),
        };
        let (answer, tree) = self
            .pool
            .install(|| self.stages.measure("planning", search))?;
        self.stages.split("planning", "motion", clock.motion_ms());
        let (status, tried) = (answer.status, answer.summary.candidates_solved);
        let nodes = answer.summary.nodes_generated;
        tracing::info!("{status:?}: {nodes} contact sets, {tried} posture problems");
        Ok((answer, tree))
    }

    /// The walls that would be met on an answer's way if they went straight on, as far as that is known before it is timed.
    ///
    /// # Errors
    /// A configuration that is not the robot's.
    pub fn walls(&mut self, answer: &SearchResult) -> Result<Vec<Wall>> {
        let posed = self.posed;
        let ways = answer.segments.iter().enumerate();
        let ways = ways.flat_map(|(stance, way)| way.configurations().map(move |q| (stance, q)));
        let look = || unseen::walls(ways, &posed.robot, &posed.terrain.faces, &posed.looked);
        self.stages.measure("unseen", look)
    }

    /// The plan of an answer that was found in an environment, in time, and the verdict of code that shares nothing with the
    /// search.
    ///
    /// # Errors
    /// What cannot be written, or read again.
    pub fn told(&mut self, answer: SearchResult, found_in: &Environment) -> Result<Told> {
        let request = self.request(found_in);
        let (posed, config, scene, stages) =
            (self.posed, self.config, self.scene, &mut self.stages);
        let (posture, motion) = (&config.posture, &config.motion);
        let timed = || answer.timed(&request, posture, motion);
        let answer = self.pool.install(|| stages.measure("planning", timed));
        let (robot, environment) = (&posed.robot, &posed.environment);
        // Motion → file, and the plan that names it.
        let mut motion_json = Vec::new();
        let motion_file = match &answer.motion {
            Some(motion) => {
                motion_json = stages.measure("writing", || serde_json::to_vec(motion))?;
                Some(MotionFile {
                    file: MOTION_FILE.to_owned(),
                    sha256: provenance::sha256(&motion_json),
                    duration_s: motion.duration_s(),
                    samples: motion.samples.len(),
                })
            }
            None => None,
        };
        let plan = Plan {
            format: PLAN_FORMAT.to_owned(),
            program: crate::program(),
            scene: scene.name.clone(),
            seed: config.seed,
            config: serde_json::to_value(config).context("the settings")?,
            inputs: self.inputs.clone(),
            robot: posed::summary(robot),
            faces: posed.terrain.faces.clone(),
            obstacles: posed.terrain.obstacles.clone(),
            thin_body_m: config.surfaces.body.thickness_m,
            required: RequiredMargins::from(&config.posture),
            goal: goal::record(&posed.goal, robot, environment),
            stances: planner::record::stances(robot, environment, &answer.path),
            motion: motion_file,
            search: answer.summary.clone(),
        };
        let motion = answer.motion.as_ref();
        let through = || unseen::unseen(&plan, motion, robot, &posed.looked);
        let through = stages.measure("unseen", through)?;
        let certificate = self.pool.install(|| {
            stages.measure("verify", || {
                let mut world = posed.world(config, &scene.name)?;
                through.iter().for_each(|through| through.tell(&mut world));
                anyhow::Ok(verify::verify_in(&plan, motion, robot, &world))
            })
        })?;
        Ok(Told {
            answer,
            plan,
            motion_json,
            through,
            certificate,
        })
    }
}
