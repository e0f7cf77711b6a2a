//! Table 1: colour ratios at normal illumination and view.

use super::{ColourRatios, PropagatedEstimate, SourceId};
use crate::sample::PublishedRatios;
use serde::{Deserialize, Serialize};

/// What a row of Table 1 is of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "String", into = "String")]
pub enum Table1Name {
    /// The preprint's cloth.
    Published,
    /// A sample, or a model at the study's own parameters.
    Source(SourceId),
    /// Lowest and highest ratio of the model over the sweep.
    ModelLow,
    ModelHigh,
    /// The model without light between the yarns, and with all of it.
    ModelDirect,
    ModelAllBounces,
}

impl Table1Name {
    const OTHERS: [(Self, &'static str); 5] = [
        (Self::Published, "published"),
        (Self::ModelLow, "model_low"),
        (Self::ModelHigh, "model_high"),
        (Self::ModelDirect, "model_direct"),
        (Self::ModelAllBounces, "model_all_bounces"),
    ];
}

impl From<String> for Table1Name {
    fn from(word: String) -> Self {
        let other = Self::OTHERS.into_iter().find(|(_, name)| *name == word);
        other.map_or_else(|| Self::Source(word.into()), |(other, _)| other)
    }
}

impl From<Table1Name> for String {
    fn from(name: Table1Name) -> Self {
        if let Table1Name::Source(id) = name {
            return id.into();
        }
        let other = Table1Name::OTHERS.into_iter().find(|(other, _)| *other == name);
        other.map_or_else(Self::new, |(_, word)| word.into())
    }
}

/// Ratios of linear RGB at normal illumination and view; `None` where there is no such value, or none that is known: no
/// light was hit, or one batch too few.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Table1Row {
    pub row: Table1Name,
    pub blue_over_red: Option<f64>,
    pub blue_over_red_se: Option<f64>,
    pub green_over_red: Option<f64>,
    pub green_over_red_se: Option<f64>,
}

impl Table1Row {
    /// Ratios with their standard errors, of those that are known; none where red is as good as 0.
    pub fn estimated(row: Table1Name, ratios: &ColourRatios) -> Self {
        let known = |ratio: &PropagatedEstimate| {
            let value = Some(ratio.value).filter(|value| value.is_finite() && !ratios.red_is_zero);
            [value, value.and_then(|value| known_error(value, ratio.se))]
        };
        let [blue_over_red, blue_over_red_se] = known(&ratios.blue_over_red);
        let [green_over_red, green_over_red_se] = known(&ratios.green_over_red);
        Self {
            row,
            blue_over_red,
            blue_over_red_se,
            green_over_red,
            green_over_red_se,
        }
    }

    /// Ratios that come without an error.
    pub fn bare(row: Table1Name, blue_over_red: f64, green_over_red: f64) -> Self {
        Self {
            row,
            blue_over_red: Some(blue_over_red),
            blue_over_red_se: None,
            green_over_red: Some(green_over_red),
            green_over_red_se: None,
        }
    }
}

/// The standard error of a value, if there is one: neither undefined nor the rounding of batches that are all equal.
pub(crate) fn known_error(value: f64, se: f64) -> Option<f64> {
    /// Rounding of a mean and its spread, relative.
    const ROUNDING: f64 = 1e-12;
    (se.is_finite() && se > ROUNDING * value.abs()).then_some(se)
}

/// Ratios of one source of Table 1.
#[derive(Clone, Debug)]
pub struct Table1Source<'a> {
    pub id: SourceId,
    pub ratios: &'a ColourRatios,
    /// Whether its standard errors mean anything; a sample may state none.
    pub errors_stated: bool,
}

/// What Table 1 shows.
#[derive(Clone, Debug)]
pub struct Table1<'a> {
    /// `None` of a cloth that is not the preprint's.
    pub published: Option<PublishedRatios>,
    /// Samples, then models.
    pub sources: Vec<Table1Source<'a>>,
    /// Of the model over the sweep; `None` where no medium has a ratio.
    pub range: Option<RatioRanges>,
    /// Of the model with direct light alone, and with all light between the yarns.
    pub orders: &'a [ColourRatios; 2],
}

impl Table1<'_> {
    pub fn rows(&self) -> Vec<Table1Row> {
        let mut rows = Vec::new();
        rows.extend(self.published.map(|PublishedRatios { real, .. }| {
            Table1Row::bare(Table1Name::Published, real.blue_over_red[0], real.green_over_red[0])
        }));
        for source in &self.sources {
            let mut row = Table1Row::estimated(Table1Name::Source(source.id.clone()), source.ratios);
            if !source.errors_stated {
                (row.blue_over_red_se, row.green_over_red_se) = (None, None);
            }
            rows.push(row);
        }
        if let Some(RatioRanges { low, high }) = &self.range {
            rows.push(Table1Row::estimated(Table1Name::ModelLow, low));
            rows.push(Table1Row::estimated(Table1Name::ModelHigh, high));
        }
        let [direct, all] = self.orders;
        rows.push(Table1Row::estimated(Table1Name::ModelDirect, direct));
        rows.push(Table1Row::estimated(Table1Name::ModelAllBounces, all));
        rows
    }
}

/// Ends of the ratios over several media, each end with its standard error; blue and green may come from different
/// media.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RatioRanges {
    pub low: ColourRatios,
    pub high: ColourRatios,
}

impl RatioRanges {
    /// Of those media whose red is not as good as 0; `None` if there are none.
    pub fn of<'a>(media: impl IntoIterator<Item = &'a ColourRatios>) -> Option<Self> {
        let mut media = media.into_iter().filter(|ratios| !ratios.red_is_zero);
        let first = *media.next()?;
        let mut range = Self {
            low: first,
            high: first,
        };
        for ratios in media {
            for (end, better) in [(&mut range.low, -1.0), (&mut range.high, 1.0)] {
                if better * (ratios.blue_over_red.value - end.blue_over_red.value) > 0.0 {
                    end.blue_over_red = ratios.blue_over_red;
                }
                if better * (ratios.green_over_red.value - end.green_over_red.value) > 0.0 {
                    end.green_over_red = ratios.green_over_red;
                }
            }
        }
        Some(range)
    }

    /// Lowest and highest BLUE/RED.
    pub fn blue_over_red(&self) -> [f64; 2] {
        [self.low, self.high].map(|end| end.blue_over_red.value)
    }

    /// Lowest and highest GREEN/RED.
    pub fn green_over_red(&self) -> [f64; 2] {
        [self.low, self.high].map(|end| end.green_over_red.value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratios(blue: f64, green: f64, red: f64) -> ColourRatios {
        let of = |value: f64| PropagatedEstimate {
            value,
            se: 0.1 * value.abs(),
            bias_monte_carlo: 0.0,
            se_monte_carlo: 0.1 * value.abs(),
            se_measurement: 0.0,
        };
        ColourRatios {
            blue_over_red: of(blue),
            green_over_red: of(green),
            red: of(red),
            red_is_zero: red == 0.0,
        }
    }

    #[test]
    fn range_takes_each_end_with_its_error_and_leaves_out_media_without_red() {
        let media = [
            ratios(9.0, 9.0, 0.0),
            ratios(0.1, 0.04, 1.0),
            ratios(0.2, 0.01, 1.0),
            ratios(0.05, 0.02, 1.0),
        ];
        let range = RatioRanges::of(&media).unwrap();
        assert_eq!(
            (range.blue_over_red(), range.green_over_red()),
            ([0.05, 0.2], [0.01, 0.04])
        );
        assert_eq!(range.high.blue_over_red, media[2].blue_over_red);
        assert_eq!(range.low.green_over_red, media[2].green_over_red);
        assert_eq!(RatioRanges::of(&media[..1]), None);
    }

    #[test]
    fn rows_are_named_by_their_sources() {
        let orders = [ratios(0.1, 0.1, 1.0), ratios(0.2, 0.2, 0.0)];
        let source = |id: &str, errors_stated| Table1Source {
            id: id.into(),
            ratios: &orders[0],
            errors_stated,
        };
        let table = Table1 {
            published: None,
            sources: vec![
                source("measured", true),
                source("measured-2", false),
                source("model", true),
            ],
            range: RatioRanges::of(&orders),
            orders: &orders,
        };
        let rows = table.rows();
        let json = serde_json::to_value(&rows).unwrap();
        let names: Vec<&str> = json
            .as_array()
            .unwrap()
            .iter()
            .filter_map(|row| row["row"].as_str())
            .collect();
        let expected = [
            "measured",
            "measured-2",
            "model",
            "model_low",
            "model_high",
            "model_direct",
            "model_all_bounces",
        ];
        assert_eq!(names, expected);
        assert_eq!(serde_json::from_value::<Vec<Table1Row>>(json).unwrap(), rows);
        assert_eq!((rows[1].blue_over_red, rows[1].blue_over_red_se), (Some(0.1), None));
        assert_eq!((rows[6].blue_over_red, rows[6].blue_over_red_se), (None, None));
    }
}
