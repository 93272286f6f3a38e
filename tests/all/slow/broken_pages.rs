//! The test of the page is itself tested: it must see what goes wrong, wherever it happens.

use crate::viewer::{check, chromium, fixture_page};

#[test]
fn a_broken_page_is_noticed() {
    let Some(chromium) = chromium() else { return };
    let html = fixture_page();
    let with_script =
        |script: &str| html.replacen("<body>", &format!("<body><script>{script}</script>"), 1);
    let breakages = [
        (
            "a motion that stands still",
            html.replacen("part)", "0)", 0)
                .replacen("this.frames-1)", "0)", 1),
            "the motion stands still",
        ),
        (
            "data that cannot be shown",
            html.replacen("\"stances\":[", "\"stanzas\":[", 1),
            "console: ",
        ),
        (
            "a console error at the first key",
            with_script("addEventListener('keydown', () => console.error('broken'))"),
            "broken",
        ),
        (
            "an exception at the last stance",
            html.replacen("\"change\":{\"kind\":\"goal\"}", "\"change\":null", 1),
            "uncaught: ",
        ),
        (
            "a promise that fails unheard",
            with_script("setTimeout(() => Promise.reject(new Error('unheard')), 0)"),
            "unheard",
        ),
        (
            "a request, refused by the page's policy",
            html.replacen(
                "</body>",
                "<img src=\"http://127.0.0.1:9/a.png\" alt=\"\"></body>",
                1,
            ),
            "Content Security Policy",
        ),
        (
            "a request where no policy refuses it",
            html.replacen("default-src 'none'", "default-src *", 1)
                .replacen("img-src data:", "img-src *", 1)
                .replacen(
                    "</body>",
                    "<img src=\"http://127.0.0.1:9/a.png\" alt=\"\"></body>",
                    1,
                ),
            "request for http://127.0.0.1:9/a.png",
        ),
        (
            "a number that is none",
            html.replacen("\"nodes_expanded\":6", "\"nodes_expanded\":{}", 1),
            "[object",
        ),
        (
            "a slider that moves nothing",
            html.replacen("oninput:", "onnothing:", 1),
            "instead of",
        ),
        (
            "a picture that stands still",
            html.replacen(
                "this.renderer.render(this.scene,this.camera)",
                "this.drawn||=(this.renderer.render(this.scene,this.camera),1)",
                1,
            ),
            "looks like the one before",
        ),
    ];
    for (what, broken, told) in breakages {
        assert_ne!(broken, html, "{what}: nothing was broken");
        let error = format!("{:#}", check(&chromium, &broken).expect_err(what));
        assert!(error.contains(told), "{what}: {error}");
    }
}
