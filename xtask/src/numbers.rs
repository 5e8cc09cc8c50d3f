//! `cargo xtask numbers`: counts the numbers in the code of the library, by folder.
//!
//! A named number is a constant of a numeric type. Its documentation states its source: theory, a standard, or a
//! bench. An unnamed number is any other literal except 0, 1, 2 and ½. Tests are left out.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use syn::visit::{self, Visit};
use syn::{Attribute, Lit, Type};

use crate::root;

/// Literals that need no name.
const PLAIN: [f64; 4] = [0.0, 0.5, 1.0, 2.0];

/// Numbers of one folder.
#[derive(Default)]
struct Counts {
    named: usize,
    /// Named numbers without documentation, as `file: NAME`.
    without_reason: Vec<String>,
    unnamed: usize,
}

/// Prints the counts of each folder below a folder.
///
/// - `folder`: `None` for the sources of all crates of the library.
pub(crate) fn print(folder: Option<&str>) -> ExitCode {
    let folders = match folder {
        Some(folder) => vec![PathBuf::from(folder)],
        None => library(),
    };
    let mut counts: BTreeMap<String, Counts> = BTreeMap::new();
    for folder in &folders {
        for file in files(folder) {
            let Ok(text) = fs::read_to_string(&file) else {
                eprintln!("{}: cannot be read", file.display());
                return ExitCode::FAILURE;
            };
            let Ok(parsed) = syn::parse_file(&text) else {
                eprintln!("{}: is not Rust", file.display());
                return ExitCode::FAILURE;
            };
            let entry = counts.entry(place(folder, &file)).or_default();
            let file = file.display().to_string();
            let mut reader = Reader {
                counts: entry,
                file,
            };
            reader.visit_file(&parsed);
        }
    }
    println!(
        "{:<28} {:>6} {:>15} {:>8}",
        "folder", "named", "without reason", "unnamed"
    );
    let row = |name: &str, counts: &Counts| {
        let without = counts.without_reason.len();
        println!(
            "{name:<28} {:>6} {without:>15} {:>8}",
            counts.named, counts.unnamed
        );
    };
    let mut all = Counts::default();
    for (name, counts) in counts {
        row(&name, &counts);
        all.named += counts.named;
        all.unnamed += counts.unnamed;
        all.without_reason.extend(counts.without_reason);
    }
    row("all", &all);
    for name in &all.without_reason {
        println!("without reason: {name}");
    }
    ExitCode::SUCCESS
}

/// Returns the source folders of all crates of the library.
pub(crate) fn library() -> Vec<PathBuf> {
    let crates = fs::read_dir(root().join("crates"));
    let mut all: Vec<PathBuf> = (crates.into_iter().flatten().flatten())
        .map(|entry| entry.path())
        .filter(|path| {
            let name = path.file_name().and_then(|name| name.to_str());
            !matches!(
                name,
                Some("sprung-cli" | "sprung-python" | "sprung-testing") | None
            )
        })
        .map(|path| path.join("src"))
        .collect();
    all.sort();
    all
}

/// Returns all Rust files below a folder that are not tests.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    let mut entries: Vec<PathBuf> = (fs::read_dir(folder).into_iter().flatten().flatten())
        .map(|entry| entry.path())
        .collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            all.extend(files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs")
            && path.file_stem().is_none_or(|stem| stem != "tests")
        {
            all.push(path);
        }
    }
    all
}

/// Returns the name of the crate and of the module in which a file is.
fn place(folder: &Path, file: &Path) -> String {
    let inside = file.strip_prefix(folder).unwrap_or(file);
    let module = match inside.iter().count() {
        1 => String::new(),
        _ => format!("/{}", inside.iter().next().unwrap_or_default().display()),
    };
    let name = folder
        .parent()
        .and_then(Path::file_name)
        .unwrap_or_default();
    format!("{}{module}", name.display())
}

/// Counts the numbers of a file.
struct Reader<'c> {
    counts: &'c mut Counts,
    file: String,
}

impl Reader<'_> {
    fn named(&mut self, name: &syn::Ident, ty: &Type, attributes: &[Attribute]) -> bool {
        if !is_number(ty) {
            return false;
        }
        self.counts.named += 1;
        if !attributes
            .iter()
            .any(|attribute| attribute.path().is_ident("doc"))
        {
            self.counts
                .without_reason
                .push(format!("{}: {name}", self.file));
        }
        true
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        match item {
            syn::Item::Mod(module) if is_test(&module.attrs) => {}
            syn::Item::Fn(function) if is_test(&function.attrs) => {}
            syn::Item::Impl(implementation) if is_test(&implementation.attrs) => {}
            syn::Item::Const(constant) if is_test(&constant.attrs) => {}
            syn::Item::Const(constant)
                if self.named(&constant.ident, &constant.ty, &constant.attrs) => {}
            _ => visit::visit_item(self, item),
        }
    }

    fn visit_impl_item_const(&mut self, constant: &'ast syn::ImplItemConst) {
        if !self.named(&constant.ident, &constant.ty, &constant.attrs) {
            visit::visit_impl_item_const(self, constant);
        }
    }

    fn visit_lit(&mut self, literal: &'ast Lit) {
        let value: Option<f64> = match literal {
            Lit::Int(number) => number.base10_parse().ok(),
            Lit::Float(number) => number.base10_parse().ok(),
            _ => return,
        };
        let is_plain =
            value.is_some_and(|value| PLAIN.iter().any(|plain| plain.total_cmp(&value).is_eq()));
        if !is_plain {
            self.counts.unnamed += 1;
        }
    }

    fn visit_attribute(&mut self, _: &'ast Attribute) {}
}

fn is_test(attributes: &[Attribute]) -> bool {
    (attributes.iter()).any(|attribute| {
        let mut tests = attribute.path().is_ident("test");
        if attribute.path().is_ident("cfg") {
            let _ = attribute.parse_nested_meta(|meta| {
                tests |= meta.path.is_ident("test");
                Ok(())
            });
        }
        tests
    })
}

/// Returns whether a type is a number, or an array or tuple of numbers.
fn is_number(ty: &Type) -> bool {
    match ty {
        Type::Path(path) => path.path.get_ident().is_some_and(|name| {
            let name = name.to_string();
            matches!(
                name.as_str(),
                "f32"
                    | "f64"
                    | "usize"
                    | "isize"
                    | "u8"
                    | "u16"
                    | "u32"
                    | "u64"
                    | "i8"
                    | "i16"
                    | "i32"
                    | "i64"
            )
        }),
        Type::Array(array) => is_number(&array.elem),
        Type::Tuple(tuple) => !tuple.elems.is_empty() && tuple.elems.iter().all(is_number),
        Type::Reference(reference) => is_number(&reference.elem),
        _ => false,
    }
}
