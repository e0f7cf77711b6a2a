//! Every deliberate fault of the physics turns the gates red that docs/checks.md says, and none is red without.

use serde_json::Value;
use specval::fault::Fault;
use std::process::Command;

/// Names of the broken gates of `check --quick`, in order.
fn broken(fault: &str) -> Vec<String> {
    let output = Command::new(env!("CARGO_BIN_EXE_specval"))
        .args(["check", "--quick", "--json", "--quiet"])
        .env("SPECVAL_FAULT", fault)
        .output()
        .unwrap();
    let document: Value = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|error| panic!("{fault}: {error}: {}", String::from_utf8_lossy(&output.stderr)));
    let gates: Vec<String> = document["gates"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|gate| gate["verdict"] == "broken")
        .map(|gate| gate["name"].as_str().unwrap().to_owned())
        .collect();
    let code = if gates.is_empty() { 0 } else { 1 };
    assert_eq!(output.status.code(), Some(code), "{fault}: {gates:?}");
    gates
}

#[test]
fn every_fault_turns_the_gates_red_that_the_table_names() {
    let docs = include_str!("../docs/checks.md");
    let (_, table) = docs.split_once("| fault | what is done | gates |").unwrap();
    let rows: Vec<(&str, Vec<&str>)> = table
        .lines()
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .map(|line| {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            let names = |cell: &'static str| cell.split('`').skip(1).step_by(2).collect::<Vec<_>>();
            (names(cells[1])[0], names(cells[3]))
        })
        .collect();
    let named: Vec<&str> = rows.iter().map(|(fault, _)| *fault).collect();
    let all: Vec<&str> = Fault::ALL.iter().map(|fault| fault.name()).collect();
    assert_eq!(named, all);
    assert_eq!(broken(""), Vec::<String>::new());
    for (fault, gates) in rows {
        let mut found = broken(fault);
        found.sort();
        let mut expected = gates.clone();
        expected.sort();
        assert_eq!(found, expected, "{fault}");
    }
}
