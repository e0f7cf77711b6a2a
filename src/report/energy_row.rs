use crate::transport::{Column, Estimate, Fraction, FractionList};
use serde::de::Error;
use serde::ser::SerializeStruct;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::HashMap;
use std::ops::{Index, IndexMut};

const KEYS: [&str; 3] = ["wavelength_nm", "theta_in_deg", "phi_in_deg"];

/// Energy ledger of one wavelength and incident direction: fractions of the incident flux, each with its standard
/// error. Indexed by fraction; [`Fraction::RouletteNet`] is here the net of all sampling, as [`Column::Fraction`] says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnergyRow {
    pub wavelength_nm: f64,
    pub theta_in_deg: f64,
    pub phi_in_deg: f64,
    /// 1 − the sum of the fractions.
    pub residual: Estimate,
    fractions: [Estimate; Fraction::COUNT],
}

impl EnergyRow {
    /// `columns` in the order of [`Column::ALL`].
    pub fn new(wavelength_nm: f64, [theta_in_deg, phi_in_deg]: [f64; 2], columns: [Estimate; Column::COUNT]) -> Self {
        let mut row = Self {
            wavelength_nm,
            theta_in_deg,
            phi_in_deg,
            ..Self::default()
        };
        for (column, estimate) in Column::ALL.into_iter().zip(columns) {
            match column {
                Column::Fraction(fraction) => row[fraction] = estimate,
                Column::Residual => row.residual = estimate,
            }
        }
        row
    }

    pub fn column(&self, column: Column) -> Estimate {
        match column {
            Column::Fraction(fraction) => self[fraction],
            Column::Residual => self.residual,
        }
    }

    /// Every column in the order of [`Column::ALL`].
    pub fn columns(&self) -> [Estimate; Column::COUNT] {
        Column::ALL.map(|column| self.column(column))
    }

    /// Names of the columns of `energy.csv`.
    pub fn header() -> Vec<&'static str> {
        let columns = Column::ALL.into_iter();
        let names = columns.flat_map(|column| [column.name(), column.se_name()]);
        KEYS.into_iter().chain(names).collect()
    }
}

impl Index<Fraction> for EnergyRow {
    type Output = Estimate;

    fn index(&self, fraction: Fraction) -> &Estimate {
        &self.fractions[fraction.index()]
    }
}

impl IndexMut<Fraction> for EnergyRow {
    fn index_mut(&mut self, fraction: Fraction) -> &mut Estimate {
        &mut self.fractions[fraction.index()]
    }
}

impl Serialize for EnergyRow {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut row = serializer.serialize_struct("EnergyRow", KEYS.len() + 2 * Column::COUNT)?;
        for (key, value) in KEYS
            .into_iter()
            .zip([self.wavelength_nm, self.theta_in_deg, self.phi_in_deg])
        {
            row.serialize_field(key, &value)?;
        }
        for column in Column::ALL {
            let Estimate { value, se } = self.column(column);
            row.serialize_field(column.name(), &value)?;
            row.serialize_field(column.se_name(), &se)?;
        }
        row.end()
    }
}

impl<'de> Deserialize<'de> for EnergyRow {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let fields: HashMap<String, Option<f64>> = Deserialize::deserialize(deserializer)?;
        // A number that is not known is null in JSON.
        let field = |name: &'static str| match fields.get(name) {
            Some(value) => Ok(value.unwrap_or(f64::NAN)),
            None => Err(D::Error::missing_field(name)),
        };
        let [wavelength_nm, theta_in_deg, phi_in_deg] = KEYS.map(field);
        let mut columns = [Estimate::default(); Column::COUNT];
        for (estimate, column) in columns.iter_mut().zip(Column::ALL) {
            *estimate = Estimate {
                value: field(column.name())?,
                se: field(column.se_name())?,
            };
        }
        Ok(Self::new(wavelength_nm?, [theta_in_deg?, phi_in_deg?], columns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_read_back_from_json_in_the_order_of_their_header() {
        let columns = std::array::from_fn(|k| Estimate {
            value: k as f64,
            se: 0.5 + k as f64,
        });
        let row = EnergyRow::new(600.0, [5.0, 10.0], columns);
        let json = serde_json::to_string(&row).unwrap();
        assert_eq!(serde_json::from_str::<EnergyRow>(&json).unwrap(), row);
        let places: Vec<_> = EnergyRow::header()
            .iter()
            .map(|name| json.find(&format!("\"{name}\":")))
            .collect();
        assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{json}");
    }

    #[test]
    fn null_is_an_unknown_number_and_a_missing_column_is_refused() {
        let json = serde_json::to_string(&EnergyRow::default()).unwrap();
        let unknown = json.replace("\"residual_se\":0.0", "\"residual_se\":null");
        assert!(
            serde_json::from_str::<EnergyRow>(&unknown)
                .unwrap()
                .residual
                .se
                .is_nan()
        );
        let short = json.replace(",\"mis_net_se\":0.0", "");
        let error = serde_json::from_str::<EnergyRow>(&short).unwrap_err().to_string();
        assert!(error.contains("missing field `mis_net_se`"), "{error}");
    }
}
