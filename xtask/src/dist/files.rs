//! The files of a release, made from the program itself.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::{Done, Release, licences, output};
use crate::root;

/// Shells, and the names of their files of completions.
pub(super) const SHELLS: [(&str, &str); 4] = [
    ("bash", "sprung"),
    ("zsh", "_sprung"),
    ("fish", "sprung.fish"),
    ("powershell", "_sprung.ps1"),
];

/// A file of a release: its path and its bytes.
pub(super) type Entry = (PathBuf, Vec<u8>);

/// Returns the manual pages: of the program and of each verb.
pub(super) fn manuals(release: &Release) -> Done<Vec<Entry>> {
    let help = output(Command::new(&release.binary).arg("--help"))?;
    let mut all = vec![page(release, None)?];
    for verb in verbs(&help) {
        all.push(page(release, Some(verb))?);
    }
    Ok(all)
}

fn page(release: &Release, verb: Option<&str>) -> Done<Entry> {
    let text = output(Command::new(&release.binary).arg("man").args(verb))?;
    let name = verb.map_or_else(|| "sprung.1".to_owned(), |verb| format!("sprung-{verb}.1"));
    Ok((PathBuf::from(name), text.into_bytes()))
}

/// Returns the verbs that the help lists.
fn verbs(help: &str) -> Vec<&str> {
    (help.lines())
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| !line.is_empty())
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|verb| *verb != "help")
        .collect()
}

/// Returns the completions for a shell.
pub(super) fn completions(release: &Release, shell: &str) -> Done<Vec<u8>> {
    Ok(output(Command::new(&release.binary).args(["completions", shell]))?.into_bytes())
}

/// Returns the licences of sprung and of the libraries in the program, and the changelog.
pub(super) fn texts() -> Done<Vec<Entry>> {
    let mut all = Vec::new();
    for name in ["LICENSE-APACHE", "LICENSE-MIT", "README.md", "CHANGELOG.md"] {
        let bytes = std::fs::read(root().join(name))
            .map_err(|error| format!("cannot read {name}: {error}"))?;
        all.push((PathBuf::from(name), bytes));
    }
    all.push((
        PathBuf::from(licences::FILE),
        licences::text("sprung-cli")?.into_bytes(),
    ));
    Ok(all)
}

/// Writes files below a folder.
pub(super) fn write(folder: &Path, entries: &[Entry]) -> Done<()> {
    for (name, bytes) in entries {
        let path = folder.join(name);
        let made = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        made.and_then(|()| std::fs::write(&path, bytes))
            .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    }
    Ok(())
}

/// Returns the place of a pattern in a text.
pub(super) fn find(text: &[u8], pattern: &[u8]) -> Option<usize> {
    text.windows(pattern.len()).position(|part| part == pattern)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verbs_are_read_from_the_help() {
        let help = "Identifies.\n\nUsage: sprung <COMMAND>\n\nCommands:\n  demo      Run\n              a demo\n  new       \
                    Write\n  help      Print\n\nOptions:\n  -h, --help  Print help\n";
        assert_eq!(verbs(help), ["demo", "new"]);
        assert_eq!(find(b"in /root/x", b"/root"), Some(3));
        assert_eq!(find(b"short", b"longer than that"), None);
    }
}
