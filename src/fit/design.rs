//! Designs of experiments: points of a space of parameters.

use super::FitError;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::str::FromStr;

/// Most points of a design.
const MOST_POINTS: usize = 100_000;

/// A parameter and the values that it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Key of the study, as `section.key`.
    pub key: String,
    levels: Levels,
    /// Whether the values were written one by one, and so are meant as they are.
    listed: bool,
}

#[derive(Clone, Debug, PartialEq)]
enum Levels {
    List(Vec<f64>),
    /// Everything between two ends.
    Range {
        from: f64,
        to: f64,
        logarithmic: bool,
    },
}

/// How points are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Design {
    /// Every value of every axis with every one of the others, the last axis fastest.
    Grid,
    /// One point in each of `points` equal strata of each axis (McKay, Beckman and Conover 1979).
    LatinHypercube { points: usize },
    /// The Sobol sequence with Owen's scrambling, whose first points fill the space at every number of them.
    Sobol { points: usize },
}

impl FromStr for Axis {
    type Err = FitError;

    /// `KEY=FROM:TO:COUNT`, `KEY=FROM:TO:COUNT:log`, `KEY=FROM:TO`, `KEY=FROM:TO:log` or `KEY=V1,V2,...`.
    fn from_str(text: &str) -> Result<Self, FitError> {
        let refuse = |found: &str| FitError::Axis {
            text: text.into(),
            found: found.into(),
        };
        let (key, values) = text.split_once('=').ok_or_else(|| refuse("no `=`"))?;
        let number = |word: &str| {
            let number: Option<f64> = word.trim().parse().ok().filter(|number: &f64| number.is_finite());
            number.ok_or_else(|| refuse(&format!("'{}', which is no finite number", word.trim())))
        };
        let levels = if values.contains(':') {
            let mut words: Vec<&str> = values.split(':').collect();
            let logarithmic = words.last() == Some(&"log");
            if logarithmic {
                words.pop();
            }
            let (from, to, count) = match words[..] {
                [from, to] => (number(from)?, number(to)?, None),
                [from, to, count] => (number(from)?, number(to)?, Some(count)),
                _ => return Err(refuse(&format!("{} parts between colons", words.len()))),
            };
            if logarithmic && (from <= 0.0 || to <= 0.0) {
                return Err(refuse("an end of a logarithmic range that is not above 0"));
            }
            if from == to {
                return Err(refuse("a range whose ends are the same"));
            }
            let range = Levels::Range { from, to, logarithmic };
            match count {
                None => range,
                Some(count) => {
                    let count: usize = count
                        .trim()
                        .parse()
                        .ok()
                        .filter(|count| (2..=MOST_POINTS).contains(count))
                        .ok_or_else(|| {
                            refuse(&format!("the count '{}', not a whole number from 2 on", count.trim()))
                        })?;
                    Levels::List((0..count).map(|k| range.at(k as f64 / (count - 1) as f64)).collect())
                }
            }
        } else {
            Levels::List(values.split(',').map(number).collect::<Result<_, _>>()?)
        };
        Ok(Self {
            key: key.trim().into(),
            levels,
            listed: !values.contains(':'),
        })
    }
}

impl Levels {
    /// The value at a place from 0 to 1.
    fn at(&self, place: f64) -> f64 {
        match self {
            Self::List(values) => {
                let index = (place * values.len() as f64) as usize;
                values[index.min(values.len() - 1)]
            }
            Self::Range { from, to, .. } if place == 0.0 || place == 1.0 => {
                if place == 0.0 {
                    *from
                } else {
                    *to
                }
            }
            Self::Range {
                from,
                to,
                logarithmic: true,
            } => from * (to / from).powf(place),
            Self::Range { from, to, .. } => from + place * (to - from),
        }
    }
}

impl Axis {
    /// The same with the values of its range at the nearest multiples of a whole number, as a key of whole numbers
    /// takes them; values that were written one by one stay.
    #[must_use]
    pub fn in_steps_of(self, step: u64) -> Self {
        if self.listed {
            return self;
        }
        let nearest = |value: f64| (value / step as f64).round() * step as f64;
        let levels = match self.levels {
            Levels::List(values) => {
                let mut values: Vec<f64> = values.into_iter().map(nearest).collect();
                values.dedup();
                Levels::List(values)
            }
            Levels::Range { from, to, .. } => {
                let (low, high) = (nearest(from.min(to)), nearest(from.max(to)));
                let count = ((high - low) / step as f64) as usize;
                Levels::List((0..=count).map(|k| low + (k as u64 * step) as f64).collect())
            }
        };
        Self { levels, ..self }
    }

    /// The values at which a range of the study's key is tried before any work: the list, or its two ends.
    pub fn extremes(&self) -> Vec<f64> {
        match &self.levels {
            Levels::List(values) => values.clone(),
            Levels::Range { from, to, .. } => vec![*from, *to],
        }
    }
}

impl Design {
    /// `grid`, `lhs` or `sobol`; the last two with a number of points.
    ///
    /// # Errors
    /// Another word, or a number of points that is missing, not due or out of range.
    pub fn named(name: &str, points: Option<usize>) -> Result<Self, FitError> {
        let refuse = |expected: &'static str, found: String| FitError::Design { expected, found };
        let points = |name| match points {
            Some(points) if (1..=MOST_POINTS).contains(&points) => Ok(points),
            Some(points) => Err(refuse("--points from 1 to 100000", points.to_string())),
            None => Err(refuse(
                "--points N beside --design lhs and --design sobol",
                format!("--design {name} alone"),
            )),
        };
        match name {
            "grid" if points("grid").is_ok() => Err(refuse(
                "--design grid without --points: it has a point for every combination",
                "--points".into(),
            )),
            "grid" => Ok(Self::Grid),
            "lhs" => Ok(Self::LatinHypercube { points: points(name)? }),
            "sobol" => Ok(Self::Sobol { points: points(name)? }),
            _ => Err(refuse("--design grid, lhs or sobol", name.into())),
        }
    }

    /// The points, each with a value an axis. The same for the same axes and seed.
    ///
    /// # Errors
    /// No axis, one key twice, a range without a count in a grid, or too many points.
    pub fn points(self, axes: &[Axis], seed: u64) -> Result<Vec<Vec<f64>>, FitError> {
        let refuse = |expected: &'static str, found: String| FitError::Design { expected, found };
        if axes.is_empty() {
            return Err(refuse("one --vary or more", "none".into()));
        }
        if let Some((_, axis)) = axes
            .iter()
            .enumerate()
            .find(|(place, axis)| axes[..*place].iter().any(|other| other.key == axis.key))
        {
            return Err(refuse("every key once", format!("{} twice", axis.key)));
        }
        match self {
            Self::Grid => {
                let mut points: Vec<Vec<f64>> = vec![Vec::new()];
                for axis in axes {
                    let Levels::List(values) = &axis.levels else {
                        return Err(refuse(
                            "a number of values in each range of a grid: KEY=FROM:TO:COUNT",
                            format!("{} without", axis.key),
                        ));
                    };
                    if points.len().saturating_mul(values.len()) > MOST_POINTS {
                        return Err(refuse("100000 points or fewer", "a larger grid".into()));
                    }
                    let with = |point: &Vec<f64>, value: &f64| point.iter().chain([value]).copied().collect();
                    points = points
                        .iter()
                        .flat_map(|point| values.iter().map(move |value| with(point, value)))
                        .collect();
                }
                Ok(points)
            }
            Self::LatinHypercube { points } => {
                let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
                let columns: Vec<Vec<f64>> = axes
                    .iter()
                    .map(|axis| {
                        let mut strata: Vec<usize> = (0..points).collect();
                        strata.shuffle(&mut rng);
                        let place = |stratum: usize, within: f64| (stratum as f64 + within) / points as f64;
                        strata
                            .into_iter()
                            .map(|stratum| axis.levels.at(place(stratum, rng.random())))
                            .collect()
                    })
                    .collect();
                Ok((0..points)
                    .map(|point| columns.iter().map(|column| column[point]).collect())
                    .collect())
            }
            Self::Sobol { points } => {
                let dimensions = sobol_burley::NUM_DIMENSIONS as usize;
                if axes.len() > dimensions {
                    return Err(refuse("256 axes or fewer of a Sobol sequence", axes.len().to_string()));
                }
                // Other bits of the seed would be lost.
                let seed = (seed ^ (seed >> 32)) as u32;
                let place =
                    |point: usize, axis: usize| f64::from(sobol_burley::sample(point as u32, axis as u32, seed));
                Ok((0..points)
                    .map(|point| {
                        let axes = axes.iter().enumerate();
                        axes.map(|(number, axis)| axis.levels.at(place(point, number)))
                            .collect()
                    })
                    .collect())
            }
        }
    }
}
