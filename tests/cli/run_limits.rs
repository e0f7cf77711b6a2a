//! What a run takes before it begins: memory, work of a batch, and what it waits for.

use specval::run::{Plan, Precision, Stage, StopRule, StoppedBy, Tolerance, Watched, memory_bytes, refuse_beyond};
use specval::study::Study;
use std::time::Duration;

const FREE: f64 = 8e9;

/// A key that makes tables too large is named with its line and a value that fits; one step more does not.
#[test]
fn a_study_too_large_for_the_memory_is_refused_by_its_key() {
    for (text, stage) in [
        ("[rig]\npixels_per_side = 10000", Stage::Views),
        ("[trace]\nexit_theta_cells = 1000", Stage::Yarn),
        (
            "[trace]\nexit_azimuth_cells = 1000\nexit_phi_cells = 1000",
            Stage::Views,
        ),
        ("[trace]\ntilts = 1000", Stage::Yarn),
        ("[trace]\nz_cells = 1000", Stage::Yarn),
        ("[trace]\nbssrdf_exit_phi_cells = 1000", Stage::Yarn),
        ("[trace]\nazimuth_cells = 1000", Stage::Yarn),
    ] {
        let study = Study::from_toml(text, "my.toml").unwrap();
        let error = refuse_beyond(&study, stage, 2, FREE).expect_err(text).to_string();
        let key = error.split('`').nth(1).unwrap().split_once('.').unwrap().1;
        let line = 1 + text.lines().position(|line| line.starts_with(key)).unwrap();
        assert!(error.starts_with(&format!("my.toml, line {line}: ")), "{error}");
        assert!(error.contains(" GB of memory where 8.0 GB are free"), "{error}");
        let most: u32 = error
            .split("at most ")
            .nth(1)
            .unwrap()
            .split(' ')
            .next()
            .unwrap()
            .parse()
            .unwrap();
        let fits = |value: u32| {
            let old = text.lines().nth(line - 1).unwrap();
            let study = Study::from_toml(&text.replace(old, &format!("{key} = {value}")), "my.toml").unwrap();
            refuse_beyond(&study, stage, 2, FREE).is_ok()
        };
        assert!(fits(most) && !fits(most + 4), "{error}");
    }
    assert!(refuse_beyond(&Study::default(), Stage::Views, 64, FREE).is_ok());
    assert!(refuse_beyond(&Study::default(), Stage::Yarn, 64, FREE).is_ok());
}

/// Many wavelengths are refused too, and every part of the estimate is a number.
#[test]
fn too_many_wavelengths_are_refused_by_their_key() {
    let mut study = Study::default();
    study.spectrum.wavelength_step_nm = 0.05;
    for stage in [Stage::Views, Stage::Yarn] {
        assert!(memory_bytes(&study, stage, 2) > memory_bytes(&Study::default(), stage, 2));
        let error = refuse_beyond(&study, stage, 2, 1e9).unwrap_err().to_string();
        assert!(error.starts_with("`spectrum.wavelength_step_nm`: "), "{error}");
    }
}

/// Batches small enough for a time: the same number of paths in more of them, alike whenever it is asked.
#[test]
fn a_short_time_makes_smaller_batches() {
    let plan = |text: &str| Plan::new(Study::from_toml(text, "my.toml").unwrap()).unwrap();
    let split = |text: &str, seconds: f64, stage| {
        let (plan, parts) = plan(text).split_for(Duration::from_secs_f64(seconds), stage).unwrap();
        assert_eq!(plan.study.trace.batches, 16 * parts);
        (parts, plan.study)
    };
    assert_eq!(split("", 3600.0, Stage::Views).0, 1);
    let (parts, study) = split("[trace]\npaths_direct = 100000000\n", 10.0, Stage::Views);
    assert!(parts > 16, "{parts}");
    assert_eq!(study.trace.paths_direct, 100_000_000);
    assert_eq!(
        split("[trace]\npaths_direct = 100000000\n", 10.0, Stage::Views).1,
        study
    );
    let clear = split("", 4.0, Stage::Yarn).0;
    let trapping = split("[medium]\nhost_index = 4\n", 4.0, Stage::Yarn).0;
    assert!(trapping > 16 * clear, "{trapping} {clear}");
}

/// 0 ± 0 is not known: a run goes on for it, and ends when there is nothing else.
#[test]
fn nothing_hit_is_not_converged() {
    for tolerance in [Tolerance::Relative(0.01), Tolerance::Absolute(0.01)] {
        let precision = Precision {
            tolerance,
            ..Precision::parse("rel 1%", Watched::Curves, &[]).unwrap()
        };
        let rule = StopRule::new(Some(precision), None, 16, false);
        let error = |batches, of: &[(f64, f64)]| tolerance.largest_error(batches, of.iter().copied());
        let nothing = [(0.0, 0.0), (0.0, 0.0)];
        let some = [(0.0, 0.0), (1.0, 0.001)];
        assert_eq!(error(16, &nothing), Some(f64::INFINITY));
        assert_eq!(rule.reached(16, || error(16, &some)), None);
        assert_eq!(rule.reached(63, || error(63, &nothing)), None);
        assert_eq!(rule.reached(64, || error(64, &nothing)), Some(StoppedBy::NothingHit));
        assert_eq!(rule.reached(64, || error(64, &some)), Some(StoppedBy::Precision));
    }
}

/// A full measurement by f* holds the tables of all batches.
#[test]
fn a_full_measurement_too_large_for_the_memory_is_refused() {
    let stage = |by_factor| Stage::Full {
        incidences: 20,
        bins: 400,
        by_factor,
    };
    let study = Study::from_toml("[trace]\nbatches = 2000\n", "my.toml").unwrap();
    assert!(refuse_beyond(&study, stage(false), 2, FREE).is_ok());
    let error = refuse_beyond(&study, stage(true), 2, FREE).unwrap_err().to_string();
    assert!(
        error.starts_with("my.toml, line 2: `trace.batches`: expected at most "),
        "{error}"
    );
    assert!(refuse_beyond(&Study::default(), stage(true), 64, FREE).is_ok());
}

/// The time of a long run is told before it begins, with the key that makes it so; that of one without end is refused.
#[test]
fn long_runs_are_told_of_and_endless_ones_refused() {
    let notice = |text: &str, stage| {
        let plan = Plan::new(Study::from_toml(text, "my.toml").unwrap()).unwrap();
        plan.work_notice(stage)
    };
    for stage in [Stage::Views, Stage::Yarn] {
        assert_eq!(notice("", stage), Ok(None));
    }
    for (text, parts) in [
        (
            "[trace]\npaths_direct = 600000000\n",
            &[" min on one core", "most of it for `trace.paths_direct` = 600000000"][..],
        ),
        (
            "[medium]\nhost_index = 4\n",
            &[" h on one core", "`host_index`", "index 4 "],
        ),
        (
            "[rig]\npixels_per_side = 1000\n",
            &[" min on one core", "`rig.pixels_per_side` = 1000"],
        ),
    ] {
        let words = notice(text, Stage::Views).unwrap().expect(text).to_string();
        for part in parts {
            assert!(words.contains(part), "{part} is missing in {words}");
        }
    }
    let endless = "[trace]\npaths_direct = 1000000000000\n[medium]\nparticle_index = 4\n";
    let error = notice(endless, Stage::Views).unwrap_err().to_string();
    assert!(error.starts_with("my.toml, line 2: `trace.paths_direct`: "), "{error}");
    assert!(error.contains(" years on one core; reduce it"), "{error}");
}

/// Particles too large for a phase table: the message names the key, its line and what to do, also where a weft has it
/// from the warp.
#[test]
fn errors_of_a_medium_name_the_line_of_the_key() {
    let error = |text: &str| match Plan::new(Study::from_toml(text, "my.toml").unwrap()) {
        Ok(_) => panic!("{text} is a plan"),
        Err(error) => error.to_string(),
    };
    let spectrum = "[spectrum]\nwavelengths_nm = [400]\n";
    for (text, place) in [
        (
            "[medium]\nparticle_diameter_nm = 20000\nhost_index = 4\nparticle_index = 1\n",
            "my.toml, line 4: `medium.particle_diameter_nm`: ",
        ),
        (
            "[medium]\ndye = \"preprint-red\"\n[weft]\nparticle_diameter_nm = 20000\nhost_index = 4\nparticle_index = \
             1\n",
            "my.toml, line 6: `weft.particle_diameter_nm`: ",
        ),
        (
            "[medium]\nparticle_diameter_nm = 20000\n[weft]\nhost_index = 4\nparticle_index = 1\n",
            "my.toml, line 4: `medium.particle_diameter_nm`: ",
        ),
    ] {
        let message = error(&format!("{spectrum}{text}"));
        assert!(message.starts_with(place), "{message}");
        assert!(message.contains("take smaller particles"), "{message}");
    }
}

/// Every command looks at its memory before it takes any.
#[test]
fn no_command_allocates_beyond_the_memory() {
    let folder = tempfile::tempdir().unwrap();
    let cells = "tilts = 200\nexit_theta_cells = 1000\nexit_phi_cells = 1000\n";
    let all = "exit_azimuth_cells = 1000\nzenith_cells = 1000\nazimuth_cells = 1000\nbssrdf_azimuth_cells = 1000\n\
               bssrdf_exit_theta_cells = 1000\nbssrdf_exit_phi_cells = 1000\nz_cells = 1000\nbatches = 10000\n\
               [rig]\npixels_per_side = 10000\n";
    for (name, text) in [("cells", cells.to_owned()), ("all", format!("{cells}{all}"))] {
        let study = format!("{name}.toml");
        std::fs::write(folder.path().join(&study), format!("[trace]\n{text}")).unwrap();
        for arguments in [
            &["measure", &study, "--paths", "10000", "--out", "x.csv"][..],
            &["trace", &study, "--paths", "10000", "--out", "x.trace"],
            &[
                "trace", &study, "--paths", "10000", "--shard", "1/2", "--out", "x.shard",
            ],
            &["report", &study, "--paths", "10000", "--out", "x"],
            &["check", &study],
            &[
                "bsdf",
                &study,
                "--method",
                "radiance-factor",
                "--paths",
                "10000",
                "--out",
                "x.ssdd",
            ],
        ] {
            let output = crate::command::specval(folder.path(), arguments);
            let message = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
            let refused = message.contains(" of memory where ") && message.contains(&format!("{study}, line "));
            assert!(refused && message.contains(": `trace."), "{arguments:?}: {message}");
        }
    }
}
