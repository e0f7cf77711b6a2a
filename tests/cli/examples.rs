//! The programs under examples/ run and show what they promise.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Cargo builds the examples with the tests, beside the program.
fn example(name: &str, arguments: &[&Path]) -> String {
    let beside = Path::new(env!("CARGO_BIN_EXE_specval")).parent().unwrap();
    let path: PathBuf = beside
        .join("examples")
        .join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    let output = Command::new(&path).args(arguments).output().unwrap_or_else(|error| {
        panic!(
            "{}: {error}; `cargo build --release --examples` makes it",
            path.display()
        )
    });
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_yarn_response_is_plotted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("f.svg");
    example("yarn_response", &[&path]);
    let svg = std::fs::read_to_string(path).unwrap();
    assert!(svg.contains("view angle") && svg.matches("<polyline").count() >= 3);
}

/// The dye absorbs blue and green far more than red, so more of it lowers both ratios; by 20 standard errors here.
#[test]
fn the_ratios_of_table_1_follow_the_absorption() {
    let ratio = |kappa: &str| -> f64 {
        let text = example("table1", &[Path::new(kappa)]);
        let line = text.lines().find(|line| line.starts_with("BLUE/RED")).unwrap();
        line.split_whitespace().nth(1).unwrap().parse().unwrap()
    };
    let (weak, strong) = (ratio("0.002"), ratio("0.02"));
    assert!(weak > 1.5 * strong && strong > 0.0, "{weak} {strong}");
}

#[test]
fn classical_shading_meets_a_measured_sample() {
    let text = example("classical", &[Path::new("merl-red-fabric")]);
    assert_eq!(text.lines().count(), 3, "{text}");
    assert!(text.lines().all(|line| line.ends_with("over 27 views")), "{text}");
}
