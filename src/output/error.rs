use std::io;
use std::path::PathBuf;

/// Why an output cannot be written, or must not be.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    #[error(
        "{}: expected a place for the output, found an input of this run, {}; nothing was changed: name another place",
        output.display(), input.display()
    )]
    IsInput { output: PathBuf, input: PathBuf },
    #[error("{} and {}: two outputs of this run would be one file; name another place for one of them", first.display(), second.display())]
    Twice { first: PathBuf, second: PathBuf },
    #[error("{}: exists already and is left as it is; name another place, or replace it with --force", path.display())]
    Exists { path: PathBuf },
    #[error("{}: is write-protected and is left as it is; name another place, or make it writable", path.display())]
    Protected { path: PathBuf },
    #[error("{}: a file stands where a folder should be; name another folder or move the file", path.display())]
    FileInTheWay { path: PathBuf },
    #[error("{}: expected a folder, found a device or a pipe; name a folder", path.display())]
    NotAFolder { path: PathBuf },
    #[error("{}: expected a file, found the name of a folder, which ends in a slash; leave the slash out", path.display())]
    FolderName { path: PathBuf },
    #[error("{}: a folder stands where this file should be written; name another place or move the folder", path.display())]
    FolderInTheWay { path: PathBuf },
    #[error("{}: expected a file, a pipe, a character device or - for stdout, found {found}; name a file", path.display())]
    NotAFile { path: PathBuf, found: &'static str },
    #[error("{}: cannot be written; name a place you may write to, or mend its permissions and free space", path.display())]
    NotWritable {
        path: PathBuf,
        #[source]
        cause: io::Error,
    },
    #[error(
        "{}: expected the state of a run, or no file, found another; this name belongs to the output: name another \
         output, or move the file", path.display()
    )]
    NotScratch { path: PathBuf },
    #[error("{}: another run is writing there; wait for its end, or name another place", path.display())]
    Busy { path: PathBuf },
}

pub(super) fn not_writable(path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> OutputError {
    let path = path.into();
    |cause| OutputError::NotWritable { path, cause }
}
