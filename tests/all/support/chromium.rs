//! A headless Chromium driven over its debugging pipe: real keys and clicks, and every complaint.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};
use tempfile::TempDir;

/// How long any one answer may take: software rendering on a loaded machine is slow.
const PATIENCE: Duration = Duration::from_secs(120);

/// WebGL through SwiftShader, and nothing that the browser does by itself.
const FLAGS: &str = "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run \
    --disable-background-networking --disable-component-update --disable-sync \
    --disable-dev-shm-usage --hide-scrollbars --use-gl=angle --use-angle=swiftshader \
    --enable-unsafe-swiftshader --remote-debugging-pipe";

/// The browser of the environment's `CHROMIUM`, or else the first on the PATH.
pub fn find() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("CHROMIUM") {
        return Some(named.into());
    }
    let folders: Vec<_> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    ["chromium", "chromium-browser", "google-chrome"]
        .iter()
        .flat_map(|name| folders.iter().map(move |folder| folder.join(name)))
        .find(|program| program.is_file())
}

/// One page in a browser of its own.
pub struct Page {
    browser: Child,
    requests: ChildStdin,
    answers: Receiver<Value>,
    session: Option<String>,
    asked: u64,
    loads: usize,
    complaints: Vec<String>,
    /// What addresses may begin with beside files and data.
    server: Option<String>,
    _profile: TempDir,
}

impl Page {
    /// Opens `url` in a window of that size, px, and waits until it is loaded.
    ///
    /// Where it is served, requests to that server are none to complain of.
    pub fn open(program: &Path, url: &str, (width, height): (u32, u32)) -> Result<Self> {
        let profile = TempDir::new()?;
        // The pipe is spoken on descriptors 3 and 4.
        let mut browser = Command::new("sh")
            .args(["-c", r#"exec "$0" "$@" 3<&0 4>&1 1>&2"#])
            .arg(program)
            .args(FLAGS.split_whitespace())
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg(format!("--window-size={width},{height}"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .with_context(|| format!("starting {}", program.display()))?;
        let requests = browser.stdin.take().context("the browser has no input")?;
        let output = browser.stdout.take().context("the browser has no output")?;
        let (sender, answers) = channel();
        std::thread::spawn(move || {
            for message in BufReader::new(output).split(0).map_while(Result::ok) {
                let Ok(message) = serde_json::from_slice(&message) else {
                    return;
                };
                if sender.send(message).is_err() {
                    return;
                }
            }
        });
        let mut page = Page {
            browser,
            requests,
            answers,
            session: None,
            asked: 0,
            loads: 0,
            complaints: Vec::new(),
            server: url
                .strip_prefix("http://")
                .map(|rest| format!("http://{}/", rest.split('/').next().unwrap_or_default())),
            _profile: profile,
        };
        let target = page.call("Target.createTarget", json!({ "url": "about:blank" }))?;
        let attached = page.call(
            "Target.attachToTarget",
            json!({ "targetId": target["targetId"], "flatten": true }),
        )?;
        page.session = attached["sessionId"].as_str().map(str::to_owned);
        for domain in ["Runtime", "Log", "Network", "Page", "Inspector"] {
            page.call(&format!("{domain}.enable"), json!({}))?;
        }
        let before = page.loads;
        page.call("Page.navigate", json!({ "url": url }))?;
        while page.loads == before {
            let message = page.next("Page.loadEventFired")?;
            page.note(&message);
        }
        Ok(page)
    }

    /// Errors and warnings of the console, exceptions nobody caught, crashes, and requests for
    /// anything but a file; since the page was opened.
    pub fn complaints(&self) -> &[String] {
        &self.complaints
    }

    /// The value of an expression; a promise is awaited.
    pub fn evaluate(&mut self, expression: &str) -> Result<Value> {
        let answer = self.call(
            "Runtime.evaluate",
            json!({ "expression": expression, "returnByValue": true, "awaitPromise": true }),
        )?;
        if let Some(details) = answer.get("exceptionDetails") {
            bail!("{expression}: {}", described(details));
        }
        Ok(answer["result"]["value"].clone())
    }

    /// What of the page the browser has no name for, of all that can be used or scrolled: roles and elements.
    pub fn nameless(&mut self) -> Result<Vec<String>> {
        const NAMED: [&str; 9] = [
            "button",
            "checkbox",
            "combobox",
            "textbox",
            "slider",
            "link",
            "region",
            "Iframe",
            "spinbutton",
        ];
        let tree = self.call("Accessibility.getFullAXTree", json!({}))?;
        let nodes = tree["nodes"].as_array().context("no tree")?;
        let bare = nodes.iter().filter(|node| {
            let (role, name) = (&node["role"]["value"], &node["name"]["value"]);
            let role = role.as_str().unwrap_or_default();
            NAMED.contains(&role) && name.as_str().unwrap_or_default().trim().is_empty()
        });
        let mut found: Vec<String> = bare.map(|node| node["role"]["value"].to_string()).collect();
        // What scrolls is reached by the keyboard: itself, or something in it.
        let stuck = self.evaluate(
            "[...document.querySelectorAll('body *')].filter((one) => {
                 const { overflowX, overflowY } = getComputedStyle(one);
                 const scrolls = (over, whole, part) => ['auto', 'scroll'].includes(over) && whole > part + 1;
                 const focusable = 'a[href], button, input, select, textarea, summary, [tabindex=\"0\"]';
                 return (scrolls(overflowX, one.scrollWidth, one.clientWidth) || scrolls(overflowY, one.scrollHeight, one.clientHeight))
                     && !one.matches(focusable) && !one.querySelector(focusable);
             }).map((one) => `${one.tagName} ${one.id} ${one.className}`)",
        )?;
        found.extend(stuck.as_array().into_iter().flatten().map(Value::to_string));
        Ok(found)
    }

    /// Has what is downloaded written to a folder.
    pub fn download_to(&mut self, folder: &Path) -> Result<()> {
        let wanted = json!({ "behavior": "allow", "downloadPath": folder });
        self.call("Browser.setDownloadBehavior", wanted)?;
        Ok(())
    }

    /// Shows the page as a screen of that size, px, in its light or dark theme.
    pub fn show_as(&mut self, (width, height): (u32, u32), theme: &str) -> Result<()> {
        let screen = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600 });
        self.call("Emulation.setDeviceMetricsOverride", screen)?;
        let wanted = json!([{ "name": "prefers-color-scheme", "value": theme }]);
        self.call("Emulation.setEmulatedMedia", json!({ "features": wanted }))?;
        Ok(())
    }

    /// Writes a text where the focus is.
    pub fn write(&mut self, text: &str) -> Result<()> {
        self.call("Input.insertText", json!({ "text": text }))?;
        Ok(())
    }

    /// Waits until an expression is true.
    pub fn until(&mut self, expression: &str) -> Result<()> {
        let begin = std::time::Instant::now();
        while self.evaluate(expression)? != json!(true) {
            anyhow::ensure!(
                begin.elapsed() < PATIENCE,
                "in vain waited for {expression}"
            );
            std::thread::sleep(Duration::from_millis(100));
        }
        Ok(())
    }

    /// Presses and releases a key.
    pub fn press(&mut self, key: &Key) -> Result<()> {
        let Key { name, code, text } = *key;
        let mut event = json!({
            "type": "keyDown", "key": name, "code": name, "windowsVirtualKeyCode": code,
        });
        if let Some(text) = text {
            event["text"] = json!(text);
        }
        self.call("Input.dispatchKeyEvent", event.clone())?;
        event["type"] = json!("keyUp");
        self.call("Input.dispatchKeyEvent", event)?;
        Ok(())
    }

    /// Presses the left button at a place, px, drags to another and releases.
    pub fn drag(&mut self, from: (f64, f64), to: (f64, f64)) -> Result<()> {
        let steps = [
            ("mousePressed", from),
            ("mouseMoved", to),
            ("mouseReleased", to),
        ];
        for (kind, (x, y)) in steps {
            self.call(
                "Input.dispatchMouseEvent",
                json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1 }),
            )?;
        }
        Ok(())
    }

    /// A picture of part of the window (x, y, width, height, px, and scale), PNG in base64.
    pub fn picture(&mut self, clip: Value) -> Result<String> {
        let wanted = json!({ "format": "png", "clip": clip });
        let answer = self.call("Page.captureScreenshot", wanted)?;
        let data = answer["data"].as_str();
        data.map(str::to_owned).context("no picture")
    }

    fn call(&mut self, method: &str, params: Value) -> Result<Value> {
        self.asked += 1;
        let mut request = json!({ "id": self.asked, "method": method, "params": params });
        if let Some(session) = &self.session {
            request["sessionId"] = json!(session);
        }
        let mut bytes = serde_json::to_vec(&request)?;
        bytes.push(0);
        self.requests
            .write_all(&bytes)
            .with_context(|| format!("asking for {method}"))?;
        loop {
            let message = self.next(method)?;
            if message["id"] != json!(self.asked) {
                self.note(&message);
            } else if let Some(error) = message.get("error") {
                bail!("{method}: {error}");
            } else {
                return Ok(message["result"].clone());
            }
        }
    }

    fn next(&self, awaited: &str) -> Result<Value> {
        self.answers
            .recv_timeout(PATIENCE)
            .with_context(|| format!("the browser did not answer {awaited}"))
    }

    /// Keeps what an event complains of.
    fn note(&mut self, message: &Value) {
        let params = &message["params"];
        match message["method"].as_str().unwrap_or_default() {
            "Page.loadEventFired" => self.loads += 1,
            "Runtime.exceptionThrown" => {
                let what = described(&params["exceptionDetails"]);
                self.complaints.push(format!("uncaught: {what}"));
            }
            "Runtime.consoleAPICalled" => {
                let (kind, args) = (params["type"].as_str().unwrap_or_default(), &params["args"]);
                if ["error", "warning", "assert"].contains(&kind) {
                    self.complaints.push(format!("console: {args}"));
                }
            }
            "Log.entryAdded" if params["entry"]["level"] == "error" => {
                let what = &params["entry"]["text"];
                self.complaints.push(format!("log: {what}"));
            }
            "Network.requestWillBeSent" => {
                let url = params["request"]["url"].as_str().unwrap_or_default();
                let ours = self
                    .server
                    .as_ref()
                    .is_some_and(|ours| url.starts_with(ours));
                let local = ["file:", "data:", "blob:"]
                    .iter()
                    .any(|kind| url.starts_with(kind));
                if !local && !ours {
                    self.complaints.push(format!("request for {url}"));
                }
            }
            "Inspector.targetCrashed" => self.complaints.push("the page crashed".to_owned()),
            _ => {}
        }
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.session = None;
        // Closing lets the browser end its own processes; it may be gone already.
        let closed = self.call("Browser.close", json!({}));
        if closed.is_err() {
            let _ = self.browser.kill();
        }
        let _ = self.browser.wait();
    }
}

fn described(details: &Value) -> String {
    let exception = details["exception"]["description"].as_str();
    exception
        .or(details["text"].as_str())
        .unwrap_or("an exception")
        .to_owned()
}

/// A key as the browser knows it.
pub struct Key {
    name: &'static str,
    code: u32,
    text: Option<&'static str>,
}

impl Key {
    pub const HOME: Key = Key::new("Home", 36, None);
    pub const RIGHT: Key = Key::new("ArrowRight", 39, None);
    pub const TAB: Key = Key::new("Tab", 9, None);
    pub const DOWN: Key = Key::new("ArrowDown", 40, None);
    pub const ENTER: Key = Key::new("Enter", 13, Some("\r"));
    pub const SPACE: Key = Key::new(" ", 32, Some(" "));
    pub const FRONT_VIEW: Key = Key::new("3", 51, Some("3"));
    pub const THEME: Key = Key::new("t", 84, Some("t"));

    const fn new(name: &'static str, code: u32, text: Option<&'static str>) -> Self {
        Self { name, code, text }
    }
}
