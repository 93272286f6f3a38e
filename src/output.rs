//! Writing results: a file, or a folder of them, is either the old one or the whole new one.

mod folder;

use std::ffi::OsString;
use std::fs::{File, FileType};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result, bail};
use serde::Serialize;

use crate::provenance::{self, STANDARD};

pub use folder::Folder;

/// Writes `bytes` to `path` in one step, creating the folders on the way; to the standard output for `-`.
///
/// The bytes go to a temporary file beside `path`, which then takes its name: a reader, a full
/// disk or an interruption never meets half a result.
///
/// # Errors
/// As [`check`]; what the operating system says, with the path.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    check(path)?;
    if path == Path::new(STANDARD) {
        return to_standard(bytes).context("the standard output: cannot be written");
    }
    write_beside(path, bytes).with_context(|| format!("{}: cannot be written", path.display()))
}

/// Refuses what cannot become a result, before anything is computed for it.
///
/// # Errors
/// A folder, a link, a device, or a file that was read as an input.
pub fn check(path: &Path) -> Result<()> {
    let name = path.display();
    if path == Path::new(STANDARD) {
        return Ok(());
    }
    let there = match path.symlink_metadata() {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        found => found.with_context(|| format!("{name}: cannot be written"))?,
    };
    if let Some(kind) = irregular(there.file_type()) {
        bail!("{name}: {kind} is there, and results go to a regular file");
    }
    if provenance::was_read(path) {
        bail!("{name}: this file is an input, which results do not replace");
    }
    Ok(())
}

/// Writes the one result of the standard output; a reader who has seen enough is no error.
fn to_standard(bytes: &[u8]) -> std::io::Result<()> {
    static TAKEN: AtomicBool = AtomicBool::new(false);
    if TAKEN.swap(true, Ordering::Relaxed) {
        return Err(std::io::Error::other("another result went there"));
    }
    let mut out = std::io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written,
    }
}

/// What something is that is not a regular file.
fn irregular(kind: FileType) -> Option<&'static str> {
    match kind {
        kind if kind.is_symlink() => Some("a link"),
        kind if kind.is_dir() => Some("a folder"),
        kind if !kind.is_file() => Some("a device or pipe"),
        _ => None,
    }
}

fn write_beside(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let folder = parent(path);
    std::fs::create_dir_all(folder)?;
    for left in abandoned(path)? {
        std::fs::remove_file(left)?;
    }
    let mut builder = tempfile::Builder::new();
    let prefix = unfinished(path);
    builder.prefix(&prefix);
    // The umask takes its part away, as it does from any new file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder)?;
    let _ = file.as_file().lock();
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|e| e.error)?;
    sync(folder)
}

/// The folder that something is in.
fn parent(path: &Path) -> &Path {
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty());
    parent.unwrap_or(Path::new("."))
}

/// What the names of files and folders begin with that are to become `path`.
fn unfinished(path: &Path) -> OsString {
    let mut prefix = OsString::from(".");
    prefix.push(path.file_name().unwrap_or_default());
    prefix.push(".scandent-");
    prefix
}

/// What runs that were killed left of `path`: those at work hold a lock on theirs.
fn abandoned(path: &Path) -> std::io::Result<Vec<PathBuf>> {
    let prefix = unfinished(path);
    let mut left = Vec::new();
    for entry in std::fs::read_dir(parent(path))? {
        let entry = entry?;
        let name = entry.file_name();
        if name
            .as_encoded_bytes()
            .starts_with(prefix.as_encoded_bytes())
            && File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok())
        {
            left.push(entry.path());
        }
    }
    left.sort();
    Ok(left)
}

/// Has the names in a folder written to the disk.
fn sync(folder: &Path) -> std::io::Result<()> {
    match cfg!(unix) {
        true => File::open(folder)?.sync_all(),
        false => Ok(()),
    }
}

/// Writes `value` to `path` as JSON with a line break at the end.
///
/// # Errors
/// As [`write()`].
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    write(path, &json(value)?)
}

/// `value` as indented JSON with a line break at the end.
///
/// # Errors
/// When a map of it has keys that are no strings.
pub fn json(value: &impl Serialize) -> Result<Vec<u8>> {
    let mut bytes = serde_json::to_vec_pretty(value)?;
    bytes.push(b'\n');
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_no_part_stays_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/er/x.json");
        write(&path, b"a longer first version").unwrap();
        // What a killed run left goes.
        std::fs::write(path.with_file_name(".x.json.scandent-dead"), b"").unwrap();
        write(&path, b"second").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
        let left: Vec<_> = std::fs::read_dir(path.parent().unwrap()).unwrap().collect();
        assert_eq!(left.len(), 1, "temporary files were left behind");
    }

    #[test]
    fn an_error_names_the_file() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("taken"), b"").unwrap();
        let error = write(&folder.path().join("taken/x.json"), b"").unwrap_err();
        assert!(format!("{error:#}").contains("x.json"), "{error:#}");
    }

    #[cfg(unix)]
    #[test]
    fn only_regular_files_that_were_not_read_are_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let [file, link, hard] = ["file", "link", "hard"].map(|name| folder.path().join(name));
        std::fs::write(&file, b"input").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        std::fs::hard_link(&file, &hard).unwrap();
        write(&file, b"input").unwrap();
        std::fs::remove_file(&hard).unwrap();
        std::fs::hard_link(&file, &hard).unwrap();
        provenance::read("scan", &file).unwrap();
        for (path, why) in [
            (file.as_path(), "an input"),
            (&hard, "an input"),
            (&link, "a link"),
            (folder.path(), "a folder"),
            (Path::new("/dev/full"), "a device"),
        ] {
            let error = write(path, b"result").unwrap_err().to_string();
            assert!(error.contains(why), "{error}");
        }
        assert_eq!(std::fs::read(&file).unwrap(), b"input");
    }
}
