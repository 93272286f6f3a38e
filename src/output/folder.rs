//! A folder of results, which takes the place of an older one in one step.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{ErrorKind, Result as IoResult, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use tempfile::TempDir;

use super::{abandoned, irregular, parent, sync, unfinished};
use crate::provenance;

/// A folder of results in the making: it stands beside its place until it is whole.
///
/// What else the older folder holds is kept: files are in both before they change places, so that a
/// run that is killed at any instant leaves them where they are; folders and what cannot be linked
/// come after. What killed runs left is taken up by the next one.
#[derive(Debug)]
pub struct Folder {
    /// Where it goes, absolute.
    place: PathBuf,
    /// The same as the user wrote it.
    shown: PathBuf,
    /// Names of files that are results: an older one's are not kept.
    ours: Vec<&'static str>,
    fresh: TempDir,
    /// Tells other runs that `fresh` is no leftover.
    _lock: Option<File>,
}

impl Folder {
    /// An empty one that is to go to `path`; `ours` are the names that its results may have.
    ///
    /// # Errors
    /// What cannot be replaced whole: no folder, the one that the program runs in, a file system's
    /// root, one with an input under a result's name; what the operating system says.
    pub fn new(path: &Path, ours: impl Into<Vec<&'static str>>) -> Result<Self> {
        let ours = ours.into();
        let shown = path.display();
        let place =
            place(path).with_context(|| format!("{shown}: cannot be a folder of results"))?;
        check(&place, &ours).with_context(|| shown.to_string())?;
        let made = || -> IoResult<TempDir> {
            take_up(&place, &ours)?;
            let mut builder = tempfile::Builder::new();
            let prefix = unfinished(&place);
            builder.prefix(&prefix);
            #[cfg(unix)]
            builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
            builder.tempdir_in(parent(&place))
        };
        let fresh = made().with_context(|| format!("{shown}: cannot be written"))?;
        let lock = File::open(fresh.path()).ok();
        let _ = lock.as_ref().map(File::lock);
        Ok(Self {
            place,
            shown: path.to_owned(),
            ours,
            fresh,
            _lock: lock,
        })
    }

    /// Adds a result.
    ///
    /// # Errors
    /// What the operating system says, with the path.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        debug_assert!(self.ours.contains(&name), "{name} is no result's name");
        let write = || -> IoResult<()> {
            let mut file = File::create(self.fresh.path().join(name))?;
            file.write_all(bytes)?;
            file.sync_all()
        };
        write().with_context(|| format!("{}: cannot be written", self.shown.join(name).display()))
    }

    /// Puts it in its place.
    ///
    /// # Errors
    /// As [`Self::new`]; the older folder is then as it was.
    pub fn publish(self) -> Result<()> {
        check(&self.place, &self.ours).with_context(|| self.shown.display().to_string())?;
        let shown = self.shown.clone();
        let done = self.replace();
        done.with_context(|| format!("{}: cannot be replaced", shown.display()))
    }

    fn replace(self) -> IoResult<()> {
        let (place, fresh) = (&self.place, self.fresh.path());
        let replaces = place.is_dir();
        if replaces {
            #[cfg(not(target_os = "wasi"))]
            std::fs::set_permissions(fresh, place.metadata()?.permissions())?;
            for name in others(place, &self.ours)? {
                // What has no second name here is moved afterwards.
                let _ = std::fs::hard_link(place.join(&name), fresh.join(&name));
            }
        }
        sync(fresh)?;
        match replaces {
            true => exchange(fresh, place)?,
            false => std::fs::rename(fresh, place)?,
        }
        sync(parent(place))?;
        // From here on `fresh` is the older folder.
        if replaces && let Err(error) = move_others(fresh, place, &self.ours) {
            let kept = self.fresh.keep();
            let what = format!("{}: some of it could not be moved: {error}", kept.display());
            return Err(std::io::Error::new(error.kind(), what));
        }
        Ok(())
    }
}

/// The folder itself, whatever links lead to it.
fn place(path: &Path) -> Result<PathBuf> {
    let place = match path.symlink_metadata() {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let name = path.file_name().context("it has no name")?;
            std::fs::create_dir_all(parent(path))?;
            provenance::canonical(parent(path))?.join(name)
        }
        found => {
            found?;
            provenance::canonical(path)?
        }
    };
    match place.exists() && !place.is_dir() {
        true => bail!("a file is there"),
        false => Ok(place),
    }
}

/// Refuses what cannot be replaced whole.
fn check(place: &Path, ours: &[&str]) -> Result<()> {
    if !place.exists() {
        return Ok(());
    }
    let here = std::env::current_dir().and_then(|here| provenance::canonical(&here));
    if here.is_ok_and(|here| here.starts_with(place)) || mounted(place)? {
        bail!(
            "results replace their folder in one step, which the working folder and the root of a \
             file system cannot be: name a folder in it"
        );
    }
    for name in ours {
        let path = place.join(name);
        let Ok(there) = path.symlink_metadata() else {
            continue;
        };
        if let Some(kind) = irregular(there.file_type()) {
            bail!("{kind} has a result's name, {name}");
        }
        if provenance::was_read(&path) {
            bail!("{name} in it is an input, which results do not replace: name another folder");
        }
    }
    Ok(())
}

/// Whether another file system begins at `place`.
fn mounted(place: &Path) -> IoResult<bool> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        Ok(place.metadata()?.dev() != parent(place).metadata()?.dev())
    }
    #[cfg(not(unix))]
    Ok(place.parent().is_none())
}

/// What a folder holds beside results.
fn others(folder: &Path, ours: &[&str]) -> IoResult<Vec<std::ffi::OsString>> {
    let names = std::fs::read_dir(folder)?.map(|entry| Ok(entry?.file_name()));
    let names: IoResult<Vec<_>> = names.collect();
    let is_ours = |name: &OsStr| ours.iter().any(|ours| name == *ours) || is_unfinished(name);
    Ok(names?.into_iter().filter(|name| !is_ours(name)).collect())
}

/// Whether a name is that of a file in the making.
fn is_unfinished(name: &OsStr) -> bool {
    let name = name.to_string_lossy();
    name.starts_with('.') && name.contains(".scandent-")
}

/// Moves what `from` holds beside results to where it was, unless it is there.
fn move_others(from: &Path, place: &Path, ours: &[&str]) -> IoResult<()> {
    for name in others(from, ours)? {
        let to = place.join(&name);
        if to.symlink_metadata().is_err() {
            std::fs::rename(from.join(name), to)?;
        }
    }
    Ok(())
}

/// Takes up what killed runs left: what is not ours goes back to its place, the rest goes.
fn take_up(place: &Path, ours: &[&str]) -> IoResult<()> {
    let aside = aside(place);
    if aside.exists() && !place.exists() {
        std::fs::rename(&aside, place)?;
    }
    for left in abandoned(place)? {
        if place.exists() {
            move_others(&left, place, ours)?;
        }
        std::fs::remove_dir_all(left)?;
    }
    Ok(())
}

/// Where a folder is for an instant that a file system cannot exchange.
fn aside(place: &Path) -> PathBuf {
    let mut name = unfinished(place);
    name.push("old");
    place.with_file_name(name)
}

/// Two folders change places: in one step where the system can, else with the older one aside for
/// an instant, from where the next run takes it back.
fn exchange(fresh: &Path, place: &Path) -> IoResult<()> {
    #[cfg(any(target_os = "linux", target_os = "macos"))]
    {
        use rustix::fs::{CWD, RenameFlags, renameat_with};
        use rustix::io::Errno;
        match renameat_with(CWD, fresh, CWD, place, RenameFlags::EXCHANGE) {
            Err(Errno::INVAL | Errno::NOSYS | Errno::NOTSUP) => {}
            done => return Ok(done?),
        }
    }
    let aside = aside(place);
    std::fs::rename(place, &aside)?;
    if let Err(error) = std::fs::rename(fresh, place) {
        std::fs::rename(&aside, place)?;
        return Err(error);
    }
    std::fs::rename(aside, fresh)
}

#[cfg(test)]
mod tests {
    use super::*;

    const OURS: &[&str] = &["plan.json", "report.json"];

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let names = entries.map(|e| e.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    fn write(place: &Path, results: &[&str]) -> Result<()> {
        let folder = Folder::new(place, OURS)?;
        for name in results {
            folder.write(name, name.as_bytes())?;
        }
        folder.publish()
    }

    #[test]
    fn results_are_replaced_together_and_the_rest_stays() {
        let parent = tempfile::tempdir().unwrap();
        let place = parent.path().join("deep/results");
        write(&place, OURS).unwrap();
        std::fs::create_dir(place.join("pictures")).unwrap();
        std::fs::write(place.join("pictures/1.png"), "mine").unwrap();
        std::fs::write(place.join("notes.txt"), "mine").unwrap();
        write(&place, &["report.json"]).unwrap();
        assert_eq!(names(&place), ["notes.txt", "pictures", "report.json"]);
        assert_eq!(names(&place.join("pictures")), ["1.png"]);
        assert_eq!(names(place.parent().unwrap()), ["results"]);
    }

    #[test]
    fn results_that_are_not_published_leave_no_trace() {
        let parent = tempfile::tempdir().unwrap();
        let place = parent.path().join("results");
        write(&place, OURS).unwrap();
        let folder = Folder::new(&place, OURS).unwrap();
        folder.write("plan.json", b"new").unwrap();
        drop(folder);
        assert_eq!(
            std::fs::read(place.join("plan.json")).unwrap(),
            b"plan.json"
        );
        assert_eq!(names(parent.path()), ["results"]);
    }

    #[test]
    fn what_killed_runs_left_is_taken_up() {
        let parent = tempfile::tempdir().unwrap();
        let place = parent.path().join("results");
        write(&place, OURS).unwrap();
        // Killed after the folders changed places, and before what else there was came along.
        let left = parent.path().join(".results.scandent-dead");
        std::fs::create_dir_all(left.join("pictures")).unwrap();
        std::fs::write(left.join("plan.json"), "old").unwrap();
        write(&place, OURS).unwrap();
        assert_eq!(names(&place), ["pictures", "plan.json", "report.json"]);
        assert_eq!(names(parent.path()), ["results"]);
        // Killed while the older one was aside.
        std::fs::rename(&place, aside(&place)).unwrap();
        drop(Folder::new(&place, OURS).unwrap());
        assert_eq!(names(parent.path()), ["results"]);
        // One that another run is at work on stays.
        let other = Folder::new(&place, OURS).unwrap();
        write(&place, OURS).unwrap();
        other.write("plan.json", b"other").unwrap();
        other.publish().unwrap();
        assert_eq!(names(&place), ["pictures", "plan.json"]);
    }

    #[test]
    fn what_cannot_be_replaced_is_refused() {
        let parent = tempfile::tempdir().unwrap();
        let place = parent.path().join("results");
        write(&place, OURS).unwrap();
        provenance::read("surfaces", &place.join("plan.json")).unwrap();
        let here = std::env::current_dir().unwrap();
        std::fs::create_dir_all(parent.path().join("other/plan.json")).unwrap();
        for (path, why) in [
            (place.as_path(), "an input"),
            (&place.join("report.json"), "a file is there"),
            (&parent.path().join("other"), "a folder has a result's name"),
            (&here, "working folder"),
            (Path::new("/"), "working folder"),
        ] {
            let error = format!("{:#}", Folder::new(path, OURS).unwrap_err());
            assert!(error.contains(why), "{error}");
        }
    }
}
