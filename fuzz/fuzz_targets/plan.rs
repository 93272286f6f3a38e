//! Any text as a plan and its motion, separated by NUL: no plan, or a certificate that can be shown and
//! written.

#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use plan::{Motion, Plan};
use robot_model::{Config, Robot, load, load_from_strings};
use verify::{Certificate, verify};

/// The robot that the seeds were planned for.
static ROBOT: LazyLock<Robot> = LazyLock::new(|| {
    let files = scenes::builtin_robot("quadruped").expect("it ships");
    let (srdf, contacts) = (Some(files.srdf), Some(files.contacts));
    let config = Config::default();
    let read = load_from_strings(files.urdf, srdf, contacts, "quadruped", &load::no_meshes, &config);
    read.expect("it is one")
});

fuzz_target!(|text: &str| {
    let (plan, motion) = text.split_once('\0').unwrap_or((text, ""));
    let Ok(plan) = serde_json::from_str::<Plan>(plan) else {
        return;
    };
    let motion = serde_json::from_str::<Motion>(motion).ok();
    let certificate = verify(&plan, motion.as_ref(), &ROBOT);
    assert!(!certificate.table().is_empty());
    let written = certificate.to_json().expect("it can be written");
    let read: Certificate = serde_json::from_str(&written).expect("it can be read");
    assert_eq!(read.pass, certificate.pass);
});
