//! Takes the sweeps of a simulated VLP-16 of the ramps of [meng] and writes them as PCD and pcap.
//!
//! ```sh
//! cargo run -p scandent-scenes --example make_lidar FOLDER [SEED]
//! ```

use std::path::PathBuf;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use scenes::simulator::lidar::{RangeNoise, Vlp16, pcap, pcd, sweep};
use scenes::worlds::slope;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let folder = PathBuf::from(args.next().ok_or("which folder?")?);
    let seed: u64 = args.next().map_or(Ok(1), |text| text.parse())?;
    std::fs::create_dir_all(&folder)?;
    let [roll, pitch, yaw] = [1.5, 8.0, 3.0].map(f64::to_radians);
    let X_WV = Isometry3::from_parts(
        Translation3::new(0.0, 0.0, 0.75),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    );
    let sensor = Vlp16::default();
    for row in slope::PAPER {
        let name = format!("slope-{}", row.angle_deg);
        let world = slope::room(&name, &[row.ramp()]).world();
        let taken = sweep(&world, &sensor, &X_WV, &RangeNoise::default(), seed, seed);
        std::fs::write(folder.join(format!("{name}.pcd")), pcd(&taken))?;
        std::fs::write(folder.join(format!("{name}.pcap")), pcap(&sensor, &taken))?;
        println!("{name}: {} of {} beams", taken.returns.len(), taken.beams);
    }
    Ok(())
}
