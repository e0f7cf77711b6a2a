use super::OutputError;
use super::error::not_writable;
use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};

/// Where an output goes, every link followed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Destination {
    typed: PathBuf,
    pub(super) target: Target,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Target {
    Stdout,
    /// A character device or a pipe: opened and written to.
    Stream,
    /// A file, there or not yet.
    File(PathBuf),
}

/// Links that lead from one to the next, as many as Linux follows.
const MOST_LINKS: usize = 40;

impl Destination {
    /// # Errors
    /// A folder, a block device or a socket; a path that leads through a file.
    pub fn find(path: &Path) -> Result<Self, OutputError> {
        Ok(Self {
            typed: path.to_owned(),
            target: target(path)?,
        })
    }

    /// As it was typed.
    pub fn path(&self) -> &Path {
        &self.typed
    }

    pub fn is_stdout(&self) -> bool {
        self.target == Target::Stdout
    }

    /// A file, beside which others can stand: no stream.
    pub fn is_file(&self) -> bool {
        matches!(self.target, Target::File(_))
    }

    /// Whether a file is there already.
    pub(super) fn exists(&self) -> bool {
        match &self.target {
            Target::File(file) => file.exists(),
            Target::Stdout | Target::Stream => false,
        }
    }

    /// What tells whether another path leads to the same file.
    pub(super) fn identity(&self) -> FileIdentity {
        match &self.target {
            Target::Stdout => FileIdentity {
                path: None,
                inode: stdout().filter(Metadata::is_file).and_then(|there| inode(&there)),
            },
            Target::Stream => FileIdentity::of(&self.typed),
            Target::File(file) => FileIdentity::of(file),
        }
    }
}

/// The file beside another whose name has this ending more.
pub fn beside(output: &Path, ending: &str) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(ending);
    name.into()
}

fn target(path: &Path) -> Result<Target, OutputError> {
    if path == Path::new("-") {
        return Ok(Target::Stdout);
    }
    let not_a_file = |found| OutputError::NotAFile {
        path: path.to_owned(),
        found,
    };
    let ends_in_slash = path
        .as_os_str()
        .as_encoded_bytes()
        .last()
        .is_some_and(|byte| std::path::is_separator(char::from(*byte)));
    if ends_in_slash && !path.is_dir() {
        return Err(OutputError::FolderName { path: path.to_owned() });
    }
    let there = match fs::metadata(path) {
        Ok(there) => there,
        Err(cause) if cause.kind() == io::ErrorKind::NotFound => {
            let end = behind_links(path);
            let name = end.file_name().ok_or_else(|| not_a_file("no name"))?;
            return Ok(Target::File(end.with_file_name(name)));
        }
        Err(cause) => return Err(not_writable(path)(cause)),
    };
    if there.is_dir() {
        Err(OutputError::FolderInTheWay { path: path.to_owned() })
    } else if inode(&there).is_some() && inode(&there) == stdout().and_then(|stdout| inode(&stdout)) {
        // /dev/stdout, or the file that the shell sends stdout to: replacing it would tear the two apart.
        Ok(Target::Stdout)
    } else if there.is_file() {
        fs::canonicalize(path).map(Target::File).map_err(not_writable(path))
    } else if is_stream(&there) {
        Ok(Target::Stream)
    } else {
        Err(not_a_file("a block device or a socket"))
    }
}

/// Where links lead whose end is missing.
fn behind_links(path: &Path) -> PathBuf {
    let mut end = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&end) {
            Ok(next) => end = end.parent().unwrap_or(Path::new("")).join(next),
            Err(_) => break,
        }
    }
    end
}

/// What makes two paths one file.
#[derive(Debug)]
pub(super) struct FileIdentity {
    path: Option<PathBuf>,
    /// Device and inode, which hard links share.
    inode: Option<(u64, u64)>,
}

impl FileIdentity {
    pub(super) fn of(path: &Path) -> Self {
        let end = behind_links(path);
        let folder = match end.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        // Of a file that is not there yet, the folder is.
        let missing = || Some(fs::canonicalize(folder).ok()?.join(end.file_name()?));
        Self {
            path: fs::canonicalize(path).ok().or_else(missing),
            inode: fs::metadata(path).ok().and_then(|there| inode(&there)),
        }
    }

    /// Of a file that is open.
    pub(super) fn of_open(there: &Metadata) -> Self {
        Self {
            path: None,
            inode: inode(there),
        }
    }

    pub(super) fn is(&self, other: &Self) -> bool {
        (self.path.is_some() && self.path == other.path) || (self.inode.is_some() && self.inode == other.inode)
    }
}

#[cfg(unix)]
fn inode(there: &Metadata) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    Some((there.dev(), there.ino()))
}

/// Only the path tells here.
#[cfg(not(unix))]
fn inode(_there: &Metadata) -> Option<(u64, u64)> {
    None
}

#[cfg(unix)]
fn is_stream(there: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    let kind = there.file_type();
    kind.is_fifo() || kind.is_char_device()
}

#[cfg(not(unix))]
fn is_stream(_there: &Metadata) -> bool {
    false
}

/// What stdout is.
#[cfg(unix)]
fn stdout() -> Option<Metadata> {
    use std::os::fd::AsFd;
    let stdout = io::stdout().as_fd().try_clone_to_owned().ok()?;
    fs::File::from(stdout).metadata().ok()
}

#[cfg(not(unix))]
fn stdout() -> Option<Metadata> {
    None
}
