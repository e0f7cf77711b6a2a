use super::OutputError;
use super::error::not_writable;
use super::file::{remove, remove_leftovers};
use super::place::FileIdentity;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Keeps a second run out while it lives. The system releases it when the process ends in whatever way, so a kill
/// leaves at most an empty file, which the next run takes over.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    _file: File,
}

/// Refuses what stands in the place of a lock or of a state and is none: a lock is empty, a state says so in its first
/// bytes.
pub fn expect_scratch(path: &Path) -> Result<(), OutputError> {
    let mut head = Vec::new();
    let read = |file: File| file.take(STATE_BEGINS.len() as u64).read_to_end(&mut head);
    match File::open(path).and_then(read) {
        Err(cause) if cause.kind() == io::ErrorKind::NotFound => Ok(()),
        Ok(_) if head.is_empty() || head == STATE_BEGINS => Ok(()),
        _ => Err(OutputError::NotScratch { path: path.to_owned() }),
    }
}

/// As the files of [`crate::artefact`] begin.
const STATE_BEGINS: &[u8] = b"specval-state ";

impl Lock {
    /// Takes the lock in this file, and removes what killed runs left of the `owned` ones half-written. A file system
    /// that knows no locks grants it to everyone.
    ///
    /// # Errors
    /// Another run has it.
    pub fn take(path: &Path, owned: &[PathBuf]) -> Result<Self, OutputError> {
        let lock = loop {
            let opened = OpenOptions::new().create(true).write(true).truncate(false).open(path);
            let file = opened.map_err(not_writable(path))?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(OutputError::Busy { path: path.to_owned() }),
                Err(TryLockError::Error(cause)) if cause.kind() == io::ErrorKind::Unsupported => {}
                Err(TryLockError::Error(cause)) => return Err(not_writable(path)(cause)),
            }
            // A run that ended meanwhile has removed the file that was opened.
            let there = file.metadata().map_err(not_writable(path))?;
            if FileIdentity::of(path).is(&FileIdentity::of_open(&there)) || cfg!(not(unix)) {
                break Self {
                    path: path.to_owned(),
                    _file: file,
                };
            }
        };
        owned.iter().try_for_each(|path| remove_leftovers(path))?;
        Ok(lock)
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // While it is still held; nothing can be told from here, and an empty file does no harm.
        let _ = remove(&self.path);
    }
}
