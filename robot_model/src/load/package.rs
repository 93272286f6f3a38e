//! Where a URDF's mesh file is: `package://`, `model://`, `file://`, relative and absolute names.

use std::path::{Path, PathBuf};

/// Places named where a mesh is in none.
const TOLD_MAX: usize = 8;

/// The places that a mesh name may stand for, most likely first.
///
/// `package://NAME/REST` is looked for as NAME/REST in each package folder and in each folder
/// above the URDF, then as REST where such a folder is itself the package, then as what REST ends with, longest
/// first, where a part of the package was copied alone. No ROS is asked.
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
    let rests = std::iter::successors(Some(whole), |name| Some(name.split_once('/')?.1));
    let above = || {
        urdf_dir
            .ancestors()
            .filter(|dir| !dir.as_os_str().is_empty())
    };
    let dirs = || package_dirs.iter().map(PathBuf::as_path).chain(above());
    rests
        .flat_map(|rest| dirs().map(move |dir| dir.join(rest)))
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
    let told = places.iter().take(TOLD_MAX);
    let told: Vec<String> = told.map(|place| place.display().to_string()).collect();
    let more = match places.len().saturating_sub(TOLD_MAX) {
        0 => String::new(),
        more => format!("\n  and {more} more places"),
    };
    let told = told.join("\n  ");
    Err(format!("no such mesh file; looked for\n  {told}{more}"))
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
        // A folder of a package, copied alone.
        let places_of = |name| places(name, Path::new("/tall/urdf"), &[]);
        let copied = places_of("package://all/robots/tall/meshes/a.stl");
        assert!(copied.contains(&PathBuf::from("/tall/meshes/a.stl")));
        assert_eq!(places("a.stl", dir, &[]), [dir.join("a.stl")]);
        assert_eq!(places("/x/a.stl", dir, &[]), [Path::new("/x/a.stl")]);
        assert_eq!(places("file:///x/a.stl", dir, &[]), [Path::new("/x/a.stl")]);
    }
}
