//! The site that `scripts/home-page` makes: every link leads somewhere, and its pages fit a desktop and a phone, in both
//! themes, without a complaint of the browser.

use std::process::Command;

use serde_json::json;

use crate::support::chromium::Page;
use crate::support::program::root;
use crate::viewer::chromium;

#[test]
fn the_site_fits_a_desktop_and_a_phone() {
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_scandent"));
    let target = program.ancestors().nth(2).expect("a target folder");
    let python = target.join("python-venv/bin/python");
    if !python.exists() {
        eprintln!("SKIPPED: no {}: scripts/test makes it", python.display());
        return;
    }
    let site = tempfile::tempdir().expect("a folder");
    let mut script = Command::new(python);
    script.arg(root("scripts/home-page")).arg(site.path());
    let made = script.output().expect("a script that runs");
    let said = String::from_utf8_lossy(&made.stdout);
    let error = String::from_utf8_lossy(&made.stderr);
    assert!(made.status.success(), "{said}{error}");

    let Some(chromium) = chromium() else { return };
    for name in ["index.html", "docs/README.html", "docs/figures.html"] {
        let url = format!("file://{}", site.path().join(name).display());
        let mut page = Page::open(&chromium, &url, (1280, 800)).expect("a page");
        // As the reader scrolls past them.
        let loaded = "Promise.all([...document.images].map((i) => (i.loading = 'eager', i.decode().then(() => i.naturalWidth > 0))))";
        let loaded = page.evaluate(&format!("{loaded}.then((all) => all.every(Boolean))"));
        assert_eq!(
            loaded.expect("pictures"),
            true,
            "{name}: a picture is missing"
        );
        let mut pictures = Vec::new();
        for (width, height) in [(1280, 800), (390, 844)] {
            for theme in ["light", "dark"] {
                page.show_as((width, height), theme).expect("a screen");
                let wide = page.evaluate("document.documentElement.scrollWidth");
                assert_eq!(wide.expect("a width"), width, "{name}");
                let nameless = page.nameless().expect("names");
                assert!(nameless.is_empty(), "{name}: no name or key: {nameless:?}");
                let clip = json!({ "x": 0, "y": 0, "width": width, "height": height, "scale": 1 });
                pictures.push(page.picture(clip).expect("a picture"));
            }
        }
        // Text and pictures on them, and the themes differ.
        assert!(
            pictures.iter().all(|picture| picture.len() > 20_000),
            "{name}"
        );
        assert!(
            pictures[0] != pictures[1] && pictures[2] != pictures[3],
            "{name}"
        );
        assert!(page.complaints().is_empty(), "{:?}", page.complaints());
    }
}
