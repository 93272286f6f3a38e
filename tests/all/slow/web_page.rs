//! The page of `scripts/web-page` in a real browser, from a file: what it plans is what the program plans, to the byte;
//! what a user does there works without a server; a broken file and a cancelled plan leave the page alive.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde_json::json;

use crate::support::chromium::Page;
use crate::support::program::{root, scandent};
use crate::viewer::chromium;

/// Largest page, bytes: the program in it is as base64 a third more than compressed, which is at most 6 MB.
const PAGE_MAX: u64 = 8_000_000;

/// Plans a scene that ships in the page and with the program.
fn plans_the_same(page: &mut Page, folder: &Path, scene: &str) -> Result<()> {
    let planned = scandent(&format!("run {scene} -o @"), &[folder]);
    ensure!(planned.status.success(), "{scene}: no plan");
    page.evaluate(&format!(
        "scandentHost.run(['run', '{scene}', '-o', 'all'])"
    ))?;
    for file in ["plan.json", "motion.json", "certificate.json"] {
        let there = page.evaluate(&format!(
            "new TextDecoder().decode(scandentHost.files().get('all/{scene}/{file}'))"
        ))?;
        let here = std::fs::read_to_string(folder.join(scene).join(file))?;
        ensure!(there == json!(here), "{scene}: {file} differs");
    }
    Ok(())
}

/// Waits until the page that is shown, as `page` there, is as asked.
fn shown(page: &mut Page, asked: &str) -> Result<()> {
    let there = "const page = document.querySelector('#shown').contentDocument;";
    let found = page.until(&format!("(() => {{ {there} return Boolean({asked}); }})()"));
    found.or_else(|error| {
        let state = format!(
            "(() => {{ {there} return page?.querySelector('#state')?.textContent ?? ''; }})()"
        );
        let state = page.evaluate(&state)?;
        Err(error.context(format!("the page says {state}")))
    })
}

/// Clicks what a selector finds in the page that is shown.
fn click(page: &mut Page, selector: &str) -> Result<()> {
    let found =
        format!("document.querySelector('#shown').contentDocument.querySelector('{selector}')");
    page.evaluate(&format!("{found}.click()"))?;
    Ok(())
}

fn use_it(page: &mut Page) -> Result<()> {
    // A scene that ships, planned and shown.
    shown(page, "page?.querySelector('a[href*=\"irregular-stairs\"]')")?;
    click(page, "a[href*=\"irregular-stairs\"]")?;
    shown(page, "page.querySelector('#plan')")?;
    click(page, "#plan")?;
    shown(
        page,
        "page.querySelector('#verdict')?.textContent.includes('PASS')",
    )?;
    ensure!(page.evaluate("scandentHost.files().has('out/irregular-stairs/motion.json')")? == true);

    // A scan is levelled.
    let scan = std::fs::read(root("scenes/scenes/hexapod-obstacles_depth.png"))?;
    page.evaluate(&format!(
        "scandentHost.add([['blocks.png', new Blob([new Uint8Array({})])]])",
        json!(scan)
    ))?;
    page.evaluate("scandentHost.go('edit/blocks.png?sensor=kinect_v1')")?;
    shown(
        page,
        "page.querySelector('#panel')?.textContent.includes('Faces (')",
    )?;

    // Files that are none; the page goes on, with a mesh and a plan on it that is cancelled.
    page.evaluate(
        "scandentHost.add(['a.png', 'a.obj', 'a.mcap', 'a.toml', 'surfaces.json'].map((name) => [name, new Blob(['\\x89PNG\\0\\xff['])]))",
    )?;
    for name in ["a.png", "a.obj", "a.mcap", "a.toml", "surfaces.json"] {
        page.evaluate(&format!("scandentHost.go('edit/{name}')"))?;
        let said = page.evaluate("document.querySelector('#said.bad').textContent")?;
        ensure!(
            said.as_str().is_some_and(|said| said.contains(name)),
            "{name}: {said}"
        );
    }
    page.evaluate(
        "scandentHost.add([['floor.obj', new Blob(['v -5 -2 0\\nv 195 -2 0\\nv 195 2 0\\nv -5 2 0\\nf 1 2 3 4\\n'])]])",
    )?;
    page.evaluate("scandentHost.go('edit/floor.obj')")?;
    shown(
        page,
        "page.querySelector('#panel')?.textContent.includes('Faces (1)')",
    )?;
    let fields = "document.querySelector('#shown').contentDocument.querySelector";
    page.evaluate(&format!(
        "{fields}('#goal_x').value = 180; {fields}('#goal_y').value = 0"
    ))?;
    click(page, "#plan")?;
    shown(
        page,
        "page.querySelector('#state').textContent.includes('contact sets')",
    )?;
    click(page, "#cancel")?;
    shown(
        page,
        "page.querySelector('#state').textContent.includes('No plan was found')",
    )
}

/// All files of a folder and its folders, with their paths from `below` on.
fn all_files(folder: &Path, below: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let files = paths.flat_map(|path| match path.is_dir() {
        true => all_files(&path, below),
        false => {
            let name = path.strip_prefix(below).expect("below it");
            let bytes = std::fs::read(&path).expect("a file");
            vec![(name.display().to_string(), bytes)]
        }
    });
    files.collect()
}

/// A picture of a real staircase and a bare URDF with its meshes: levelled, planned with what the form suggests and
/// shown; from the files that are left the program plans the same.
fn real_stairs(page: &mut Page, folder: &Path) -> Result<()> {
    let shared = std::env::var_os("SCANDENT_SHARED").map_or_else(|| root("../shared"), Into::into);
    let (scan, robot) = (
        shared.join("scans/rgbd/k2_stairs_0001_depth.png"),
        shared.join("robots/jvrc1"),
    );
    if !scan.exists() || !robot.exists() {
        eprintln!("SKIPPED: {} is not there", scan.display());
        return Ok(());
    }
    let mut files = all_files(&robot, &shared.join("robots"));
    files.retain(|(name, _)| !name.ends_with("orig.urdf"));
    files.push(("stairs.png".to_owned(), std::fs::read(&scan)?));
    page.evaluate("window.given = []")?;
    for (name, bytes) in &files {
        let (name, bytes) = (json!(name), json!(bytes));
        page.evaluate(&format!(
            "given.push([{name}, new Blob([new Uint8Array({bytes})])]), 0"
        ))?;
    }
    page.evaluate("scandentHost.add(given)")?;
    page.evaluate("scandentHost.go('edit/stairs.png?sensor=kinect_v2')")?;
    shown(
        page,
        "page?.querySelector('#urdf')?.value.endsWith('jvrc1.urdf')",
    )?;
    click(page, "#plan")?;
    shown(
        page,
        "page.querySelector('#state')?.textContent.includes('contact sets') || page.querySelector('#verdict')",
    )?;
    shown(
        page,
        "page.querySelector('#verdict')?.textContent.includes('PASS')",
    )?;
    let left = |page: &mut Page, name: &str| -> Result<String> {
        let text = page.evaluate(&format!(
            "new TextDecoder().decode(scandentHost.files().get('{name}'))"
        ))?;
        Ok(text.as_str().context("a text")?.to_owned())
    };
    for (name, bytes) in &files {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().context("a folder")?)?;
        std::fs::write(path, bytes)?;
    }
    for name in ["stairs.toml", "stairs.surfaces.json"] {
        std::fs::write(folder.join(name), left(page, name)?)?;
    }
    let planned = scandent(
        "plan @ -o @",
        &[&folder.join("stairs.toml"), &folder.join("here")],
    );
    ensure!(planned.status.success(), "no plan");
    let stances = |text: &str| -> Result<serde_json::Value> {
        Ok(serde_json::from_str::<serde_json::Value>(text)?["stances"].take())
    };
    let here = std::fs::read_to_string(folder.join("here/plan.json"))?;
    let there = left(page, "out/stairs/plan.json")?;
    ensure!(stances(&here)? == stances(&there)?, "the stances differ");
    Ok(())
}

#[test]
fn the_page_plans_without_a_server_what_the_program_plans() {
    let Some(chromium) = chromium() else { return };
    let folder = tempfile::tempdir().unwrap();
    let added = Command::new("rustup")
        .args(["target", "add", "wasm32-wasip1"])
        .status();
    if !added.is_ok_and(|status| status.success()) {
        eprintln!(
            "\n!!!!! SKIPPED: no target wasm32-wasip1 (offline?): the page was opened by nobody !!!!!\n"
        );
        return;
    }
    let built = Command::new(root("scripts/web-page"))
        .arg(folder.path())
        .status();
    assert!(built.is_ok_and(|status| status.success()));
    let file = folder.path().join("index.html");
    assert!(file.metadata().unwrap().len() < PAGE_MAX);
    let address = format!("file://{}", file.display());
    let mut page = Page::open(&chromium, &address, (1100, 760)).unwrap();
    // The compiler rounds what it knows beforehand itself, and in a page more than in a test: `elementary` tells.
    let scenes = ["irregular-stairs", "hexapod-obstacles"];
    let done = use_it(&mut page);
    let done = done.and_then(|()| real_stairs(&mut page, folder.path()));
    let done = done.and_then(|()| {
        let mut scenes = scenes.iter();
        scenes.try_for_each(|scene| plans_the_same(&mut page, folder.path(), scene))
    });
    done.with_context(|| page.complaints().join("\n")).unwrap();
    assert!(page.complaints().is_empty(), "{:?}", page.complaints());
}
