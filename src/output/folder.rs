use super::file::{make_folder, prepare, write_all};
use super::place::Destination;
use super::record::WrittenRecord;
use super::{Lock, OutputError, expect_scratch};
use std::path::{Path, PathBuf};

/// One file of a report, complete in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedFile {
    pub name: String,
    pub bytes: Vec<u8>,
}

/// What became of files of an earlier report that a new one does not have, by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EarlierFiles {
    pub removed: Vec<String>,
    pub left: Vec<String>,
}

/// A folder for a report, prepared before a simulation starts, so that a bad path fails in the first second. No second
/// run may write there while this lives.
#[derive(Debug)]
pub struct ReportFolder {
    path: PathBuf,
    force: bool,
    _lock: Lock,
}

impl ReportFolder {
    /// File in the folder that an interrupted run goes on from.
    pub const STATE: &str = "specval.state";
    const LOCK: &str = "specval.lock";

    /// Makes the folder where it is missing, and tries to write in it. `names` are the files that will be written;
    /// `force` lets them replace files that no earlier report wrote, or that were changed since.
    ///
    /// # Errors
    /// As [`prepare`]; another run that has the folder.
    pub fn prepare(path: &Path, names: &[String], inputs: &[PathBuf], force: bool) -> Result<Self, OutputError> {
        let earlier = WrittenRecord::read(path);
        let own = names.iter().map(String::as_str).chain([WrittenRecord::NAME]);
        let outputs: Vec<PathBuf> = own.map(|name| path.join(name)).collect();
        let scratch = [Self::STATE, Self::LOCK].map(|name| path.join(name));
        let is_own = |file: &Path| scratch.iter().any(|own| own == file) || owns(&earlier, path, file);
        let may_replace = |place: &Destination| force || is_own(place.path());
        let all: Vec<&Path> = outputs.iter().chain(&scratch).map(PathBuf::as_path).collect();
        make_folder(path)?;
        scratch.iter().try_for_each(|path| expect_scratch(path))?;
        prepare(&all, inputs, &may_replace)?;
        let owned: Vec<PathBuf> = outputs.iter().chain(&scratch).cloned().collect();
        let lock = Lock::take(&path.join(Self::LOCK), &owned)?;
        Ok(Self {
            path: path.to_owned(),
            force,
            _lock: lock,
        })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes all files or none, and removes what an earlier report wrote here that this one does not and nobody
    /// changed. Files of an earlier report that stay are named: those that were changed, and those of a name
    /// `is_of_report` that no record has.
    pub fn write(&self, files: &[NamedFile], is_of_report: impl Fn(&str) -> bool) -> Result<EarlierFiles, OutputError> {
        // Read again, now under the lock: the run that had it before may have ended since.
        let earlier = WrittenRecord::read(&self.path);
        let record = WrittenRecord::of(files.iter().map(|file| (file.name.as_str(), file.bytes.as_slice())));
        let places: Vec<Destination> = files
            .iter()
            .map(|file| Destination::find(&self.path.join(&file.name)))
            .collect::<Result<_, _>>()?;
        for place in &places {
            // A file that came while the run was on its way, or one that was not foreseen.
            if place.exists() && !self.force && !owns(&earlier, &self.path, place.path()) {
                return Err(OutputError::Exists {
                    path: place.path().to_owned(),
                });
            }
        }
        let record_at = Destination::find(&self.path.join(WrittenRecord::NAME))?;
        // Should a kill come between two files, both the old and the new ones are known.
        let both = earlier.and(&record).bytes();
        let mut set: Vec<(&Destination, &[u8])> = vec![(&record_at, &both)];
        set.extend(
            places
                .iter()
                .zip(files)
                .map(|(place, file)| (place, file.bytes.as_slice())),
        );
        write_all(&set)?;
        let removed = record.remove_others(&earlier, &self.path)?;
        write_all(&[(&record_at, &record.bytes())])?;
        let names = || record.names().chain([WrittenRecord::NAME, Self::STATE, Self::LOCK]);
        let there = std::fs::read_dir(&self.path).into_iter().flatten().flatten();
        let mut left: Vec<String> = there
            .filter_map(|entry| entry.file_name().into_string().ok())
            .filter(|name| is_of_report(name) || earlier.names().any(|known| known == name))
            .filter(|name| names().all(|own| own != name))
            .collect();
        left.sort();
        Ok(EarlierFiles { removed, left })
    }
}

fn owns(record: &WrittenRecord, folder: &Path, path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str());
    name.is_some_and(|name| record.owns(folder, name))
}
