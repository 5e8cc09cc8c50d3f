//! Shapes of signatures and structs that a reader cannot follow.

use std::path::Path;

use syn::visit::{self, Visit};

use crate::{crates, sources};

/// Elements of a tuple beyond which only names tell what they are.
const MOST_ELEMENTS: usize = 2;

/// Functions with longer tuples, by file and name: Python has no other words for them.
const FOR_PYTHON: [(&str, &str); 1] = [("sprung-python/src/results.rs", "compare")];

/// Functions with a long tuple in their signature.
struct Signatures<'f> {
    file: &'f str,
    text: &'f str,
    /// Names of types of the file that stand for a long tuple.
    aliases: Vec<String>,
    /// Where the search for the next function begins; they are visited in the order of the text.
    at: usize,
    has_long_tuple: bool,
    found: Vec<String>,
}

impl<'f> Signatures<'f> {
    fn read(file: &'f str, text: &'f str) -> Vec<String> {
        let parsed = syn::parse_file(text).unwrap_or_else(|e| panic!("{file}: {e}"));
        let mut aliases = Aliases::default();
        aliases.visit_file(&parsed);
        let mut all = Signatures {
            file,
            text,
            aliases: aliases.0,
            at: 0,
            has_long_tuple: false,
            found: Vec::new(),
        };
        all.visit_file(&parsed);
        all.found
    }

    /// Moves to the next function of this name.
    fn go_to(&mut self, name: &str) {
        let begins = ["(", "<"].map(|bracket| format!("fn {name}{bracket}"));
        let rest = &self.text[self.at..];
        let next = begins.iter().filter_map(|begin| rest.find(begin)).min();
        self.at += next.map_or(0, |next| next + "fn ".len());
    }
}

impl<'ast> Visit<'ast> for Signatures<'_> {
    fn visit_signature(&mut self, signature: &'ast syn::Signature) {
        let name = signature.ident.to_string();
        self.go_to(&name);
        self.has_long_tuple = false;
        visit::visit_signature(self, signature);
        let is_for_python = FOR_PYTHON.contains(&(self.file, &name));
        if std::mem::take(&mut self.has_long_tuple) && !is_for_python {
            let line = 1 + self.text[..self.at].matches('\n').count();
            self.found.push(format!("{}:{line}: {name}", self.file));
        }
    }

    fn visit_type_tuple(&mut self, tuple: &'ast syn::TypeTuple) {
        self.has_long_tuple |= tuple.elems.len() > MOST_ELEMENTS;
        visit::visit_type_tuple(self, tuple);
    }

    fn visit_type_path(&mut self, path: &'ast syn::TypePath) {
        let name = path.path.get_ident().map(ToString::to_string);
        self.has_long_tuple |= name.is_some_and(|name| self.aliases.contains(&name));
        visit::visit_type_path(self, path);
    }
}

/// Names of types that stand for a long tuple.
#[derive(Default)]
struct Aliases(Vec<String>);

impl<'ast> Visit<'ast> for Aliases {
    fn visit_item_type(&mut self, item: &'ast syn::ItemType) {
        let mut long = HasLongTuple(false);
        long.visit_type(&item.ty);
        if long.0 {
            self.0.push(item.ident.to_string());
        }
    }
}

struct HasLongTuple(bool);

impl<'ast> Visit<'ast> for HasLongTuple {
    fn visit_type_tuple(&mut self, tuple: &'ast syn::TypeTuple) {
        self.0 |= tuple.elems.len() > MOST_ELEMENTS;
        visit::visit_type_tuple(self, tuple);
    }
}

/// Every Rust file of the crates with its path below their folder, tests and benchmarks too.
fn files() -> impl Iterator<Item = (String, String)> {
    let named = |path: &Path| path.strip_prefix(crates()).unwrap().display().to_string();
    let folders = std::fs::read_dir(crates()).unwrap();
    let folders = folders.map(|folder| folder.unwrap().path());
    folders
        .flat_map(|folder| {
            let inside = ["src", "tests", "benches"].map(|part| folder.join(part));
            inside.into_iter().filter(|part| part.is_dir())
        })
        .flat_map(move |part| sources(&part))
        .map(move |(path, text)| (named(&path), text))
}

#[test]
fn functions_take_and_give_structs_with_names_instead_of_long_tuples() {
    let found: Vec<String> = files()
        .flat_map(|(file, text)| Signatures::read(&file, &text))
        .collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn long_tuples_are_found_in_arguments_results_and_behind_names() {
    let text = "type Long = Vec<(u8, u8, u8)>;\n\
                fn a(_: (u8, u8)) {}\n\
                fn b(_: &[(u8, u8, u8)]) {}\n\
                impl S { fn c() -> Option<(u8, u8, u8)> { None } }\n\
                fn d() -> Long { let _: (u8, u8, u8) = f(); Vec::new() }";
    let words = ["x.rs:3: b", "x.rs:4: c", "x.rs:5: d"];
    assert_eq!(Signatures::read("x.rs", text), words);
}
