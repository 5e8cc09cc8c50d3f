//! Where the files of an experiment come from.

use std::fs::File;
use std::io::{Read, Result as IoResult};
use std::path::Path;

use super::bag::of_bag;
use super::error::SessionError;
use super::switch::finish;
use crate::log::{Input, LogFile};

/// Opens the files that an experiment names.
///
/// Paths are those of the experiment file, put behind the folder of the session if it has one. Every
/// closure from a path to an input is one.
pub trait Files: Send + Sync {
    /// Opens a log at its beginning; called as often as it is read.
    ///
    /// # Errors
    ///
    /// What keeps it from being opened.
    fn open(&self, path: &Path) -> IoResult<Box<dyn Input>>;

    /// Returns a text file.
    ///
    /// # Errors
    ///
    /// What keeps it from being read.
    fn text(&self, path: &Path) -> IoResult<String> {
        let mut text = String::new();
        self.open(path)?.read_to_string(&mut text)?;
        Ok(text)
    }

    /// Prepares a folder whose results are about to be read: puts in their places those that a
    /// killed run left half there. Nothing has to be done where no run is killed.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if that fails.
    fn settle(&self, _folder: &Path) -> Result<(), SessionError> {
        Ok(())
    }
}

impl<F: Fn(&Path) -> IoResult<Box<dyn Input>> + Send + Sync> Files for F {
    fn open(&self, path: &Path) -> IoResult<Box<dyn Input>> {
        self(path)
    }
}

/// Files of the file system; a folder in the place of a log is a bag of ROS 2.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl Files for Disk {
    fn open(&self, path: &Path) -> IoResult<Box<dyn Input>> {
        if path.is_dir() {
            return Ok(Box::new(File::open(of_bag(path)?)?));
        }
        Ok(Box::new(LogFile::new(File::open(path)?, path)))
    }

    fn text(&self, path: &Path) -> IoResult<String> {
        std::fs::read_to_string(path)
    }

    fn settle(&self, folder: &Path) -> Result<(), SessionError> {
        finish(folder)
    }
}

/// Returns a text file.
///
/// # Errors
///
/// [`SessionError::Unreadable`] with its name.
pub(super) fn read_text(files: &dyn Files, path: &Path) -> Result<String, SessionError> {
    files.text(path).map_err(|source| SessionError::Unreadable {
        file: path.display().to_string(),
        source,
    })
}
