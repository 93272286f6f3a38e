//! The LiDAR chain on one sweep of 21 600 beams, one thread: filter, ground, slope, description.
//!
//! The medians are printed at the end; `benches/peers/slope.sh` sets them beside PCL's.
//!
//! ```sh
//! cargo bench -p scandent-perception --bench lidar
//! ```

use std::hint::black_box;
use std::path::Path;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use perception::lidar::{LidarCloud, LidarConfig, detect};
use perception::parse_lidar;

#[path = "../tests/all/ramps.rs"]
mod ramps;

/// A sweep of the ramp of 15.3°, or the PCD that `SCANDENT_CLOUD` names.
fn cloud() -> LidarCloud {
    if let Some(path) = std::env::var_os("SCANDENT_CLOUD") {
        let path = Path::new(&path);
        let bytes = std::fs::read(path).expect("SCANDENT_CLOUD names a file");
        return parse_lidar(path, &bytes, None)
            .expect("a LiDAR's file")
            .cloud;
    }
    let row = scenes::worlds::slope::PAPER[2];
    let truth = scenes::worlds::slope::room("bench", &[row.ramp()]);
    ramps::cloud(&ramps::take(&truth, &ramps::usual_mount(), 1))
}

/// The median time of `run`.
fn median(mut run: impl FnMut()) -> Duration {
    let mut times: Vec<Duration> = (0..51)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed()
        })
        .collect();
    times.sort();
    times[times.len() / 2]
}

fn benches(criterion: &mut Criterion) {
    let cloud = cloud();
    let config = LidarConfig::default();
    // The chain of a cloud with rings runs on the thread that calls it.
    criterion.bench_function("slope of a sweep", |b| {
        b.iter(|| black_box(detect(&cloud, None, &config)));
    });
    let whole = median(|| {
        black_box(detect(&cloud, None, &config)).ok();
    });
    println!(
        "{} points: {whole:.2?}; at most 20 ms are wanted",
        cloud.len()
    );
}

criterion_group!(lidar, benches);
criterion_main!(lidar);
