//! What a page must do, whatever plan it shows.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};

use super::chromium::{Key, Page};

/// Opens the page, moves through all its stances by key, slider and play button, switches every
/// layer, view and theme, and fails on any complaint of the browser.
///
/// `stances`: how many the page must have.
pub fn check_page(chromium: &Path, html: &Path, stances: usize) -> Result<()> {
    ensure!(stances > 1, "a plan of one stance does not move");
    let url = format!("file://{}#stance=1", html.canonicalize()?.display());
    let mut page = Page::open(chromium, &url, (1000, 640))?;
    use_page(&mut page, stances).with_context(|| page.complaints().join("\n"))
}

fn use_page(page: &mut Page, stances: usize) -> Result<()> {
    let quiet = |page: &Page, doing: &str| {
        ensure!(page.complaints().is_empty(), "complaints while {doing}");
        Ok(())
    };
    quiet(page, "opening")?;
    let ready = page.evaluate("window.scandent?.ready === true")?;
    ensure!(ready == true, "the page is not ready");
    let count = page.evaluate("window.scandent.stanceCount")?;
    ensure!(
        count == stances,
        "the page has {count} stances, the plan {stances}"
    );
    expect_stance(page, 1).context("opened at #stance=1")?;

    // Every stance by key, each with a picture of its own.
    page.evaluate("document.querySelector('#stance').focus()")?;
    page.press(&Key::HOME)?;
    // The names over the picture change too: only the picture itself shall tell.
    page.evaluate(
        "for (const over of document.querySelectorAll('#labels, #caption')) over.style.opacity = 0",
    )?;
    let mut before = None;
    for stance in 0..stances {
        if stance > 0 {
            page.press(&Key::RIGHT)?;
        }
        expect_stance(page, stance)?;
        settle(page)?;
        let picture = picture(page)?;
        ensure!(
            before.as_ref() != Some(&picture),
            "stance {stance} looks like the one before"
        );
        before = Some(picture);
        let odd =
            page.evaluate("document.body.innerText.match(/.*(undefined|NaN|\\[object).*/)?.[0]")?;
        ensure!(odd.is_null(), "stance {stance} says {odd}");
        let why = format!(
            "JSON.parse(document.querySelector('#scandent-data').textContent).trace?.choices
                 .filter((choice) => choice.stance === {stance})
                 .every(({{ alternatives }}) => ['Why this contact', ...alternatives.map((one) => one.reason)]
                     .every((words) => document.querySelector('#panel').textContent.includes(words)))"
        );
        let why = page.evaluate(&why)?;
        ensure!(why != false, "stance {stance} does not say why");
        quiet(page, &format!("showing stance {stance}"))?;
    }

    // The slider by mouse: from the last stance to the first.
    let thumb = |end: &str| {
        format!(
            "(() => {{ const box = document.querySelector('#stance').getBoundingClientRect();
               return [box.{end} {} 8, box.top + box.height / 2]; }})()",
            if end == "left" { "+" } else { "-" },
        )
    };
    let (left, right) = (place(page, &thumb("left"))?, place(page, &thumb("right"))?);
    page.drag(right, left)?;
    expect_stance(page, 0).context("after dragging the slider")?;

    // Play, by the keyboard.
    page.evaluate("document.activeElement.blur()")?;
    page.press(&Key::SPACE)?;
    let patience = Instant::now() + Duration::from_secs(60);
    while page.evaluate("document.querySelector('#stance').value")? == "0" {
        ensure!(Instant::now() < patience, "playing does not move");
        std::thread::sleep(Duration::from_millis(100));
    }
    page.press(&Key::SPACE)?;
    let playing = page.evaluate("document.querySelector('#play').ariaPressed")?;
    ensure!(playing == "false", "playing does not stop");
    quiet(page, "playing")?;

    // Moments of the motion, where there is one.
    let moves = page.evaluate(
        "JSON.parse(document.querySelector('#scandent-data').textContent).motion !== null",
    )?;
    if moves == true {
        // Of the robot alone: forces of the moment would hide that it stands still.
        page.evaluate(
            "globalThis.off = [...document.querySelectorAll('#layers input:checked')]
                 .filter((box) => box.id !== 'layer-robot');
             off.forEach((box) => box.click())",
        )?;
        let mut moment = |time: &str| -> Result<String> {
            page.evaluate(&format!("location.hash = '#time={time}'"))?;
            settle(page)?;
            let said = page.evaluate("document.querySelector('#caption').innerText")?;
            let said = said.as_str().unwrap_or_default().to_owned();
            ensure!(
                said.contains(&format!("{time} s of")),
                "at {time} s the page says {said}"
            );
            picture(page)
        };
        ensure!(moment("1.3")? != moment("1.7")?, "the motion stands still");
        page.evaluate("off.forEach((box) => box.click())")?;
        quiet(page, "showing the motion")?;
    }

    // Layers, views, themes, the address.
    let layers = page.evaluate(
        "(() => { const boxes = [...document.querySelectorAll('#layers input')];
           for (const box of boxes) { box.click(); box.click(); }
           return boxes.length; })()",
    )?;
    ensure!(layers.as_u64() > Some(8), "{layers} layers");
    page.evaluate(
        "document.querySelectorAll('#views button').forEach((button) => button.click())",
    )?;
    for (key, what) in [
        (Key::FRONT_VIEW, "another view"),
        (Key::THEME, "another theme"),
    ] {
        let before = picture(page)?;
        page.press(&key)?;
        settle(page)?;
        ensure!(picture(page)? != before, "{what} looks the same");
    }
    page.evaluate(&format!(
        "location.hash = '#stance={}&view=right'",
        stances - 1
    ))?;
    settle(page)?;
    expect_stance(page, stances - 1).context("after a change of the address")?;
    quiet(page, "switching layers, views and themes")
}

/// Waits until two frames were drawn.
fn settle(page: &mut Page) -> Result<()> {
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))")?;
    Ok(())
}

/// What the stage shows, panel and slider left out.
fn picture(page: &mut Page) -> Result<String> {
    let stage = "(() => { const box = document.querySelector('#stage').getBoundingClientRect();
        return { x: box.x, y: box.y, width: box.width, height: box.height, scale: 1 }; })()";
    let clip = page.evaluate(stage)?;
    page.picture(clip)
}

fn expect_stance(page: &mut Page, stance: usize) -> Result<()> {
    let shown = page.evaluate(
        "[document.querySelector('#stance').value, document.querySelector('#panel h2').firstChild.data]",
    )?;
    let wanted = serde_json::json!([stance.to_string(), format!("Stance {stance}")]);
    ensure!(
        shown == wanted,
        "the page shows {shown} instead of {wanted}"
    );
    Ok(())
}

fn place(page: &mut Page, expression: &str) -> Result<(f64, f64)> {
    let place = page.evaluate(expression)?;
    let at = |k: usize| place[k].as_f64().context("no place");
    Ok((at(0)?, at(1)?))
}
