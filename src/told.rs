//! What a command tells: words as it goes or, with `--json`, one document at the end.

use std::fmt::Display;
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::Result;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};

use crate::mistakes;
use crate::progress::ProgressLine;
use crate::provenance::STANDARD;
use crate::status::{self, Status, UsageError};

/// The document of a command, told with `--json`.
#[derive(Default, Serialize, JsonSchema)]
pub struct Document {
    /// The command, as `calibrate camera`; nothing where the command line holds none.
    command: String,
    /// The program's version.
    version: String,
    /// How it ended: `done`, `failed`, `no_plan`, `not_executed`, `undecided`, `usage` or `error`.
    status: String,
    /// The exit code that says so.
    exit_code: u8,
    /// What was met on the way.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    notes: Vec<String>,
    /// Files and folders of results.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    written: Vec<String>,
    /// Pages to look at.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    open: Vec<String>,
    /// Criteria that do not hold.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    failures: Vec<String>,
    /// Why it did nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<Failure>,
    /// What was found or done, under names of the command's own.
    #[serde(flatten)]
    facts: Map<String, Value>,
}

/// Why a command did nothing.
#[derive(Serialize, JsonSchema)]
struct Failure {
    /// `usage` or `error`.
    kind: String,
    /// All of it in words.
    message: String,
    /// Each mistake in words.
    mistakes: Vec<String>,
    /// The exit code.
    exit_code: u8,
}

/// Takes what a command tells. What is written to it are words, which the document leaves out; what the document
/// holds are facts. [`Self::note`], [`Self::written`], [`Self::open`] and [`Self::fails`] are both.
pub struct Told<'a> {
    out: &'a mut dyn Write,
    document: Option<Box<Document>>,
    /// Whether somebody waits at a terminal.
    is_awaited: bool,
}

impl<'a> Told<'a> {
    /// Words to `out`.
    pub fn words(out: &'a mut dyn Write) -> Self {
        Self {
            out,
            document: None,
            is_awaited: false,
        }
    }

    /// The same, with what is being done on stderr.
    #[must_use]
    pub fn awaited(self) -> Self {
        Self {
            is_awaited: true,
            ..self
        }
    }

    /// One document to `out`, for the command of a name.
    pub fn document(command: &str, out: &'a mut dyn Write) -> Self {
        let document = Document {
            command: command.to_owned(),
            version: crate::program().version,
            ..Document::default()
        };
        Self {
            out,
            document: Some(Box::new(document)),
            is_awaited: false,
        }
    }

    /// Adds what was found or done, under a name of its own.
    ///
    /// # Errors
    /// A map of which the keys are no strings.
    pub fn fact(&mut self, name: &str, value: impl Serialize) -> Result<()> {
        if let Some(document) = &mut self.document {
            let value = serde_json::to_value(value)?;
            document.facts.insert(name.to_owned(), value);
        }
        Ok(())
    }

    /// Adds a fact that is written as JSON already.
    ///
    /// # Errors
    /// Text that is no JSON.
    pub fn written_fact(&mut self, name: &str, json: &[u8]) -> Result<()> {
        if let Some(document) = &mut self.document {
            let value = serde_json::from_slice(json)?;
            document.facts.insert(name.to_owned(), value);
        }
        Ok(())
    }

    /// Adds to a list, or says it.
    fn item(
        &mut self,
        list: impl FnOnce(&mut Document) -> &mut Vec<String>,
        item: String,
        words: &str,
    ) -> std::io::Result<()> {
        match &mut self.document {
            None => writeln!(self.out, "{words}{item}"),
            Some(document) => {
                list(document).push(item);
                Ok(())
            }
        }
    }

    /// Does what may take long, and says what it is meanwhile.
    pub fn during<T>(&self, stage: &str, work: impl FnOnce() -> T) -> T {
        let line = self.is_awaited.then(ProgressLine::default);
        if let Some(line) = &line {
            line.stage(stage);
        }
        work()
    }

    /// Does many pieces of work, which call what they are given as each is done, and counts them meanwhile.
    pub fn counting<T>(
        &self,
        stage: &str,
        of: usize,
        work: impl FnOnce(&(dyn Fn() + Sync)) -> T,
    ) -> T {
        let line = self.is_awaited.then(ProgressLine::default);
        line.iter().for_each(|line| line.stage(stage));
        let done = AtomicUsize::new(0);
        let count = |done| line.iter().for_each(|line| line.count(stage, done, of));
        work(&|| count(done.fetch_add(1, Ordering::Relaxed) + 1))
    }

    /// Tells at once of one of many that is done; of a document on stderr.
    pub fn done(&mut self, words: &str) -> std::io::Result<()> {
        match self.document {
            None => writeln!(self.out, "{words}").and_then(|()| self.out.flush()),
            Some(_) => writeln!(std::io::stderr(), "{words}"),
        }
    }

    /// Notes what was met on the way.
    ///
    /// # Errors
    /// When it cannot be written; as of those below.
    pub fn note(&mut self, note: impl Display) -> std::io::Result<()> {
        self.item(|d| &mut d.notes, note.to_string(), "")
    }

    /// Tells of a result in a file or folder; who reads the standard output sees that.
    ///
    /// # Errors
    /// As there.
    pub fn written(&mut self, path: &Path) -> std::io::Result<()> {
        match path == Path::new(STANDARD) {
            true => Ok(()),
            false => self.item(|d| &mut d.written, path.display().to_string(), "written: "),
        }
    }

    /// Tells of a page to look at.
    ///
    /// # Errors
    /// As there.
    pub fn open(&mut self, page: impl Display) -> std::io::Result<()> {
        self.item(|d| &mut d.open, page.to_string(), "open in a browser: ")
    }

    /// Tells of a criterion that does not hold; the words go to stderr.
    pub fn fails(&mut self, failure: &str) {
        match &mut self.document {
            None => eprintln!("fails: {failure}"),
            Some(document) => document.failures.push(failure.to_owned()),
        }
    }

    /// Tells how the command ended, once, and gives the exit code.
    pub fn end(&mut self, ended: &Result<Status>) -> ExitCode {
        let (name, code) = match ended {
            Ok(status) => (status.name(), status.code()),
            Err(error) if error.is::<UsageError>() => ("usage", status::USAGE),
            Err(_) => ("error", status::ERROR),
        };
        let said = match (self.document.take(), ended) {
            (None, Ok(_)) => self.out.flush(),
            (None, Err(error)) => {
                eprintln!("error: {error:#}");
                Ok(())
            }
            (Some(mut document), ended) => {
                name.clone_into(&mut document.status);
                document.exit_code = code;
                document.error = ended.as_ref().err().map(|error| Failure {
                    kind: name.to_owned(),
                    message: format!("{error:#}"),
                    mistakes: mistakes::of(error),
                    exit_code: code,
                });
                serde_json::to_value(document)
                    .map_err(Into::into)
                    .and_then(|document| writeln!(self.out, "{document:#}"))
                    .and_then(|()| self.out.flush())
            }
        };
        match said {
            Ok(()) => ExitCode::from(code),
            Err(error) => {
                eprintln!("error: {error}");
                ExitCode::from(status::ERROR)
            }
        }
    }
}

impl Write for Told<'_> {
    fn write(&mut self, words: &[u8]) -> std::io::Result<usize> {
        match self.document {
            None => self.out.write(words),
            Some(_) => Ok(words.len()),
        }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}
