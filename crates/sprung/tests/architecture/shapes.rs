//! Signatures and structs that a reader cannot follow: long tuples, and many fields.

use std::path::Path;
use std::sync::OnceLock;

use syn::visit::{self, Visit};

use crate::{crates, sources};

/// Elements of a tuple beyond which only names tell what they are.
const MOST_ELEMENTS: usize = 2;

/// Functions with longer tuples, by file and name: Python has no other words for them.
const FOR_PYTHON: [(&str, &str); 1] = [("sprung-python/src/results.rs", "compare")];

/// Fields of a struct beyond which it is several by meaning.
const MOST_FIELDS: usize = 15;

/// Structs with more fields, by file and name. Each is a table of the experiment file or an object of a JSON file, and
/// has the keys that the file has.
const AS_WIDE_AS_THEIR_FILE: [(&str, &str); 12] = [
    ("sprung-robot/src/log.rs", "Log"),
    ("sprung-robot/src/robot.rs", "Joint"),
    ("sprung-robot/src/run.rs", "Simulate"),
    ("sprung-robot/src/excite.rs", "Excite"),
    ("sprung-method/src/check/result.rs", "CheckedLog"),
    ("sprung-method/src/compare/result.rs", "ComparedResult"),
    ("sprung-method/src/control/result.rs", "ControlDesign"),
    ("sprung-method/src/excite/result.rs", "Excitation"),
    (
        "sprung-method/src/estimate/result/identification.rs",
        "EstimateResult",
    ),
    (
        "sprung-method/src/estimate/result/identification.rs",
        "ParameterEstimate",
    ),
    ("sprung-method/src/estimate/result/log_info.rs", "LogInfo"),
    (
        "sprung-method/src/estimate/result/refinement.rs",
        "Refinement",
    ),
];

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
    fn read(file: &'f str, text: &'f str, parsed: &syn::File) -> Vec<String> {
        let mut aliases = Aliases::default();
        aliases.visit_file(parsed);
        let mut all = Signatures {
            file,
            text,
            aliases: aliases.0,
            at: 0,
            has_long_tuple: false,
            found: Vec::new(),
        };
        all.visit_file(parsed);
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

/// Names and numbers of fields of the structs of a file with many fields.
struct WideStructs(Vec<(String, usize)>);

impl WideStructs {
    fn read(parsed: &syn::File) -> Vec<(String, usize)> {
        let mut all = Self(Vec::new());
        all.visit_file(parsed);
        all.0
    }
}

impl<'ast> Visit<'ast> for WideStructs {
    fn visit_item_struct(&mut self, item: &'ast syn::ItemStruct) {
        if item.fields.len() > MOST_FIELDS {
            self.0.push((item.ident.to_string(), item.fields.len()));
        }
    }
}

/// What the tests look for.
#[derive(Default)]
struct Found {
    /// Functions with a long tuple in their signature.
    signatures: Vec<String>,
    /// File, and name and number of fields, of each struct with many fields.
    wide: Vec<(String, (String, usize))>,
}

impl Found {
    /// Returns what all crates have; the tests share it, because parsing takes most of their time.
    fn in_crates() -> &'static Self {
        static FOUND: OnceLock<Found> = OnceLock::new();
        FOUND.get_or_init(|| {
            let mut all = Self::default();
            for (file, text) in files() {
                let parsed = parsed(&file, &text);
                all.signatures
                    .extend(Signatures::read(&file, &text, &parsed));
                let wide = WideStructs::read(&parsed).into_iter();
                all.wide.extend(wide.map(|found| (file.clone(), found)));
            }
            all
        })
    }
}

fn parsed(file: &str, text: &str) -> syn::File {
    syn::parse_file(text).unwrap_or_else(|e| panic!("{file}: {e}"))
}

#[test]
fn structs_have_few_fields_unless_a_file_has_as_many_keys() {
    let mut unused = AS_WIDE_AS_THEIR_FILE.to_vec();
    let mut found = Vec::new();
    for (file, (name, fields)) in &Found::in_crates().wide {
        match unused.iter().position(|known| *known == (file, name)) {
            Some(known) => drop(unused.swap_remove(known)),
            None => found.push(format!("{file}: {name} has {fields} fields")),
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
    assert!(unused.is_empty(), "remove from the list: {unused:?}");
}

#[test]
fn structs_with_many_fields_are_found() {
    let fields = "f: u8, ".repeat(MOST_FIELDS);
    let struct_of =
        |fields: String| parsed("x.rs", &format!("mod m {{ struct Wide {{ {fields} }} }}"));
    assert_eq!(WideStructs::read(&struct_of(fields.clone())), []);
    let wide = WideStructs::read(&struct_of(fields + "h: u8"));
    assert_eq!(wide, [("Wide".to_owned(), MOST_FIELDS + 1)]);
}

#[test]
fn functions_take_and_give_structs_with_names_instead_of_long_tuples() {
    let found = &Found::in_crates().signatures;
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
    assert_eq!(Signatures::read("x.rs", text, &parsed("x.rs", text)), words);
}
