//! Whether links and joints make one tree, and which.

use std::collections::{BTreeMap, BTreeSet};

use super::urdf::{Joint, Urdf};
use crate::Error;

/// The links as a tree.
pub(super) struct Tree {
    /// Index of the root link.
    pub root: usize,
    /// The joints that each link is the parent of, in the file's order: (joint, child link).
    pub children: Vec<Vec<(usize, usize)>>,
}

/// The tree of a URDF's links.
///
/// # Errors
/// [`Error::Tree`] naming the link or joint: a name given twice, a link with two parents, a loop,
/// none or several roots. [`Error::Unknown`] when a joint names a link that is not there.
pub(super) fn of(file: &str, urdf: &Urdf) -> Result<Tree, Error> {
    let refuse = |cause: String| {
        Err(Error::Tree {
            file: file.to_owned(),
            cause,
        })
    };
    let mut index = BTreeMap::new();
    for (i, link) in urdf.links.iter().enumerate() {
        if index.insert(link.name.as_str(), i).is_some() {
            return refuse(format!("two links are named \"{}\"", link.name));
        }
    }
    let mut names = BTreeSet::new();
    for joint in &urdf.joints {
        if !names.insert(joint.name.as_str()) {
            return refuse(format!(
                "line {}: two joints are named \"{}\"",
                joint.line, joint.name
            ));
        }
    }
    let find = |joint: &Joint, end: &str, link: &str| {
        index.get(link).copied().ok_or_else(|| {
            let place = format!(
                "{file}: line {}: {end} of joint \"{}\"",
                joint.line, joint.name
            );
            Error::unknown(Some(&place), "link", link, index.keys().copied())
        })
    };
    // At most one joint moves a link.
    let mut mover: Vec<Option<usize>> = vec![None; urdf.links.len()];
    let mut children = vec![Vec::new(); urdf.links.len()];
    for (j, joint) in urdf.joints.iter().enumerate() {
        let parent = find(joint, "parent", &joint.parent)?;
        let child = find(joint, "child", &joint.child)?;
        if let Some(other) = mover[child].replace(j) {
            let (link, line) = (&joint.child, joint.line);
            let (first, second) = (&urdf.joints[other].name, &joint.name);
            return refuse(format!(
                "line {line}: link \"{link}\" is the child of two joints, \"{first}\" and \
                 \"{second}\": a closed chain is no tree"
            ));
        }
        children[parent].push((j, child));
    }
    // One root, from which every link is reached.
    let roots: Vec<usize> = (0..urdf.links.len())
        .filter(|&i| mover[i].is_none())
        .collect();
    let root = match roots.as_slice() {
        [root] => *root,
        [] => {
            let cycle = cycle_of(urdf, &index, &mover, 0);
            return refuse(format!(
                "there is no root link: the links {cycle} form a loop"
            ));
        }
        several => {
            let names: Vec<_> = several
                .iter()
                .map(|&i| format!("\"{}\"", urdf.links[i].name))
                .collect();
            let (count, list) = (
                names.len(),
                names.iter().take(8).cloned().collect::<Vec<_>>(),
            );
            let list = list.join(", ");
            return refuse(format!("there are {count} root links and not one: {list}"));
        }
    };
    let mut reached = vec![false; urdf.links.len()];
    let mut open = vec![root];
    while let Some(link) = open.pop() {
        reached[link] = true;
        open.extend(children[link].iter().map(|&(_, child)| child));
    }
    match reached.iter().position(|r| !r) {
        None => Ok(Tree { root, children }),
        Some(lost) => {
            let cycle = cycle_of(urdf, &index, &mover, lost);
            refuse(format!("the links {cycle} form a loop"))
        }
    }
}

/// The links met on the way up from `start` once it repeats itself.
fn cycle_of(
    urdf: &Urdf,
    index: &BTreeMap<&str, usize>,
    mover: &[Option<usize>],
    start: usize,
) -> String {
    let mut path: Vec<usize> = Vec::new();
    let mut seen = vec![false; mover.len()];
    let mut at = start;
    while !seen[at] {
        seen[at] = true;
        path.push(at);
        let parent = mover[at].and_then(|j| index.get(urdf.joints[j].parent.as_str()));
        let Some(&parent) = parent else { break };
        at = parent;
    }
    let first = path.iter().position(|&link| link == at).unwrap_or(0);
    let names: Vec<_> = path[first..]
        .iter()
        .take(8)
        .map(|&i| &urdf.links[i].name)
        .collect();
    format!("{names:?}")
}
