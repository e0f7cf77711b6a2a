//! Every deliberate fault of the physics turns the gates red that docs/checks.md says, and none is red without.

use specval::check::{self, CheckEffort, GateVerdict};
use specval::fault::{self, Fault};
use specval::run::Plan;
use specval::study::Study;

/// Few wavelengths and small tables: the laws are those of any study, and a check of it takes a tenth of the built-in
/// study's.
const SMALL: &str = "
[spectrum]
wavelengths_nm = [430.0, 530.0, 580.0, 660.0]
[rig]
pixels_per_side = 8
[trace]
bssrdf_azimuth_cells = 4
bssrdf_exit_theta_cells = 2
bssrdf_exit_phi_cells = 4
exit_azimuth_cells = 12
exit_theta_cells = 4
exit_phi_cells = 8
";
/// Wefts of a yarn of their own.
const WEFT: &str = "[weft]\nparticle_diameter_nm = 300.0\n";
/// Of the ledger.
const FEW_DIRECTIONS: &str = "zenith_cells = 3\nazimuth_cells = 8\n";

/// Names of the broken gates of `check --quick` with this fault, in alphabetical order.
fn broken(study: &str, fault: Option<Fault>) -> Vec<&'static str> {
    fault::commit(fault);
    let plan = Plan::new(Study::from_toml(study, "study").unwrap()).unwrap();
    let checked =
        check::study(&plan, CheckEffort::quick(), &|_| ()).unwrap_or_else(|error| panic!("{fault:?}: {error}"));
    fault::commit(None);
    let broken = checked.gates.iter().filter(|gate| gate.verdict == GateVerdict::Broken);
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

/// One fault is committed at a time, for the whole process: all of them are in one test.
#[test]
fn every_fault_turns_the_gates_red_that_the_table_names() {
    let rows = documented();
    let named: Vec<&str> = rows.iter().map(|(fault, _)| *fault).collect();
    assert_eq!(named, Fault::ALL.map(Fault::name));
    let (few, many) = (format!("{SMALL}{FEW_DIRECTIONS}"), SMALL.to_owned());
    let two_yarns = format!("{few}{WEFT}");
    assert_eq!(broken(&few, None), Vec::<&str>::new());
    assert_eq!(broken(&two_yarns, None), Vec::<&str>::new());
    let mut wrong = Vec::new();
    for (fault, (_, gates)) in Fault::ALL.into_iter().zip(&rows) {
        let study = match fault {
            // One in a hundred of what roulette gives takes paths from many directions to be seen.
            Fault::RouletteBias => &many,
            Fault::WeftAsWarp => &two_yarns,
            _ => &few,
        };
        let found = broken(study, Some(fault));
        if found != *gates {
            wrong.push((fault.name(), found));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
#[ignore = "minutes, and alone: the built-in study"]
fn so_it_does_with_the_built_in_study() {
    let caught = |(fault, (name, gates)): (Fault, (&'static str, Vec<&str>))| {
        let found = broken(if fault == Fault::WeftAsWarp { WEFT } else { "" }, Some(fault));
        (!gates.iter().any(|gate| found.contains(gate))).then_some((name, found))
    };
    let missed: Vec<_> = Fault::ALL.into_iter().zip(documented()).filter_map(caught).collect();
    assert!(missed.is_empty(), "{missed:#?}");
    assert_eq!(broken("", None), Vec::<&str>::new());
}

/// Light lost or gained in a cloth shaded with f* and all bounces is told in cloths of other weaves and of white yarns,
/// too.
#[test]
#[ignore = "minutes"]
fn light_lost_in_other_cloths_is_told() {
    let faults = [
        Fault::SunlitLoss,
        Fault::BetweenGain,
        Fault::BounceGain,
        Fault::PassageLoss,
        Fault::EnteringHigh,
        Fault::ApertureLoss,
        Fault::ClothLoss,
    ];
    for cloth in ["[cloth]\nweave = \"twill-2-1\"\n", "[medium]\nkappa_peak = 0.0\n"] {
        let study = format!("{SMALL}{FEW_DIRECTIONS}{cloth}");
        assert_eq!(broken(&study, None), Vec::<&str>::new(), "{cloth}");
        for fault in faults {
            assert_ne!(broken(&study, Some(fault)), Vec::<&str>::new(), "{fault:?} {cloth}");
        }
    }
}
