//! Drawn posture problems of every family, for the robots that ship: how many are solved and how
//! long that takes, on one thread.
//!
//! Each problem is solved three times and its median counts; families are told apart, and in each
//! the problems with a posture from those without. `SCANDENT_BENCH_POSTURES` says how many problems
//! a family has (60).
#![allow(missing_docs, clippy::expect_used)]

use std::hint::black_box;
use std::time::Instant;

use robot_model::Robot;
use scandent::posture_problem;
use scenes::contact_sets::{Family, generate};

const ROBOTS: [&str; 2] = ["hrp2", "hexapod"];
const SEED: u64 = 1;
const REPEATS: usize = 3;

fn robot(name: &str) -> Robot {
    scenes::robot(name).expect("it ships")
}

/// The value below which the part `q` of the values lies: the nearest rank.
fn quantile(values: &mut [f64], q: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let rank = (q * values.len() as f64).ceil() as usize;
    values
        .get(rank.saturating_sub(1))
        .copied()
        .unwrap_or(f64::NAN)
}

/// A quantile in µs; a dash where there is nothing to tell of.
fn told(values: &mut [f64], q: f64) -> String {
    match quantile(values, q) {
        us if us.is_nan() => "–".to_owned(),
        us => format!("{us:.0}"),
    }
}

/// Times of the solved and of the failed problems of a family, µs.
fn times(robot: &Robot, family: Family, count: usize) -> [Vec<f64>; 2] {
    let config = posture::Config::default();
    let margins = scandent::posture_problem::margins(&config);
    let set = generate(robot, &[family], &margins, count, SEED).expect("problems");
    let reference = robot.resting();
    let mut us = [Vec::new(), Vec::new()];
    for problem in &set.problems {
        let posed =
            posture_problem::pose(problem, robot, &reference, set.body_m).expect("a problem");
        let problem = posed.problem(robot);
        let mut solved = false;
        let mut repeats: Vec<f64> = (0..REPEATS)
            .map(|_| {
                let begin = Instant::now();
                let outcome = posture::solve(black_box(&problem), &config).expect("a problem");
                solved = black_box(outcome).posture().is_some();
                begin.elapsed().as_secs_f64() * 1e6
            })
            .collect();
        us[usize::from(!solved)].push(quantile(&mut repeats, 0.5));
    }
    us
}

fn main() {
    // `cargo test --benches` only asks whether it runs.
    let testing = std::env::args().any(|arg| arg == "--test");
    let count = std::env::var("SCANDENT_BENCH_POSTURES").map_or(60, |text| {
        text.parse()
            .expect("SCANDENT_BENCH_POSTURES is a number of problems")
    });
    let count = if testing { 1 } else { count };
    println!("robot    family      solved         median µs   95 %      failed: median µs   95 %");
    for name in ROBOTS {
        let robot = robot(name);
        for family in Family::ALL.into_iter().filter(|f| f.suits(&robot)) {
            let [mut solved, mut failed] = times(&robot, family, count);
            println!(
                "{name:<8} {:<11} {:>4} of {:<4} {:>12} {:>6} {:>22} {:>6}",
                family.name(),
                solved.len(),
                count,
                told(&mut solved, 0.5),
                told(&mut solved, 0.95),
                told(&mut failed, 0.5),
                told(&mut failed, 0.95),
            );
        }
    }
}
