//! Runs that are killed and go on, and runs that stop by precision or time.

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Child, Output, Stdio};
use std::time::{Duration, Instant};

use crate::command::{command, specval};
use crate::runs::refusal;

/// About two seconds: 16 batches in four rounds. No sample uncertainty, so that curves have Monte Carlo errors alone.
const STUDY: &str = "
[spectrum]
wavelengths_nm = [450, 550, 650]
[trace]
batches = 16
paths_bssrdf = 160
paths_direct = 16000
zenith_cells = 2
azimuth_cells = 4
exit_azimuth_cells = 12
exit_theta_cells = 4
exit_phi_cells = 8
bssrdf_exit_theta_cells = 2
bssrdf_exit_phi_cells = 4
tilts = 4
[rig]
incidences_deg = [0, 30]
view_min_deg = -40
view_max_deg = 40
view_step_deg = 20
pixels_per_side = 8
[measured]
sample = \"cloth.csv\"
[sweep]
kappa_peak = []
volume_fraction = []
particle_diameter_nm = []
particle_index = []
";

const REPORT: [&str; 4] = ["report", "study.toml", "--out", "out"];
const STATE: &str = "out/specval.state";

/// A folder with the study and its sample.
fn scratch() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut sample = "theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b\n".to_owned();
    for theta_i in [0, 30] {
        for theta_v in [-40, -20, 0, 20, 40] {
            sample += &format!("{theta_i},{theta_v},0.3,0.004,0.03\n");
        }
    }
    fs::write(folder.path().join("cloth.csv"), sample).unwrap();
    fs::write(folder.path().join("study.toml"), STUDY).unwrap();
    folder
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let output = specval(folder, arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {message}");
    output
}

fn start(folder: &Path, arguments: &[&str]) -> Child {
    let mut command = command(folder, arguments);
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// SIGKILL: nothing of the program runs any more.
fn kill(mut child: Child) {
    child.kill().unwrap();
    child.wait().unwrap();
}

/// Runs until there is a state, and no further.
fn interrupt(folder: &Path, arguments: &[&str], state: &str) {
    let mut child = start(folder, &[arguments, &["--checkpoint", "0s"]].concat());
    while !folder.join(state).exists() {
        assert!(child.try_wait().unwrap().is_none(), "ended without a state");
        std::thread::sleep(Duration::from_millis(2));
    }
    kill(child);
    assert!(folder.join(state).exists());
}

/// Every file of the report, and with them that there is no other.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<(String, Vec<u8>)> = fs::read_dir(folder.join("out"))
        .unwrap()
        .map(Result::unwrap)
        .map(|e| (e.file_name().into_string().unwrap(), fs::read(e.path()).unwrap()))
        .collect();
    files.sort();
    files
}

fn assert_same_files(found: &[(String, Vec<u8>)], expected: &[(String, Vec<u8>)]) {
    let names = |files: &[(String, Vec<u8>)]| files.iter().map(|f| f.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(found), names(expected));
    for (found, expected) in found.iter().zip(expected) {
        assert!(found.1 == expected.1, "{}", found.0);
    }
}

fn effort(folder: &Path) -> Value {
    let document: Value = serde_json::from_slice(&fs::read(folder.join("out/report.json")).unwrap()).unwrap();
    document["provenance"]["effort"].clone()
}

fn rows(path: &Path) -> Vec<csv::StringRecord> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.records().map(Result::unwrap).collect()
}

#[test]
fn a_killed_report_goes_on_to_the_same_bytes() {
    let whole = scratch();
    let output = run(whole.path(), &REPORT);
    assert!(output.stderr.is_empty());
    let expected = files(whole.path());
    assert_eq!(expected.len(), 7 + 2 * 4);
    assert_eq!(effort(whole.path())["stopped_by"], "paths");
    assert_eq!(effort(whole.path())["batches"], 16);

    let folder = scratch();
    interrupt(folder.path(), &REPORT, STATE);
    // Half a file of an earlier kill goes with the state.
    fs::write(folder.path().join("out/specval.state.1234-0.partial"), "half").unwrap();
    let resumed = run(
        folder.path(),
        &[&REPORT[..], &["--resume", "--checkpoint=1h", "--threads", "1"]].concat(),
    );
    let notices = String::from_utf8(resumed.stderr).unwrap();
    assert!(notices.contains("specval.state: goes on after"), "{notices}");
    assert_same_files(&files(folder.path()), &expected);
    assert_eq!(resumed.stdout, output.stdout);
}

/// With every round saved, killed again and again at moments that are spread over a run, whatever it is doing there.
#[test]
fn kills_at_any_moment_do_no_harm() {
    let until = ["--until", "abs 0.004", "--quiet"];
    let arguments = [&REPORT[..], &until].concat();
    let whole = scratch();
    let began = Instant::now();
    run(whole.path(), &arguments);
    let time = began.elapsed();
    let expected = files(whole.path());
    assert_eq!(effort(whole.path())["stopped_by"], "precision");

    let folder = scratch();
    for share in [0.37, 0.02, 0.61, 0.11, 0.83, 0.29, 0.5, 0.71] {
        let child = start(
            folder.path(),
            &[&arguments[..], &["--resume", "--checkpoint", "0s"]].concat(),
        );
        std::thread::sleep(time.mul_f64(share));
        kill(child);
    }
    run(folder.path(), &[&arguments[..], &["--resume"]].concat());
    // Half-written files of killed runs are gone too.
    assert_same_files(&files(folder.path()), &expected);
}

#[test]
fn a_killed_measurement_goes_on_to_the_same_bytes() {
    let measure = ["measure", "study.toml", "--out", "curves.csv"];
    let whole = scratch();
    run(whole.path(), &measure);
    let folder = scratch();
    interrupt(folder.path(), &measure, "curves.csv.state");
    assert!(!folder.path().join("curves.csv").exists());
    run(folder.path(), &[&measure[..], &["--resume"]].concat());
    let curves = |folder: &Path| fs::read(folder.join("curves.csv")).unwrap();
    assert!(curves(folder.path()) == curves(whole.path()));
    assert!(!folder.path().join("curves.csv.state").exists());
}

#[test]
fn states_of_other_runs_are_refused_by_key() {
    let folder = scratch();
    interrupt(folder.path(), &REPORT, STATE);
    let state = fs::read(folder.path().join(STATE)).unwrap();
    let other = STUDY.replace("[measured]", "[medium]\nkappa_peak = 0.003\n[measured]");
    fs::write(folder.path().join("other.toml"), other).unwrap();
    fs::write(folder.path().join("curves.csv.state"), &state).unwrap();
    for (arguments, words) in [
        (
            &["report", "study.toml", "--out", "out", "--resume", "--seed", "7"][..],
            &["`seed`", "expected 7", "found 1"][..],
        ),
        (
            &["report", "other.toml", "--out", "out", "--resume"],
            &["`study.medium.kappa_peak`", "0.003", "0.0065"],
        ),
        (
            &["report", "study.toml", "--out", "out", "--resume", "--paths", "999"],
            &["`study.trace.paths_direct`", "999"],
        ),
        (
            &["measure", "study.toml", "--out", "curves.csv", "--resume"],
            &["curves.csv.state", "`command`", "measure", "report"],
        ),
    ] {
        let message = refusal(folder.path(), arguments);
        for word in words {
            assert!(message.contains(word), "{message:?} does not say {word:?}");
        }
        assert!(fs::read(folder.path().join(STATE)).unwrap() == state);
    }
    // Another sample under the same name.
    let sample = folder.path().join("cloth.csv");
    let readings = fs::read_to_string(&sample).unwrap();
    fs::write(&sample, readings.replace("0.004", "0.005")).unwrap();
    let message = refusal(folder.path(), &[&REPORT[..], &["--resume"]].concat());
    assert!(message.contains("`inputs.") && message.contains("sha256"), "{message}");
    assert!(fs::read(folder.path().join(STATE)).unwrap() == state);
}

#[test]
fn damaged_states_are_refused_and_left_alone() {
    let folder = scratch();
    interrupt(folder.path(), &REPORT, STATE);
    let place = folder.path().join(STATE);
    let sound = fs::read(&place).unwrap();
    let mut damaged: Vec<Vec<u8>> = [0, 10, sound.len() / 2, sound.len() - 1]
        .map(|length| sound[..length].to_vec())
        .to_vec();
    damaged.push([&sound[..], &[0]].concat());
    for byte in [3, 16, 25, 60, sound.len() / 2, sound.len() - 40, sound.len() - 1] {
        for bit in [0, 6] {
            let mut flipped = sound.clone();
            flipped[byte] ^= 1 << bit;
            damaged.push(flipped);
        }
    }
    for state in damaged {
        fs::write(&place, &state).unwrap();
        let message = refusal(folder.path(), &[&REPORT[..], &["--resume"]].concat());
        assert!(message.contains("specval.state"), "{message}");
        assert!(fs::read(&place).unwrap() == state, "changed: {message}");
    }
    // Not asked to go on from it, a run has no use for it.
    run(folder.path(), &REPORT);
    assert!(!place.exists());
}

#[test]
fn without_a_state_a_run_begins_at_its_beginning_and_says_so() {
    let folder = scratch();
    let arguments = [
        "measure",
        "study.toml",
        "--out",
        "curves.csv",
        "--paths",
        "160",
        "--resume",
    ];
    let notices = String::from_utf8(run(folder.path(), &arguments).stderr).unwrap();
    assert!(
        notices.contains("curves.csv.state") && notices.contains("from its beginning"),
        "{notices}"
    );
    assert!(
        run(folder.path(), &[&arguments[..], &["--quiet", "--force"]].concat())
            .stderr
            .is_empty()
    );
}

#[test]
fn until_reaches_the_precision_it_names() {
    let folder = scratch();
    let text = run(folder.path(), &[&REPORT[..], &["--until", "rel 1%"]].concat()).stdout;
    let text = String::from_utf8(text).unwrap();
    assert!(
        text.contains("stopped by precision") && text.contains("rel 0.01 curves"),
        "{text}"
    );
    let effort_of = effort(folder.path());
    let reached = effort_of["reached"]["largest_error"].as_f64().unwrap();
    assert!(reached <= 0.01, "{effort_of}");
    assert!(effort_of["batches"].as_u64() > Some(16), "{effort_of}");
    assert_eq!(effort_of["asked"]["batches"], 100_000);
    let mut largest = 0.0_f64;
    for row in rows(&folder.path().join("out/curves.csv")) {
        if &row[2] == "model" && &row[3] == "y" {
            // A normalised point has no error of its own at the reference: an empty cell.
            let number = |column: usize| match &row[column] {
                "" => 0.0,
                text => text.parse::<f64>().unwrap(),
            };
            largest = largest.max(number(5) / number(4));
        }
    }
    assert!(
        largest > 0.0 && largest <= reached * (1.0 + 1e-9),
        "{largest} {reached}"
    );

    let ratios = [&REPORT[..], &["--until", "rel 5% ratios"]].concat();
    run(folder.path(), &ratios);
    let effort_of = effort(folder.path());
    let reached = effort_of["reached"]["largest_error"].as_f64().unwrap();
    let table = rows(&folder.path().join("out/table1.csv"));
    let model = table.iter().find(|row| &row[0] == "model").unwrap();
    let number = |column: usize| model[column].parse::<f64>().unwrap();
    let largest = (number(2) / number(1)).max(number(4) / number(3).abs());
    assert!(reached <= 0.05, "{effort_of}");
    approx::assert_relative_eq!(largest, reached, max_relative = 1e-9);
}

/// A sample of 45° alone: the report normalises at its reading nearest to the normal, and so does what is watched.
#[test]
fn until_watches_what_a_report_without_a_normal_reading_shows() {
    let folder = scratch();
    let mut sample = "theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b\n".to_owned();
    for theta_v in [-40, -20, 0, 20, 40] {
        sample += &format!("45,{theta_v},0.03,0.0004,0.003\n");
    }
    fs::write(folder.path().join("cloth.csv"), sample).unwrap();
    let study = STUDY.replace("incidences_deg = [0, 30]", "incidences_deg = [45]");
    fs::write(folder.path().join("study.toml"), study).unwrap();
    run(folder.path(), &[&REPORT[..], &["--until", "rel 2%"]].concat());
    let reached = effort(folder.path())["reached"]["largest_error"].as_f64().unwrap();
    let mut largest = 0.0_f64;
    let mut reference = 1.0;
    for row in rows(&folder.path().join("out/curves.csv")) {
        // A normalised point has no error of its own at the reference: an empty cell.
        let number = |column: usize| match &row[column] {
            "" => 0.0,
            text => text.parse::<f64>().unwrap(),
        };
        if &row[2] == "model" && &row[3] == "y" {
            match (number(0), number(1)) {
                (45.0, 0.0) => reference = number(5),
                _ => largest = largest.max(number(5) / number(4)),
            }
        }
    }
    assert!(reached <= 0.02, "{reached}");
    // That of the curves, in which the reference has no error.
    assert!(reference < 1e-12, "{reference}");
    approx::assert_relative_eq!(largest, reached, max_relative = 1e-9);
}

/// Nothing scatters in yarns so thin: the run ends soon whatever precision it waits for, and says why.
#[test]
fn until_ends_where_its_precision_is_out_of_reach() {
    let folder = scratch();
    let study = format!("{STUDY}[yarn]\nradius_mm = 1e-6\n[specular]\nweight = 0\n");
    fs::write(folder.path().join("study.toml"), study).unwrap();
    let arguments = ["measure", "study.toml", "--out", "curves.csv", "--until", "rel 1%"];
    let text = String::from_utf8(run(folder.path(), &arguments).stdout).unwrap();
    assert!(
        text.contains("stopped by precision out of reach") && text.contains("; ask for less")
            || text.contains("stopped by nothing hit"),
        "{text}"
    );
}

/// A run with a time that is killed goes on with what is left of its batches, to the bytes of one without a break.
#[test]
fn a_killed_run_with_a_time_goes_on_to_the_same_bytes() {
    let timed = [&REPORT[..], &["--max-time", "1h"]].concat();
    let whole = scratch();
    run(whole.path(), &timed);
    let broken = scratch();
    interrupt(broken.path(), &timed, STATE);
    let notices = String::from_utf8(run(broken.path(), &[&timed[..], &["--resume"]].concat()).stderr).unwrap();
    assert!(notices.contains("goes on after "), "{notices}");
    assert!(files(whole.path()) == files(broken.path()));
    assert_eq!(effort(broken.path())["stopped_by"], "paths");
}

#[test]
fn typed_paths_end_a_run_that_waits_for_its_precision() {
    let folder = scratch();
    let until = ["--until", "rel 1e-6", "--paths", "1600"];
    run(folder.path(), &[&REPORT[..], &until].concat());
    let effort = effort(folder.path());
    assert_eq!(
        (&effort["stopped_by"], &effort["batches"]),
        (&"paths".into(), &16.into())
    );
    assert_eq!(effort["paths_per_batch"]["direct"], 100);
    assert!(effort["reached"]["largest_error"].as_f64() > Some(1e-6));
}

#[test]
fn max_time_ends_a_run_soon_and_says_so() {
    let folder = scratch();
    let long = STUDY
        .replace("batches = 16", "batches = 400")
        .replace("paths_bssrdf = 160", "paths_bssrdf = 4000")
        .replace("paths_direct = 16000", "paths_direct = 4000000");
    fs::write(folder.path().join("study.toml"), long).unwrap();
    let measure = ["measure", "study.toml", "--out", "curves.csv", "--max-time", "1s"];
    let began = Instant::now();
    let text = String::from_utf8(run(folder.path(), &measure).stdout).unwrap();
    let seconds = began.elapsed().as_secs_f64();
    // One round more than the second, on a machine that does other things too; all batches take minutes.
    assert!((1.0..10.0).contains(&seconds), "{seconds} s");
    assert!(
        text.contains("stopped by time (asked: 1 s, 400 batches at most)") && text.contains("standard error"),
        "{text}"
    );
    let curves = fs::read_to_string(folder.path().join("curves.csv")).unwrap();
    assert!(
        curves.starts_with("# effort: ") && curves.contains("stopped by time"),
        "{curves}"
    );
    // It stays a sample.
    fs::write(folder.path().join("study.toml"), STUDY).unwrap();
    let report = [&REPORT[..], &["--measured", "curves.csv", "--paths", "1600"]].concat();
    run(folder.path(), &report);
}

#[test]
fn bad_rules_are_refused_with_an_example() {
    let folder = scratch();
    for (arguments, words) in [
        (["--until", "1%"], ["--until", "rel 1%"]),
        (["--until", "rel -1%"], ["--until", "> 0"]),
        (["--until", "abs 1%"], ["--until", "abs 0.001"]),
        (["--max-time", "soon"], ["--max-time", "90s"]),
        (["--max-time", "-1s"], ["--max-time", "90s"]),
        (["--checkpoint", "5"], ["--checkpoint", "90s"]),
    ] {
        let option = arguments.join("=");
        let arguments = [&REPORT[..], &[&option]].concat();
        let message = refusal(folder.path(), &arguments);
        for word in words {
            assert!(message.contains(word), "{message:?} does not say {word:?}");
        }
        assert!(!folder.path().join("out").exists());
    }
    let oblique = STUDY.replace("incidences_deg = [0, 30]", "incidences_deg = [30]");
    fs::write(folder.path().join("study.toml"), oblique).unwrap();
    let measure = [
        "measure",
        "study.toml",
        "--out",
        "curves.csv",
        "--until",
        "rel 1% ratios",
    ];
    let message = refusal(folder.path(), &measure);
    assert!(
        message.contains("normal incidence") && message.contains("`curves`"),
        "{message}"
    );
}
