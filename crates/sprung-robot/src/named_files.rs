//! The files that an experiment names, except logs.

use std::io::{Error, ErrorKind, Result};
use std::path::{Component, Path, PathBuf};

use super::urdf::LARGEST_MESH;

/// Folders above that of the URDF in which packages are searched.
const LEVELS: usize = 16;

/// Opens the files that an experiment names, except logs. A closure from a path to a text opens no meshes.
pub trait NamedFiles {
    /// Returns the text of a file.
    ///
    /// # Errors
    ///
    /// The error of reading the file.
    fn text(&mut self, path: &Path) -> Result<String>;

    /// Returns the first bytes of a file.
    ///
    /// # Errors
    ///
    /// The error of reading the file. The default has no files.
    fn bytes(&mut self, _path: &Path, _limit: u64) -> Result<Vec<u8>> {
        Err(ErrorKind::NotFound.into())
    }
}

impl<F: FnMut(&Path) -> Result<String>> NamedFiles for F {
    fn text(&mut self, path: &Path) -> Result<String> {
        self(path)
    }
}

/// Opens no file: for experiments that name only logs.
///
/// # Errors
///
/// Always [`ErrorKind::NotFound`].
pub fn no_files(_: &Path) -> Result<String> {
    Err(ErrorKind::NotFound.into())
}

/// Returns the bytes of a mesh, at most one more than allowed.
///
/// - `urdf`: the file that names the mesh; `name`: a path relative to it, or `package://NAME/path` with the folder NAME
///   beside or above the URDF.
pub(super) fn mesh(files: &mut dyn NamedFiles, urdf: &Path, name: &str) -> Result<Vec<u8>> {
    let mut bytes = |path: &Path| files.bytes(path, LARGEST_MESH + 1);
    let folder = urdf.parent().unwrap_or(Path::new("")).to_owned();
    let Some(inside) = name.strip_prefix("package://") else {
        let path = name.strip_prefix("file://").unwrap_or(name);
        return bytes(&folder.join(path));
    };
    let mut at = folder;
    for _ in 0..=LEVELS {
        match bytes(&at.join(inside)) {
            Err(error) if error.kind() == ErrorKind::NotFound => at = above(&at),
            found => return found,
        }
    }
    let package = inside.split('/').next().unwrap_or(inside);
    Err(Error::new(
        ErrorKind::NotFound,
        format!("no folder \"{package}\" beside or above the URDF has it"),
    ))
}

/// Returns the folder above another, also if that is above the folder of the experiment.
fn above(folder: &Path) -> PathBuf {
    match folder.components().next_back() {
        Some(Component::Normal(_)) => folder.parent().unwrap_or(folder).to_owned(),
        Some(Component::RootDir | Component::Prefix(_)) => folder.to_owned(),
        Some(Component::ParentDir | Component::CurDir) | None => folder.join(".."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct OneFile(&'static str);

    impl NamedFiles for OneFile {
        fn text(&mut self, _: &Path) -> Result<String> {
            Err(ErrorKind::NotFound.into())
        }

        fn bytes(&mut self, path: &Path, _: u64) -> Result<Vec<u8>> {
            if path == Path::new(self.0) {
                return Ok(vec![1]);
            }
            Err(ErrorKind::NotFound.into())
        }
    }

    #[test]
    fn meshes_are_found_beside_the_urdf_and_in_packages_above_it() {
        for (urdf, name, file) in [
            ("arm.urdf", "meshes/a.stl", "meshes/a.stl"),
            (
                "robots/arm.urdf",
                "../meshes/a.stl",
                "robots/../meshes/a.stl",
            ),
            ("arm.urdf", "file:///tmp/a.stl", "/tmp/a.stl"),
            (
                "ws/pkg/urdf/arm.urdf",
                "package://pkg/a.stl",
                "ws/pkg/a.stl",
            ),
            ("urdf/arm.urdf", "package://pkg/a.stl", "pkg/a.stl"),
            ("urdf/arm.urdf", "package://pkg/a.stl", "../../pkg/a.stl"),
            ("../urdf/arm.urdf", "package://pkg/a.stl", "../../pkg/a.stl"),
            ("/ws/pkg/arm.urdf", "package://pkg/a.stl", "/ws/pkg/a.stl"),
        ] {
            let found = mesh(&mut OneFile(file), Path::new(urdf), name);
            assert_eq!(found.unwrap(), [1], "{urdf} {name}");
        }
        let found = mesh(
            &mut OneFile("pkg/b.stl"),
            Path::new("arm.urdf"),
            "package://pkg/a.stl",
        );
        let found = found.unwrap_err().to_string();
        assert!(found.contains("no folder \"pkg\""), "{found}");
        let mut closure = |_: &Path| Ok(String::new());
        assert!(mesh(&mut closure, Path::new("arm.urdf"), "a.stl").is_err());
    }
}
