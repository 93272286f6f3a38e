//! Where a URDF's mesh file is: `package://`, `model://`, `file://`, relative and absolute names.

use std::path::{Path, PathBuf};

/// The places that a mesh name may stand for, most likely first.
///
/// `package://NAME/REST` is looked for as NAME/REST in each package folder and in each folder
/// above the URDF, then as REST where such a folder is itself the package (or where nothing
/// better was found, a package that goes by another folder name). No ROS is asked.
pub(super) fn places(filename: &str, urdf_dir: &Path, package_dirs: &[PathBuf]) -> Vec<PathBuf> {
    if let Some(path) = filename.strip_prefix("file://") {
        return vec![urdf_dir.join(path)];
    }
    let in_package = ["package:", "model:"]
        .iter()
        .find_map(|s| filename.strip_prefix(s));
    let Some(in_package) = in_package else {
        // Joining an absolute path gives that path.
        let beside = std::iter::once(urdf_dir.join(filename));
        return beside
            .chain(package_dirs.iter().map(|dir| dir.join(filename)))
            .collect();
    };
    let whole = in_package.trim_start_matches('/');
    let rest = whole.split_once('/').map_or(whole, |(_package, rest)| rest);
    let above = || {
        urdf_dir
            .ancestors()
            .filter(|dir| !dir.as_os_str().is_empty())
    };
    let dirs = || package_dirs.iter().map(PathBuf::as_path).chain(above());
    dirs()
        .map(|dir| dir.join(whole))
        .chain(dirs().map(|dir| dir.join(rest)))
        .collect()
}

/// The first of a mesh's places that is there.
///
/// # Errors
/// The list of the places looked at.
pub(super) fn find(
    filename: &str,
    urdf_dir: &Path,
    package_dirs: &[PathBuf],
) -> Result<PathBuf, String> {
    let places = places(filename, urdf_dir, package_dirs);
    if let Some(found) = places.iter().find(|place| place.is_file()) {
        return Ok(found.clone());
    }
    let looked: Vec<String> = places
        .iter()
        .map(|place| place.display().to_string())
        .collect();
    Err(format!(
        "no such mesh file; looked for\n  {}",
        looked.join("\n  ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_are_searched_for_upward() {
        let dir = Path::new("/robots/tall/urdf");
        for name in [
            "package://tall/meshes/a.stl",
            "package:///tall/meshes/a.stl",
        ] {
            let places = places(name, dir, &[PathBuf::from("/ros")]);
            assert_eq!(places[0], Path::new("/ros/tall/meshes/a.stl"));
            assert!(places.contains(&PathBuf::from("/robots/tall/meshes/a.stl")));
        }
        assert_eq!(places("a.stl", dir, &[]), [dir.join("a.stl")]);
        assert_eq!(places("/x/a.stl", dir, &[]), [Path::new("/x/a.stl")]);
        assert_eq!(places("file:///x/a.stl", dir, &[]), [Path::new("/x/a.stl")]);
    }
}
