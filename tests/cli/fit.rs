//! `specval fit` and `specval compare`: files, documents, exit codes, bad input.

use crate::command::specval;
use crate::runs::{json, refusal, succeed};
use std::fs;
use tempfile::TempDir;

/// Nothing that must be traced anew varies, so the fit traces once.
const SMALL: &str = "[fit]\nparticles = 64\nfree = [{ key = \"specular.weight\", min = 0.0, max = 1.0 }]\n";

fn with_study(text: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("s.toml"), text).unwrap();
    folder
}

#[test]
fn a_fit_writes_a_study_that_runs() {
    let folder = with_study(SMALL);
    let document = json(folder.path(), &["fit", "s.toml", "--measured", "merl-red-fabric"]);
    assert_eq!(document["readings"], 243);
    assert_eq!(document["isotropic"], true);
    assert_eq!(document["converged"], true);
    assert_eq!(document["runs"], 1);
    let names: Vec<&str> = (document["parameters"].as_array().unwrap().iter())
        .map(|parameter| parameter["name"].as_str().unwrap())
        .collect();
    assert_eq!(
        names,
        [
            "specular.weight",
            "absorption at 450 nm",
            "absorption at 545 nm",
            "absorption at 630 nm"
        ]
    );
    assert_eq!(document["rivals"].as_array().unwrap().len(), 4);
    let written = |name: &str| folder.path().join("fit").join(name);
    for name in ["study.toml", "dye.csv", "fit.json", "curves.csv", "fit.svg", "fit.png"] {
        assert!(written(name).is_file(), "{name}");
    }
    assert_eq!(fs::read_to_string(written("curves.csv")).unwrap().lines().count(), 244);
    // The study takes its absorption from the file beside it, wherever it is run.
    let medium = json(folder.path(), &["medium", "fit/study.toml"]);
    let mu_a = medium["mu_a_per_mm"].as_array().unwrap();
    let dye = document["dye"].as_array().unwrap();
    for (mu_a, dye) in mu_a.iter().zip(dye) {
        assert!((mu_a.as_f64().unwrap() / dye[1].as_f64().unwrap() - 1.0).abs() < 1e-9);
    }
    let weight = document["parameters"][0]["value"].as_f64().unwrap();
    let study = fs::read_to_string(written("study.toml")).unwrap();
    assert!(study.contains(&format!("weight = {weight}")), "{study}");
    // The same study and seed give the same bytes on any number of threads.
    let first = fs::read(written("fit.json")).unwrap();
    succeed(
        folder.path(),
        &["fit", "s.toml", "--measured", "merl-red-fabric", "--threads", "1"],
    );
    assert!(fs::read(written("fit.json")).unwrap() == first);
}

/// A grey sample has one channel, and one absorption.
#[test]
fn a_sample_of_luminance_alone_is_fitted() {
    let folder = with_study(SMALL);
    let document = json(folder.path(), &["fit", "s.toml", "--measured", "mecho-6216"]);
    assert_eq!(document["parameters"].as_array().unwrap().len(), 2);
    assert_eq!(document["parameters"][1]["name"], "absorption at 555 nm");
    assert!(document["misfit"].as_f64().unwrap().is_finite());
}

#[test]
fn a_fit_that_runs_out_of_time_says_so() {
    let folder = with_study("[fit]\nparticles = 64\n");
    let document = json(folder.path(), &["fit", "s.toml", "--max-time", "1ms"]);
    assert_eq!(document["converged"], false);
    assert_eq!(document["runs"], 1);
}

#[test]
fn fits_of_what_cannot_be_fitted_are_refused() {
    let free = |key: &str| format!("[fit]\nfree = [{{ key = \"{key}\", min = 0.1, max = 0.5 }}]\n");
    for (study, sample, wanted) in [
        (
            free("medium.volume_fractoin"),
            "merl-red-fabric",
            "did you mean `medium.volume_fraction`?",
        ),
        (free("medium.kappa_peak"), "merl-red-fabric", "free dye"),
        (
            "[fit]\nfree = [{ key = \"trace.tilts\", min = 1, max = 5 }]\n".into(),
            "merl-red-fabric",
            "that take any number of a range",
        ),
        (
            "[fit]\nfree = [{ key = \"specular.weight\", min = 0.5, max = 0.1 }]\n".into(),
            "merl-red-fabric",
            "below its max",
        ),
        (SMALL.into(), "voloboy2008-cotton", "published colour ratios"),
        (SMALL.into(), "few.csv", "at most as many free parameters as readings"),
    ] {
        let folder = with_study(&study);
        let few = "theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b\n0,10,0.3,0.1,0.05\n";
        fs::write(folder.path().join("few.csv"), few).unwrap();
        let message = refusal(folder.path(), &["fit", "s.toml", "--quiet", "--measured", sample]);
        assert!(message.contains(wanted), "{message}");
    }
}

#[test]
fn a_comparison_has_every_model_and_an_exit_code() {
    let folder = with_study(SMALL);
    let arguments = ["compare", "s.toml", "--measured", "merl-red-fabric", "--json"];
    let output = specval(folder.path(), &arguments);
    let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let sample = &document["samples"][0];
    let models = sample["models"].as_array().unwrap();
    assert_eq!(models.len(), 6);
    assert_eq!(models[0]["parameters"].as_array().unwrap().len(), 0);
    assert_eq!(models[1]["left_out"].as_array().unwrap().len(), 3);
    // Round transparent yarns with another dye are worse on this sample than classical shading.
    assert_eq!(document["verdict"], "worse", "{document}");
    assert_eq!(output.status.code(), Some(1));
    let quick = specval(folder.path(), &[&arguments[..], &["--no-left-out"]].concat());
    assert_eq!(quick.status.code(), Some(2));
}
