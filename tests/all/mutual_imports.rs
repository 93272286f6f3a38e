//! No two source files import each other, but a module and its child: a reader follows imports one way.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};

type Module = Vec<String>;

/// Every module of the crate whose sources are in `folder`, with its file.
fn modules(folder: &Path, module: &Module, found: &mut BTreeMap<Module, PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a source folder") {
        let path = entry.expect("an entry").path();
        let stem = path.file_stem().expect("a name").to_string_lossy();
        let child = || [&module[..], &[stem.to_string()]].concat();
        if path.is_dir() {
            modules(&path, &child(), found);
        } else if path.extension().is_some_and(|e| e == "rs") && stem != "tests" {
            let here = matches!(&*stem, "mod" | "lib" | "main");
            found.insert(if here { module.clone() } else { child() }, path);
        }
    }
}

/// The paths that a file names, as written; those of its tests left out.
#[derive(Default)]
struct Paths(Vec<Module>);

impl Paths {
    fn add_tree(&mut self, before: &Module, tree: &syn::UseTree) {
        let with = |name: &syn::Ident| [&before[..], &[name.to_string()]].concat();
        match tree {
            syn::UseTree::Path(path) => self.add_tree(&with(&path.ident), &path.tree),
            syn::UseTree::Name(name) => self.0.push(with(&name.ident)),
            syn::UseTree::Rename(name) => self.0.push(with(&name.ident)),
            syn::UseTree::Glob(_) => self.0.push(before.clone()),
            syn::UseTree::Group(group) => {
                group.items.iter().for_each(|t| self.add_tree(before, t));
            }
        }
    }
}

impl<'ast> Visit<'ast> for Paths {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if !module.attrs.iter().any(|a| a.path().is_ident("cfg")) {
            visit::visit_item_mod(self, module);
        }
    }

    fn visit_use_tree(&mut self, tree: &'ast syn::UseTree) {
        self.add_tree(&Vec::new(), tree);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names = path.segments.iter().map(|s| s.ident.to_string());
        self.0.push(names.collect());
        visit::visit_path(self, path);
    }
}

/// The module that a path of `module` leads into, where it stays in the crate.
fn target(module: &Module, path: &Module, all: &BTreeMap<Module, PathBuf>) -> Option<Module> {
    let mut rest = &path[..];
    let mut at = match rest.first()?.as_str() {
        "crate" => Vec::new(),
        "self" | "super" => module.clone(),
        _ => return None,
    };
    while let Some(first @ ("crate" | "self" | "super")) = rest.first().map(String::as_str) {
        if first == "super" {
            at.pop();
        }
        rest = &rest[1..];
    }
    for name in rest {
        let deeper = [&at[..], std::slice::from_ref(name)].concat();
        if !all.contains_key(&deeper) {
            break;
        }
        at = deeper;
    }
    Some(at)
}

/// Pairs of files of a crate that import each other, beside modules and their children.
fn mutual(sources: &Path) -> Vec<String> {
    let mut all = BTreeMap::new();
    modules(sources, &Vec::new(), &mut all);
    let mut imports: BTreeSet<(&Module, Module)> = BTreeSet::new();
    for (module, file) in &all {
        let text = std::fs::read_to_string(file).expect("a source file");
        let mut paths = Paths::default();
        paths.visit_file(&syn::parse_file(&text).expect("Rust"));
        let targets = paths.0.iter().filter_map(|p| target(module, p, &all));
        imports.extend(targets.map(|to| (module, to)));
    }
    let family = |a: &Module, b: &Module| a.starts_with(b) || b.starts_with(a);
    imports
        .iter()
        .filter(|(from, to)| *from < to && !family(from, to))
        .filter(|(from, to)| imports.contains(&(to, (*from).clone())))
        .map(|(from, to)| format!("{} and {}", all[*from].display(), all[to].display()))
        .collect()
}

#[test]
fn no_two_files_import_each_other_but_parent_and_child() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = mutual(&root.join("src"));
    for entry in std::fs::read_dir(root).expect("the workspace") {
        let folder = entry.expect("an entry").path();
        if folder.join("Cargo.toml").is_file() && folder.join("src").is_dir() {
            found.extend(mutual(&folder.join("src")));
        }
    }
    assert_eq!(found, Vec::<String>::new());
}
