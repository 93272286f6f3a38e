//! The organised path against the chain on the same frame, in the same run.
//!
//! Speed on one machine says little about another: what counts is the ratio, printed at the end.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use perception::{Method, extract};

#[path = "../tests/all/support.rs"]
mod support;

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
    let scan = support::scan(&support::stairs(), &support::pose(), true, 1);
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
        let config = support::by(method);
        group.bench_function(name, |bencher| {
            pool.install(|| bencher.iter(|| black_box(extract(&scan, &scan.X_WV, &config))));
        });
    }
    group.finish();

    let time = |method: Method, runs: usize| {
        let config = support::by(method);
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
