"""Makes a copy of sprung whose named numbers an environment variable scales."""

import re
import subprocess
from pathlib import Path

# Types of numbers whose products with ½ and 2 have a meaning.
TYPE = r"(?:f64|usize|u64|u32|i32|\[f64; *\d+\]|\(f64, *f64\)|\[\(f64, *f64\); *\d+\])"
CONSTANT = re.compile(rf"^( *)((?:pub(?:\([a-z: ]+\))? )?)const ([A-Z][A-Z0-9_]*): ({TYPE}) = ([^;]*);$", re.MULTILINE)
TESTS = re.compile(r"^#\[cfg\(test\)\]\s*mod ", re.MULTILINE)
# Comments, texts, characters and imports stay; a name may have a path in front.
WORD = re.compile(r"""//[^\n]*|/\*.*?\*/|r\#".*?"\#|"(?:\\.|[^"\\])*"|'(?:\\[^']+|[^'\\])'|\buse\s[^;]*;"""
                  r"""|(?P<path>(?:\b\w+::)*)\b(?P<name>[A-Z][A-Z0-9_]*)\b""", re.DOTALL | re.VERBOSE)

MODULE = '''//! Numbers that the environment variable SPRUNG_NUMBER scales: `name=factor`.

pub(crate) trait Scaled: Sized {
    fn scaled(self, factor: f64) -> Self;
}

impl Scaled for f64 {
    fn scaled(self, factor: f64) -> Self {
        self * factor
    }
}

macro_rules! counts {
    ($($ty:ty),*) => {$(
        impl Scaled for $ty {
            fn scaled(self, factor: f64) -> Self {
                if self == 0 { 0 } else { ((self as f64 * factor) as Self).max(1) }
            }
        }
    )*};
}

counts!(usize, u64, u32, i32);

impl<T: Scaled, const N: usize> Scaled for [T; N] {
    fn scaled(self, factor: f64) -> Self {
        self.map(|one| one.scaled(factor))
    }
}

impl<T: Scaled> Scaled for (T, T) {
    fn scaled(self, factor: f64) -> Self {
        (self.0.scaled(factor), self.1.scaled(factor))
    }
}

/// Returns a number or its scaled value, and appends its name to the file SPRUNG_NUMBERS_USED.
pub(crate) fn value<T: Scaled>(name: &str, number: T) -> T {
    if let Ok(path) = std::env::var("SPRUNG_NUMBERS_USED") {
        use std::io::Write as _;
        let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
        file.and_then(|mut file| file.write_all(format!("{name}\\n").as_bytes())).unwrap();
    }
    match std::env::var("SPRUNG_NUMBER").ok().as_deref().and_then(|setting| setting.split_once('=')) {
        Some((wanted, factor)) if wanted == name => number.scaled(factor.parse().unwrap()),
        _ => number,
    }
}
'''


def sources(folder):
    """Returns the texts of the Rust files of a folder without tests."""
    return {path: path.read_text() for path in sorted(folder.rglob("*.rs")) if path.stem != "tests"}


def split_at_tests(text):
    """Returns the part of a file before its tests, and its tests."""
    tests = TESTS.search(text)
    return (text, "") if tests is None else (text[:tests.start()], text[tests.start():])


def constants(files, folder):
    """Returns the constants of files: their names in the report, by file and name."""
    found = {}
    for path, text in files.items():
        for one in CONSTANT.finditer(split_at_tests(text)[0]):
            place = path.relative_to(folder).with_suffix("").as_posix()
            found[path, one[3]] = f"{place}::{one[3]}"
    return found


def needed_by_compiler(text, name):
    """Returns whether the compiler needs a number: it is a length or a part of a pattern or text."""
    return re.search(rf"; *(?:\w+::)*{name}\b *\]|^ *(?:\S+\.\.=?)?{name}\b *(?:\.\.=?\S* *)?=>|::<[^>;()]*\b{name}\b|{{{name}[:}}]",
                     text, re.MULTILINE)


def rewritten(text, known, report_names, path):
    """Returns a file in which the known numbers are functions of the environment.

    - known: names that the file defines or imports
    - report_names: names in the report of the constants that the file defines, by name
    """
    text, tests = split_at_tests(text)

    def use(match):
        name = match["name"]
        if name is None or name not in known or match["path"].startswith(("f64", "usize", "std")):
            return match[0]
        before = text[max(0, match.start() - 6):match.start()]
        return match[0] if before.endswith("const ") else f"(*{match[0]})"

    def definition(match):
        indent, visible, name, kind, value = match.groups()
        if name not in report_names:
            return match[0]
        return (f"{indent}{visible}static {name}: std::sync::LazyLock<{kind}> = "
                f'std::sync::LazyLock::new(|| crate::scaled_numbers::value("{report_names[name]}", {value}));')

    return CONSTANT.sub(definition, WORD.sub(use, text)) + tests


def copied(root, copy, folder):
    """Copies the files of the repository and rewrites the numbers of a folder of a crate.

    Returns the rewritten numbers and those that the compiler needs.
    """
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=root, capture_output=True, text=True, check=True)
    for name in filter(None, listed.stdout.split("\0")):
        if (root / name).is_file():
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            text = (root / name).read_bytes()
            # An unchanged file keeps its time, so that a second build is short.
            if not (copy / name).is_file() or (copy / name).read_bytes() != text:
                (copy / name).write_bytes(text)
    source = next(parent for parent in (root / folder).parents if parent.name == "src")
    crate = sources(source)
    found = constants(sources(root / folder), root / folder)
    outside = "\n".join(path.read_text() for path in (root / "crates").rglob("*.rs")
                        if source not in path.parents)
    public = {name for path, name in found
              if re.search(rf"\bpub(?:\([a-z: ]+\))? const {name}\b", crate[path])}
    fixed = {(path, name) for path, name in found if needed_by_compiler(crate[path], name)
             or name in public and any(needed_by_compiler(text, name) for text in crate.values())
             or re.search(rf"\bpub const {name}\b", crate[path]) and re.search(rf"\b{name}\b", outside)}
    changed = {key: name for key, name in found.items() if key not in fixed}
    shared = {name for _, name in changed if name in public}
    for path, text in crate.items():
        report_names = {name: report for (where, name), report in changed.items() if where == path}
        own_fixed = {name for where, name in fixed if where == path}
        defined = {one[3] for one in CONSTANT.finditer(split_at_tests(text)[0])}
        # Other folders of the crate have numbers of the same names.
        imports = r"\b" if (root / folder) in path.parents else rf"\b{Path(folder).name}::[^;]*\b"
        imported = {name for name in shared if name not in defined and re.search(rf"{imports}{name}\b", text)}
        known = (report_names.keys() | imported) - own_fixed
        if known:
            (copy / path.relative_to(root)).write_text(rewritten(text, known, report_names, path))
    main = copy / source.relative_to(root) / "lib.rs"
    main.write_text((source / "lib.rs").read_text() + "\nmod scaled_numbers;\n")
    (main.parent / "scaled_numbers.rs").write_text(MODULE)
    return sorted(changed.values()), sorted(found[key] for key in fixed)
