//! Reference tables, Gauss–Legendre nodes and relative errors for the tests of the optics.

use std::f64::consts::PI;

/// A CSV whose first lines, marked `#`, say where it comes from.
pub struct Table {
    header: Vec<&'static str>,
    rows: Vec<Vec<&'static str>>,
}

impl Table {
    pub fn parse(text: &'static str) -> Self {
        let mut lines = text
            .lines()
            .filter(|l| !l.starts_with('#') && !l.is_empty())
            .map(|l| l.split(',').collect());
        Self {
            header: lines.next().unwrap(),
            rows: lines.collect(),
        }
    }

    pub fn len(&self) -> usize {
        self.rows.len()
    }

    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|cells| Row { table: self, cells })
    }
}

pub struct Row<'t> {
    table: &'t Table,
    cells: &'t [&'static str],
}

impl Row<'_> {
    pub fn text(&self, column: &str) -> &'static str {
        self.cells[self.table.header.iter().position(|h| *h == column).unwrap()]
    }

    pub fn number(&self, column: &str) -> f64 {
        self.text(column).parse().unwrap()
    }
}

impl std::fmt::Debug for Row<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.cells[..self.cells.len().min(5)].join(","))
    }
}

pub fn relative(found: f64, expected: f64) -> f64 {
    if found == expected {
        0.0
    } else {
        ((found - expected) / expected).abs()
    }
}

/// Nodes and weights on −1..1: Newton's method on the recurrence, no table.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 0.0;
            for _ in 0..8 {
                let (mut p, mut below) = (x, 1.0);
                for k in 2..=n {
                    let k = k as f64;
                    (p, below) = (((2.0 * k - 1.0) * x * p - (k - 1.0) * below) / k, p);
                }
                slope = n as f64 * (x * p - below) / (x * x - 1.0);
                x -= p / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}
