use super::OutputError;
use super::error::not_writable;
use super::place::{Destination, FileIdentity, Target};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Finds out before any work whether these outputs can be written and may be; leaves nothing behind. `may_replace` is
/// asked for each that exists.
///
/// # Errors
/// An output that is one of the inputs, by path or as a hard link, or another output; one that exists and may not be
/// replaced; one that cannot be written.
pub fn prepare(
    outputs: &[&Path],
    inputs: &[PathBuf],
    may_replace: &dyn Fn(&Destination) -> bool,
) -> Result<Vec<Destination>, OutputError> {
    let places: Vec<Destination> = outputs
        .iter()
        .map(|path| Destination::find(path))
        .collect::<Result<_, _>>()?;
    let identities: Vec<FileIdentity> = places.iter().map(Destination::identity).collect();
    let inputs: Vec<(&PathBuf, FileIdentity)> = inputs.iter().map(|path| (path, FileIdentity::of(path))).collect();
    for (i, (place, identity)) in places.iter().zip(&identities).enumerate() {
        if let Some((input, _)) = inputs.iter().find(|(_, input)| input.is(identity)) {
            return Err(OutputError::IsInput {
                output: place.path().to_owned(),
                input: input.to_path_buf(),
            });
        }
        let same = |j: &usize| identities[*j].is(identity) || (place.is_stdout() && places[*j].is_stdout());
        if let Some(other) = (0..i).find(same) {
            return Err(OutputError::Twice {
                first: places[other].path().to_owned(),
                second: place.path().to_owned(),
            });
        }
    }
    for place in &places {
        if place.exists() && !may_replace(place) {
            return Err(OutputError::Exists {
                path: place.path().to_owned(),
            });
        }
        if place.is_file() {
            // Dropped again at once, which removes it.
            Output::create(place)?;
        }
    }
    Ok(places)
}

/// Makes a folder where it is missing.
pub fn make_folder(path: &Path) -> Result<(), OutputError> {
    if let Some(file) = path.ancestors().find(|p| p.is_file()) {
        return Err(OutputError::FileInTheWay { path: file.to_owned() });
    }
    if let Some(other) = path.ancestors().find(|p| p.exists() && !p.is_dir()) {
        return Err(OutputError::NotAFolder { path: other.to_owned() });
    }
    fs::create_dir_all(path).map_err(not_writable(path))
}

/// Writes one output: a file whole or not at all.
pub fn write_whole(place: &Destination, bytes: &[u8]) -> Result<(), OutputError> {
    write_all(&[(place, bytes)])
}

/// Writes all files of a set or none: the first is moved to its place when the last is whole on the disk.
pub fn write_all(set: &[(&Destination, &[u8])]) -> Result<(), OutputError> {
    let mut outputs = Vec::with_capacity(set.len());
    // What goes to a stream cannot be taken back, so it comes when all files are known to fit.
    let (files, streams): (Vec<_>, Vec<_>) = set.iter().partition(|(place, _)| place.is_file());
    for (place, bytes) in files.into_iter().chain(streams) {
        let mut output = Output::create(place)?;
        output
            .write_all(bytes)
            .and_then(|()| output.settle())
            .map_err(not_writable(place.path()))?;
        outputs.push(output);
    }
    outputs.into_iter().try_for_each(Output::publish)
}

/// Removes a file, if it is there.
pub fn remove(path: &Path) -> Result<(), OutputError> {
    match fs::remove_file(path) {
        Err(cause) if cause.kind() != io::ErrorKind::NotFound => Err(not_writable(path)(cause)),
        _ => Ok(()),
    }
}

/// An output that is being written.
///
/// A file is written beside its place. Dropped before [`Output::finish`], it is removed and what stood in the place is
/// untouched. A kill leaves it behind, named `NAME.<process id>-<n>.partial`, which nothing ever reads.
#[derive(Debug)]
pub struct Output {
    typed: PathBuf,
    sink: Sink,
}

#[derive(Debug)]
enum Sink {
    Stdout(io::Stdout),
    Stream(File),
    // The open file comes first: it cannot be removed everywhere.
    Staged(File, Partial),
}

impl Output {
    pub fn create(place: &Destination) -> Result<Self, OutputError> {
        let typed = place.path().to_owned();
        let sink = match &place.target {
            Target::Stdout => Sink::Stdout(io::stdout()),
            Target::Stream => {
                let opened = OpenOptions::new().write(true).open(&typed);
                Sink::Stream(opened.map_err(not_writable(&typed))?)
            }
            Target::File(file) => {
                if fs::metadata(file).is_ok_and(|there| there.permissions().readonly()) {
                    return Err(OutputError::Protected { path: typed });
                }
                let (file, partial) = Partial::create(file).map_err(not_writable(&typed))?;
                Sink::Staged(file, partial)
            }
        };
        Ok(Self { typed, sink })
    }

    /// Waits until everything is on the disk, and moves a file to its place.
    pub fn finish(mut self) -> Result<(), OutputError> {
        self.settle().map_err(not_writable(&self.typed))?;
        self.publish()
    }

    fn settle(&mut self) -> io::Result<()> {
        match &mut self.sink {
            Sink::Staged(file, _) => file.sync_all(),
            _ => self.flush(),
        }
    }

    fn publish(self) -> Result<(), OutputError> {
        match self.sink {
            Sink::Staged(file, partial) => {
                drop(file);
                partial.publish().map_err(not_writable(self.typed))
            }
            Sink::Stdout(_) | Sink::Stream(_) => Ok(()),
        }
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.sink {
            Sink::Stdout(stdout) => stdout.write(bytes),
            Sink::Stream(file) | Sink::Staged(file, _) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.sink {
            Sink::Stdout(stdout) => stdout.flush(),
            Sink::Stream(file) | Sink::Staged(file, _) => file.flush(),
        }
    }
}

/// A file on its way to its place; removed when dropped before it is there.
#[derive(Debug)]
struct Partial {
    path: PathBuf,
    place: PathBuf,
    moved: bool,
}

impl Partial {
    /// Beside its place, so that the move is one step on one file system.
    fn create(place: &Path) -> io::Result<(File, Self)> {
        // Keeps two outputs of one process apart; the process id keeps processes apart.
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let mut name = place.file_name().unwrap_or_default().to_owned();
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        name.push(format!(".{}-{n}.partial", std::process::id()));
        let path = place.with_file_name(name);
        let file = File::create_new(&path)?;
        let place = place.to_owned();
        Ok((
            file,
            Self {
                path,
                place,
                moved: false,
            },
        ))
    }

    fn publish(mut self) -> io::Result<()> {
        if let Ok(there) = fs::metadata(&self.place) {
            fs::set_permissions(&self.path, there.permissions())?;
        }
        fs::rename(&self.path, &self.place)?;
        self.moved = true;
        sync_folder(&self.place)
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

/// Removes what killed runs left of this file: its name, process id and number, `.partial`.
pub(super) fn remove_leftovers(path: &Path) -> Result<(), OutputError> {
    let own = path.file_name().unwrap_or_default().as_encoded_bytes();
    let is_number = |digits: &[u8]| !digits.is_empty() && digits.iter().all(u8::is_ascii_digit);
    let is_leftover = |name: &[u8]| {
        let numbers = name
            .strip_prefix(own)
            .and_then(|rest| rest.strip_prefix(b".")?.strip_suffix(b".partial"));
        let mut numbers = numbers.unwrap_or_default().split(|byte| *byte == b'-');
        let numbers = [numbers.next(), numbers.next(), numbers.next()];
        matches!(numbers, [Some(process), Some(n), None] if is_number(process) && is_number(n))
    };
    for entry in fs::read_dir(folder_of(path)).into_iter().flatten().flatten() {
        if is_leftover(entry.file_name().as_encoded_bytes()) {
            remove(&entry.path())?;
        }
    }
    Ok(())
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Makes the move itself last through a power cut.
#[cfg(unix)]
fn sync_folder(place: &Path) -> io::Result<()> {
    use io::ErrorKind::{InvalidInput, PermissionDenied, Unsupported};
    match File::open(folder_of(place)).and_then(|folder| folder.sync_all()) {
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
