use super::notice::TextNotice;

/// Decimal commas of a table: commas that separate nothing.
#[derive(Default)]
pub(super) struct Decimals {
    /// Number of cells such as `0,25`, and the line and text of the first.
    commas: usize,
    first_comma: Option<(usize, String)>,
    /// Of the first cell such as `0.25`.
    first_point: Option<(usize, String)>,
    /// A cell that cannot have its comma for thousands: `0,25`, `12,5` or `0,125`.
    is_certain: bool,
}

impl Decimals {
    /// A cell with a decimal point.
    pub(super) fn cell(&mut self, cell: String, line: usize) -> String {
        if !is_number_with(&cell, ',') {
            if self.first_point.is_none() && is_number_with(&cell, '.') {
                self.first_point = Some((line, cell.clone()));
            }
            return cell;
        }
        self.commas += 1;
        self.is_certain |= !may_be_thousands(&cell);
        let changed = cell.replace(',', ".");
        self.first_comma.get_or_insert((line, cell));
        changed
    }

    /// Line, what is expected, what was found and the remedy, where a comma can be a decimal mark or one of thousands.
    pub(super) fn ambiguous(&self) -> Option<(usize, &'static str, String, &'static str)> {
        const EXPECTED: &str = "one decimal mark in the whole table";
        let (line, comma) = self.first_comma.as_ref()?;
        if let Some((other, point)) = &self.first_point {
            let found = format!("a comma in {comma} and, on line {other}, a point in {point}");
            let remedy = "write every number with a decimal point, and nothing between thousands";
            return Some((*line, EXPECTED, found, remedy));
        }
        (!self.is_certain).then(|| {
            let found = format!("{comma}, whose comma can be a decimal mark or one of thousands");
            (
                *line,
                EXPECTED,
                found,
                "write a decimal point, or leave the mark of thousands out",
            )
        })
    }

    pub(super) fn notice(&self) -> Option<TextNotice> {
        let (line, first) = self.first_comma.as_ref()?;
        Some(TextNotice::DecimalCommas {
            cells: self.commas,
            first: first.clone(),
            line: *line,
        })
    }
}

/// Digits with this one decimal mark, perhaps a sign and an exponent.
fn is_number_with(cell: &str, mark: char) -> bool {
    let unsigned = cell.strip_prefix(['+', '-', '\u{2212}']).unwrap_or(cell);
    let (mantissa, exponent) = unsigned.split_once(['e', 'E']).unwrap_or((unsigned, "0"));
    let is_digits = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
    let exponent = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
    let parts = mantissa.split_once(mark);
    parts.is_some_and(|(whole, part)| mantissa.len() > 1 && is_digits(whole) && is_digits(part))
        && !exponent.is_empty()
        && is_digits(exponent)
}

/// One to three digits, the first not 0, and three more.
fn may_be_thousands(cell: &str) -> bool {
    let unsigned = cell.trim_start_matches(['+', '-', '\u{2212}']);
    let parts = unsigned.split_once(',');
    parts.is_some_and(|(whole, part)| (1..=3).contains(&whole.len()) && !whole.starts_with('0') && part.len() == 3)
}
