//! Links between the pages of the documentation, and the explanations of all codes of findings.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::files::files;
use crate::root;

/// Words in the library with the form of a code that are no codes.
const OTHER_WORDS: [&str; 26] = [
    "as-stamped",
    "at-a-glance",
    "condition-number",
    "cross-checks",
    "d-optimal",
    "go-on",
    "hold-out",
    "kebab-case",
    "least-squares",
    "link-damping",
    "lost-counts",
    "measured-and-predicted",
    "my-arm",
    "on-cycle",
    "output-error",
    "prediction-error",
    "scale-invariant",
    "sensed-springs",
    "sprung-out",
    "standard-errors",
    "state-feedback",
    "stiff-joints",
    "two-stage",
    "unix-none",
    "warm-up",
    "worst-error",
];

/// Returns a page without its fenced blocks and without code in backquotes in link targets.
fn prose(page: &str) -> String {
    let mut is_code = false;
    let lines = page.lines().filter(|line| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Returns the targets of the links and pictures of a page.
fn targets(page: &str) -> Vec<String> {
    let text = prose(page);
    let links = (text.split("](").skip(1))
        .filter_map(|rest| rest.split_once(')').map(|(target, _)| target));
    let pictures = (text.split(" src=\"").skip(1)).filter_map(|rest| rest.split('"').next());
    links
        .chain(pictures)
        .filter(|target| !target.contains(char::is_whitespace))
        .map(str::to_owned)
        .collect()
}

/// Returns the anchors that the headings of a page get.
fn anchors(page: &str) -> BTreeSet<String> {
    let mut seen = BTreeMap::new();
    let mut all = BTreeSet::new();
    for line in prose(page).lines() {
        let heading = line.trim_start_matches('#');
        if heading.len() == line.len() || !heading.starts_with(' ') {
            continue;
        }
        let letters = heading.trim().to_lowercase();
        let anchor: String = (letters.chars())
            .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'))
            .map(|c| if c == ' ' { '-' } else { c })
            .collect();
        let count = seen.entry(anchor.clone()).or_insert(0);
        all.insert(match *count {
            0 => anchor,
            count => format!("{anchor}-{count}"),
        });
        *count += 1;
    }
    all
}

/// Returns the fault of a link, if it has one.
fn fault(page: &Path, target: &str) -> Option<String> {
    if target.starts_with("https://") || target.starts_with("http://") {
        return None;
    }
    let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
    let path = match file {
        "" => page.to_owned(),
        file => page.parent().unwrap().join(file),
    };
    if !path.exists() {
        return Some(format!("{}: no file {target}", page.display()));
    }
    if anchor.is_empty() {
        return None;
    }
    let is_there = path.is_file() && anchors(&fs::read_to_string(path).unwrap()).contains(anchor);
    (!is_there).then(|| format!("{}: no heading {target}", page.display()))
}

#[test]
fn links_lead_to_files_and_headings() {
    let mut faults = Vec::new();
    let mut count = 0;
    for page in files(&root(), "md") {
        let text = fs::read_to_string(&page).unwrap();
        let targets = targets(&text);
        count += targets.len();
        faults.extend(targets.iter().filter_map(|target| fault(&page, target)));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(count > 100, "{count}");
}

#[test]
fn wrong_links_are_found() {
    let page = root().join("README.md");
    assert_eq!(fault(&page, "docs/README.md"), None);
    assert_eq!(fault(&page, "docs/README.md#look-up"), None);
    assert!(fault(&page, "docs/absent.md").is_some());
    assert!(fault(&page, "docs/README.md#absent").is_some());
    let page = "[a](b.md) `x`\n```sh\n[c](d.md)\n```\n[e\nf](g.md#h) <img src=\"i.svg\">";
    assert_eq!(targets(page), ["b.md", "g.md#h", "i.svg"]);
    let headings = "# The `log`, in short\n## More\n## More\n#no heading";
    let expected = ["more", "more-1", "the-log-in-short"];
    assert!(anchors(headings).iter().eq(expected.iter()));
}

#[test]
fn the_index_names_every_page() {
    let index = root().join("docs/README.md");
    let text = fs::read_to_string(&index).unwrap();
    let named: BTreeSet<PathBuf> = (targets(&text).iter())
        .map(|target| index.parent().unwrap().join(target))
        .collect();
    for page in files(&root().join("docs"), "md") {
        assert!(page == index || named.contains(&page), "{}", page.display());
    }
}

/// Returns the words in quotation marks that consist of lower-case letters and hyphens.
fn words(code: &str) -> BTreeSet<&str> {
    let is_word = |word: &&str| {
        let is_letter = |c: char| c.is_ascii_lowercase() || c == '-';
        !word.is_empty()
            && word.chars().all(is_letter)
            && !word.starts_with('-')
            && !word.ends_with('-')
    };
    // Every second part is inside of a string, but a quotation mark in a string may shift them.
    code.split('"').filter(is_word).collect()
}

/// Returns the codes in the first cells of the tables of a page.
fn first_cells(page: &str) -> BTreeSet<&str> {
    let cells = page.lines().filter_map(|line| line.strip_prefix("| `"));
    cells
        .flat_map(|line| line.split(" |").next().unwrap().split(", "))
        .map(|code| code.trim_matches('`'))
        .collect()
}

/// Returns the source folders of all crates of the library.
fn library() -> Vec<PathBuf> {
    let others = ["sprung-cli", "sprung-python", "sprung-testing"];
    let crates = fs::read_dir(root().join("crates")).unwrap();
    let paths = crates.map(|entry| entry.unwrap().path());
    paths
        .filter(|path| !others.iter().any(|other| path.ends_with(other)))
        .map(|path| path.join("src"))
        .collect()
}

/// Returns the codes that the explanations name.
fn explained() -> BTreeSet<String> {
    let folder = root().join("crates/sprung-base/src/explanation");
    let texts = files(&folder, "toml")
        .into_iter()
        .map(|path| fs::read_to_string(path).unwrap());
    let lines: Vec<String> = texts
        .flat_map(|text| text.lines().map(str::to_owned).collect::<Vec<_>>())
        .filter(|line| line.starts_with("codes = "))
        .collect();
    lines
        .iter()
        .flat_map(|line| words(line))
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_code_has_an_explanation() {
    let explained = explained();
    let named: BTreeSet<&str> = explained.iter().map(String::as_str).collect();
    // The table in the code writes this page.
    let page = fs::read_to_string(root().join("docs/reference/what-works.md")).unwrap();
    let refusals = first_cells(&page);

    let sources: Vec<PathBuf> = (library().iter())
        // The core has no findings; its names of laws contain hyphens.
        .filter(|folder| !folder.ends_with("sprung-core/src"))
        .flat_map(|folder| files(folder, "rs"))
        .collect();
    let texts: Vec<String> = (sources.iter())
        .filter(|path| !path.ends_with("tests.rs"))
        .map(|path| fs::read_to_string(path).unwrap())
        .collect();
    let code: String = (texts.iter())
        .map(|text| text.split("#[cfg(test)]").next().unwrap())
        .collect();
    let present = words(&code);
    for code in &named {
        assert!(present.contains(code), "{code} is no code of the program");
    }

    let with_hyphen = present.iter().filter(|word| word.contains('-'));
    let mut codes: BTreeSet<&str> = with_hyphen.copied().collect();
    // Codes of a single word: the first text after a severity.
    for rest in code.split("Severity::").skip(1) {
        let rest = rest.trim_start_matches(char::is_alphabetic);
        let rest = rest.trim_start_matches([' ', '\n', '}', ',']);
        let word = rest
            .strip_prefix('"')
            .and_then(|rest| rest.split('"').next());
        codes.extend(word.filter(|word| present.contains(word)));
    }
    let stale: Vec<&&str> = (OTHER_WORDS.iter())
        .filter(|word| !codes.contains(*word))
        .collect();
    assert!(
        stale.is_empty(),
        "no longer words of the program: {stale:?}"
    );
    let missing: Vec<&&str> = (codes.iter())
        .filter(|code| !named.contains(**code) && !refusals.contains(**code))
        .filter(|code| !OTHER_WORDS.contains(code))
        .collect();
    assert!(
        missing.is_empty(),
        "crates/sprung-base/src/explanation lacks {missing:?}"
    );
}
