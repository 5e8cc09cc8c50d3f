//! Which file of some crates uses which other file, read from the code.
//!
//! A path is followed through re-exports to the file that defines its item. A `mod.rs` that re-exports names of its
//! children does not count as their user. Test modules are left out.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use syn::visit::{self, Visit};
use syn::{Item, UseTree, Visibility};

/// Names of enclosing modules, from the crate's root.
pub(crate) type ModulePath = Vec<String>;

/// The text of a file.
#[derive(Clone)]
pub(crate) struct Source {
    pub(crate) module: ModulePath,
    pub(crate) file: PathBuf,
    pub(crate) text: String,
}

/// A file of a crate: its definitions, imports and names.
#[derive(Default)]
struct Scope {
    file: PathBuf,
    defined: BTreeSet<String>,
    /// Path of each imported name.
    imported: BTreeMap<String, ModulePath>,
    /// Modules of which all names are imported.
    globs: Vec<ModulePath>,
    /// Paths that the code names.
    used: Vec<ModulePath>,
}

/// Crates of the library with the module path of their roots. A crate of one module has the name of that module.
pub(crate) const LIBRARY: [(&str, &[&str]); 9] = [
    ("sprung-base", &[]),
    ("sprung-robot", &["description"]),
    ("sprung-model", &["model"]),
    ("sprung-log", &["log"]),
    ("sprung-method", &[]),
    ("sprung-export", &["export"]),
    ("sprung-servo", &["servo"]),
    ("sprung-report", &["report"]),
    ("sprung", &[]),
];

/// Files of a crate or of the library, and which uses which.
pub(crate) struct Files {
    scopes: BTreeMap<ModulePath, Scope>,
    uses: OnceLock<BTreeSet<Use>>,
}

/// One file uses another.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Use {
    pub(crate) from: ModulePath,
    pub(crate) to: ModulePath,
    /// The item that is used.
    pub(crate) name: String,
}

impl Scope {
    /// Adds the names of the root of another crate.
    fn join(&mut self, other: Self) {
        self.defined.extend(other.defined);
        self.imported.extend(other.imported);
        self.globs.extend(other.globs);
        self.used.extend(other.used);
    }
}

impl Files {
    /// Reads all files below the folder of a crate's root.
    pub(crate) fn read(root: &Path) -> Self {
        Self::of(&[], texts(root, &[]))
    }

    /// Returns all crates of the library as if they were one; all tests share them. Its list of public names uses no
    /// module.
    pub(crate) fn library() -> &'static Self {
        static LIBRARY: OnceLock<Files> = OnceLock::new();
        LIBRARY.get_or_init(Self::read_library)
    }

    fn read_library() -> Self {
        let mut all = BTreeMap::new();
        for (name, prefix) in LIBRARY {
            let read = Self::of(
                prefix,
                texts(&crate::crates().join(name).join("src"), prefix),
            );
            for (module, scope) in read.scopes {
                let is_list = name == "sprung" && module.is_empty();
                match all.entry(module) {
                    Entry::Vacant(place) if !is_list => {
                        place.insert(scope);
                    }
                    Entry::Occupied(mut root) if !is_list => root.get_mut().join(scope),
                    _ => {}
                }
            }
        }
        Self::with(all)
    }

    fn with(scopes: BTreeMap<ModulePath, Scope>) -> Self {
        Self {
            scopes,
            uses: OnceLock::new(),
        }
    }

    /// Reads files from memory.
    ///
    /// - `prefix`: module path of the crate's root.
    pub(crate) fn of(prefix: &[&str], texts: impl IntoIterator<Item = Source>) -> Self {
        let mut scopes = BTreeMap::new();
        for Source { module, file, text } in texts {
            // A file named `tests` is a test module like the modules at the end of other files.
            if module.last().is_some_and(|last| last == "tests") {
                continue;
            }
            let parsed =
                syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
            let mut scope = Scope {
                file,
                ..Scope::default()
            };
            let mut reader = Reader {
                prefix: prefix.iter().map(|part| (*part).to_owned()).collect(),
                scope: &mut scope,
                module: module.clone(),
            };
            reader.visit_file(&parsed);
            scopes.insert(module, scope);
        }
        Self::with(scopes)
    }

    /// Returns which file uses which, without repetition.
    pub(crate) fn uses(&self) -> &BTreeSet<Use> {
        self.uses.get_or_init(|| self.find_uses())
    }

    fn find_uses(&self) -> BTreeSet<Use> {
        let mut all = BTreeSet::new();
        for (module, scope) in &self.scopes {
            for path in &scope.used {
                if let Some((to, name)) = self.resolve(path, 0)
                    && to != *module
                {
                    let from = module.clone();
                    all.insert(Use { from, to, name });
                }
            }
        }
        all
    }

    /// Returns the file that defines the end of a path; `None` if that is a module or outside the crate.
    fn resolve(&self, path: &[String], depth: usize) -> Option<(ModulePath, String)> {
        // Re-exports have few steps; the limit ends a loop of globs.
        if depth > 8 {
            return None;
        }
        let inside = (0..=path.len())
            .rev()
            .find(|&end| self.scopes.contains_key(&path[..end]))?;
        let (module, rest) = path.split_at(inside);
        let (name, behind) = rest.split_first()?;
        let scope = &self.scopes[module];
        if scope.defined.contains(name) {
            return Some((module.to_vec(), name.clone()));
        }
        let on = |from: &ModulePath| [from, behind].concat();
        if let Some(from) = scope.imported.get(name) {
            return self.resolve(&on(from), depth + 1);
        }
        (scope.globs.iter()).find_map(|glob| self.resolve(&[&glob[..], rest].concat(), depth + 1))
    }

    /// Returns the uses between children of one module, each a file or a folder with all its files.
    pub(crate) fn uses_between_children(&self, module: &[String]) -> Vec<Between> {
        between_children(self.uses(), module)
    }

    /// Returns the uses that close a circle between children of one module, of each module with folders, and
    /// the name of the module.
    pub(crate) fn circles_of_folders(&self) -> Vec<(String, String)> {
        let uses = self.uses();
        let folder_of = |module: &ModulePath| Some(module[..module.len().checked_sub(2)?].to_vec());
        let modules: BTreeSet<ModulePath> = (self.scopes.keys())
            .filter_map(folder_of)
            .filter(|module| !module.is_empty())
            .collect();
        let child = |name: &String| vec![name.clone()];
        let of_module = |module: &ModulePath| -> Vec<(String, String)> {
            let between = between_children(uses, module);
            let edges: BTreeSet<Use> = (between.iter())
                .map(|use_of| Use {
                    from: child(&use_of.from),
                    to: child(&use_of.to),
                    name: String::new(),
                })
                .collect();
            let reached = Reached::of(&edges);
            (between.iter())
                .filter(|use_of| reached.has(&child(&use_of.to), &child(&use_of.from)))
                .map(|use_of| (module.join("/"), use_of.found.words()))
                .collect()
        };
        modules.iter().flat_map(of_module).collect()
    }

    /// Returns the uses that are part of a circle: the used file uses the using file, directly or by others.
    pub(crate) fn circles(&self) -> Vec<String> {
        let uses = self.uses();
        let file = |module: &ModulePath| self.scopes[module].file.display();
        let reached = Reached::of(uses);
        (uses.iter())
            .filter(|u| reached.has(&u.to, &u.from))
            .map(|u| format!("{} uses {} of {}", file(&u.from), u.name, file(&u.to)))
            .collect()
    }
}

impl Use {
    /// Returns the use for messages.
    pub(crate) fn words(&self) -> String {
        let [from, to] = [&self.from, &self.to].map(|path| path.join("/"));
        format!("{from} uses {} of {to}", self.name)
    }
}

/// A use between two children of a module.
pub(crate) struct Between {
    /// Name of the child that uses the other.
    pub(crate) from: String,
    pub(crate) to: String,
    pub(crate) found: Use,
}

fn between_children(uses: &BTreeSet<Use>, module: &[String]) -> Vec<Between> {
    let inside = |path: &ModulePath| path.strip_prefix(module)?.first().cloned();
    (uses.iter())
        .filter_map(|found| {
            Some(Between {
                from: inside(&found.from)?,
                to: inside(&found.to)?,
                found: found.clone(),
            })
        })
        .filter(|use_of| use_of.from != use_of.to)
        .collect()
}

/// For each file that uses others, all files that it uses, directly or by others.
struct Reached<'u>(BTreeMap<&'u ModulePath, BTreeSet<&'u ModulePath>>);

impl<'u> Reached<'u> {
    fn of(uses: &'u BTreeSet<Use>) -> Self {
        let mut direct: BTreeMap<&ModulePath, BTreeSet<&ModulePath>> = BTreeMap::new();
        for found in uses {
            direct.entry(&found.from).or_default().insert(&found.to);
        }
        let all_of = |from: &'u ModulePath| {
            let mut seen = BTreeSet::new();
            let mut open = vec![from];
            while let Some(at) = open.pop() {
                let next = direct.get(at).into_iter().flatten().copied();
                open.extend(next.filter(|to| seen.insert(*to)));
            }
            seen
        };
        Self(direct.keys().map(|from| (*from, all_of(from))).collect())
    }

    fn has(&self, from: &ModulePath, to: &ModulePath) -> bool {
        self.0.get(from).is_some_and(|reached| reached.contains(to))
    }
}

/// Returns the module path of the root of a crate of the library; `None` if the name is that of no such crate.
fn crate_root(name: &str) -> Option<ModulePath> {
    let is_it = |library: &str| library != "sprung" && library.replace('-', "_") == name;
    let (_, prefix) = LIBRARY.into_iter().find(|(library, _)| is_it(library))?;
    Some(prefix.iter().map(|part| (*part).to_owned()).collect())
}

/// Returns all files below the folder of a crate's root.
fn texts(root: &Path, prefix: &[&str]) -> Vec<Source> {
    let module_of = |path: &Path| {
        let inside = path.strip_prefix(root).unwrap().with_extension("");
        let mut module: ModulePath = (inside.iter())
            .map(|part| part.to_str().unwrap().to_owned())
            .collect();
        if module.last().is_some_and(|last| last == "mod") || is_root(&module) {
            module.pop();
        }
        let prefix = prefix.iter().map(|part| (*part).to_owned());
        prefix.chain(module).collect()
    };
    let all = crate::sources(root).into_iter();
    all.map(|(file, text)| Source {
        module: module_of(&file),
        file,
        text,
    })
    .collect()
}

fn is_root(module: &[String]) -> bool {
    matches!(module, [one] if one == "lib" || one == "main")
}

/// Gathers the definitions, imports and names of a file.
struct Reader<'s> {
    /// Module path of the crate's root.
    prefix: ModulePath,
    scope: &'s mut Scope,
    module: ModulePath,
}

impl Reader<'_> {
    /// Returns a path from the root of the crate; `None` if it leads out of the crate.
    fn absolute(&self, path: &[String]) -> Option<ModulePath> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => Some([&self.prefix, rest].concat()),
            "self" => Some([&self.module, rest].concat()),
            "super" => {
                let ups = path.iter().take_while(|part| *part == "super").count();
                let kept = self.module.len().checked_sub(ups)?;
                Some([&self.module[..kept], &path[ups..]].concat())
            }
            name => {
                if let Some(prefix) = crate_root(name) {
                    return Some([&prefix, rest].concat());
                }
                if let Some(from) = self.scope.imported.get(name) {
                    return Some([from, rest].concat());
                }
                // A child module, or an item of this file.
                Some([&self.module, path].concat())
            }
        }
    }

    fn import(&mut self, tree: &UseTree, before: &[String], hands_on: bool) {
        let with = |name: &syn::Ident| [before, &[name.to_string()]].concat();
        match tree {
            UseTree::Path(path) => self.import(&path.tree, &with(&path.ident), hands_on),
            UseTree::Group(group) => {
                for tree in &group.items {
                    self.import(tree, before, hands_on);
                }
            }
            UseTree::Glob(_) => {
                if let Some(from) = self.absolute(before) {
                    self.scope.globs.push(from);
                }
            }
            UseTree::Name(name) if name.ident == "self" => {
                let local = before.last().cloned().unwrap_or_default();
                self.take(local, before, hands_on);
            }
            UseTree::Name(name) => self.take(name.ident.to_string(), &with(&name.ident), hands_on),
            UseTree::Rename(name) => {
                self.take(name.rename.to_string(), &with(&name.ident), hands_on);
            }
        }
    }

    fn take(&mut self, local: String, path: &[String], hands_on: bool) {
        let Some(from) = self.absolute(path) else {
            return;
        };
        let of_child = from.starts_with(&self.module) && from.len() > self.module.len();
        if !(hands_on && of_child) {
            self.scope.used.push(from.clone());
        }
        self.scope.imported.insert(local, from);
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_file(&mut self, file: &'ast syn::File) {
        // Imports and definitions are read first, because code may name them before they appear.
        for item in &file.items {
            if is_test(attributes(item)) {
                continue;
            }
            if let Item::Use(item) = item {
                let hands_on = !matches!(item.vis, Visibility::Inherited);
                self.import(&item.tree, &[], hands_on);
            } else if let Some(name) = name_of(item) {
                self.scope.defined.insert(name);
            }
        }
        visit::visit_file(self, file);
    }

    fn visit_item(&mut self, item: &'ast Item) {
        if !is_test(attributes(item)) && !matches!(item, Item::Use(_)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let parts: Vec<String> = (path.segments.iter())
            .map(|part| part.ident.to_string())
            .collect();
        if path.leading_colon.is_none()
            && let Some(path) = self.absolute(&parts)
        {
            self.scope.used.push(path);
        }
        visit::visit_path(self, path);
    }
}

fn attributes(item: &Item) -> &[syn::Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

fn is_test(attributes: &[syn::Attribute]) -> bool {
    (attributes.iter()).any(|attribute| {
        let mut tests = false;
        if attribute.path().is_ident("cfg") {
            let _ = attribute.parse_nested_meta(|meta| {
                tests |= meta.path.is_ident("test");
                Ok(())
            });
        }
        tests
    })
}

fn name_of(item: &Item) -> Option<String> {
    let name = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Macro(item) => item.ident.as_ref()?,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(name.to_string())
}

#[test]
fn circles_are_found_through_what_is_handed_on() {
    let file = |module: &str, text: &str| {
        let parts = module.split('/').filter(|part| !part.is_empty());
        Source {
            module: parts.map(str::to_owned).collect(),
            file: PathBuf::from(module),
            text: text.to_owned(),
        }
    };
    let common = [
        file("", "mod a; mod b; pub use a::Alone;"),
        file("a", "mod child; pub use child::Shown; pub struct Alone;"),
        file("b", "use crate::a::Shown; pub fn b(_: Shown) {}"),
    ];
    let child = |text: &str| {
        Files::of(
            &[],
            common.clone().into_iter().chain([file("a/child", text)]),
        )
    };
    let straight = child("pub struct Shown; #[cfg(test)] mod tests { use crate::b::b; }");
    assert!(straight.circles().is_empty(), "{:?}", straight.circles());
    let ring = child("pub struct Shown; fn f() { crate::b::b(Shown) }");
    assert_eq!(
        ring.circles(),
        ["a/child uses b of b", "b uses Shown of a/child"]
    );
    let up = child("use super::Alone; pub struct Shown(Alone);");
    assert!(
        up.circles().is_empty(),
        "a parent may be used that uses nothing"
    );
}

#[test]
fn circles_between_folders_are_found_without_circles_between_files() {
    let file = |module: &str, text: &str| {
        let parts = module.split('/').filter(|part| !part.is_empty());
        Source {
            module: parts.map(str::to_owned).collect(),
            file: PathBuf::from(module),
            text: text.to_owned(),
        }
    };
    let files = |back: &str| {
        Files::of(
            &[],
            [
                file("m", "mod left; mod right;"),
                file("m/left", "mod a; mod b; pub use a::A; pub use b::B;"),
                file("m/left/a", "pub struct A;"),
                file("m/left/b", "use crate::m::right::R; pub struct B(R);"),
                file("m/right", "mod r; pub use r::R;"),
                file("m/right/r", back),
            ],
        )
    };
    assert!(files("pub struct R;").circles_of_folders().is_empty());
    let ring = files("use crate::m::left::A; pub struct R(A);");
    assert!(ring.circles().is_empty());
    let words = [
        "m/left/b uses R of m/right/r",
        "m/right/r uses A of m/left/a",
    ];
    let expected = words.map(|words| ("m".to_owned(), words.to_owned()));
    assert_eq!(ring.circles_of_folders(), expected);
}
