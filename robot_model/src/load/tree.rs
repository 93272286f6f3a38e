//! Whether links and joints make one tree, and which.

use std::collections::{BTreeMap, BTreeSet};

use super::urdf::Urdf;
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
/// [`Error::File`] naming the link or joint: a name given twice, a link with two parents, a loop,
/// none or several roots. [`Error::Unknown`] when a joint names a link that is not there.
pub(super) fn of(file: &str, urdf: &Urdf) -> Result<Tree, Error> {
    let refuse = |cause: String| Err(Error::file(file, cause));
    let (links, joints) = (&urdf.robot.links, &urdf.robot.joints);
    let mut refused = Vec::new();
    let mut index = BTreeMap::new();
    for (i, link) in links.iter().enumerate() {
        if index.insert(link.name.as_str(), i).is_some() {
            let cause = format!("two links are named \"{}\"", link.name);
            refused.push(Error::file(file, cause));
        }
    }
    let mut names = BTreeSet::new();
    // At most one joint moves a link: its (parent, joint) by the link's index.
    let mut mover: Vec<Option<(usize, usize)>> = vec![None; links.len()];
    let mut children = vec![Vec::new(); links.len()];
    for (j, (joint, line)) in joints.iter().zip(&urdf.joint_lines).enumerate() {
        let name = joint.name.as_str();
        if !names.insert(name) {
            let cause = format!("line {line}: two joints are named \"{name}\"");
            refused.push(Error::file(file, cause));
        }
        let find = |end: &str, link: &str| {
            index.get(link).copied().ok_or_else(|| {
                let place = format!("{file}: line {line}: {end} of joint \"{name}\"");
                Error::unknown(Some(&place), "link", link, index.keys().copied())
            })
        };
        let ends = [("parent", &joint.parent.link), ("child", &joint.child.link)];
        let ends = ends.map(|(end, link)| find(end, link).map_err(|error| refused.push(error)));
        let [Ok(parent), Ok(child)] = ends else {
            continue;
        };
        if let Some((_, other)) = mover[child].replace((parent, j)) {
            let (link, first) = (&joint.child.link, &joints[other].name);
            let cause = format!(
                "line {line}: link \"{link}\" is the child of two joints, \"{first}\" and \
                 \"{name}\": a closed chain is no tree"
            );
            refused.push(Error::file(file, cause));
        }
        children[parent].push((j, child));
    }
    Error::all(refused)?;
    // At most one root, from which every link is reached: what is not reached hangs on a loop.
    let roots: Vec<usize> = (0..links.len()).filter(|&i| mover[i].is_none()).collect();
    if roots.len() > 1 {
        let named = roots.iter().take(8).map(|&i| links[i].name.as_str());
        return refuse(format!(
            "there are {} root links and not one: {:?}",
            roots.len(),
            named.collect::<Vec<_>>()
        ));
    }
    let mut reached = vec![false; links.len()];
    let mut open = roots.clone();
    while let Some(link) = open.pop() {
        reached[link] = true;
        open.extend(children[link].iter().map(|&(_, child)| child));
    }
    match (reached.iter().position(|r| !r), roots.first()) {
        (None, Some(&root)) => Ok(Tree { root, children }),
        (lost, _) => {
            let cycle = loop_above(lost.unwrap_or(0), &mover);
            let names = cycle.iter().take(8).map(|&i| links[i].name.as_str());
            let names: Vec<_> = names.collect();
            refuse(format!("the links {names:?} form a loop"))
        }
    }
}

/// The links of the loop that the way up from `start` ends in.
fn loop_above(start: usize, mover: &[Option<(usize, usize)>]) -> Vec<usize> {
    let mut path: Vec<usize> = Vec::new();
    let mut next = Some(start);
    while let Some(link) = next {
        if let Some(first) = path.iter().position(|&met| met == link) {
            return path.split_off(first);
        }
        path.push(link);
        next = mover[link].map(|(parent, _)| parent);
    }
    path
}
