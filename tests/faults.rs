//! Every deliberate fault of the physics turns the gates red that docs/checks.md says, and none is red without.

use specval::check::{self, CheckEffort, Verdict};
use specval::fault::{self, Fault};
use specval::run::Plan;
use specval::study::Study;

/// Few wavelengths and small tables: the laws are those of any study, and a check of it takes a tenth of the built-in study's.
const SMALL: &str = "
[spectrum]
wavelengths_nm = [430.0, 530.0, 580.0, 660.0]
[trace]
bssrdf_azimuth_cells = 4
bssrdf_exit_theta_cells = 2
bssrdf_exit_phi_cells = 4
exit_azimuth_cells = 12
exit_theta_cells = 4
exit_phi_cells = 8
zenith_cells = 3
azimuth_cells = 8
[rig]
pixels_per_side = 8
";

/// Names of the broken gates of a check with this fault, in order.
fn broken(study: &str, effort: CheckEffort, fault: Option<Fault>) -> Vec<&'static str> {
    fault::commit(fault);
    let plan = Plan::new(Study::from_toml(study, "study").unwrap()).unwrap();
    let checked = check::study(&plan, effort, &|_| ()).unwrap_or_else(|error| panic!("{fault:?}: {error}"));
    fault::commit(None);
    let broken = checked.gates.iter().filter(|gate| gate.verdict == Verdict::Broken);
    let mut names: Vec<&str> = broken.map(|gate| gate.name).collect();
    names.sort();
    names
}

/// The rows of the table, each a fault and the gates it breaks.
fn documented() -> Vec<(&'static str, Vec<&'static str>)> {
    let docs = include_str!("../docs/checks.md");
    let (_, table) = docs.split_once("| fault | what is done | gates |").unwrap();
    let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    rows.map(|line| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let names = |cell: &'static str| cell.split('`').skip(1).step_by(2).collect::<Vec<_>>();
        let mut gates = names(cells[3]);
        gates.sort();
        (names(cells[1])[0], gates)
    })
    .collect()
}

fn holds_the_table_against(study: &str, effort: CheckEffort) {
    let rows = documented();
    let named: Vec<&str> = rows.iter().map(|(fault, _)| *fault).collect();
    assert_eq!(named, Fault::ALL.map(Fault::name));
    assert_eq!(broken(study, effort, None), Vec::<&str>::new());
    let found: Vec<(&str, Vec<&str>)> = Fault::ALL
        .into_iter()
        .map(|fault| (fault.name(), broken(study, effort, Some(fault))))
        .collect();
    for (found, expected) in std::iter::zip(&found, &rows) {
        println!("{found:?}");
        if found != expected {
            println!("    expected {:?}", expected.1);
        }
    }
    assert!(found == rows, "see above");
}

/// One fault is committed at a time, so this is the only test that runs beside none.
#[test]
fn every_fault_turns_the_gates_red_that_the_table_names() {
    holds_the_table_against(SMALL, CheckEffort::quick());
}

#[test]
#[ignore = "minutes, and alone: the built-in study"]
fn so_it_does_with_the_built_in_study() {
    holds_the_table_against("", CheckEffort::quick());
}
