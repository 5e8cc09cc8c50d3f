//! The archive and the Debian package.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::files::{self, Entry, SHELLS};
use super::{Done, Release, output};
use crate::publication;

/// Makes a package twice and checks that the bytes are the same.
pub(super) fn twice(release: &Release, make: fn(&Release) -> Done<PathBuf>) -> Done<PathBuf> {
    let read =
        |path: &Path| std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()));
    let first = read(&make(release)?)?;
    // Times of files have a resolution of seconds in some formats.
    std::thread::sleep(std::time::Duration::from_millis(1100));
    let package = make(release)?;
    if read(&package)? != first {
        return Err(format!(
            "{} has other bytes the second time",
            package.display()
        ));
    }
    println!(
        "{} ({} bytes, the same twice)",
        package.display(),
        first.len()
    );
    Ok(package)
}

/// Removes a folder and creates it again.
pub(super) fn emptied(folder: &Path) -> Done<()> {
    let _ = std::fs::remove_dir_all(folder);
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot create {}: {error}", folder.display()))
}

/// Makes an archive with the program, its licences, completions and manual pages.
pub(super) fn archive(release: &Release) -> Done<PathBuf> {
    let name = format!("sprung-{}-{}", release.version, release.target);
    let parent = release.out.join("archive");
    let folder = parent.join(&name);
    emptied(&parent)?;
    files::write(&folder, &files::texts()?)?;
    for (shell, file) in SHELLS {
        let entry = (
            Path::new("completions").join(file),
            files::completions(release, shell)?,
        );
        files::write(&folder, &[entry])?;
    }
    files::write(&folder.join("man/man1"), &files::manuals(release)?)?;
    install(release, &folder.join("sprung"))?;
    let package = release.out.join(format!("{name}.tar.gz"));
    let plain = release.out.join(format!("{name}.tar"));
    output(
        Command::new("tar")
            .arg("--create")
            .arg("--file")
            .arg(&plain)
            .arg("--directory")
            .arg(&parent)
            .args([
                "--sort=name",
                "--owner=0",
                "--group=0",
                "--numeric-owner",
                "--format=ustar",
            ])
            .args([&*format!("--mtime=@{}", release.time), "--mode=u=rwX,go=rX"])
            .arg(&name),
    )?;
    // The header then has neither a name nor a time.
    output(
        Command::new("gzip")
            .args(["--no-name", "--best", "--force"])
            .arg(&plain),
    )?;
    Ok(package)
}

/// Makes a Debian package.
pub(super) fn debian(release: &Release) -> Done<PathBuf> {
    let folder = release.out.join("debian");
    emptied(&folder)?;
    let share = folder.join("usr/share");
    let doc = share.join("doc/sprung");
    let mut copyright = Vec::new();
    for (name, bytes) in files::texts()? {
        // Debian expects these names.
        let place = match name.to_str() {
            Some("README.md") => "README.md",
            Some("CHANGELOG.md") => "changelog",
            _ => {
                copyright.extend_from_slice(&bytes);
                copyright.push(b'\n');
                continue;
            }
        };
        files::write(&doc, &[(PathBuf::from(place), bytes)])?;
    }
    files::write(&doc, &[(PathBuf::from("copyright"), copyright)])?;
    for (shell, place) in [
        ("bash", "bash-completion/completions/sprung"),
        ("zsh", "zsh/vendor-completions/_sprung"),
        ("fish", "fish/vendor_completions.d/sprung.fish"),
    ] {
        let entry: Entry = (PathBuf::from(place), files::completions(release, shell)?);
        files::write(&share, &[entry])?;
    }
    let manuals = share.join("man/man1");
    files::write(&manuals, &files::manuals(release)?)?;
    compress_all(&manuals)?;
    compress(&doc.join("changelog"))?;
    install(release, &folder.join("usr/bin/sprung"))?;

    let architecture = output(Command::new("dpkg").arg("--print-architecture"))?;
    let architecture = architecture.trim();
    let control = control(release, architecture, size_of(&folder)?)?;
    files::write(
        &folder,
        &[(PathBuf::from("DEBIAN/control"), control.into_bytes())],
    )?;
    output(
        Command::new("chmod")
            .args(["--recursive", "u=rwX,go=rX"])
            .arg(&folder),
    )?;
    let package = release
        .out
        .join(format!("sprung_{}_{architecture}.deb", release.version));
    output(
        Command::new("dpkg-deb")
            .args(["--root-owner-group", "-Zgzip", "--build"])
            .args([&folder, &package])
            .env("SOURCE_DATE_EPOCH", release.time.to_string()),
    )?;
    Ok(package)
}

/// Copies the program and makes it executable.
fn install(release: &Release, to: &Path) -> Done<()> {
    let bytes = std::fs::read(&release.binary)
        .map_err(|error| format!("cannot read the program: {error}"))?;
    files::write(Path::new(""), &[(to.to_owned(), bytes)])?;
    output(Command::new("chmod").arg("755").arg(to)).map(drop)
}

fn compress(file: &Path) -> Done<()> {
    output(Command::new("gzip").args(["--no-name", "--best"]).arg(file)).map(drop)
}

fn compress_all(folder: &Path) -> Done<()> {
    let entries =
        std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    (entries.filter_map(Result::ok)).try_for_each(|entry| compress(&entry.path()))
}

/// Returns the size of all files in a folder, KiB.
fn size_of(folder: &Path) -> Done<u64> {
    let said = output(
        Command::new("du")
            .args(["--summarize", "--apparent-size", "--block-size=1K"])
            .arg(folder),
    )?;
    let size = said
        .split_whitespace()
        .next()
        .and_then(|size| size.parse().ok());
    size.ok_or_else(|| format!("du says {said:?}"))
}

fn control(release: &Release, architecture: &str, size: u64) -> Done<String> {
    let bytes = std::fs::read(&release.binary)
        .map_err(|error| format!("cannot read the program: {error}"))?;
    let libc = libc_of(&bytes).map_or_else(String::new, |(major, minor)| {
        format!(" (>= {major}.{minor})")
    });
    let [authors, contact, homepage] = ["authors", "contact", "homepage"].map(publication::value);
    let (authors, contact, homepage) = (authors?, contact?, homepage?);
    Ok(format!(
        "Package: sprung\nVersion: {}\nSection: science\nPriority: optional\nArchitecture: {architecture}\n\
         Depends: libc6{libc}, libgcc-s1\nInstalled-Size: {size}\nMaintainer: {authors} <{contact}>\nHomepage: {homepage}\n\
         Description: identifies flexible-joint robots from measured logs\n \
         sprung estimates the dynamic parameters of robots with flexible joints: inertial parameters, \n \
         stiffnesses, rotor inertias and friction, with intervals and a verdict.\n",
        release.version
    ))
}

/// Returns the newest version of the C library whose symbols the program uses.
fn libc_of(program: &[u8]) -> Option<(u32, u32)> {
    const START: &[u8] = b"GLIBC_";
    let versions = program
        .windows(START.len() + 6)
        .filter(|part| part.starts_with(START));
    versions
        .filter_map(|part| {
            let text = part[START.len()..].split(|byte| *byte == 0).next()?;
            let (major, minor) = std::str::from_utf8(text).ok()?.split_once('.')?;
            let minor = minor.split('.').next()?;
            Some((major.parse().ok()?, minor.parse().ok()?))
        })
        .max()
}

#[cfg(test)]
mod tests {
    use super::libc_of;

    #[test]
    fn the_newest_c_library_counts() {
        let program = b"x\0GLIBC_2.2.5\0y\0GLIBC_2.34\0GLIBC_2.9\0GLIBC_PRIVATE\0";
        assert_eq!(libc_of(program), Some((2, 34)));
        assert_eq!(libc_of(b"static"), None);
    }
}
