//! What a result was computed from: each input's role, name and SHA-256.

use std::collections::BTreeSet;
use std::fmt::Display;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};

use anyhow::{Context, Result, bail};
use plan::Input;
use sha2::{Digest, Sha256};

/// The name of the standard input and output.
pub const STANDARD: &str = "-";
/// The role of what flags asked for beside a scene.
pub const FLAGS: &str = "flags";

/// Every file that this process has read as an input, so that no result replaces one.
static READ: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// The inputs read so far, in the order in which they were read.
#[derive(Clone, Debug, Default)]
pub struct Inputs {
    list: Vec<Input>,
}

impl Inputs {
    /// Notes an input of which the bytes are at hand.
    pub fn note(&mut self, role: &str, name: &str, bytes: &[u8]) {
        self.push(Input {
            role: role.to_owned(),
            name: name.to_owned(),
            sha256: sha256(bytes),
        });
    }

    /// Notes what was read before.
    pub fn add(&mut self, others: &Self) {
        others
            .list
            .iter()
            .cloned()
            .for_each(|input| self.push(input));
    }

    fn push(&mut self, input: Input) {
        if !self.list.contains(&input) {
            self.list.push(input);
        }
    }

    /// Reads a file and notes it.
    ///
    /// # Errors
    /// What the operating system says, with the role and the path.
    pub fn read(&mut self, role: &str, path: &Path) -> Result<Vec<u8>> {
        let bytes = raw(role, path)?;
        self.note(role, &path.display().to_string(), &bytes);
        tracing::info!("{role} {}: {} bytes", path.display(), bytes.len());
        Ok(unmarked(role, bytes))
    }

    /// As [`Self::read`], of a text.
    ///
    /// # Errors
    /// As there; what is no text.
    pub fn text(&mut self, role: &str, path: &Path) -> Result<String> {
        text(path.display(), self.read(role, path)?)
    }

    /// The inputs.
    pub fn into_list(self) -> Vec<Input> {
        self.list
    }
}

/// The text of a file of that name.
///
/// # Errors
/// What is no text.
pub fn text(name: impl Display, bytes: Vec<u8>) -> Result<String> {
    String::from_utf8(bytes).with_context(|| format!("{name}: not a text file"))
}

/// The bytes of a file, without the byte-order mark that some editors begin a text with.
///
/// # Errors
/// What the operating system says, with the role and the path.
pub fn read(role: &str, path: &Path) -> Result<Vec<u8>> {
    Ok(unmarked(role, raw(role, path)?))
}

fn raw(role: &str, path: &Path) -> Result<Vec<u8>> {
    if role == "mesh" && path == Path::new(STANDARD) {
        bail!("-: which kind of mesh is it? stl:- or obj:-");
    }
    if is_standard(path) {
        let bytes = standard_input();
        return bytes.context(format!("the standard input: cannot read this {role} file"));
    }
    will_read(path);
    std::fs::read(path).with_context(|| format!("{}: cannot read this {role} file", path.display()))
}

/// Whether a path is the standard input: `-`, or with what it is to be read as, such as `-.stl`.
pub fn is_standard(path: &Path) -> bool {
    path.file_stem().is_some_and(|stem| stem == STANDARD) && path.parent() == Some(Path::new(""))
}

/// All of the standard input: the same for whoever asks again.
fn standard_input() -> std::io::Result<Vec<u8>> {
    static BYTES: OnceLock<std::io::Result<Vec<u8>>> = OnceLock::new();
    let read = || {
        let mut bytes = Vec::new();
        std::io::stdin().read_to_end(&mut bytes).map(|_| bytes)
    };
    match BYTES.get_or_init(read) {
        Ok(bytes) => Ok(bytes.clone()),
        Err(error) => Err(error.kind().into()),
    }
}

fn unmarked(role: &str, mut bytes: Vec<u8>) -> Vec<u8> {
    // A mesh may be binary: its reader knows.
    if role != "mesh" && bytes.starts_with("\u{feff}".as_bytes()) {
        bytes.drain(..3);
    }
    bytes
}

/// The absolute path of what is there, whatever links lead to it.
///
/// # Errors
/// What the operating system says.
pub fn canonical(path: &Path) -> std::io::Result<PathBuf> {
    // WASI does not tell; a browser's files have no links.
    if cfg!(target_os = "wasi") {
        path.metadata()?;
        return std::path::absolute(path);
    }
    path.canonicalize()
}

/// Notes that a file is an input before it is read.
pub fn will_read(path: &Path) {
    if let Ok(path) = canonical(path) {
        let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
        read.insert(path);
    }
}

/// Does work that reads results, which its caller may replace afterwards: a library's process goes on.
pub fn reading_results<T>(work: impl FnOnce() -> T) -> T {
    let lock = || READ.lock().unwrap_or_else(PoisonError::into_inner);
    let before = lock().clone();
    let done = work();
    *lock() = before;
    done
}

/// Whether a file that was read is this one, under any name.
pub fn was_read(path: &Path) -> bool {
    let read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    identity(path).is_some_and(|this| {
        read.iter()
            .any(|read| identity(read).as_ref() == Some(&this))
    })
}

#[cfg(unix)]
fn identity(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    let there = path.metadata().ok()?;
    Some((there.dev(), there.ino()))
}

#[cfg(not(unix))]
fn identity(path: &Path) -> Option<PathBuf> {
    canonical(path).ok()
}

/// SHA-256 in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// Two digits a byte.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sha256_agrees_with_the_standards_example() {
        // FIPS 180-2, appendix B.1.
        assert_eq!(
            sha256(b"abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }

    #[test]
    fn an_input_that_is_read_twice_is_listed_once() {
        let mut inputs = Inputs::default();
        inputs.note("scan", "a.png", b"1");
        inputs.note("scan", "a.png", b"1");
        inputs.note("scan", "b.png", b"2");
        let names: Vec<_> = inputs.into_list().into_iter().map(|i| i.name).collect();
        assert_eq!(names, ["a.png", "b.png"]);
    }
}
