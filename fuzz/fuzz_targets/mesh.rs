//! Any bytes as a mesh of any format: triangles that refer to vertices, or an error that names the
//! file.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use robot_model::mesh_file;

fuzz_target!(|bytes: &[u8]| {
    for name in ["fuzz.stl", "fuzz.obj", "fuzz.ply", "fuzz.dae", "fuzz.glb"] {
        match mesh_file::parse(Path::new(name), bytes) {
            Ok(mesh) => {
                let known = |&i: &u32| (i as usize) < mesh.vertices.len();
                assert!(mesh.triangles.iter().flatten().all(known));
            }
            Err(error) => assert!(error.to_string().contains(name)),
        }
    }
});
