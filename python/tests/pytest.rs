//! The package's own tests, in Python, on the library that cargo built: pytest, and mypy by its strict rules.
//!
//! Python comes from `target/python-venv`, which `scripts/test` makes; without it nothing is tested. The
//! program that they compare with is the one beside the library: `cargo test --workspace` builds both.
#![allow(missing_docs, clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::Command;

/// The package as pip would install it: its sources with the library among them.
fn installed(sources: &Path, built: &Path) -> PathBuf {
    let site = built.join("python-site");
    let package = site.join("scandent");
    let _ = std::fs::remove_dir_all(&package);
    std::fs::create_dir_all(&package).unwrap();
    for entry in std::fs::read_dir(sources.join("scandent")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            std::fs::copy(&path, package.join(path.file_name().unwrap())).unwrap();
        }
    }
    let library =
        ["lib_scandent.so", "lib_scandent.dylib"].map(|name| built.join("deps").join(name));
    let library = library.iter().find(|path| path.exists()).unwrap();
    std::fs::copy(library, package.join("_scandent.abi3.so")).unwrap();
    site
}

mod slow {
    use super::*;

    #[test]
    fn the_package_passes_its_tests_and_is_typed() {
        let sources = Path::new(env!("CARGO_MANIFEST_DIR"));
        let test = std::env::current_exe().unwrap();
        let built = test.ancestors().nth(2).unwrap();
        let python = built.parent().unwrap().join("python-venv/bin/python");
        if !python.exists() {
            eprintln!("SKIPPED: no {}: scripts/test makes it", python.display());
            return;
        }
        let site = installed(sources, built);
        let program = built.join("scandent");
        for (folder, what) in [
            // Python looks for modules where it runs: not beside the sources, which have no library.
            ("tests", "pytest -q -rs -p no:cacheprovider"),
            (".", "mypy --cache-dir=/dev/null scandent tests"),
        ] {
            let mut command = Command::new(&python);
            command
                .arg("-m")
                .args(what.split(' '))
                .current_dir(sources.join(folder));
            command
                .env("PYTHONPATH", &site)
                .env("PYTHONDONTWRITEBYTECODE", "1");
            // With the feature `mujoco` the library asks for MuJoCo's.
            if let Ok(folder) = std::env::var("MUJOCO_DYNAMIC_LINK_DIR") {
                command.env("LD_LIBRARY_PATH", folder);
            }
            if program.exists() {
                command.env("SCANDENT_PROGRAM", &program);
            }
            let done = command.output().unwrap();
            let said = String::from_utf8_lossy(&done.stdout);
            println!("{said}");
            let error = String::from_utf8_lossy(&done.stderr);
            assert!(done.status.success(), "{what}:\n{said}\n{error}");
        }
    }
}
