//! The names that users have: those that `sprung` re-exports, and its sessions.

use std::fs;

use syn::{Item, UseTree, Visibility};

/// Public names, one in a line as `module::name`. A change of this list is a change for users.
const LIST: &str = include_str!("public_names.txt");

/// More names than a reader can look through.
const MAX_PUBLIC_NAMES: usize = 141;

#[test]
fn public_names_are_those_of_the_list() {
    let source = crate::crates().join("sprung/src");
    let mut found = Vec::new();
    let lib = fs::read_to_string(source.join("lib.rs")).unwrap();
    for item in syn::parse_file(&lib).unwrap().items {
        if let Item::Mod(module) = item {
            let name = module.ident.to_string();
            let inside = if let Some((_, items)) = module.content {
                items
            } else {
                let text = fs::read_to_string(source.join(&name).join("mod.rs")).unwrap();
                syn::parse_file(&text).unwrap().items
            };
            for item in inside {
                if let Item::Use(item) = item
                    && matches!(item.vis, Visibility::Public(_))
                {
                    found.extend(
                        names(&item.tree)
                            .iter()
                            .map(|member| format!("{name}::{member}")),
                    );
                }
            }
        }
    }
    found.sort_unstable();
    found.dedup();
    let known: Vec<&str> = LIST.lines().collect();
    assert!(
        known.len() <= MAX_PUBLIC_NAMES,
        "{} public names",
        known.len()
    );
    let lost: Vec<_> = (known.iter())
        .filter(|known_name| !found.iter().any(|name| name == *known_name))
        .collect();
    let new: Vec<_> = (found.iter())
        .filter(|name| !known.contains(&name.as_str()))
        .collect();
    assert!(
        lost.is_empty() && new.is_empty(),
        "no longer public: {lost:?}; newly public: {new:?}"
    );
}

fn names(tree: &UseTree) -> Vec<String> {
    match tree {
        UseTree::Path(path) => names(&path.tree),
        UseTree::Group(group) => group.items.iter().flat_map(names).collect(),
        UseTree::Name(name) => vec![name.ident.to_string()],
        UseTree::Rename(name) => vec![name.rename.to_string()],
        UseTree::Glob(_) => panic!("a glob hides which names are public"),
    }
}
