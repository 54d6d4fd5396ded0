//! Headless Chromium, driven through pipes by `DevTools`.

use std::fs::{File, OpenOptions};
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::time::Duration;

use serde_json::{Value, json};
use tempfile::TempDir;

/// After so long without a word the browser hangs.
const PATIENCE: Duration = Duration::from_mins(1);

/// A browser with one tab.
pub(crate) struct Browser {
    child: Child,
    to: File,
    from: Receiver<Value>,
    session: String,
    calls: u64,
    /// What was heard and not asked for yet.
    events: Vec<Value>,
    /// Its profile and its pipes.
    _folder: TempDir,
}

/// The browser of this machine: what `CHROMIUM` names, or what is in the path.
pub(crate) fn installed() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("CHROMIUM") {
        return Some(named.into());
    }
    let path = std::env::var_os("PATH")?;
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    ["chromium", "chromium-browser", "google-chrome"]
        .iter()
        .find_map(|name| folders.iter().map(|folder| folder.join(name)).find(|file| file.is_file()))
}

impl Browser {
    /// Starts a browser.
    pub(crate) fn start(program: &Path) -> Self {
        let folder = tempfile::tempdir().expect("the system has a folder for temporaries");
        let pipe = |name: &str| {
            let path = folder.path().join(name);
            let made = Command::new("mkfifo").arg(&path).status().expect("there is a mkfifo");
            assert!(made.success(), "{}", path.display());
            path
        };
        let (ask, hear) = (pipe("ask"), pipe("hear"));
        // The browser reads its file 3, and writes to its file 4.
        let child = Command::new("sh")
            .args(["-c", r#"exec "$0" "$@" 3<"$ASK" 4>"$HEAR""#])
            .arg(program)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"])
            .args(["--remote-debugging-pipe", "--force-color-profile=srgb"])
            .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
            .env("ASK", &ask)
            .env("HEAR", &hear)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("there is a sh");
        let to = OpenOptions::new().write(true).open(ask).expect("the shell opens the other end");
        let from = BufReader::new(File::open(hear).expect("the shell opens the other end"));
        let (tell, heard) = mpsc::channel();
        std::thread::spawn(move || {
            for message in from.split(0) {
                let message = message.ok().and_then(|text| serde_json::from_slice(&text).ok());
                if message.is_none_or(|message: Value| tell.send(message).is_err()) {
                    break;
                }
            }
        });
        let mut browser = Self {
            child,
            to,
            from: heard,
            session: String::new(),
            calls: 0,
            events: Vec::new(),
            _folder: folder,
        };
        let tab = browser.call("Target.createTarget", &json!({"url": "about:blank"}));
        let attach = json!({"targetId": tab["targetId"], "flatten": true});
        let session = browser.call("Target.attachToTarget", &attach);
        session["sessionId"].as_str().expect("a session").clone_into(&mut browser.session);
        for domain in ["Page", "Runtime", "Log"] {
            browser.call(&format!("{domain}.enable"), &json!({}));
        }
        browser
    }

    fn hear(&mut self) -> Value {
        self.from.recv_timeout(PATIENCE).expect("the browser answers")
    }

    /// Calls a method of the protocol, and returns its result.
    pub(crate) fn call(&mut self, method: &str, params: &Value) -> Value {
        self.calls += 1;
        let mut call = json!({"id": self.calls, "method": method, "params": params});
        if !self.session.is_empty() {
            call["sessionId"] = json!(self.session);
        }
        self.to.write_all(format!("{call}\0").as_bytes()).expect("the browser listens");
        loop {
            let mut message = self.hear();
            if message["id"] == self.calls {
                assert!(message["error"].is_null(), "{method}: {}", message["error"]);
                return message["result"].take();
            }
            self.events.push(message);
        }
    }

    /// Opens a page in a window of that width, and returns what went wrong meanwhile.
    pub(crate) fn open(&mut self, page: &Path, width: u32) -> Vec<String> {
        let size = json!({"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": false});
        self.call("Emulation.setDeviceMetricsOverride", &size);
        self.events.clear();
        self.call("Page.navigate", &json!({"url": format!("file://{}", page.display())}));
        while self.events.iter().all(|event| event["method"] != "Page.loadEventFired") {
            let event = self.hear();
            self.events.push(event);
        }
        self.complaints()
    }

    /// Errors and warnings of the page since this was last asked.
    pub(crate) fn complaints(&mut self) -> Vec<String> {
        let is_complaint = |event: &Value| match event["method"].as_str() {
            Some("Runtime.exceptionThrown") => true,
            Some("Log.entryAdded") => event["params"]["entry"]["level"] != "verbose",
            Some("Runtime.consoleAPICalled") => {
                ["error", "warning", "assert"].iter().any(|bad| event["params"]["type"] == *bad)
            }
            _ => false,
        };
        let events = std::mem::take(&mut self.events);
        let said = events.iter().filter(|event| is_complaint(event));
        said.map(|event| event["params"].to_string()).collect()
    }

    /// The value of an expression on the page.
    pub(crate) fn value(&mut self, expression: &str) -> Value {
        let asked = json!({"expression": expression, "returnByValue": true});
        let mut answer = self.call("Runtime.evaluate", &asked);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {answer}");
        answer["result"]["value"].take()
    }

    /// Presses a key.
    pub(crate) fn press(&mut self, key: &str) {
        let (code, text) = match key {
            "Tab" => (9, ""),
            "Enter" => (13, "\r"),
            "ArrowRight" => (39, ""),
            "Escape" => (27, ""),
            other => panic!("no code for {other}"),
        };
        for kind in ["keyDown", "keyUp"] {
            let text = if kind == "keyDown" { text } else { "" };
            let key = json!({"type": kind, "key": key, "code": key, "text": text, "windowsVirtualKeyCode": code});
            self.call("Input.dispatchKeyEvent", &key);
        }
    }

    /// Moves the pointer.
    pub(crate) fn point_at(&mut self, [x, y]: [f64; 2]) {
        let at = json!({"type": "mouseMoved", "x": x, "y": y});
        self.call("Input.dispatchMouseEvent", &at);
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Its answer does not come where it is gone already.
        let _ = self.to.write_all(b"{\"id\":0,\"method\":\"Browser.close\"}\0");
        let _ = self.child.wait();
    }
}
