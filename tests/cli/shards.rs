//! Traces dealt over machines and put together again, as typed: the merge is the single run bit for bit, and whatever
//! does not belong together is refused by name, its files untouched.

use specval::run::YarnArtefact;
use specval::transport::Fraction;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;
use tempfile::TempDir;

use crate::command::{command, specval};
use crate::runs::refusal;

/// A study of 16 batches that runs in a fraction of a second.
const STUDY: &str = "
[spectrum]
wavelengths_nm = [450, 600]
[trace]
batches = 16
paths_bssrdf = 64
paths_direct = 640
zenith_cells = 3
azimuth_cells = 8
exit_azimuth_cells = 8
exit_theta_cells = 3
exit_phi_cells = 4
bssrdf_azimuth_cells = 4
bssrdf_exit_theta_cells = 2
bssrdf_exit_phi_cells = 4
z_cells = 4
tilts = 3
";

/// What a run that succeeds prints; it says nothing on stderr.
fn succeed(folder: &Path, arguments: &[&str]) -> String {
    let output = specval(folder, arguments);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        output.status.success() && message.is_empty(),
        "{arguments:?}: {message}"
    );
    String::from_utf8(output.stdout).unwrap()
}

/// A run that refuses its input, says all the words, and leaves every file of the folder as it was.
fn refuse(folder: &Path, arguments: &[&str], words: &[&str]) {
    let before = contents(folder);
    let message = refusal(folder, arguments);
    for word in words {
        assert!(message.contains(word), "{message:?} does not say {word:?}");
    }
    assert!(contents(folder) == before, "{arguments:?} changed the folder");
}

/// Names and contents of a folder's files, but for the empty lock and the begun file that a killed run leaves and any
/// other takes away.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| {
            let entry = entry.unwrap();
            (
                entry.file_name().into_string().unwrap(),
                fs::read(entry.path()).unwrap(),
            )
        })
        .collect();
    files.retain(|(name, _): &(String, _)| !name.ends_with(".state.lock") && !name.ends_with(".partial"));
    files.sort();
    files
}

/// A folder with `study.toml`.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("study.toml"), STUDY).unwrap();
    folder
}

/// Traces all shards of N on so many threads and gives their names.
fn shards(folder: &Path, of: usize, threads: &str) -> Vec<String> {
    (1..=of)
        .map(|k| {
            let (name, shard) = (format!("{k}of{of}.shard"), format!("{k}/{of}"));
            let trace = [
                "trace",
                "study.toml",
                "--threads",
                threads,
                "--shard",
                &shard,
                "--out",
                &name,
            ];
            succeed(folder, &trace);
            name
        })
        .collect()
}

fn merge(folder: &Path, out: &str, shards: &[impl AsRef<str>]) -> String {
    let mut arguments = vec!["merge", "--force", "--out", out];
    arguments.extend(shards.iter().map(AsRef::as_ref));
    succeed(folder, &arguments)
}

#[test]
fn merged_shards_are_the_single_run_bit_for_bit() {
    let folder = folder();
    let folder = folder.path();
    let printed = succeed(folder, &["trace", "study.toml", "--out", "one.yarn", "--threads", "3"]);
    let one = fs::read(folder.join("one.yarn")).unwrap();
    succeed(
        folder,
        &["trace", "study.toml", "--out", "one.yarn", "--threads", "1", "--force"],
    );
    assert!(fs::read(folder.join("one.yarn")).unwrap() == one, "threads");

    let mut three = shards(folder, 3, "1");
    let mut sixteen = shards(folder, 16, "3");
    let before: Vec<_> = contents(folder);
    assert_eq!(merge(folder, "merged.yarn", &three), printed);
    assert!(fs::read(folder.join("merged.yarn")).unwrap() == one, "3 shards");
    three.rotate_left(1);
    merge(folder, "merged.yarn", &three);
    assert!(
        fs::read(folder.join("merged.yarn")).unwrap() == one,
        "3 shards in another order"
    );
    sixteen.reverse();
    merge(folder, "merged.yarn", &sixteen);
    assert!(fs::read(folder.join("merged.yarn")).unwrap() == one, "16 shards");

    // Batches 0 to 4 from three shards, the others from sixteen.
    let mut mixed = vec!["1of3.shard".to_owned()];
    mixed.extend((6..=16).map(|k| format!("{k}of16.shard")));
    merge(folder, "merged.yarn", &mixed);
    assert!(
        fs::read(folder.join("merged.yarn")).unwrap() == one,
        "of different sizes"
    );

    fs::remove_file(folder.join("merged.yarn")).unwrap();
    assert!(contents(folder) == before, "merging changed its inputs");
}

#[test]
fn incomplete_or_overlapping_sets_of_shards_are_refused_by_name() {
    let folder = folder();
    let folder = folder.path();
    let [a, b, c] = &shards(folder, 3, "1")[..] else {
        unreachable!()
    };
    shards(folder, 4, "1");
    refuse(
        folder,
        &["merge", "--out", "m", a, c],
        &["missing", "shard 2/3", "batches 5 to 9"],
    );
    refuse(
        folder,
        &["merge", "--out", "m", b],
        &["missing", "shard 1/3", "shard 3/3"],
    );
    refuse(
        folder,
        &["merge", "--out", "m", a, b, a, c],
        &["1of3.shard and 1of3.shard", "batches 0 to 4"],
    );
    fs::copy(folder.join(b), folder.join("copy")).unwrap();
    refuse(
        folder,
        &["merge", "--out", "m", a, b, "copy", c],
        &["2of3.shard", "copy", "batches 5 to 9"],
    );
    refuse(
        folder,
        &["merge", "--out", "m", a, b, "4of4.shard", c],
        &["3of3.shard and 4of4.shard", "batches 12 to 15", "3/3", "4/4"],
    );
    refuse(
        folder,
        &["merge", "--out", a, a, b, c],
        &["input of this run", "1of3.shard", "another place"],
    );
    refuse(
        folder,
        &["merge", "--out", &format!("./{c}"), a, b, c],
        &["input of this run", "3of3.shard"],
    );
    refuse(
        folder,
        &["merge", "--out", "no/such/folder/m", a, b, c],
        &["no/such/folder"],
    );
    refuse(folder, &["merge", "--out", "m"], &["SHARD"]);
}

#[cfg(unix)]
#[test]
fn a_link_to_a_shard_is_no_place_for_the_artefact() {
    let folder = folder();
    let folder = folder.path();
    let names = shards(folder, 1, "1");
    std::os::unix::fs::symlink(folder.join(&names[0]), folder.join("link")).unwrap();
    refuse(
        folder,
        &["merge", "--out", "link", &names[0]],
        &["link", "1of1.shard", "input"],
    );
}

#[test]
fn foreign_and_unsound_files_are_refused_by_name() {
    let folder = folder();
    let folder = folder.path();
    let [a, b] = &shards(folder, 2, "1")[..] else {
        unreachable!()
    };
    let trace = ["trace", "study.toml", "--shard", "2/2"];

    succeed(folder, &[&trace[..], &["--out", "seed", "--seed", "7"]].concat());
    refuse(
        folder,
        &["merge", "--out", "m", a, "seed"],
        &["seed: a shard of another run", "`seed`: expected 1, found 7"],
    );
    succeed(folder, &[&trace[..], &["--out", "paths", "--paths", "700"]].concat());
    refuse(
        folder,
        &["merge", "--out", "m", a, "paths"],
        &["paths: ", "`study.trace.paths_bssrdf`", "700"],
    );
    let other = STUDY.to_owned() + "[medium]\nkappa_peak = 0.003\n";
    fs::write(folder.join("other.toml"), other).unwrap();
    succeed(folder, &["trace", "other.toml", "--shard", "2/2", "--out", "dye"]);
    refuse(
        folder,
        &["merge", "--out", "m", a, "dye"],
        &["dye: ", "`study.medium.kappa_peak`", "0.003"],
    );

    let whole = fs::read(folder.join(b)).unwrap();
    fs::write(folder.join("cut"), &whole[..whole.len() - 9]).unwrap();
    refuse(
        folder,
        &["merge", "--out", "m", a, "cut"],
        &["cut: ", "bytes", "a shard"],
    );
    let mut changed = whole.clone();
    let middle = changed.len() / 2;
    changed[middle] ^= 1;
    fs::write(folder.join("changed"), changed).unwrap();
    refuse(
        folder,
        &["merge", "--out", "m", a, "changed"],
        &["changed: ", "checksum"],
    );
    refuse(
        folder,
        &["merge", "--out", "m", a, "study.toml"],
        &["study.toml: ", "a shard"],
    );
    refuse(
        folder,
        &["merge", "--out", "m", a, "none"],
        &["none: ", "cannot be read"],
    );
    refuse(folder, &["merge", "--out", "m", a, "."], &[".: ", "a folder"]);
    succeed(folder, &["trace", "study.toml", "--out", "yarn"]);
    refuse(
        folder,
        &["merge", "--out", "m", a, "yarn"],
        &["yarn: ", "a shard", "the artefact"],
    );
}

#[test]
fn impossible_shard_numbers_are_refused() {
    let folder = folder();
    let folder = folder.path();
    let shard = |of: &str, words: &[&str]| {
        refuse(folder, &["trace", "study.toml", "--out", "s", "--shard", of], words);
    };
    for wrong in ["0/3", "4/3", "3", "a/b", "1/0"] {
        shard(wrong, &["--shard", wrong, "K/N"]);
    }
    shard("3/17", &["3/17", "16", "trace.batches"]);
}

/// A longer run of the same study, so that it can be killed on its way.
fn long_folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let long = STUDY.replace("640", "64000").replace("= 64\n", "= 16000\n");
    fs::write(folder.path().join("study.toml"), long).unwrap();
    folder
}

const TRACE: [&str; 4] = ["trace", "study.toml", "--out", "yarn"];
const STATE: &str = "yarn.state";

/// Runs until there is a state, and no further.
fn interrupt(folder: &Path, arguments: &[&str]) {
    kill_when(folder, arguments, || folder.join(STATE).exists());
    assert!(folder.join(STATE).exists() && !folder.join("yarn").exists());
}

/// Goes on until the state has more batches than this, and no further.
fn interrupt_again(folder: &Path, arguments: &[&str], batches_before: u64) {
    let resume = [arguments, &["--resume"]].concat();
    kill_when(folder, &resume, || batches(folder) > batches_before);
}

fn kill_when(folder: &Path, arguments: &[&str], it_is_time: impl Fn() -> bool) {
    let mut child = command(folder, &[arguments, &["--checkpoint", "0s"]].concat())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while !it_is_time() {
        assert!(child.try_wait().unwrap().is_none(), "{arguments:?} ended too soon");
        std::thread::sleep(Duration::from_millis(2));
    }
    // SIGKILL: nothing of the program runs any more.
    child.kill().unwrap();
    child.wait().unwrap();
}

/// Batches of the state.
fn batches(folder: &Path) -> u64 {
    let file = specval::artefact::Reader::open(folder.join(STATE), specval::artefact::ArtefactKind::State).unwrap();
    file.header()["batches"].as_u64().unwrap()
}

#[test]
fn killed_traces_resume_to_the_same_bytes() {
    let folder = long_folder();
    let folder = folder.path();
    let printed = succeed(folder, &TRACE);
    let whole = fs::read(folder.join("yarn")).unwrap();
    fs::remove_file(folder.join("yarn")).unwrap();
    assert!(!folder.join(STATE).exists());
    interrupt(folder, &TRACE);
    let first = batches(folder);
    interrupt_again(folder, &TRACE, first);
    let resume = [&TRACE[..], &["--resume", "--threads", "1", "--quiet"]].concat();
    assert_eq!(succeed(folder, &resume), printed);
    assert!(fs::read(folder.join("yarn")).unwrap() == whole);
    let left: Vec<String> = contents(folder).into_iter().map(|file| file.0).collect();
    assert_eq!(left, ["study.toml", "yarn"]);
}

#[test]
fn states_of_other_runs_are_refused_and_left_alone() {
    let folder = long_folder();
    let folder = folder.path();
    interrupt(folder, &TRACE);
    let resume = [&TRACE[..], &["--resume"]].concat();
    let with = |more: &[&str], words: &[&str]| refuse(folder, &[&resume[..], more].concat(), words);
    with(&["--seed", "9"], &["yarn.state", "`seed`", "9"]);
    with(
        &["--paths", "999"],
        &["yarn.state", "`study.trace.paths_direct`", "999"],
    );
    let state = fs::read(folder.join(STATE)).unwrap();
    let middle = state.len() / 2;
    let mut changed = state.clone();
    changed[middle] ^= 4;
    for damaged in [&state[..middle], &changed, b""] {
        fs::write(folder.join(STATE), damaged).unwrap();
        with(&[], &["yarn.state"]);
    }
    fs::write(folder.join(STATE), fs::read(folder.join("study.toml")).unwrap()).unwrap();
    with(&[], &["yarn.state", "state of a run"]);
}

#[test]
fn a_trace_stops_at_the_precision_of_the_scattered_light() {
    let folder = folder();
    let folder = folder.path();
    let run = [&TRACE[..], &["--until", "abs 0.01"]].concat();
    let text = succeed(folder, &run);
    assert!(text.contains("stopped by precision"), "{text}");
    let yarn = YarnArtefact::read(&folder.join("yarn")).unwrap();
    let largest = yarn
        .energy
        .iter()
        .map(|row| row[Fraction::Scattered].se)
        .fold(0.0, f64::max);
    assert!(
        yarn.batches >= 8 && largest > 0.0 && largest <= 0.01,
        "{} {largest}",
        yarn.batches
    );
    // With the paths typed they are the most that are traced.
    let run = [
        &TRACE[..],
        &["--until", "rel 1e-9 scattered", "--paths", "640", "--force"],
    ]
    .concat();
    assert!(succeed(folder, &run).contains("stopped by paths"));
    assert_eq!(YarnArtefact::read(&folder.join("yarn")).unwrap().batches, 16);
    refuse(
        folder,
        &[&TRACE[..], &["--until", "rel 1% curves"]].concat(),
        &["--until", "scattered", "curves"],
    );
}

#[test]
fn states_beyond_the_stop_rule_are_refused() {
    let folder = folder();
    let folder = folder.path();
    let until = |precision: &'static str| [&TRACE[..], &["--until", precision]].concat();
    interrupt(folder, &until("abs 1e-5"));
    interrupt_again(folder, &until("abs 1e-5"), 20);
    let found = batches(folder).to_string();
    let resume = |arguments: &[&str], most: &str| {
        let arguments = [arguments, &["--resume", "--quiet"]].concat();
        refuse(folder, &arguments, &["yarn.state", most, &found]);
    };
    resume(&TRACE, "at most 16 batches");
    resume(&until("abs 0.5"), "at most 8 batches");
}

#[test]
fn shards_do_not_stop_half_way() {
    let folder = folder();
    for option in [&["--until", "rel 1%"][..], &["--max-time", "1s"], &["--resume"]] {
        let shard = [&TRACE[..], &["--shard", "1/2"], option].concat();
        refuse(folder.path(), &shard, &["--shard", option[0]]);
    }
}
