//! Loads every URDF below the given folders and prints one line each: what became of it.
//!
//!   cargo run -p robot_model --example load_all -- third_party/example-robot-data

use std::path::{Path, PathBuf};

use robot_model::{Config, RobotFiles, load};

fn main() {
    let mut urdfs = Vec::new();
    for folder in std::env::args().skip(1) {
        collect(Path::new(&folder), &mut urdfs);
    }
    urdfs.sort();
    let (mut strict, mut lenient) = (0, 0);
    for urdf in &urdfs {
        let name = urdf.file_name().unwrap_or_default().to_string_lossy();
        let config = Config {
            lenient: true,
            ..Config::default()
        };
        let files = RobotFiles::new(urdf);
        let forgiving = RobotFiles {
            config,
            ..files.clone()
        };
        let (robot, how) = match load(&files) {
            Ok(robot) => (robot, ""),
            Err(error) => {
                println!("{name:36} refused: {error}");
                match load(&forgiving) {
                    Ok(robot) => (robot, " (lenient)"),
                    Err(_) => continue,
                }
            }
        };
        if how.is_empty() {
            strict += 1
        } else {
            lenient += 1
        }
        println!(
            "{name:36} {:3} joints {:4} frames {:3} shapes {:5} pairs {:9.3} kg {:3} notes{how}",
            robot.nj(),
            robot.frames.len(),
            robot.collision.shapes().len(),
            robot.collision.pairs().len(),
            robot.mass_kg,
            robot.notes.len(),
        );
        if std::env::var_os("NOTES").is_some() {
            for note in &robot.notes {
                println!("    {note}");
            }
        }
    }
    println!(
        "{} files: {strict} load, {lenient} more when lenient",
        urdfs.len()
    );
}

fn collect(folder: &Path, urdfs: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            collect(&path, urdfs);
        } else if path.extension().is_some_and(|e| e == "urdf") {
            urdfs.push(path);
        }
    }
}
