//! Version, addresses and authors in all files that name them, from `Cargo.toml` and `publication.toml`.

use std::fs;

use crate::root;
use crate::steps::said;

/// File of the values, relative to the root of the repository.
const FILE: &str = "publication.toml";

/// Lines with values, for each file: the text before the first `{` identifies the line, words in braces are keys.
const LINES: &[(&str, &[&str])] = &[
    (
        "Cargo.toml",
        &[
            "repository = \"{repository}\"",
            "homepage = \"{homepage}\"",
            "documentation = \"{documentation}\"",
        ],
    ),
    (
        "crates/sprung-python/pyproject.toml",
        &[
            "authors = [{ name = \"{authors}\" }]",
            "Homepage = \"{homepage}\"",
            "Repository = \"{repository}\"",
            "Issues = \"{repository}/issues\"",
            "Documentation = \"{documentation}\"",
        ],
    ),
    (
        "CITATION.cff",
        &[
            "version: {version}",
            "- name: {authors}",
            "repository-code: {repository}",
            "url: {homepage}",
        ],
    ),
    (
        "codemeta.json",
        &[
            "\"version\": \"{version}\",",
            "\"name\": \"{authors}\"",
            "\"codeRepository\": \"{repository}\",",
            "\"issueTracker\": \"{repository}/issues\",",
            "\"url\": \"{homepage}\",",
            "\"softwareHelp\": \"{documentation}\",",
        ],
    ),
    ("paper/paper.md", &["- name: {authors}"]),
    ("packaging/Dockerfile", &["ARG VERSION={version}"]),
    (
        "packaging/conda/recipe.yaml",
        &[
            "version: {version}",
            "homepage: {homepage}",
            "repository: {repository}",
            "documentation: {documentation}",
        ],
    ),
    (
        "crates/sprung-cli/package.xml",
        &[
            "<version>{version}</version>",
            "<maintainer email=\"{contact}\">{authors}</maintainer>",
            "<author>{authors}</author>",
            "<url type=\"website\">{homepage}</url>",
            "<url type=\"repository\">{repository}</url>",
            "<url type=\"bugtracker\">{repository}/issues</url>",
        ],
    ),
    (
        ".github/ISSUE_TEMPLATE/config.yml",
        &["url: {repository}/security/advisories/new"],
    ),
    ("CODE_OF_CONDUCT.md", &["Contact: <{contact}>"]),
];

/// Keys of `publication.toml`.
const KEYS: [&str; 8] = [
    "authors",
    "orcid",
    "affiliation",
    "contact",
    "repository",
    "homepage",
    "documentation",
    "doi",
];

/// Returns a value of `publication.toml`, or the version of the workspace.
pub(crate) fn value(key: &str) -> Result<String, String> {
    if key == "version" {
        return Ok(env!("CARGO_PKG_VERSION").to_owned());
    }
    let text = fs::read_to_string(root().join(FILE)).map_err(|error| format!("{FILE}: {error}"))?;
    let line = text.lines().find_map(|line| {
        let (name, rest) = line.split_once(" = ")?;
        (name == key).then(|| rest.trim_matches('"').to_owned())
    });
    line.ok_or_else(|| format!("{FILE} has no {key}"))
}

/// Returns a line with its values.
fn filled(line: &str) -> Result<String, String> {
    let mut text = line.to_owned();
    for key in KEYS.into_iter().chain(["version"]) {
        if text.contains(&format!("{{{key}}}")) {
            text = text.replace(&format!("{{{key}}}"), &value(key)?);
        }
    }
    Ok(text)
}

/// Returns a file with its values.
fn file(name: &str, lines: &[&str]) -> Result<(String, String), String> {
    let old = fs::read_to_string(root().join(name)).map_err(|error| format!("{name}: {error}"))?;
    let mut new = old.clone();
    for line in lines {
        let key = KEYS
            .iter()
            .chain(&["version"])
            .filter_map(|key| line.find(&format!("{{{key}}}")))
            .min();
        let start = &line[..key.ok_or_else(|| format!("{line} has no key"))?];
        let found = (new.lines())
            .find(|found| found.trim_start().starts_with(start) && !names_another(found, start))
            .ok_or_else(|| format!("{name} has no line that begins with {start:?}"))?;
        let indent = &found[..found.len() - found.trim_start().len()];
        let wanted = format!("\n{indent}{}\n", filled(line)?);
        new = new.replacen(&format!("\n{found}\n"), &wanted, 1);
    }
    Ok((old, new))
}

/// Returns whether a line of the same beginning has another subject: the name of the program in `codemeta.json`.
fn names_another(line: &str, start: &str) -> bool {
    start == "\"name\": \"" && line.ends_with(',')
}

/// Writes the values into all files.
pub(crate) fn write() -> Option<()> {
    let each = |(name, lines): &(&str, &[&str])| {
        let (_, new) = file(name, lines)?;
        fs::write(root().join(name), new).map_err(|error| format!("{name}: {error}"))
    };
    said("publication", LINES.iter().try_for_each(each))
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn files_agree_on_version_addresses_and_authors() {
        for (name, lines) in LINES {
            let (old, new) = file(name, lines).unwrap();
            assert_eq!(old, new, "{name}: run cargo xtask docs");
        }
        let manifest = fs::read_to_string(root().join("Cargo.toml")).unwrap();
        let version = format!("version = \"{}\"", value("version").unwrap());
        let crates = (manifest.lines())
            .filter(|line| line.contains("path = \"crates/") && line.contains("version = "));
        for line in crates {
            assert!(line.contains(&version), "{line}");
        }
    }

    #[test]
    fn every_manifest_takes_the_addresses_from_the_workspace() {
        let crates = fs::read_dir(root().join("crates")).unwrap();
        let manifests = crates.map(|entry| entry.unwrap().path().join("Cargo.toml"));
        for path in manifests {
            let text = fs::read_to_string(&path).unwrap();
            for key in ["version", "repository", "homepage", "documentation"] {
                let line = format!("{key}.workspace = true");
                assert!(text.contains(&line), "{}: {line}", path.display());
            }
        }
    }

    #[test]
    fn the_paper_has_at_most_a_thousand_words() {
        let text = fs::read_to_string(root().join("paper/paper.md")).unwrap();
        let body = text.split("\n---\n").nth(1).unwrap();
        let words = body.split_whitespace().count();
        assert!(words <= 1000, "{words}");
    }

    /// Prints the placeholders, past the capture of libtest. Only a release must not have any.
    #[test]
    fn placeholders_are_listed() {
        let is_unset = |key: &&str| {
            let value = value(key).unwrap();
            value.is_empty() || value.contains("example.invalid") || value == "The sprung authors"
        };
        let unset: Vec<&str> = KEYS.into_iter().filter(is_unset).collect();
        let line = format!("UNSET in {FILE}: {}\n", unset.join(", "));
        std::io::stderr().write_all(line.as_bytes()).unwrap();
    }
}
