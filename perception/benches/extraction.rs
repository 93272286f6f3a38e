//! The organised path against the chain on the same frame, in the same run.
//!
//! Speed on one machine says little about another: what counts is the ratio, printed at the end.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use perception::{Config, Method, Scan, extract};

#[path = "../tests/all/support.rs"]
mod support;

/// Steps, a table, a wall and a ramp, 640 × 480, with the errors of an Xtion.
fn frame() -> Scan {
    let world = [
        support::block("floor", [4.0, 0.0, -0.05], [12.0, 12.0, 0.1], 0.0, 0.0),
        support::block("wall", [4.35, 0.0, 1.5], [0.1, 12.0, 3.0], 0.0, 0.0),
        support::block("step1", [1.15, 0.05, 0.075], [0.34, 0.62, 0.15], 0.1, 0.0),
        support::block("step2", [1.50, -0.02, 0.15], [0.36, 0.70, 0.30], -0.07, 0.0),
        support::block("step3", [1.88, 0.06, 0.22], [0.38, 0.55, 0.44], 0.05, 0.0),
        support::block(
            "step4",
            [2.26, -0.03, 0.285],
            [0.36, 0.60, 0.57],
            -0.12,
            0.0,
        ),
        support::block("table", [2.90, 0.0, 0.695], [0.80, 1.60, 0.03], 0.02, 0.0),
        support::block("ramp", [1.9, -1.15, 0.105], [1.2, 0.8, 0.04], 0.0, -0.21),
    ];
    support::scan(&world, &support::camera(1.45, 0.61), true, 1)
}

fn config(method: Method) -> Config {
    Config {
        method,
        ..Config::default()
    }
}

/// Median time of a few runs.
fn median(runs: usize, mut run: impl FnMut()) -> Duration {
    let mut times: Vec<Duration> = (0..runs)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed()
        })
        .collect();
    times.sort();
    times[runs / 2]
}

fn benches(criterion: &mut Criterion) {
    let scan = frame();
    // One thread: that is what the figures of others are given for.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a thread pool");
    let mut group = criterion.benchmark_group("extract 640x480, one thread");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(8));
    for (name, method) in [
        ("organised", Method::Organised),
        ("chain", Method::Brossette2013),
    ] {
        let config = config(method);
        group.bench_function(name, |bencher| {
            pool.install(|| bencher.iter(|| black_box(extract(&scan, &scan.X_WV, &config))));
        });
    }
    group.finish();

    let time = |method: Method, runs: usize| {
        let config = config(method);
        pool.install(|| {
            median(runs, || {
                black_box(extract(&scan, &scan.X_WV, &config)).ok();
            })
        })
    };
    let (organised, chain) = (time(Method::Organised, 21), time(Method::Brossette2013, 5));
    let ratio = chain.as_secs_f64() / organised.as_secs_f64();
    println!(
        "organised {organised:.2?}, chain {chain:.2?}: the organised path is {ratio:.0}× faster"
    );
    let reading = median(21, || {
        black_box(scan.depth.as_ref().map(|depth| depth.to_cloud()));
    });
    println!(
        "points of the depth image: {reading:.2?} ({} px)",
        scan.cloud.points.len()
    );
}

criterion_group!(extraction, benches);
criterion_main!(extraction);
