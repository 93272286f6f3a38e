//! What a command tells: words as it goes or, with `--json`, one document at the end.

use std::fmt::Display;
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use anyhow::Result;
use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::mistakes;
use crate::progress::ProgressLine;
use crate::provenance::STANDARD;
use crate::status::{self, Status, UsageError};

/// Takes what a command tells. What is written to it are words, which the document leaves out; what the document
/// holds are facts. [`Self::note`], [`Self::written`], [`Self::open`] and [`Self::fails`] are both.
pub struct Told<'a> {
    out: &'a mut dyn Write,
    document: Option<Map<String, Value>>,
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
        let document = json!({ "command": command, "version": crate::program().version });
        Self {
            out,
            document: document.as_object().cloned(),
            is_awaited: false,
        }
    }

    /// Adds what was found or done, under a name of its own.
    ///
    /// # Errors
    /// A map of which the keys are no strings.
    pub fn fact(&mut self, name: &str, value: impl Serialize) -> Result<()> {
        if let Some(document) = &mut self.document {
            document.insert(name.to_owned(), serde_json::to_value(value)?);
        }
        Ok(())
    }

    /// Adds a fact that is written as JSON already.
    ///
    /// # Errors
    /// Text that is no JSON.
    pub fn written_fact(&mut self, name: &str, json: &[u8]) -> Result<()> {
        if let Some(document) = &mut self.document {
            document.insert(name.to_owned(), serde_json::from_slice(json)?);
        }
        Ok(())
    }

    /// Adds to a list, or says it.
    fn item(&mut self, list: &str, item: &str, words: &str) -> std::io::Result<()> {
        match &mut self.document {
            None => writeln!(self.out, "{words}{item}"),
            Some(document) => {
                let list = document.entry(list).or_insert_with(|| json!([]));
                list.as_array_mut()
                    .into_iter()
                    .for_each(|l| l.push(item.into()));
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

    /// Tells at once of one of many that is done; of a document on stderr.
    ///
    /// # Errors
    /// When it cannot be written.
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
        self.item("notes", &note.to_string(), "")
    }

    /// Tells of a result in a file or folder; who reads the standard output sees that.
    ///
    /// # Errors
    /// As there.
    pub fn written(&mut self, path: &Path) -> std::io::Result<()> {
        match path == Path::new(STANDARD) {
            true => Ok(()),
            false => self.item("written", &path.display().to_string(), "written: "),
        }
    }

    /// Tells of a page to look at.
    ///
    /// # Errors
    /// As there.
    pub fn open(&mut self, page: impl Display) -> std::io::Result<()> {
        self.item("open", &page.to_string(), "open in a browser: ")
    }

    /// Tells of a criterion that does not hold; the words go to stderr.
    pub fn fails(&mut self, failure: &str) {
        match self.document {
            None => eprintln!("fails: {failure}"),
            // A list in memory takes every item.
            Some(_) => drop(self.item("failures", failure, "")),
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
                document.insert("status".to_owned(), name.into());
                document.insert("exit_code".to_owned(), code.into());
                if let Err(error) = ended {
                    let message = format!("{error:#}");
                    let error = json!({
                        "kind": name,
                        "message": message,
                        "mistakes": mistakes::of(error),
                        "exit_code": code,
                    });
                    document.insert("error".to_owned(), error);
                }
                writeln!(self.out, "{:#}", Value::Object(document)).and_then(|()| self.out.flush())
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
