use super::layout::{self, HEADER_LIMIT, Head, Placed};
use super::{ArrayInfo, ArtefactError, BUFFER, Element, Hashed, Identity, Kind};
use serde_json::Value;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Writes one file beside its place and moves it there when it is whole.
///
/// Dropped before [`Writer::finish`], or after an error, it removes what it wrote and leaves what stood in the place
/// untouched. Killed, it leaves a file named `.<process id>-<n>.partial` behind, which nothing ever reads.
#[derive(Debug)]
pub struct Writer {
    // Before `partial`: an open file cannot be removed everywhere.
    output: BufWriter<Hashed<File>>,
    partial: Partial,
    /// As the caller named it.
    path: PathBuf,
    place: PathBuf,
    arrays: Vec<Placed>,
    /// The array being written and how many of its values are.
    current: usize,
    written: usize,
    failed: bool,
}

impl Writer {
    /// Writes the header. `header` is whatever the reader should find beside the arrays; `arrays` are written with
    /// [`Writer::append`] in this order.
    pub fn create(
        path: impl Into<PathBuf>,
        kind: Kind,
        identity: &Identity,
        header: &Value,
        arrays: &[ArrayInfo],
    ) -> Result<Self, ArtefactError> {
        let path = path.into();
        let undeclared = |expected: String, found| ArtefactError::Undeclared {
            path: path.clone(),
            expected,
            found,
        };
        let arrays = layout::place(arrays)
            .map_err(|found| undeclared("arrays of different names that fit into a file".into(), found))?;
        let head = Head {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            identity: identity.clone(),
            header: header.clone(),
            arrays,
        };
        let mut lines = kind.magic().into_bytes();
        lines.push(b'\n');
        let magic = lines.len();
        serde_json::to_writer(&mut lines, &head)
            .map_err(|cause| undeclared("a header that JSON can hold".into(), cause.to_string()))?;
        lines.push(b'\n');
        if (lines.len() - magic) as u64 > HEADER_LIMIT {
            let found = format!("{} bytes; write large tables as arrays", lines.len() - magic);
            return Err(undeclared(format!("a header of at most {HEADER_LIMIT} bytes"), found));
        }
        // JSON too deep to be read back must fail now, not after the run.
        Head::parse(&lines[magic..]).map_err(|found| undeclared("a header that can be read back".into(), found))?;
        let place = resolve(&path)?;
        let not_writable = not_writable(&path);
        let (file, partial) = Partial::create(&place).map_err(not_writable)?;
        let mut output = BufWriter::with_capacity(BUFFER, Hashed::new(file));
        output.write_all(&lines).map_err(not_writable)?;
        Ok(Self {
            output,
            partial,
            place,
            arrays: head.arrays,
            current: 0,
            written: 0,
            failed: false,
            path,
        })
    }

    /// Writes the next values of an array, from its first to its last in any number of calls. An array must be complete
    /// before the next one begins. After an error the file can no longer be finished.
    pub fn append<T: Element>(
        &mut self,
        array: &str,
        values: impl IntoIterator<Item = T>,
    ) -> Result<(), ArtefactError> {
        // Until all went well; a panic inside the iterator counts too.
        let failed_before = std::mem::replace(&mut self.failed, true);
        self.begin::<T>(array)?;
        let count = self.count();
        for value in values {
            if self.written == count {
                return Err(self.undeclared(format!("{count} values of `{array}`"), "more".into()));
            }
            value.write_le(&mut self.output).map_err(not_writable(&self.path))?;
            self.written += 1;
        }
        self.failed = failed_before;
        Ok(())
    }

    /// Writes the checksum, waits until the file is on the disk, and moves it to its place.
    pub fn finish(mut self) -> Result<(), ArtefactError> {
        self.skip_complete(None);
        if let Some(next) = self.arrays.get(self.current) {
            let expected = format!("{} values of `{}`", self.count(), next.info.name);
            return Err(self.undeclared(expected, format!("{}", self.written)));
        }
        if self.failed {
            return Err(self.undeclared("all values to be written".into(), "an earlier error".into()));
        }
        let not_writable = not_writable(&self.path);
        let hashed = self.output.into_inner().map_err(|e| not_writable(e.into_error()))?;
        let (mut file, checksum) = hashed.finish();
        file.write_all(&checksum)
            .and_then(|()| file.sync_all())
            .map_err(not_writable)?;
        drop(file);
        self.partial.move_to(&self.place).map_err(not_writable)?;
        sync_folder(&self.place).map_err(not_writable)
    }

    /// Moves on to this array if its turn has come.
    fn begin<T: Element>(&mut self, array: &str) -> Result<(), ArtefactError> {
        self.skip_complete(Some(array));
        match self.arrays.get(self.current) {
            Some(next) if next.info.name == array && next.info.element == T::TYPE => Ok(()),
            Some(next) => {
                let expected = format!(
                    "values {} to {} of `{}` as {}",
                    self.written,
                    self.count(),
                    next.info.name,
                    next.info.element
                );
                Err(self.undeclared(expected, format!("`{array}` as {}", T::TYPE)))
            }
            None => Err(self.undeclared("no further array".into(), format!("`{array}`"))),
        }
    }

    /// Passes the arrays that are complete, up to one of this name.
    fn skip_complete(&mut self, until: Option<&str>) {
        while let Some(array) = self.arrays.get(self.current)
            && Some(array.info.name.as_str()) != until
            && self.written == self.count()
        {
            self.current += 1;
            self.written = 0;
        }
    }

    /// Values of the array being written.
    fn count(&self) -> usize {
        let current = self.arrays.get(self.current);
        current.and_then(|array| array.info.count()).unwrap_or(0)
    }

    fn undeclared(&self, expected: String, found: String) -> ArtefactError {
        ArtefactError::Undeclared {
            path: self.path.clone(),
            expected,
            found,
        }
    }
}

fn not_writable(path: &Path) -> impl Fn(io::Error) -> ArtefactError + Copy + '_ {
    |cause| ArtefactError::NotWritable {
        path: path.to_owned(),
        cause,
    }
}

/// Where the file really goes: a link stays a link, and what is no file (`/dev/null`) is never replaced by one.
fn resolve(path: &Path) -> Result<PathBuf, ArtefactError> {
    let not_a_file = || ArtefactError::NotAFile { path: path.to_owned() };
    match fs::metadata(path) {
        Ok(there) if there.is_file() => fs::canonicalize(path).map_err(not_writable(path)),
        Ok(_) => Err(not_a_file()),
        Err(cause) if cause.kind() == io::ErrorKind::NotFound => {
            // A trailing separator would make the move fail after all the work.
            let name = path.file_name().ok_or_else(not_a_file)?;
            Ok(path.with_file_name(name))
        }
        Err(cause) => Err(not_writable(path)(cause)),
    }
}

/// A file on its way to its place; removed when dropped before it is there.
#[derive(Debug)]
struct Partial {
    path: PathBuf,
    moved: bool,
}

impl Partial {
    /// Beside its place, so that the move is one step on one file system.
    fn create(place: &Path) -> io::Result<(File, Self)> {
        // Keeps two writers of one process apart; the process id keeps processes apart.
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let mut name = place.file_name().unwrap_or_default().to_owned();
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        name.push(format!(".{}-{n}.partial", std::process::id()));
        let path = place.with_file_name(name);
        let file = File::create(&path)?;
        Ok((file, Self { path, moved: false }))
    }

    fn move_to(mut self, place: &Path) -> io::Result<()> {
        fs::rename(&self.path, place)?;
        self.moved = true;
        Ok(())
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        if !self.moved {
            // Nothing can be told from here, and a leftover does no harm.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Makes the move itself last through a power cut.
#[cfg(unix)]
fn sync_folder(place: &Path) -> io::Result<()> {
    use io::ErrorKind::{InvalidInput, PermissionDenied, Unsupported};
    let folder = match place.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    match File::open(folder).and_then(|folder| folder.sync_all()) {
        // The file is whole and in its place. Not every file system can do more, nor may a folder always be opened.
        Err(cause) if matches!(cause.kind(), InvalidInput | PermissionDenied | Unsupported) => Ok(()),
        other => other,
    }
}

/// Folders cannot be opened as files here; the file itself is on the disk.
#[cfg(not(unix))]
fn sync_folder(_place: &Path) -> io::Result<()> {
    Ok(())
}
