//! A program under test, run by its command line.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use serde_json::Value;

/// A built `scandent`.
pub struct Program {
    path: PathBuf,
}

/// What a run of it left.
pub struct Ran {
    pub code: i32,
    pub printed: String,
    pub errors: String,
}

impl Program {
    pub fn new(path: &Path) -> Result<Self> {
        let path = path
            .canonicalize()
            .with_context(|| format!("{}: no such program; build it first", path.display()))?;
        Ok(Self { path })
    }

    /// Runs it with these arguments; an exit code that is none of `codes` is an error.
    pub fn run<S: AsRef<str>>(&self, args: &[S], codes: &[i32]) -> Result<Ran> {
        let args: Vec<&str> = args.iter().map(AsRef::as_ref).collect();
        let output = Command::new(&self.path)
            .args(&args)
            .env_remove("RUST_LOG")
            .output()
            .with_context(|| format!("{} cannot be started", self.path.display()))?;
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let (printed, errors) = (text(&output.stdout), text(&output.stderr));
        let (code, status) = (output.status.code(), output.status);
        let Some(code) = code.filter(|code| codes.contains(code)) else {
            bail!(
                "`scandent {}` ended with {status}: {errors}",
                args.join(" ")
            );
        };
        Ok(Ran {
            code,
            printed,
            errors,
        })
    }

    /// Names of the scenes that ship with it.
    pub fn scenes(&self) -> Result<Vec<String>> {
        let list = self.run(&["scenes"], &[0])?.printed;
        let first = |line: &str| line.split_whitespace().next().map(str::to_owned);
        Ok(list.lines().filter_map(first).collect())
    }
}

/// A JSON file.
pub fn json(path: &Path) -> Result<Value> {
    let bytes = std::fs::read(path).with_context(|| format!("{}", path.display()))?;
    serde_json::from_slice(&bytes).with_context(|| format!("{}", path.display()))
}

/// A path as an argument.
pub fn argument(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}
