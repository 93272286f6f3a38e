//! The command line as a user meets it: exit codes and messages.

use std::path::Path;
use std::process::Command;

use crate::support::program::{FLOOR, ends_with, read, root, said, scandent, succeeds};

/// Command lines with their exit codes and what the message must say.
#[rustfmt::skip]
const REFUSED: &[(&str, i32, &[&str])] = &[
    // A wrong command line is a usage error.
    ("--no-such-flag", 2, &["--no-such-flag"]),
    ("no-such-command", 2, &["no-such-command"]),
    ("run --threads 0", 2, &["--threads"]),
    ("run --seed minus-one", 2, &["--seed"]),
    ("plan --goal 1,far", 2, &["far", "not a number"]),
    ("plan --goal 1,2,3,4,5", 2, &["5 numbers given"]),
    ("export plan.json --format yaml", 2, &["mcc-yaml, json, csv, motion-csv"]),
    ("plan --mesh a.stl --surfaces b.json", 2, &["cannot be used with"]),
    // An unknown setting lists the known ones.
    ("config --set planner.nodez_max=1", 2, &["nodez_max", "`nodes_max`"]),
    ("config --set plannner.nodes_max=1", 2, &["plannner", "`planner`"]),
    ("config --set planner.nodes_max=many", 2, &["planner.nodes_max=many"]),
    ("config --set planner.nodes_max", 2, &["table.key=value"]),
    // All that is wrong is told at once.
    ("config --set planner.nodez_max=1 --set motion.dt_s=0", 2, &["nodez_max", "motion.dt_s is 0"]),
    ("plan irregular-stairs --start lying --start-contacts foot,left_foot --goal 2,0", 1, &["2 mistakes", "\"lying\"", "\"foot\""]),
    ("plan irregular-stairs --goal-contact foot=floor --goal-contact hand=roof", 1,
        &["4 mistakes", "patch \"foot\"", "floor", "patch \"hand\"", "roof"]),
    ("plan irregular-stairs --start lying --goal-contact foot=roof", 1,
        &["3 mistakes", "\"lying\"", "patch \"foot\"", "roof"]),
    ("plan --surfaces no/such/file.x --robot no/such/robot.urdf --goal 1,0", 1, &["2 mistakes", "file.x", "robot.urdf"]),
    // A missing file is named.
    ("surfaces no/such/file.x", 1, &["no/such/file.x"]),
    ("surfaces --mesh -", 1, &["stl:- or obj:-"]),
    ("surfaces --mesh no/such/file.x", 1, &["no/such/file.x"]),
    ("verify no/such/file.x", 1, &["no/such/file.x"]),
    ("view no/such/file.x -o x.html", 1, &["no/such/file.x"]),
    ("export no/such/file.x --format csv", 1, &["no/such/file.x"]),
    ("robot no/such/file.x", 1, &["no/such/file.x"]),
    ("run no/such/scene.toml", 1, &["no/such/scene.toml"]),
    ("plan --surfaces no/such/file.x --goal 1,0", 1, &["no/such/file.x"]),
    ("posture no/such/file.x --robot builtin:hrp2 -o x.json", 1, &["no/such/file.x"]),
    ("config --config no/such/file.x", 1, &["no/such/file.x"]),
    ("slope no/such.pcap", 1, &["no/such.pcap"]),
    ("calibrate lidar no/such.pcap", 1, &["no/such.pcap"]),
    // An unknown scene or robot lists those that ship.
    ("run iregular-stairs", 1, &["iregular-stairs", "irregular-stairs"]),
    ("robot builtin:hrp3", 1, &["hrp3", "hrp2"]),
];

#[test]
fn what_cannot_be_done_is_refused_by_name() {
    for (line, code, words) in REFUSED {
        ends_with(line, &[], *code, words);
    }
}

#[test]
fn mistakes_of_a_scene_are_told_in_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("scene.toml");
    std::fs::write(folder.path().join("floor.obj"), FLOOR).expect("writable");
    let text = "name = \"x\"\nmesh_file = \"floor.obj\"\nrobot.urdf = \"builtin:hrp2\"\nstart = { posture = \"lying\", \
        base_position_m = [0.0, 0.0, 0.6487], contacts = [\"left_foot\", \"right_foot\"] }\n\
        friction.patch = { hoof = 0.5 }\ngoal.contact = [{ patch = \"foot\", surface = \"roof\" }, \
        { patch = \"left_foot\", surface = \"ground\" }]\n";
    std::fs::write(&scene, text).expect("writable");
    let all = ["4 mistakes", "hoof", "lying", "\"foot\"", "roof"];
    ends_with("plan @", &[&scene], 1, &all);
    // With a start that holds, what else is wrong.
    std::fs::write(&scene, text.replace("lying", "half_sitting")).expect("writable");
    ends_with(
        "plan @",
        &[&scene],
        1,
        &["3 mistakes", "hoof", "\"foot\"", "roof"],
    );
}

#[test]
fn the_printed_settings_can_be_read_back() {
    let changed = succeeds("config --set planner.nodes_max=123", &[]);
    assert!(changed.contains("nodes_max = 123"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("settings.toml");
    std::fs::write(&file, &changed).expect("writable");
    assert_eq!(succeeds("config --config @", &[&file]), changed);
}

#[test]
fn a_broken_settings_file_names_file_and_line() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("broken.toml");
    std::fs::write(&file, "[planner]\nnodes_max = = 3\n").expect("writable");
    ends_with("config --config @", &[&file], 1, &["broken.toml", "line 2"]);
    let several = "[planner]\nnodez_max = 1\n[posture]\nclearance_m = \"far\"\ntorque_use = -1\n[plan]\na = 1\nb = 2\n";
    std::fs::write(&file, several).expect("writable");
    let words = [
        "broken.toml: 4 mistakes",
        "nodez_max",
        "clearance_m",
        "torque_use is -1",
        "`plan`",
    ];
    ends_with("config --config @", &[&file], 1, &words);
}

#[test]
fn every_scene_that_ships_is_listed_with_what_it_shows() {
    let list = succeeds("scenes", &[]);
    for scene in scenes::names() {
        let mut lines = list.lines();
        let line = lines.find(|line| line.starts_with(&format!("{scene} ")));
        let described = line.is_some_and(|line| line.len() > scene.len() + 20);
        assert!(described, "no description of {scene}: {list}");
    }
}

#[test]
fn the_robot_that_ships_is_described() {
    let words = ["30 joints", "left_foot", "right_foot", "half_sitting"];
    ends_with("robot builtin:hrp2", &[], 0, &words);
}

/// Ids and number of the surfaces in a file.
fn surface_ids(path: &Path) -> Vec<String> {
    let terrain = surfaces::Terrain::from_json(&read(path)).expect("a terrain");
    terrain.faces.iter().map(|f| f.id.to_string()).collect()
}

#[test]
fn several_scans_are_one_set_and_can_be_registered() {
    let scan: &Path = &root("scenes/scenes/irregular-stairs_depth.png");
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("surfaces.json");
    let turn = "-0.6,0.6,-0.37416573867,0.37416573867";
    let run = |line: &str, scans: &[&Path]| {
        let told = succeeds(
            &format!("surfaces -o @ {line}"),
            &[&[&*file], scans].concat(),
        );
        (told, surface_ids(&file))
    };
    let here = format!("--pose 0,0,1.3,{turn}");
    let (_, single) = run(&format!("@ {here}"), &[scan]);
    // The same scan twice: every face is found again, and keeps its name.
    let twice = format!("@ @ {here} {here}");
    let (told, both) = run(&twice, &[scan; 2]);
    assert!(told.contains("are one face"), "{told}");
    assert!(!told.contains("warning"), "{told}");
    let kept = both.iter().filter(|id| single.contains(id)).count();
    assert!(2 * kept > single.len(), "{single:?} became {both:?}");
    assert!(both.len() < single.len() + single.len() / 2);
    let apart = format!("{twice} --set perception.fuse_views=false");
    let (_, apart) = run(&apart, &[scan; 2]);
    assert_eq!(apart.len(), 2 * single.len());
    // Stairs ahead and no wall beside: a shift is left open, and named.
    let off = format!("--pose 0.01,0,1.31,{turn}");
    let refine = "--set perception.registration.refine=true";
    let (told, _) = run(&format!("@ @ {here} {off} {refine}"), &[scan; 2]);
    assert!(told.contains("as given stay the shift along"), "{told}");
}

#[test]
fn data_sets_give_depths_poses_and_a_camera_in_files_of_their_own() {
    let png: &Path = &root("scenes/scenes/irregular-stairs_depth.png");
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let write = |name: &str, bytes: &[u8]| {
        std::fs::write(at(name), bytes).expect("a file");
        at(name)
    };
    // The image as an array of metres, its camera and its pose as others write them.
    let scan = perception::read_scan(png, &perception::SensorOptions::default()).expect("a scan");
    let depth = scan.depth.expect("an image");
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (480, 640)}";
    let mut array = b"\x93NUMPY\x01\x00".to_vec();
    array.extend((header.len() as u16).to_le_bytes());
    array.extend(
        header
            .bytes()
            .chain(depth.z_m.iter().flat_map(|z| z.to_le_bytes())),
    );
    let array = write("depth.npy", &array);
    let camera = r#"{"width": 640, "height": 480, "intrinsic_matrix": [525, 0, 0, 0, 525, 0, 319.5, 239.5, 1]}"#;
    let camera = write("camera.json", camera.as_bytes());
    let pose = "0 0 1.3 -0.6 0.6 -0.37416573867 0.37416573867";
    let truth = write(
        "groundtruth.txt",
        format!("# t x y z q\n7.5 {pose}\n").as_bytes(),
    );
    let log = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
    let log = write("path.log", format!("0 0 1\n{log}1 1 2\n{log}").as_bytes());
    let surfaces = |name: &str, line: &str, files: &[&Path]| {
        let told = succeeds(
            &format!("surfaces -o @ {line}"),
            &[&[&*at(name)], files].concat(),
        );
        (told, read(at(name)))
    };
    let plain = format!("@ --sensor xtion --pose {}", pose.replace(' ', ","));
    let (_, plain) = surfaces("plain.json", &plain, &[png]);
    let line = format!(
        "@ --sensor xtion:{} --pose {}@7.52",
        camera.display(),
        truth.display()
    );
    assert_eq!(surfaces("set.json", &line, &[&array]).1, plain);
    // A plan holds the sums of these files, too.
    let line = line.replace("@ --sensor", "plan --scan @ --goal 0.3,0 -o @ --sensor");
    let plan = at("out/plan.json");
    succeeds(&line, &[&array, &at("out")]);
    succeeds("verify @", &[&plan]);
    for (file, role) in [(&camera, "intrinsics"), (&truth, "trajectory")] {
        let text = read(file);
        std::fs::write(file, format!("{text}\n")).expect("writable");
        let other = format!("{role} {} is another file now", file.display());
        ends_with("verify @", &[&plan], 1, &[&other]);
        std::fs::write(file, text).expect("writable");
    }
    // In the world of the first camera, levelled by what that one shows.
    let line = format!(
        "@ @ --sensor xtion --level --up -0.679,0,-0.734 --pose {0}@0 --pose {0}@1",
        log.display()
    );
    let (told, _) = surfaces("both.json", &line, &[png; 2]);
    assert_eq!(told.matches("levelled by").count(), 1, "{told}");
    assert!(told.contains("are one face"), "{told}");
    let line = format!("surfaces @ --sensor xtion --pose {}@9", truth.display());
    ends_with(&line, &[png], 1, &["groundtruth.txt", "no pose at 9"]);
}

/// Two squares of 1 m, one a step of 0.1 m over the other, in a unit of `scale` m, seen from above or below.
fn step_obj(scale: f64, from_above: bool) -> String {
    let square = |number: usize| {
        let at = |x: f64, y: f64| {
            let (x, z) = (x + number as f64, 0.1 * number as f64);
            format!("v {} {} {}\n", x / scale, y / scale, z / scale)
        };
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let corners: String = corners.into_iter().map(|(x, y)| at(x, y)).collect();
        let mut order = [1, 2, 3, 4].map(|corner| (corner + 4 * number).to_string());
        if !from_above {
            order.reverse();
        }
        format!("{corners}f {}\n", order.join(" "))
    };
    square(0) + &square(1)
}

#[test]
fn a_mesh_that_is_almost_right_is_said_to_be_so() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mesh = folder.path().join("step.obj");
    for (scale, from_above, words) in [
        (1.0, true, ""),
        (0.01, true, "is the file in m, not in mm or cm?"),
        (0.001, true, "is the file in m, not in mm or cm?"),
        (1.0, false, "face down: are its normals"),
    ] {
        std::fs::write(&mesh, step_obj(scale, from_above)).expect("writable");
        let told = ends_with("surfaces --mesh @", &[&mesh], 0, &[words]);
        assert_eq!(told.contains("warning"), !words.is_empty(), "{told}");
        // The same as a file of surfaces.
        let file = folder.path().join("surfaces.json");
        succeeds("surfaces --mesh @ -o @", &[&mesh, &file]);
        let out = folder.path().join("out");
        let line = "plan --surfaces @ --goal 0.5,0.5 -o @ --set planner.nodes_max=1";
        let told = said(&scandent(line, &[&file, &out]));
        assert_eq!(told.contains("warning"), !words.is_empty(), "{told}");
        assert!(told.contains(words), "{told}");
    }
}

/// A floor as a reconstruction has it: cells of 3 cm, none level with its neighbours.
#[test]
fn a_mesh_of_noise_is_said_to_be_a_scan() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mesh = folder.path().join("noise.obj");
    let side = 40;
    let cells = |n: usize| (0..n).flat_map(move |i| (0..n).map(move |j| (i, j)));
    let vertices = cells(side).map(|(i, j)| {
        let up = ((i * i + 3 * j * j + i * j) % 7) as f64;
        format!("v {} {} {}\n", 0.03 * i as f64, 0.03 * j as f64, 2e-3 * up)
    });
    let faces = cells(side - 1).map(|(i, j)| {
        let [a, b] = [i * side + j + 1, (i + 1) * side + j + 1];
        format!("f {a} {b} {}\nf {a} {} {}\n", b + 1, b + 1, a + 1)
    });
    let text: String = vertices.chain(faces).collect();
    std::fs::write(&mesh, text + "v 3 0 0\nv 4 0 0\nv 4 0.5 0\nf -3 -2 -1\n").expect("writable");
    let words = ["% of it are faces too small", "--scan", "--eye X,Y,Z"];
    ends_with("surfaces --mesh @", &[&mesh], 0, &words);
}

#[test]
fn every_command_has_a_manual_page_with_its_flags() {
    let folder = tempfile::tempdir().expect("a folder");
    succeeds("man -o @", &[folder.path()]);
    let help = succeeds("--help", &[]);
    let commands = help
        .lines()
        .skip_while(|l| !l.starts_with("Commands:"))
        .skip(1);
    let commands = commands.take_while(|l| !l.is_empty());
    let names = commands.filter_map(|l| l.split_whitespace().next());
    let mut seen = 0;
    for name in names.filter(|name| *name != "help") {
        let page = read(folder.path().join(format!("scandent-{name}.1"))).replace('\\', "");
        let flags = succeeds(&format!("{name} --help"), &[]);
        for flag in flags
            .split_whitespace()
            .filter(|w| w.starts_with("--") && w.len() > 2)
        {
            let flag = flag.trim_end_matches(|c: char| !c.is_alphanumeric());
            assert!(page.contains(flag), "{name} has no {flag} on its page");
            seen += 1;
        }
    }
    assert!(seen > 100, "{seen} flags");
}

#[test]
fn completions_name_the_commands() {
    for shell in ["bash", "zsh", "fish"] {
        ends_with(&format!("completions {shell}"), &[], 0, &["surfaces"]);
    }
}

#[test]
fn a_reader_that_leaves_early_is_no_error() {
    if !Path::new("/bin/sh").exists() {
        eprintln!("SKIPPED: no /bin/sh to make a pipe with");
        return;
    }
    // `true` closes the pipe at once; the completions are larger than a pipe holds.
    let program = env!("CARGO_BIN_EXE_scandent");
    let script = format!("{{ '{program}' completions zsh; echo $? >&2; }} | true");
    let output = Command::new("/bin/sh")
        .args(["-c", &script])
        .output()
        .expect("sh");
    assert_eq!(said(&output).trim(), "0");
}
