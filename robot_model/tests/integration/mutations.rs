//! Whatever the bytes of a file, reading it ends in a robot or an error.

use std::path::Path;

use proptest::prelude::*;
use robot_model::load::no_meshes;
use robot_model::{Config, Kinematics, Robot, load_from_strings, mesh_file};

use crate::support;

const URDF: &str = include_str!("../golden/test_tree.urdf");
const SRDF: &str = r#"<robot name="r"><group_state name="s" group="g"><joint name="hip" value="0.5"/>
  <joint name="root_joint" value="0 0 1 0 0 0 1"/></group_state>
  <disable_collisions link1="shank" link2="trunk" reason="Never"/></robot>"#;
const CONTACTS: &str = r#"[[patch]]
name = "foot"
link = "sole"
position_m = [0.0, 0.0, -0.01]
rpy_rad = [0.0, 0.0, 0.1]
polygon_m = [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]]
roles = ["foot"]
friction = 0.6
"#;
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                   property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                   end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1/1 2/2 4/3 3/4\nf -1 -2 -3\n";
const DAE: &str = r##"<COLLADA><asset><unit meter="0.5"/></asset>
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="a" count="12">0 0 0 1 0 0 1 1 0 0 1 0</float_array>
<technique_common><accessor source="#a" count="4" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<polylist count="1"><input semantic="VERTEX" source="#v" offset="0"/><vcount>4</vcount>
<p>0 1 2 3</p></polylist></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="w"><node id="n"><matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>
<rotate>0 0 1 90</rotate><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>"##;

const GLTF: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "accessors": [{"bufferView": 0,
"componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
"bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36,
"uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;

/// Words that such files are sensitive to, and nothing, a blank and a byte order mark.
const WORDS: &str = "0|-1|1e308|-1e-308|nan|inf|99999999999999999999|4294967295|\"|<|>|/|#|root|trunk|\
    shank|hip|fixed|revolute|prismatic|floating|| |\u{feff}";

/// One change to a file: what is done, the place, and a byte, a length and a word to do it with.
type Edit = (Change, usize, u8, usize, &'static str);

#[derive(Clone, Copy, Debug)]
enum Change {
    Byte,
    Cut,
    Insert,
    Double,
    /// Replaces the word (letters, digits, signs) at the place.
    Word,
}

fn edits() -> impl Strategy<Value = Vec<Edit>> {
    use Change::{Byte, Cut, Double, Insert, Word};
    let change = prop::sample::select(&[Byte, Cut, Insert, Double, Word]);
    let word = prop::sample::select(WORDS.split('|').collect::<Vec<_>>());
    let edit = (change, any::<usize>(), any::<u8>(), 0..400_usize, word);
    prop::collection::vec(edit, 1..5)
}

fn edited(bytes: &[u8], edits: &[Edit]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for &(change, at, byte, length, word) in edits {
        let at = at % (bytes.len() + 1);
        let end = (at + length).min(bytes.len());
        let of_word = |b: &u8| b.is_ascii_alphanumeric() || b"+-._".contains(b);
        let word_end = at + bytes[at..].iter().take_while(|b| of_word(b)).count();
        let (range, by) = match change {
            Change::Byte => (at..(at + 1).min(bytes.len()), vec![byte]),
            Change::Cut => (at..end, Vec::new()),
            Change::Insert => (at..at, word.as_bytes().to_vec()),
            Change::Double => (at..at, bytes[at..end].to_vec()),
            Change::Word => (at..word_end, word.as_bytes().to_vec()),
        };
        bytes.splice(range, by);
    }
    bytes
}

fn text(original: &str, edits: &[Edit]) -> String {
    String::from_utf8_lossy(&edited(original.as_bytes(), edits)).into_owned()
}

/// What was accepted must work, too.
fn exercise(robot: &Robot) {
    let neutral = robot.neutral();
    let kinematics = Kinematics::new(robot, &neutral);
    let mut out = Vec::new();
    let collision = &robot.collision;
    collision.self_proximities(&kinematics, 0.1, &mut out);
    let mut bodies = robot.bodies.iter();
    assert!(bodies.all(|b| b.lower < b.upper && b.mass_kg >= 0.0));
    let mut postures = robot.postures.values();
    assert!(postures.all(|p| [p.joints.len(), p.is_stated.len()] == [robot.nj(); 2]));
}

proptest! {
    #![proptest_config(support::cases(2000))]

    #[test]
    fn urdfs(edits in edits(), lenient in any::<bool>()) {
        let config = Config { lenient, ..Config::default() };
        let urdf = text(URDF, &edits);
        if let Ok(robot) = load_from_strings(&urdf, None, None, "m", &no_meshes, &config) {
            exercise(&robot);
        }
    }

    #[test]
    fn srdfs_and_contacts(
        srdf in edits(), contacts in edits(), lenient in any::<bool>(),
    ) {
        let config = Config { lenient, ..Config::default() };
        let (srdf, contacts) = (text(SRDF, &srdf), text(CONTACTS, &contacts));
        for (srdf, contacts) in [(Some(srdf.as_str()), None), (None, Some(contacts.as_str()))] {
            if let Ok(robot) = load_from_strings(URDF, srdf, contacts, "m", &no_meshes, &config) {
                exercise(&robot);
            }
        }
    }

    #[test]
    fn meshes(edits in edits(), triangles in 0..20_u32, count in any::<u32>(), lie in any::<bool>()) {
        let mut stl = b"a binary file".to_vec();
        stl.resize(80, 0);
        stl.extend(if lie { count } else { triangles }.to_le_bytes());
        stl.extend((0..triangles * 50).map(|i| (i % 64) as u8));
        let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0.5\n\
                     endloop\nendfacet\n";
        let ascii = format!("solid s\n{facet}{facet}endsolid s\n");
        for (name, bytes) in [
            ("m.stl", stl.as_slice()),
            ("m.stl", ascii.as_bytes()),
            ("m.obj", OBJ.as_bytes()),
            ("m.ply", PLY.as_bytes()),
            ("m.dae", DAE.as_bytes()),
            ("m.gltf", GLTF.as_bytes()),
        ] {
            if let Ok(mesh) = mesh_file::parse(Path::new(name), &edited(bytes, &edits)) {
                let n = mesh.vertices.len();
                prop_assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < n));
                prop_assert!(mesh.vertices.iter().flat_map(|v| v.iter()).all(|c| c.is_finite()));
            }
        }
    }

    #[test]
    fn anything(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        for name in ["m.stl", "m.obj", "m.dae", "m.ply", "m.glb", "m.off", "m"] {
            let _ = mesh_file::parse(Path::new(name), &bytes);
        }
    }
}

/// The texts that the edits start from are themselves fine.
#[test]
fn unedited_files_are_read() {
    let config = Config::default();
    load_from_strings(URDF, Some(SRDF), Some(CONTACTS), "m", &no_meshes, &config).expect("robot");
    for (name, text) in [
        ("m.obj", OBJ),
        ("m.ply", PLY),
        ("m.dae", DAE),
        ("m.gltf", GLTF),
    ] {
        mesh_file::parse(Path::new(name), text.as_bytes()).expect(name);
    }
}
