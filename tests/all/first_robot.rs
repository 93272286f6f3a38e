//! `docs/first-robot.md` followed by the letter: every command in it does what the page says.

use std::process::Command;

use crate::support::program::{assert_ended, read, root};

#[test]
fn a_new_user_comes_from_a_urdf_to_a_verified_plan() {
    let place = tempfile::tempdir().unwrap();
    let scenes = place.path().join("scenes");
    std::os::unix::fs::symlink(root("scenes"), scenes).unwrap();
    let page = std::fs::read_to_string(root("docs/first-robot.md")).unwrap();
    let joined = page.replace("\\\n", " ");
    let commands = joined.lines().filter_map(|l| l.strip_prefix("scandent "));
    let mut ran = 0;
    for line in commands {
        let mut command = Command::new(env!("CARGO_BIN_EXE_scandent"));
        command
            .current_dir(place.path())
            .args(line.split_whitespace());
        let said = assert_ended(&command.output().unwrap(), 0, &[]);
        if line.starts_with("plan") {
            assert!(said.contains("verified: all of"), "{said}");
        }
        ran += 1;
    }
    assert!(ran >= 4, "{ran} commands");
    for made in ["robot.html", "contacts.toml", "hrp2.srdf"] {
        assert!(place.path().join("out/hrp2").join(made).is_file(), "{made}");
    }
    assert!(place.path().join("out/first/view.html").is_file());
    // The same without files: proposed in memory, and said.
    let scene = read(place.path().join("out/worlds/worlds/stairs-up-hrp2-1.toml"));
    assert!(scene.contains("hrp2.urdf"));
}
