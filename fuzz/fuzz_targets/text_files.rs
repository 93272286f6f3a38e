//! Any text as a surfaces file and as a scene file: what it says, or an error.

#![no_main]

use libfuzzer_sys::fuzz_target;
use scenes::SceneFile;
use surfaces::Terrain;

fuzz_target!(|text: &str| {
    if let Ok(terrain) = Terrain::from_json(text) {
        terrain.validate().expect("what is read is valid");
    }
    let _ = SceneFile::parse(text);
});
