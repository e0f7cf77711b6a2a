//! The Percus–Yevick structure factor against the closed form in 50 digits.

use specval::optics::percus_yevick;

use super::reference::{Table, relative};

#[test]
fn closed_form_in_fifty_digits() {
    let table = Table::parse(include_str!("../../data/mie/py_structure_factor.csv"));
    assert_eq!(table.len(), 201);
    for row in table.rows() {
        for (column, eta) in [("S_eta0.14", 0.14), ("S_eta0.30", 0.30), ("S_eta0.45", 0.45)] {
            let found = percus_yevick(row.number("qd"), eta);
            let error = relative(found, row.number(column));
            assert!(error <= 1e-10, "{column} at {row:?}: {found:e} is off by {error:e}");
        }
    }
}

/// Between the rows of the table the function is as smooth as between its series and its closed form: no jump at the
/// seam.
#[test]
fn smooth_across_the_seam_of_its_two_forms() {
    for eta in [0.05, 0.14, 0.7] {
        let [below, at, above] = [2.0 - 1e-6, 2.0, 2.0 + 1e-6].map(|qd| percus_yevick(qd, eta));
        assert!((above - 2.0 * at + below).abs() <= 1e-11 * at, "{below} {at} {above}");
    }
}
