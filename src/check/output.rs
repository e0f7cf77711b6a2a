//! A check as text, as JUnit XML and as annotations of GitHub's workflow commands: pure functions.

use super::gate::{Gate, GateVerdict};
use super::{CheckError, Checked};
use crate::number::significant;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};
use std::fmt::Write;

/// A line a gate, then what moved, then the verdict.
pub fn table(checked: &Checked) -> String {
    let width = checked.gates.iter().map(|gate| gate.name.len()).max().unwrap_or(0);
    let mut text = format!(
        "{:<width$} {:<10} {:>7} {:>10} {:>9} {:>9} {:>7}  worst at\n",
        "gate", "verdict", "cells", "value", "se", "tolerance", "z"
    );
    for gate in &checked.gates {
        let z = gate.z.map_or("–".into(), |z| significant(z, 3));
        let _ = writeln!(
            text,
            "{:<width$} {:<10} {:>7} {:>10} {:>9} {:>9} {z:>7}  {}",
            gate.name,
            gate.verdict.word(),
            gate.cells,
            significant(gate.value, 3),
            significant(gate.se, 2),
            significant(gate.tolerance, 2),
            gate.worst
        );
    }
    for gate in &checked.gates {
        if gate.verdict != GateVerdict::Holds || gate.note.is_some() {
            let _ = writeln!(text, "\n{}: {}\n  {}", gate.name, gate.law, gate.message());
        }
    }
    if let Some(drift) = checked.drift.as_ref().filter(|drift| !drift.moved.is_empty()) {
        let _ = writeln!(
            text,
            "\n{:<28} {:>13} {:>12} {:>12} {:>8}",
            "moved", "wavelength_nm", "value", "baseline", "sigmas"
        );
        for moved in &drift.moved {
            let _ = writeln!(
                text,
                "{:<28} {:>13} {:>12.6} {:>12.6} {:>8.2}",
                moved.name, moved.wavelength_nm, moved.value, moved.baseline, moved.sigmas
            );
        }
    }
    let count = |verdict| checked.gates.iter().filter(|gate| gate.verdict == verdict).count();
    let _ = writeln!(
        text,
        "\n{}: {} hold, {} broken, {} undecided",
        checked.verdict.word(),
        count(GateVerdict::Holds),
        count(GateVerdict::Broken),
        count(GateVerdict::Undecided)
    );
    text
}

/// One test per gate: a broken law is a failure, an undecided one an error.
pub fn junit(checked: &Checked) -> Result<Vec<u8>, CheckError> {
    let count = |verdict| {
        let gates = checked.gates.iter().filter(|gate| gate.verdict == verdict);
        gates.count().to_string()
    };
    let totals = [
        ("tests", checked.gates.len().to_string()),
        ("failures", count(GateVerdict::Broken)),
        ("errors", count(GateVerdict::Undecided)),
    ];
    let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
    writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let attributes = |name: &'static str| {
        let totals = totals.iter().map(|(key, value)| (*key, value.as_str()));
        std::iter::once(("name", name)).chain(totals).collect::<Vec<_>>()
    };
    writer
        .create_element("testsuites")
        .with_attributes(attributes("specval check"))
        .write_inner_content(|writer| {
            writer
                .create_element("testsuite")
                .with_attributes(attributes(checked.subject.kind))
                .write_inner_content(|writer| checked.gates.iter().try_for_each(|gate| case(writer, gate)))?;
            Ok(())
        })?;
    let mut bytes = writer.into_inner();
    bytes.push(b'\n');
    Ok(bytes)
}

fn case(writer: &mut Writer<Vec<u8>>, gate: &Gate) -> std::io::Result<()> {
    let case = writer
        .create_element("testcase")
        .with_attributes([("classname", "specval.check"), ("name", gate.name)]);
    let message = gate.message();
    let outcome = match gate.verdict {
        GateVerdict::Holds => "system-out",
        GateVerdict::Broken => "failure",
        GateVerdict::Undecided => "error",
    };
    case.write_inner_content(|writer| {
        let element = writer.create_element(outcome);
        let element = match gate.verdict {
            GateVerdict::Holds => element,
            _ => element.with_attributes([("message", message.as_str())]),
        };
        element.write_text_content(BytesText::new(&format!("{}: {message}", gate.law)))?;
        Ok(())
    })?;
    Ok(())
}

/// Workflow commands of GitHub Actions: an error for every broken law, a warning for every undecided one.
pub fn annotations(checked: &Checked) -> String {
    let mut text = String::new();
    for gate in &checked.gates {
        let command = match gate.verdict {
            GateVerdict::Holds => continue,
            GateVerdict::Broken => "error",
            GateVerdict::Undecided => "warning",
        };
        let message = format!("{}: {}", gate.law, gate.message());
        let message = message.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A");
        let _ = writeln!(text, "::{command} title=specval check {}::{message}", gate.name);
    }
    text
}
