//! `scandent serve` and the page of surfaces, used by the keyboard alone in a real browser: faces edited and drawn,
//! files saved, a plan computed, shown and cancelled; and what the server refuses.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use nalgebra::Isometry3;
use scandent::cli::Global;
use scandent::serve::Server;
use scenes::SceneFile;
use serde_json::{Value, json};
use surfaces::{Face, Terrain};
use tempfile::TempDir;

use crate::support::chromium::{Key, Page};
use crate::viewer::chromium;

/// A folder with a floor, long enough that a plan along all of it takes a while, and a step.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let floor = Face::rectangle(
        "floor",
        Isometry3::translation(95.0, 0.0, 0.0),
        [200.0, 3.0],
    );
    let step = Face::rectangle("step", Isometry3::translation(0.0, 3.0, 0.2), [1.0, 1.0]);
    let terrain = Terrain::new(vec![floor.unwrap(), step.unwrap()], Vec::new()).unwrap();
    std::fs::write(
        folder.path().join("a floor.surfaces.json"),
        terrain.to_json().unwrap(),
    )
    .unwrap();
    folder
}

/// Serves a folder; the address with the token.
fn served(folder: &Path) -> String {
    let server = Server::bind(folder, 0, &Global::default()).unwrap();
    let address = server.address();
    std::thread::spawn(move || server.run());
    address
}

/// One request; the code and the body of the answer.
fn request(
    address: &str,
    method: &str,
    path: &str,
    host: Option<&str>,
    body: &str,
) -> (u16, String) {
    let (ours, _) = address
        .strip_prefix("http://")
        .unwrap()
        .split_once('/')
        .unwrap();
    let host = host.unwrap_or(ours);
    let mut stream = TcpStream::connect(ours).unwrap();
    let length = body.len();
    write!(stream, "{method} {path} HTTP/1.1\r\nHost: {host}\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n{body}").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    (
        head.split(' ').nth(1).unwrap().parse().unwrap(),
        body.to_owned(),
    )
}

/// Moves the focus by Tab until it is on what a selector finds.
fn tab_to(page: &mut Page, selector: &str) -> Result<()> {
    for _ in 0..400 {
        page.press(&Key::TAB)?;
        if page.evaluate(&format!("document.activeElement.matches('{selector}')"))? == true {
            return Ok(());
        }
    }
    anyhow::bail!("the keyboard does not come to {selector}")
}

/// Comes to a field by keyboard and writes into it what it then holds alone.
fn fill(page: &mut Page, selector: &str, text: &str) -> Result<()> {
    tab_to(page, selector)?;
    page.evaluate("document.activeElement.select()")?;
    page.write(text)
}

fn text(page: &mut Page, selector: &str) -> Result<String> {
    let said = page.evaluate(&format!("document.querySelector('{selector}').textContent"))?;
    Ok(said.as_str().unwrap_or_default().to_owned())
}

/// Saves both files and reads them back.
fn saved(page: &mut Page, downloads: &Path, name: &str) -> Result<(SceneFile, Terrain)> {
    page.download_to(downloads)?;
    let file = |name: &str| {
        let begin = Instant::now();
        loop {
            match std::fs::read_to_string(downloads.join(name)) {
                Ok(text) if !text.is_empty() => return Ok::<String, anyhow::Error>(text),
                _ => ensure!(
                    begin.elapsed() < Duration::from_secs(60),
                    "{name} is not saved"
                ),
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    };
    for what in ["scene", "surfaces"] {
        page.evaluate("document.activeElement.blur()")?;
        tab_to(page, &format!("#save-{what}"))?;
        page.press(&Key::ENTER)?;
    }
    let scene = SceneFile::parse(&file(&format!("{name}.toml"))?)?;
    let terrain = Terrain::from_json(&file(&format!("{name}.surfaces.json"))?)?;
    Ok((scene, terrain))
}

fn edit_save_and_plan(page: &mut Page, downloads: &Path) -> Result<()> {
    let ready = page.evaluate("window.scandent?.ready === true")?;
    ensure!(ready == true, "the page is not ready");
    ensure!(
        text(page, "#panel")?.contains("hand: its highest point"),
        "why not is not said"
    );
    let nameless = page.nameless()?;
    ensure!(nameless.is_empty(), "without a name or a key: {nameless:?}");
    // The step is for nothing; a face beside it is drawn.
    tab_to(page, "select[aria-label$=\"step\"]")?;
    page.press(&Key::DOWN)?;
    // A goal is suggested.
    let goal = page.evaluate("document.querySelector('#goal_x').value")?;
    ensure!(goal == "95", "{goal}");
    page.evaluate("document.querySelector('#goal_x').value = ''")?;
    // The floor is slippery; what is no number is not saved, nor what has no goal.
    for (friction, said) in [("ice", "friction of floor"), ("0.4", "goal")] {
        page.evaluate("document.activeElement.blur()")?;
        fill(page, "input[aria-label^=\"friction of floor\"]", friction)?;
        tab_to(page, "#save-scene")?;
        page.press(&Key::ENTER)?;
        page.until(&format!(
            "document.querySelector('#said').textContent.includes('{said}')"
        ))?;
    }
    page.evaluate("document.activeElement.blur()")?;
    fill(page, "#corners", "2 2 0.1\n3 2 0.1\n3 3 0.1\n2 3 0.1")?;
    tab_to(page, "#add")?;
    page.press(&Key::ENTER)?;
    page.evaluate("document.activeElement.blur()")?;
    fill(page, "#friction", "0.5")?;
    fill(page, "#goal_x", "0.4")?;
    fill(page, "#goal_y", "0")?;
    fill(page, "#goal_yaw", "0")?;
    fill(page, "#name", "mine")?;
    let (scene, terrain) = saved(page, downloads, "mine")?;
    ensure!(
        scene.goal.base_position_m == Some(vec![0.4, 0.0]) && scene.friction.default == Some(0.5)
    );
    ensure!(scene.surfaces_file.as_deref() == Some("mine.surfaces.json"));
    let roles: Vec<_> = terrain
        .faces
        .iter()
        .map(|f| (f.id.as_str(), f.roles.clone()))
        .collect();
    ensure!(
        roles
            == [
                ("floor", None),
                ("step", Some(Vec::new())),
                ("drawn-1", None)
            ],
        "{roles:?}"
    );
    let friction = terrain.faces.iter().map(|f| f.friction);
    ensure!(friction.eq([Some(0.4), None, None]));
    let drawn = &terrain.faces[2];
    ensure!((drawn.region.area() - 1.0).abs() < 1e-9 && drawn.normal_W().z > 0.999_999);
    ensure!(page.complaints().is_empty(), "complaints while editing");

    // Planned, and played.
    page.evaluate("document.activeElement.blur()")?;
    tab_to(page, "#plan")?;
    page.press(&Key::ENTER)?;
    page.until(
        "location.pathname.endsWith('/show/out/mine/view.html') && window.scandent?.ready === true",
    )?;
    // It plays by itself, to the end.
    page.until("Number(document.querySelector('#stance').value) === Number(document.querySelector('#stance').max)")?;
    ensure!(
        text(page, "#verdict")?.contains("PASS"),
        "the plan is not verified"
    );
    Ok(())
}

fn cancel(page: &mut Page) -> Result<()> {
    fill(page, "#goal_x", "180")?;
    fill(page, "#goal_y", "0")?;
    tab_to(page, "#plan")?;
    page.press(&Key::ENTER)?;
    page.until("document.querySelector('#state').textContent.includes('contact sets')")?;
    page.evaluate("document.activeElement.blur()")?;
    tab_to(page, "#cancel")?;
    page.press(&Key::ENTER)?;
    page.until("document.querySelector('#result') !== null")?;
    ensure!(
        text(page, "#state")?.contains("No plan was found"),
        "not cancelled"
    );
    Ok(())
}

#[test]
fn surfaces_are_edited_saved_planned_on_and_a_plan_is_cancelled() {
    let Some(chromium) = chromium() else { return };
    let (folder, downloads) = (folder(), tempfile::tempdir().unwrap());
    let address = served(folder.path());
    let page = || {
        Page::open(
            &chromium,
            &format!("{address}edit/a%20floor.surfaces.json"),
            (1100, 760),
        )
    };
    let mut first = page().unwrap();
    let done = edit_save_and_plan(&mut first, downloads.path());
    done.with_context(|| first.complaints().join("\n")).unwrap();
    assert!(first.complaints().is_empty(), "{:?}", first.complaints());
    drop(first);
    let mut second = page().unwrap();
    let done = cancel(&mut second);
    done.with_context(|| second.complaints().join("\n"))
        .unwrap();
    assert!(second.complaints().is_empty(), "{:?}", second.complaints());
    // The edited files are those of a command.
    for file in ["mine.toml", "mine.surfaces.json", "out/mine/plan.json"] {
        assert!(folder.path().join(file).is_file(), "{file}");
    }
}

#[test]
fn what_is_not_asked_well_is_refused_with_a_message() {
    let folder = folder();
    let address = served(folder.path());
    let token = address.rsplit('/').nth(1).unwrap().to_owned();
    let floor: Value = serde_json::from_str(
        &std::fs::read_to_string(folder.path().join("a floor.surfaces.json")).unwrap(),
    )
    .unwrap();
    let asked = |scene: &str| json!({ "scene": scene, "surfaces": floor }).to_string();
    let scene = |name: &str, robot: &str| {
        asked(&format!(
            "name = \"{name}\"\nsurfaces_file = \"x\"\nrobot.urdf = \"{robot}\"\ngoal.base_position_m = [0.4, 0.0]\n"
        ))
    };
    let at = |path: &str| format!("/{token}/{path}");
    let get = |path: &str, host: Option<&str>| request(&address, "GET", path, host, "");
    let post = |body: &str| request(&address, "POST", &at("plan"), None, body);
    let mut answers = vec![
        (get("/", None), 403, "token"),
        (get("/0123/status", None), 403, "token"),
        (
            get(&at("status"), Some("evil.example")),
            403,
            "only http://127.0.0.1",
        ),
        (
            request(&address, "POST", &at("status"), None, ""),
            405,
            "GET",
        ),
    ];
    for (path, code, said) in [
        ("edit/../../etc/passwd", 403, "leads out"),
        ("edit/%2e%2e%2fx.json", 403, "leads out"),
        ("edit//etc/passwd", 403, "leads out"),
        ("show/a%20floor.surfaces.json", 400, "only pages of plans"),
        ("edit/absent.json", 404, "absent.json"),
        ("%ff", 400, "UTF-8"),
        ("nonsense", 404, "no such address"),
        ("plan", 405, "POST"),
    ] {
        answers.push((get(&at(path), None), code, said));
    }
    let bare = |scene: &str| json!({ "scene": scene, "surfaces": {} }).to_string();
    for (body, code, said) in [
        ("{".into(), 400, "no JSON"),
        ("{}".into(), 400, "scene"),
        (bare("x = "), 400, "no TOML"),
        (bare("name = \"x\""), 400, "surfaces"),
        (asked("name = \"x\""), 400, "robot"),
        (scene("../x", "builtin:hrp2"), 400, "name"),
        (scene("x", "../secret.urdf"), 404, "secret"),
        (scene("x", "/etc/passwd"), 403, "leads out"),
    ] {
        answers.push((post(&body), code, said));
    }
    for ((got, answer), code, said) in answers {
        assert_eq!(got, code, "{said:?} is wanted: {answer}");
        assert!(answer.contains(said), "no {said:?}: {answer}");
    }
    // None of it left anything.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    assert_eq!(request(&address, "GET", &at(""), None, "").0, 200);
}
