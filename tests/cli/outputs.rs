//! Where results go: no input is written over, a file that exists needs `--force`, a set is written whole or not at
//! all.

use crate::command::specval;
use crate::runs::{stderr, succeed};
use std::fs;
use std::path::Path;

const STUDY: &str = "[spectrum]\nwavelengths_nm = [450, 550, 650]\n[trace]\nbatches = 2\npaths_direct = \
                     40\npaths_bssrdf = 4\nparticles = 40\ntilts = 3\n[rig]\npixels_per_side = 4\nview_step_deg = \
                     130\nincidences_deg = [0, 30]\n[sweep]\nkappa_peak = []\nvolume_fraction = \
                     []\nparticle_diameter_nm = []\nparticle_index = []\n";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.toml"), STUDY).unwrap();
    folder
}

/// Exit code 2 and these words.
fn refuse(folder: &Path, arguments: &[&str], words: &str) {
    let output = specval(folder, arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stderr(&output));
    assert!(stderr(&output).contains(words), "{arguments:?}: {}", stderr(&output));
}

/// Names and bytes of all files of a folder.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = entries
        .filter(|path| path.is_file())
        .map(|path| {
            (
                path.file_name().unwrap().to_string_lossy().into_owned(),
                fs::read(&path).unwrap(),
            )
        })
        .collect();
    files.sort();
    files
}

#[test]
fn an_input_is_never_an_output() {
    let folder = folder();
    let here = folder.path();
    let table = "wavelength_nm,value\n400,0.5\n700,0.5\n";
    fs::create_dir(here.join("d")).unwrap();
    for name in [
        "dye.csv",
        "index.csv.state",
        "a.csv.energy.csv",
        "light.csv",
        "backing.csv",
    ] {
        fs::write(here.join(name), table).unwrap();
    }
    let index = table.replace("0.5", "1.5");
    fs::write(here.join("index.csv.state"), index).unwrap();
    fs::write(
        here.join("t.toml"),
        format!(
            "{STUDY}[medium]\ndye = \"dye.csv\"\nhost_index = \"index.csv.state\"\n[weft]\ndye \
             = \"a.csv.energy.csv\"\n[cloth]\nbacking = \"backing.csv\"\n[colour]\nilluminant \
             = \"light.csv\"\n[measured]\nsample = \"d/curves.csv\"\n"
        ),
    )
    .unwrap();
    succeed(here, &["measure", "s.toml", "--out", "d/curves.csv"]);
    succeed(here, &["trace", "s.toml", "--out", "a.trace"]);
    succeed(here, &["trace", "s.toml", "--out", "a.shard", "--shard", "1/2"]);
    let before = (files(here), files(&here.join("d")));
    for arguments in [
        &["measure", "s.toml", "--out", "s.toml"][..],
        &["bsdf", "s.toml", "--to", "csv", "--out", "s.toml"],
        &["bsdf", "s.toml", "--out", "b.csv", "--errors", "./s.toml"],
        &["measure", "t.toml", "--out", "dye.csv"],
        &["measure", "t.toml", "--out", "a.csv"],
        &["measure", "t.toml", "--out", "index.csv"],
        &["measure", "t.toml", "--out", "light.csv"],
        &["trace", "t.toml", "--out", "backing.csv"],
        &["trace", "t.toml", "--out", "d/../t.toml"],
        &["report", "t.toml", "--out", "d"],
        &["report", "s.toml", "--measured", "d/curves.csv", "--out", "d"],
        &["reabsorb", "a.trace", "--kappa-peak", "0.001", "--out", "a.trace"],
        &["merge", "a.shard", "--out", "a.shard"],
        &["check", "s.toml", "--quick", "--junit", "s.toml"],
        &["check", "--quick", "--against", "s.toml", "--junit", "s.toml"],
        &["check", "--sample", "d/curves.csv", "--junit", "d/curves.csv"],
        &["convert", "d/curves.csv", "d/curves.csv"],
    ] {
        refuse(here, &[arguments, &["--force"]].concat(), "input of this run");
        refuse(here, arguments, "input of this run");
    }
    assert!((files(here), files(&here.join("d"))) == before);
    refuse(
        here,
        &["bsdf", "s.toml", "--out", "b.csv", "--errors", "./b.csv"],
        "two outputs",
    );
}

#[cfg(unix)]
#[test]
fn links_do_not_hide_an_input_and_stay_links() {
    let folder = folder();
    let here = folder.path();
    std::os::unix::fs::symlink("s.toml", here.join("soft")).unwrap();
    fs::hard_link(here.join("s.toml"), here.join("hard")).unwrap();
    for link in ["soft", "hard"] {
        refuse(
            here,
            &["measure", "s.toml", "--out", link, "--force"],
            "input of this run",
        );
    }
    assert_eq!(fs::read_to_string(here.join("s.toml")).unwrap(), STUDY);
    // A link that leads nowhere yet, and the same when its end is there.
    std::os::unix::fs::symlink("real.csv", here.join("link.csv")).unwrap();
    succeed(here, &["measure", "s.toml", "--out", "link.csv"]);
    let first = fs::read(here.join("real.csv")).unwrap();
    refuse(here, &["measure", "s.toml", "--out", "link.csv"], "--force");
    succeed(
        here,
        &["measure", "s.toml", "--out", "link.csv", "--force", "--seed", "2"],
    );
    assert!(here.join("link.csv").is_symlink());
    assert!(fs::read(here.join("real.csv")).unwrap() != first);
}

#[test]
fn a_file_that_exists_needs_force_in_every_command() {
    let folder = folder();
    let here = folder.path();
    succeed(here, &["trace", "s.toml", "--out", "a.trace"]);
    succeed(here, &["trace", "s.toml", "--out", "a.shard", "--shard", "1/1"]);
    succeed(here, &["measure", "s.toml", "--out", "a.csv"]);
    fs::create_dir(here.join("d")).unwrap();
    for name in ["there", "there.csv", "study.toml", "d/table1.md"] {
        fs::write(here.join(name), "mine").unwrap();
    }
    for arguments in [
        &["init", "."][..],
        &["trace", "s.toml", "--out", "there"],
        &["trace", "s.toml", "--out", "there", "--shard", "1/2"],
        &["merge", "a.shard", "--out", "there"],
        &["reabsorb", "a.trace", "--kappa-peak", "0.005", "--out", "there"],
        &["measure", "s.toml", "--out", "there"],
        &["bsdf", "s.toml", "--out", "new.csv", "--errors", "there.csv"],
        &["check", "--sample", "a.csv", "--junit", "there"],
        &["convert", "a.csv", "there.csv"],
        &["report", "s.toml", "--out", "d"],
    ] {
        refuse(here, arguments, "replace it with --force");
    }
    for name in ["there", "there.csv", "study.toml", "d/table1.md"] {
        assert_eq!(fs::read_to_string(here.join(name)).unwrap(), "mine", "{name}");
    }
    succeed(here, &["report", "s.toml", "--out", "d", "--force"]);
    succeed(here, &["init", ".", "--force"]);
    assert!(
        fs::read_to_string(here.join("study.toml"))
            .unwrap()
            .contains("[medium]")
    );
    // A file that only has the name of a state is none, whatever is said.
    fs::write(here.join("b.csv.state"), "mine").unwrap();
    refuse(here, &["measure", "s.toml", "--out", "b.csv", "--force"], "b.csv.state");
}

#[test]
fn a_dash_is_stdout_and_holds_one_document() {
    let folder = folder();
    let here = folder.path();
    succeed(here, &["measure", "s.toml", "--out", "a.csv"]);
    let output = succeed(here, &["measure", "s.toml", "--out", "-"]);
    assert!(output.stdout == fs::read(here.join("a.csv")).unwrap());
    assert!(
        stderr(&output).contains("brightness factors"),
        "the summary goes to stderr"
    );
    refuse(here, &["measure", "s.toml", "--out", "-", "--json"], "one document");
    refuse(here, &["measure", "s.toml", "--out", "-", "--resume"], "--resume");
    refuse(here, &["report", "s.toml", "--out", "-"], "folder");
    succeed(here, &["trace", "s.toml", "--out", "a.trace"]);
    let output = succeed(here, &["trace", "s.toml", "--out", "-"]);
    assert!(output.stdout == fs::read(here.join("a.trace")).unwrap());
    let output = succeed(here, &["init", "-"]);
    assert!(String::from_utf8(output.stdout).unwrap().contains("[medium]"));
    let output = succeed(here, &["convert", "a.csv", "-", "--to", "csv", "--quiet"]);
    assert!(output.stdout.starts_with(b"#") || output.stdout.starts_with(b"theta_i_deg"));
    assert!(!here.join("-").exists() && !here.join("-.state").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_nothing_of_a_set() {
    let folder = folder();
    let here = folder.path();
    // /dev/full takes no byte; what else belongs to the set is not there then either.
    let full = [
        "bsdf",
        "s.toml",
        "--theta-step",
        "45",
        "--phi-step",
        "90",
        "--paths",
        "40",
    ];
    refuse(
        here,
        &[&full[..], &["--out", "b.csv", "--errors", "/dev/full"]].concat(),
        "No space left",
    );
    assert_eq!(files(here).len(), 1, "{:?}", files(here));
    assert!(!Path::new("/dev/full").is_file());
}

#[test]
fn a_report_takes_away_what_an_earlier_one_left_and_nothing_else() {
    let folder = folder();
    let here = folder.path();
    let d = here.join("d");
    fs::write(here.join("one.toml"), STUDY.replace("[0, 30]", "[0]")).unwrap();
    succeed(here, &["report", "s.toml", "--out", "d"]);
    fs::write(d.join("graph9.svg"), "mine").unwrap();
    fs::write(d.join("graph4.svg"), "edited").unwrap();
    let output = succeed(here, &["report", "one.toml", "--out", "d"]);
    assert!(stderr(&output).contains("graph3.png"), "{}", stderr(&output));
    let names: Vec<String> = files(&d).into_iter().map(|(name, _)| name).collect();
    let expected = [
        "curves.csv",
        "energy.csv",
        "graph1.png",
        "graph1.svg",
        "graph2.png",
        "graph2.svg",
        "graph4.svg",
        "graph9.svg",
        "report.json",
        "report.sha256",
        "result.json",
        "table1.csv",
        "table1.md",
    ];
    assert_eq!(names, expected);
    // Changed since: no longer this program's own.
    fs::write(d.join("table1.md"), "edited").unwrap();
    refuse(here, &["report", "one.toml", "--out", "d"], "table1.md");
    assert_eq!(fs::read_to_string(d.join("table1.md")).unwrap(), "edited");
}

#[test]
fn a_second_run_into_one_place_is_refused() {
    let folder = folder();
    let here = folder.path();
    fs::create_dir(here.join("d")).unwrap();
    let lock = |name: &str| {
        let file = fs::File::create(here.join(name)).unwrap();
        file.try_lock().unwrap();
        file
    };
    let held = [lock("d/specval.lock"), lock("a.csv.state.lock")];
    refuse(here, &["report", "s.toml", "--out", "d"], "another run");
    refuse(here, &["measure", "s.toml", "--out", "a.csv"], "another run");
    refuse(here, &["trace", "s.toml", "--out", "a.csv"], "another run");
    // As after a kill: the files are there, and nobody holds them.
    drop(held);
    succeed(here, &["report", "s.toml", "--out", "d"]);
    succeed(here, &["measure", "s.toml", "--out", "a.csv"]);
    assert!(!here.join("d/specval.lock").exists() && !here.join("a.csv.state.lock").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn names_that_are_no_text_are_no_panic() {
    use std::os::unix::ffi::OsStrExt;
    let folder = folder();
    let here = folder.path();
    let name = std::ffi::OsStr::from_bytes(b"ba\xffd.csv");
    fs::copy(
        here.join("s.toml"),
        here.join(std::ffi::OsStr::from_bytes(b"s\xff.toml")),
    )
    .unwrap();
    for arguments in [
        &["report", "s.toml", "--json", "--out"][..],
        &["measure", "s.toml", "--json", "--force", "--out"],
        &[
            "bsdf",
            "s.toml",
            "--theta-step",
            "45",
            "--phi-step",
            "90",
            "--paths",
            "40",
            "--json",
            "--to",
            "csv",
            "--force",
            "--out",
        ],
        &["trace", "s.toml", "--json", "--force", "--out"],
        &["init", "--json"],
        &["weave"],
        &["colour"],
        &["inspect", "--json"],
        &["reabsorb", "--kappa-peak", "0.1", "--out", "x"],
        &["merge", "--out", "x"],
        &["medium", "--json"],
        &["check", "--quick", "--against"],
        &["check", "--quick", "--sample"],
    ] {
        for name in [name, std::ffi::OsStr::from_bytes(b"other\xff")] {
            let output = crate::command::command(here, arguments).arg(name).output().unwrap();
            assert!(
                matches!(output.status.code(), Some(0 | 2)),
                "{arguments:?}: {}",
                stderr(&output)
            );
            assert!(
                !stderr(&output).contains("panicked"),
                "{arguments:?}: {}",
                stderr(&output)
            );
        }
    }
    let folder = here.join(std::ffi::OsStr::from_bytes(b"other\xff"));
    let report: serde_json::Value = serde_json::from_slice(&fs::read(folder.join("report.json")).unwrap()).unwrap();
    let command = report["provenance"]["command"].as_array().unwrap();
    assert_eq!(command.last().unwrap(), "other\\xff");
}

#[test]
fn a_file_of_another_kind_is_told_by_what_it_is() {
    let folder = folder();
    let here = folder.path();
    fs::write(here.join("d.wif"), "[WIF]\nVersion=1.1\n").unwrap();
    fs::write(here.join("dye.csv"), "wavelength_nm,value\n400,0.5\n").unwrap();
    fs::write(here.join("check.json"), "{\"gates\": [], \"subject\": {}}").unwrap();
    fs::write(here.join("broken.toml"), "[medium\nkappa").unwrap();
    succeed(here, &["trace", "s.toml", "--out", "a.trace"]);
    succeed(here, &["trace", "s.toml", "--out", "a.shard", "--shard", "1/2"]);
    succeed(here, &["measure", "s.toml", "--out", "a.csv"]);
    for (arguments, words) in [
        (
            &["report", "d.wif"][..],
            "a weave draft (WIF); see it with `specval weave",
        ),
        (
            &["measure", "a.trace", "--out", "x"],
            "the artefact of a trace; change its absorption with `specval reabsorb`",
        ),
        (&["medium", "a.csv"], "a measured sample; compare with it by"),
        (
            &["check", "check.json"],
            "the document of `specval check --json`; compare with it by `specval check --against",
        ),
        (
            &["reabsorb", "s.toml", "--kappa-peak", "1", "--out", "x"],
            "a study; run it",
        ),
        (&["merge", "a.trace", "--out", "x"], "the artefact of a trace; "),
        (&["weave", "a.csv"], "a measured sample; "),
        (&["colour", "a.trace"], "the artefact of a trace; "),
        (&["convert", "d.wif", "x.csv"], "a weave draft (WIF); "),
        (
            &["report", "--measured", "s.toml"],
            "expected a measured sample, found a study",
        ),
        (
            &["check", "--sample", "a.shard"],
            "a shard of a trace; add shards with `specval merge`",
        ),
        (
            &["check", "--quick", "--against", "dye.csv"],
            "a table of spectra; see its colours",
        ),
        // Its own fault is worth more than a guess.
        (&["report", "broken.toml"], "line 1"),
    ] {
        refuse(here, arguments, words);
    }
    // Of the program's own files `inspect` shows counts and units.
    for (file, words) in [
        ("s.toml", &["study, run by", " nm\n", " deg"][..]),
        ("a.trace", &["trace, whose absorption", " x ", " of "]),
        ("a.shard", &["shard of a trace", " x "]),
        ("check.json", &["result of a check", "list of 0"]),
    ] {
        let output = crate::command::specval(here, &["inspect", file]);
        assert!(output.status.success(), "{file}: {}", stderr(&output));
        let shown = String::from_utf8(output.stdout).unwrap();
        assert!(words.iter().all(|words| shown.contains(words)), "{file}: {shown}");
    }
}

/// Usual things that are given in place of a table, in every place that reads one.
#[test]
fn foreign_files_are_named_wherever_they_are_read() {
    let folder = folder();
    let here = folder.path();
    fs::write(
        here.join("s.csv"),
        "wavelength_nm,a\n400,0.5\n500,0.5\n600,0.5\n700,0.5\n",
    )
    .unwrap();
    for (file, bytes, words) in [
        (
            "a.csv.gz",
            &b"\x1f\x8b\x08\x08\0\0\0\0"[..],
            "found a gzip archive; unpack it",
        ),
        (
            "a.xlsx",
            b"PK\x03\x04\x14\0\x06\0[Content_Types].xml",
            "found a spreadsheet; save the sheet as CSV",
        ),
        ("a.zip", b"PK\x03\x04\x14\0\0\0a.csv", "found a ZIP archive; unpack it"),
        ("a.pdf", b"%PDF-1.7\n", "found a PDF document; give the table"),
        (
            "a.htm",
            b"<!DOCTYPE html>\n<html><body>x",
            "found a web page (HTML); download the file itself",
        ),
        (
            "a.json",
            b"{\"data\": [1, 2]}",
            "found a JSON document; export its values as CSV",
        ),
        (
            "a.txt",
            b"404: Not Found",
            "found the error message of a web server; download",
        ),
        (
            "a.csv",
            b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n",
            "`git lfs pull`",
        ),
    ] {
        fs::write(here.join(file), bytes).unwrap();
        fs::write(here.join("dye.toml"), format!("[medium]\ndye = \"./{file}\"\n")).unwrap();
        let illuminant = format!("./{file}");
        for arguments in [
            &["report", "--measured", file][..],
            &["report", file],
            &["check", "--sample", file],
            &["inspect", file],
            &["convert", file, "x.csv"],
            &["colour", file],
            &["colour", "s.csv", "--illuminant", &illuminant],
            &["weave", file],
            &["medium", "dye.toml"],
        ] {
            refuse(here, arguments, words);
        }
    }
}

/// Places that are none for a folder or a file, and a study that comes through a pipe.
#[cfg(unix)]
#[test]
fn devices_slashes_and_stdin() {
    let folder = folder();
    let here = folder.path();
    for (arguments, words) in [
        (
            &["init", "/dev/null"][..],
            "/dev/null: expected a folder, found a device or a pipe; name a folder",
        ),
        (
            &["report", "s.toml", "--out", "/dev/null"],
            "/dev/null: expected a folder, found a device",
        ),
        (
            &["measure", "s.toml", "--out", "x.csv/"],
            "x.csv/: expected a file, found the name of a folder",
        ),
    ] {
        refuse(here, arguments, words);
    }
    let study = fs::File::open(here.join("s.toml")).unwrap();
    let mut piped = crate::command::command(here, &["measure", "-", "--out", "piped.csv"]);
    let output = piped.stdin(study).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    succeed(here, &["measure", "s.toml", "--out", "named.csv"]);
    let [piped, named] = ["piped.csv", "named.csv"].map(|file| fs::read(here.join(file)).unwrap());
    assert!(!named.is_empty() && piped == named);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_names_stdout() {
    let folder = folder();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut command = crate::command::command(folder.path(), &["medium", "s.toml"]);
    let output = command.stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let message = stderr(&output);
    assert!(
        message.starts_with("error: stdout: cannot be written; free space"),
        "{message}"
    );
}
