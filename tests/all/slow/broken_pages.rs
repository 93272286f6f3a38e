//! The test of the page is itself tested: it must see what goes wrong, wherever it happens.

use crate::viewer::{check, chromium, fixture_page};

#[test]
fn a_broken_page_is_noticed() {
    let Some(chromium) = chromium() else { return };
    let html = fixture_page();
    let with_script =
        |script: &str| html.replacen("<body>", &format!("<body><script>{script}</script>"), 1);
    let replaced = |from: &str, to: &str| html.replacen(from, to, 1);
    let with_image = |html: &str| {
        let image = "<img src=\"http://127.0.0.1:9/a.png\" alt=\"\"></body>";
        html.replacen("</body>", image, 1)
    };
    let unguarded = replaced("default-src 'none'", "default-src *");
    let unguarded = unguarded.replacen("img-src data:", "img-src *", 1);
    #[rustfmt::skip]
    let breakages = [
        ("a motion that stands still", replaced("this.frames-1)", "0)"), "the motion stands still"),
        ("data that cannot be shown", replaced("\"stances\":[", "\"stanzas\":["), "console: "),
        ("a console error at the first key",
            with_script("addEventListener('keydown', () => console.error('broken'))"), "broken"),
        ("an exception at the last stance",
            replaced("\"change\":{\"kind\":\"goal\"}", "\"change\":null"), "uncaught: "),
        ("a promise that fails unheard",
            with_script("setTimeout(() => Promise.reject(new Error('unheard')), 0)"), "unheard"),
        ("a request, refused by the page's policy", with_image(&html), "Content Security Policy"),
        ("a request where no policy refuses it", with_image(&unguarded),
            "request for http://127.0.0.1:9/a.png"),
        ("a number that is none",
            replaced("\"nodes_expanded\":6", "\"nodes_expanded\":{}"), "[object"),
        ("a slider that moves nothing", replaced("\"Stance\",oninput:", "\"Stance\",onnothing:"), "instead of"),
        ("a picture that stands still",
            replaced("this.renderer.render(this.scene,this.camera)",
                "this.drawn||=(this.renderer.render(this.scene,this.camera),1)"),
            "looks like the one before"),
    ];
    for (what, broken, told) in breakages {
        assert_ne!(broken, html, "{what}: nothing was broken");
        let error = format!("{:#}", check(&chromium, &broken).expect_err(what));
        assert!(error.contains(told), "{what}: {error}");
    }
}
