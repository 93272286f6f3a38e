//! The page that `scandent view` writes, in a real browser.
//!
//! Passes when the page opens from a file without the network, goes through every stance by key,
//! mouse and play button, each stance with a picture of its own, and the browser complains of
//! nothing: no error, warning or uncaught exception. Without a Chromium it is skipped, loudly.

use std::path::{Path, PathBuf};

use plan::Plan;
use scandent::view::{Compared, ViewInput, compare_page, page};
use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::support::biped::{ANKLE, COM_MARGIN, FOOT};
use crate::support::chromium::{Key, Page};
use crate::support::page::check_page;
use crate::support::program::{number, root};
use crate::support::{chromium, fixture};

/// A browser; without one it says so.
pub fn chromium() -> Option<PathBuf> {
    let found = chromium::find();
    if found.is_none() {
        eprintln!(
            "\n!!!!! SKIPPED: no chromium, chromium-browser or google-chrome on the PATH, and \
             CHROMIUM is not set: the page was opened by nobody !!!!!\n"
        );
    }
    found
}

/// The page of the hand-made plan and motion.
pub fn fixture_page() -> String {
    let motion = fixture::motion();
    page_with(Some(&motion))
}

fn page_with(motion: Option<&plan::Motion>) -> String {
    let (plan, robot, cloud) = (fixture::plan(), fixture::robot(), fixture::cloud());
    page(&ViewInput {
        motion,
        trace: Some(&fixture::trace()),
        cloud_W: &cloud,
        ..ViewInput::new(&plan, &robot)
    })
    .expect("a page")
}

/// Opens a page and uses it.
pub fn check(chromium: &Path, html: &str) -> anyhow::Result<()> {
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("a page.html");
    std::fs::write(&file, html)?;
    check_page(chromium, &file, fixture::plan().stances.len())
}

#[test]
fn the_page_shows_every_stance_without_a_complaint() {
    let Some(chromium) = chromium() else { return };
    check(&chromium, &fixture_page()).unwrap();
    check(&chromium, &page_with(None)).unwrap();
}

#[test]
fn plans_stand_side_by_side_on_one_clock() {
    let Some(chromium) = chromium() else { return };
    let (mut plans, robot) = ([fixture::plan(), fixture::plan()], fixture::robot());
    plans[1].stances[2].margins.torque_use = 0.77;
    plans[1].config = serde_json::json!({ "posture": { "torque_use": 0.77 } });
    plans[0].config = serde_json::json!({ "posture": { "torque_use": 0.5 } });
    let motion = fixture::motion();
    let compared = plans
        .iter()
        .zip(["one", "<other>"])
        .map(|(plan, name)| Compared {
            name,
            input: ViewInput {
                motion: Some(&motion),
                ..ViewInput::new(plan, &robot)
            },
        });
    let html = compare_page(&compared.collect::<Vec<_>>()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("compare.html");
    std::fs::write(&file, html).unwrap();
    let address = format!("file://{}", file.display());
    let mut page = Page::open(&chromium, &address, (1000, 640)).unwrap();
    let row =
        "[...document.querySelectorAll('tr')].find((row) => row.textContent.includes('Torque'))";
    let cells = format!("[...{row}.cells].map((cell) => [cell.textContent, cell.className])");
    let cells = page.evaluate(&cells).unwrap();
    assert_eq!(cells[2][0], "77.0\u{a0}%");
    assert_eq!(
        (&cells[1][1], &cells[2][1]),
        (&"best".into(), &"".into()),
        "{cells}"
    );
    let said = page
        .evaluate("document.querySelector('header').textContent")
        .unwrap();
    let said = said.as_str().unwrap();
    assert!(said.contains("posture.torque_use = 0.77 instead of 0.5") && said.contains("<other>"));
    let frames = "[...document.querySelectorAll('iframe')]";
    let ready = format!("{frames}.every((frame) => frame.contentWindow.scandent?.ready)");
    page.until(&ready).unwrap();
    page.evaluate("document.querySelector('#play').focus()")
        .unwrap();
    page.press(&Key::ENTER).unwrap();
    let end = format!("{:.1} s of", motion.duration_s());
    page.until(&format!(
        "{frames}.every(({{ contentDocument: shown }}) => shown.querySelector('#caption').textContent.includes('{end}'))"
    ))
    .unwrap();
    assert_eq!(page.nameless().unwrap(), [""; 0]);
    page.evaluate("document.body.append(document.createElement('button')), true")
        .unwrap();
    assert_eq!(page.nameless().unwrap(), ["\"button\""]);
    assert!(page.complaints().is_empty(), "{:?}", page.complaints());
}

/// The data as the page's script reads them.
fn data_of(html: &str) -> Value {
    let start = "<script type=\"application/json\" id=\"scandent-data\">";
    let (_, rest) = html.split_once(start).unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn the_bundle_is_that_of_the_sources() {
    let mut hash = Sha256::new();
    for folder in ["viewer/src", "viewer/web"] {
        let entries = std::fs::read_dir(root(folder)).unwrap();
        let mut sources: Vec<_> = entries
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.extension().is_some_and(|e| e == "js"))
            .collect();
        sources.sort();
        for source in &sources {
            hash.update(std::fs::read(source).unwrap());
        }
    }
    let hex: String = hash
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let web = std::fs::read_to_string(root("viewer/dist/web.js")).unwrap();
    for (name, bundle) in [("viewer", fixture_page()), ("page", web)] {
        assert!(
            bundle.contains(&format!("/* scandent {name}; sources sha256:{hex};")),
            "viewer/dist/ is older than its sources: run `npm ci && npm run build` in viewer/"
        );
    }
}

#[test]
fn the_page_loads_nothing_and_no_name_breaks_out_of_it() {
    let html = fixture_page();
    // Nothing may be fetched.
    assert!(html.contains("default-src 'none'"));
    // The scene is called `</script><b>one step`.
    assert!(html.contains("<title>&lt;/script&gt;&lt;b&gt;one step"));
    assert_eq!(html.matches("</script").count(), 2);
    let data = data_of(&html);
    assert_eq!(data["scene"], "</script><b>one step");
    assert_eq!(data["surfaces"][1]["id"], "<step & 1>");
}

#[test]
fn the_bodies_are_where_the_posture_puts_them() {
    let data = data_of(&fixture_page());
    let plan = fixture::plan();
    let shown = data["stances"].as_array().unwrap();
    assert_eq!(shown.len(), plan.stances.len());
    for (shown, stance) in shown.iter().zip(&plan.stances) {
        let poses = shown["poses"].as_array().unwrap();
        assert_eq!(poses.len(), 7 * 11);
        // The ankles are over their feet: bodies 5 and 10.
        for (contact, ankle) in stance.contacts.iter().zip([5, 10]) {
            let foot = contact.X_WC.p;
            let wanted = [foot[0], foot[1], foot[2] + ANKLE];
            for (axis, wanted) in wanted.iter().enumerate() {
                let off = number(&poses[7 * ankle + axis]) - wanted;
                assert!(off.abs() < 1e-4, "{axis} of {}", contact.patch);
            }
        }
    }
}

#[test]
fn the_support_region_is_that_of_the_loaded_feet() {
    let data = data_of(&fixture_page());
    // Standing on both feet, the CoM in the middle: the soles' ends are nearest.
    let support = &data["stances"][0]["support"];
    assert_eq!(support["level"], true);
    assert_eq!(support["com_edge_m"], FOOT[0]);
    // On the right foot alone its sides are, and forces act inside of them.
    let support = &data["stances"][1]["support"];
    assert_eq!(support["com_edge_m"], FOOT[1]);
    assert_eq!(support["com_promised_m"], COM_MARGIN);
    // The forces may act in the inner part of a foot, wherever they come from.
    let kept = support["kept"].as_array().unwrap();
    let most = FOOT[0] - COM_MARGIN + 1e-4;
    assert!(kept.iter().all(|p| number(&p[0]).abs() <= most));
}

#[test]
fn another_robot_or_a_stance_that_contradicts_itself_is_refused() {
    let robot = fixture::robot();
    let refused = |change: fn(&mut Plan), words: [&str; 2]| {
        let mut plan = fixture::plan();
        change(&mut plan);
        let refused = page(&ViewInput::new(&plan, &robot));
        let error = format!("{:#}", refused.unwrap_err());
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    let toe = |p: &mut Plan| p.robot.joint_names[1] = "toe".into();
    refused(toe, ["\"toe\"", "left_hip_pitch"]);
    let short = |p: &mut Plan| p.stances[3].q.truncate(16);
    refused(short, ["stance 3", "10 joints"]);
    let three = |p: &mut Plan| p.stances[2].contacts[1].forces_W.truncate(3);
    refused(three, ["stance 2", "3 forces at 4 points"]);
}
