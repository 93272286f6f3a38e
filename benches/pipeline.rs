//! The whole way of each scene that ships, on one thread: perception, planning, verification.
//!
//! The last lines set the medians beside the figures that [brossette2013] gives for its two plans
//! (2.7 s of perception, 98.4 s and 122.3 s of planning on one thread of an i7-3840QM): another
//! machine and other scenes of the same kind, so the ratio is an order of magnitude, no race.
#![allow(missing_docs, clippy::expect_used)]

use std::hint::black_box;
use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;

use criterion::{Criterion, criterion_group, criterion_main};
use scandent::config::Config;
use scandent::pipeline::{self, PlanOutcome, RunOptions};
use scandent::provenance::Inputs;
use scandent::robot_files::Robots;
use scandent::scene::Scene;

/// Scene, and the paper's seconds of perception and planning for its counterpart.
const SCENES: [(&str, f64, f64); 2] = [
    ("irregular-stairs", 2.7, 98.4),
    ("slope-and-hand", 2.7, 122.3),
];

fn plan(name: &str) -> PlanOutcome {
    let mut inputs = Inputs::default();
    let scene = Scene::open(name, &mut inputs).expect("the scene ships");
    let global = scandent::cli::Global::default();
    let config = Config::layered(Some((&scene.name, &scene.settings)), &global).expect("defaults");
    let cancel = AtomicBool::new(false);
    let manner = RunOptions {
        threads: NonZeroUsize::new(1),
        stage: &|_| {},
        progress: &|_| {},
        cancel: &cancel,
        robots: &Robots::default(),
    };
    pipeline::plan(&scene, &config, &manner, inputs).expect("a plan")
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn benches(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("pipeline");
    group.sample_size(10);
    for (name, ..) in SCENES {
        group.bench_function(name, |b| b.iter(|| black_box(plan(name))));
    }
    group.finish();

    println!("scene              stage        median ms   the paper's s   ratio   nodes   stances");
    for (name, perception_s, planning_s) in SCENES {
        let runs: Vec<PlanOutcome> = (0..11).map(|_| plan(name)).collect();
        for (stage, paper_s) in [("perception", perception_s), ("planning", planning_s)] {
            let ms = median(runs.iter().map(|run| run.report.stages_ms[stage]).collect());
            let report = &runs[0].report;
            println!(
                "{name:<18} {stage:<12} {ms:>9.1}   {paper_s:>13.1} {:>7.0}   {:>5}   {:>7}",
                1e3 * paper_s / ms,
                report.nodes_generated,
                report.path_stances
            );
        }
    }
}

criterion_group!(pipeline_benches, benches);
criterion_main!(pipeline_benches);
