use super::{NamedFile, ReportError};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A folder known to be writable. Made before a simulation starts, so that a bad path fails in the first second.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
}

impl OutputFolder {
    /// Makes the folder where it is missing and tries to write in it.
    pub fn prepare(path: impl Into<PathBuf>) -> Result<Self, ReportError> {
        let path = path.into();
        if let Some(file) = path.ancestors().find(|p| p.is_file()) {
            return Err(ReportError::FileInTheWay { path: file.to_owned() });
        }
        fs::create_dir_all(&path).map_err(not_writable(&path))?;
        let probe = partial(&path, "probe");
        fs::write(&probe, b"")
            .and_then(|()| fs::remove_file(&probe))
            .map_err(not_writable(&path))?;
        Ok(Self { path })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes all files beside their places first and then moves them there, so no reader ever meets half a file and a
    /// full disk leaves the earlier report as it was.
    pub fn write(&self, files: &[NamedFile]) -> Result<(), ReportError> {
        for file in files {
            let path = self.path.join(&file.name);
            if path.is_dir() {
                return Err(ReportError::FolderInTheWay { path });
            }
        }
        let staging = Staging::new(partial(&self.path, "files"))?;
        for file in files {
            let path = staging.0.join(&file.name);
            fs::write(&path, &file.bytes).map_err(not_writable(&self.path.join(&file.name)))?;
        }
        for file in files {
            let path = self.path.join(&file.name);
            fs::rename(staging.0.join(&file.name), &path).map_err(not_writable(&path))?;
        }
        Ok(())
    }
}

/// Finds out before a long run whether [`write_whole`] will be able to; leaves nothing behind.
pub fn check_writable(path: &Path) -> Result<(), ReportError> {
    let staged = staged(path)?;
    fs::write(&staged, [])
        .and_then(|()| fs::remove_file(&staged))
        .map_err(not_writable(path))
}

/// Writes one file whole or not at all.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), ReportError> {
    let staged = staged(path)?;
    fs::write(&staged, bytes)
        .and_then(|()| fs::rename(&staged, path))
        .map_err(|cause| {
            // The staged file may not exist; the first error is the one to tell.
            let _ = fs::remove_file(&staged);
            not_writable(path)(cause)
        })
}

/// Where a file waits until it is whole: beside its place, so that the move is one step.
fn staged(path: &Path) -> Result<PathBuf, ReportError> {
    if path.is_dir() {
        return Err(ReportError::FolderInTheWay { path: path.to_owned() });
    }
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.partial", std::process::id()));
    Ok(path.with_file_name(name))
}

/// The folder files wait in; removed with whatever is left in it when dropped.
struct Staging(PathBuf);

impl Staging {
    fn new(path: PathBuf) -> Result<Self, ReportError> {
        fs::create_dir_all(&path).map_err(not_writable(&path))?;
        Ok(Self(path))
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        // Nothing can be told from here; an empty leftover folder does no harm.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A name inside the folder (the same file system, so that a move is one step) that no other process uses.
fn partial(folder: &Path, what: &str) -> PathBuf {
    folder.join(format!(".specval-{}-{what}.partial", std::process::id()))
}

fn not_writable(path: &Path) -> impl FnOnce(io::Error) -> ReportError + use<> {
    let path = path.to_owned();
    |cause| ReportError::NotWritable { path, cause }
}
