//! The folder that is served: no name leads out of it.

use std::path::{Component, Path, PathBuf};

use anyhow::{Context, Result};
use scenes::SceneFile;

use super::{Refusal, refuse};
use crate::provenance::canonical;

/// The folder.
pub(super) struct Folder {
    /// Absolute, without links.
    root: PathBuf,
    /// As the user wrote it.
    shown: PathBuf,
}

impl Folder {
    /// # Errors
    /// One that is not there.
    pub(super) fn new(path: &Path) -> Result<Self> {
        let root = canonical(path);
        let root = root.with_context(|| format!("{}: cannot be served", path.display()))?;
        anyhow::ensure!(root.is_dir(), "{}: no folder", path.display());
        Ok(Self {
            root,
            shown: path.to_owned(),
        })
    }

    /// Where it is, without links.
    pub(super) fn root(&self) -> &Path {
        &self.root
    }

    /// Where it is, as the user wrote it.
    pub(super) fn shown(&self) -> &Path {
        &self.shown
    }

    /// The absolute path of a file in it.
    pub(super) fn file(&self, name: &str) -> Result<PathBuf, Refusal> {
        let plain = |part: Component<'_>| matches!(part, Component::Normal(_));
        if name.is_empty() || !Path::new(name).components().all(plain) {
            return refuse(
                403,
                format!("{name:?} leads out of the folder that is served"),
            );
        }
        self.inside(&self.root.join(name))
    }

    /// A path that a file in the folder names, refused where it, or a link in it, leads out.
    fn inside(&self, path: &Path) -> Result<PathBuf, Refusal> {
        let name = path.strip_prefix(&self.root).unwrap_or(path).display();
        match canonical(path) {
            Ok(there) if there.starts_with(&self.root) => Ok(there),
            Ok(_) => refuse(
                403,
                format!("{name} leads out of the folder that is served"),
            ),
            Err(cause) => refuse(404, format!("{name}: {cause}")),
        }
    }

    /// Refuses a scene that names a file outside.
    pub(super) fn holds(&self, scene: &SceneFile) -> Result<(), Refusal> {
        let robot = &scene.robot;
        let urdf = Some(&robot.urdf).filter(|urdf| !urdf.starts_with("builtin:"));
        let environment = [&scene.surfaces_file, &scene.mesh_file];
        let scans = scene.scan.iter();
        let scans = scans.flat_map(|s| [&s.depth, &s.cloud, &s.calibration, &s.extrinsics]);
        let files = [&robot.srdf, &robot.contacts]
            .into_iter()
            .chain(environment)
            .chain(scans);
        let mut named = files.flatten().chain(urdf);
        named.try_for_each(|name| self.inside(&self.root.join(name)).map(drop))
    }

    /// Names of all files in it and in the folders of results in it, in order.
    pub(super) fn files(&self) -> Vec<String> {
        let mut found = Vec::new();
        self.walk(&self.root, 2, &mut found);
        found.sort();
        found
    }

    fn walk(&self, folder: &Path, deeper: usize, found: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let (path, kind) = (entry.path(), entry.file_type());
            if entry.file_name().as_encoded_bytes().starts_with(b".") {
                continue;
            }
            match kind {
                Ok(kind) if kind.is_dir() && deeper > 0 => self.walk(&path, deeper - 1, found),
                Ok(kind) if kind.is_file() => {
                    let name = path.strip_prefix(&self.root).ok().and_then(Path::to_str);
                    found.extend(name.map(str::to_owned));
                }
                _ => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_leads_out() {
        let outside = tempfile::tempdir().unwrap();
        let root = outside.path().join("served");
        std::fs::create_dir_all(root.join("deep")).unwrap();
        std::fs::write(outside.path().join("secret.json"), "{}").unwrap();
        std::fs::write(root.join("deep/mine.json"), "{}").unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink(outside.path(), root.join("link")).unwrap();
        let folder = Folder::new(&root).unwrap();
        assert!(folder.file("deep/mine.json").is_ok());
        for (name, code) in [
            ("../secret.json", 403),
            ("deep/../../secret.json", 403),
            ("/etc/passwd", 403),
            ("", 403),
            ("link/secret.json", 403),
            ("absent.json", 404),
        ] {
            assert_eq!(folder.file(name).unwrap_err().0, code, "{name}");
        }
        assert_eq!(folder.files(), ["deep/mine.json"]);
        let text = |urdf: &str| {
            format!(
                "name = \"x\"\nsurfaces_file = \"deep/mine.json\"\nrobot.urdf = \"{urdf}\"\ngoal.base_position_m = [1.0, 0.0]\n"
            )
        };
        let holds = |urdf: &str| folder.holds(&SceneFile::parse(&text(urdf)).unwrap());
        assert!(holds("builtin:hrp2").is_ok() && holds("deep/mine.json").is_ok());
        assert_eq!(holds("../secret.json").unwrap_err().0, 403);
        assert_eq!(holds("/etc/passwd").unwrap_err().0, 403);
    }
}
