//! Installs a package into an empty folder and runs the program there.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::files::SHELLS;
use super::packages::emptied;
use super::{Done, Release, output};

/// Installs a package and runs the program: its version, its completions, a page of its manual, and the demo.
pub(super) fn run(release: &Release, package: &Path) -> Done<()> {
    let folder = release.out.join("try");
    emptied(&folder)?;
    let is_debian = package
        .extension()
        .is_some_and(|extension| extension == "deb");
    let program = if is_debian {
        output(Command::new("dpkg-deb").arg("-x").args([package, &folder]))?;
        folder.join("usr/bin/sprung")
    } else {
        output(
            Command::new("tar")
                .arg("-xzf")
                .arg(package)
                .arg("-C")
                .arg(&folder),
        )?;
        let name = format!("sprung-{}-{}", release.version, release.target);
        folder.join(name).join("sprung")
    };
    let work = folder.join("work");
    emptied(&work)?;
    // No variable of this shell but the path to the shells.
    let clean = |program: &Path| {
        let mut command = Command::new(program);
        command
            .env_clear()
            .env("PATH", "/usr/bin:/bin")
            .env("HOME", &work)
            .current_dir(&work);
        command
    };
    let sprung = |words: &[&str]| output(clean(&program).args(words));
    let version = sprung(&["--version"])?;
    if version.split_whitespace().nth(1) != Some(release.version.as_str()) {
        return Err(format!("the installed program says {version:?}"));
    }
    for (shell, _) in SHELLS {
        if !sprung(&["completions", shell])?.contains("identify") {
            return Err(format!("the completions for {shell} do not know identify"));
        }
    }
    let completions = work.join("completions.bash");
    std::fs::write(&completions, sprung(&["completions", "bash"])?)
        .map_err(|error| error.to_string())?;
    output(clean(Path::new("bash")).arg("-n").arg(&completions))?;
    if !sprung(&["man", "identify"])?.contains("sprung\\-identify") {
        return Err("the manual of identify has no name".to_owned());
    }
    let said = sprung(&["demo", "--no-progress"])?;
    let written = [
        "experiment.toml",
        "sprung-out/identification.json",
        "sprung-out/report.html",
    ];
    let missing: Vec<PathBuf> = (written
        .iter()
        .map(|file| work.join("sprung-demo").join(file)))
    .filter(|file| !file.exists())
    .collect();
    if !missing.is_empty() {
        return Err(format!("the demo did not write {missing:?}"));
    }
    println!(
        "{}: {}",
        package.display(),
        said.lines().last().unwrap_or_default()
    );
    Ok(())
}
