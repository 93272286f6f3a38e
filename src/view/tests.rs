use std::path::Path;

use sha2::{Digest, Sha256};

use super::*;

#[path = "../../tests/viewer/fixture.rs"]
mod fixture;

fn fixture_page() -> String {
    let (plan, robot, cloud) = (fixture::plan(), fixture::robot(), fixture::cloud());
    let motion = fixture::motion();
    page(&ViewInput {
        plan: &plan,
        motion: Some(&motion),
        robot: &robot,
        cloud_W: &cloud,
    })
    .unwrap()
}

/// The data as the page's script reads them.
fn data_of(html: &str) -> Value {
    let start = "<script type=\"application/json\" id=\"scandent-data\">";
    let (_, rest) = html.split_once(start).unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn the_bundle_is_that_of_the_sources() {
    let viewer = Path::new(env!("CARGO_MANIFEST_DIR")).join("viewer");
    let mut sources: Vec<_> = std::fs::read_dir(viewer.join("src"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "js"))
        .collect();
    sources.sort();
    let mut hash = Sha256::new();
    for source in &sources {
        hash.update(std::fs::read(source).unwrap());
    }
    let hex: String = hash
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    assert!(
        SCRIPT.starts_with(&format!("/* scandent viewer; sources sha256:{hex};")),
        "viewer/dist/viewer.js is older than its sources: run `npm ci && npm run build` in viewer/"
    );
}

#[test]
fn the_page_loads_nothing_and_no_name_breaks_out_of_it() {
    let html = fixture_page();
    assert!(
        html.contains("default-src 'none'"),
        "nothing may be fetched"
    );
    assert!(!SCRIPT.contains("</script"), "the script would end early");
    // The scene is called `</script><b>one step`.
    assert!(html.contains("<title>&lt;/script&gt;&lt;b&gt;one step"));
    assert_eq!(html.matches("</script>").count(), 2);
    let data = data_of(&html);
    assert_eq!(data["scene"], "</script><b>one step");
    assert_eq!(data["surfaces"][1]["id"], "<step & 1>");
}

#[test]
fn the_bodies_are_where_the_posture_puts_them() {
    let data = data_of(&fixture_page());
    let plan = fixture::plan();
    assert_eq!(
        data["stances"].as_array().unwrap().len(),
        plan.stances.len()
    );
    for (shown, stance) in data["stances"]
        .as_array()
        .unwrap()
        .iter()
        .zip(&plan.stances)
    {
        let poses = shown["poses"].as_array().unwrap();
        assert_eq!(poses.len(), 7 * 5);
        // The legs' origins are 0.3 m above their feet: bodies 2 and 4.
        for (contact, leg) in stance.contacts.iter().zip([2, 4]) {
            let foot = contact.X_WC.p;
            let wanted = [foot[0], foot[1], foot[2] + 0.3];
            for (axis, wanted) in wanted.iter().enumerate() {
                let there = poses[7 * leg + axis].as_f64().unwrap();
                assert!(
                    (there - wanted).abs() < 1e-4,
                    "{} of {}",
                    axis,
                    contact.patch
                );
            }
        }
    }
}

#[test]
fn the_support_region_is_that_of_the_loaded_feet() {
    let data = data_of(&fixture_page());
    // Standing on both feet: x ± 0.08 m, y ± (0.12 + 0.04) m, the CoM in the middle.
    let support = &data["stances"][0]["support"];
    assert_eq!(support["level"], true);
    assert_eq!(support["com_edge_m"], 0.08);
    // On the left foot alone, one foot of 0.08 × 0.16 m remains.
    let support = &data["stances"][1]["support"];
    assert_eq!(support["com_edge_m"], 0.04);
    // The forces act in its inner half.
    assert_eq!(support["com_promised_m"], 0.02);
    // The forces may act in the inner half of a foot, wherever they come from.
    let kept = support["kept"].as_array().unwrap();
    assert!(kept.iter().all(|p| p[0].as_f64().unwrap().abs() <= 0.0401));
}

#[test]
fn another_robot_or_a_stance_that_contradicts_itself_is_refused() {
    let robot = fixture::robot();
    let refusal = |change: &dyn Fn(&mut Plan)| {
        let mut plan = fixture::plan();
        change(&mut plan);
        let error = page(&ViewInput {
            plan: &plan,
            motion: None,
            robot: &robot,
            cloud_W: &[],
        })
        .unwrap_err();
        format!("{error:#}")
    };
    let error = refusal(&|plan| plan.robot.joint_names[1] = "knee".into());
    assert!(
        error.contains("\"knee\"") && error.contains("left_leg_joint"),
        "{error}"
    );
    let error = refusal(&|plan| {
        plan.stances[3].q.pop();
    });
    assert!(
        error.contains("stance 3") && error.contains("4 joints"),
        "{error}"
    );
    let error = refusal(&|plan| {
        plan.stances[2].contacts[0].forces_W.pop();
    });
    assert!(
        error.contains("stance 2") && error.contains("3 forces at 4 points"),
        "{error}"
    );
}
