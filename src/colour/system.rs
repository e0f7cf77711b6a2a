use nalgebra::{Matrix3, Vector3};

use super::interpolation::{SpectralInterpolation, uniform_step};
use super::rgb_space::bradford;
use super::{Adaptation, Colour, ColourError, Convention, Illuminant, Lab, LinearRgb, Xyz};
use crate::fault::{self, Fault};
use crate::spectrum::{Spectrum, WavelengthGrid};

/// The conversion of spectra on one wavelength grid under one [`Convention`], weights worked out once.
///
/// X = k Σ S(λ) x̄(λ) β(λ), likewise Y and Z, k = 1/Σ S ȳ, so the perfect diffuser has Y = 1. On a grid that resolves
/// the observer, of equal steps of 10 nm at most over 390..730 nm or more, the sums run over exactly its wavelengths:
/// no interpolation, no correction of the ends.
///
/// On any other grid they run over every nanometre of the tables, 360..780 nm, and β is interpolated: by Sprague's
/// polynomial where six or more steps are equal, else linearly, and beyond the ends it is that of the nearest end (the
/// practice of ASTM E308). Whatever the grid, the perfect diffuser is then the same white, and a grey sample stays
/// grey. Against 10 nm over 390..730 nm, on the reflectances of a colour chart and of dyed cloths, the colour
/// difference of this is at most 0.04 ΔE*ab for 400..700 nm in steps of 10 nm, 0.3 in steps of 20 nm, and 20 for three
/// wavelengths.
#[derive(Clone, Debug)]
pub struct ColourSystem {
    convention: Convention,
    /// k S times x̄, ȳ, z̄, a row a wavelength.
    weights: Vec<Vector3<f64>>,
    white: Vector3<f64>,
    /// XYZ → linear RGB, adaptation included.
    to_rgb: Matrix3<f64>,
    method: String,
    fitness: Fitness,
}

/// Whether a grid can carry a colour.
#[derive(Clone, Debug, PartialEq)]
enum Fitness {
    Sound,
    /// Why the colour is doubtful.
    Doubtful(String),
    /// Why there is none.
    None(String),
}

/// Where a grid must lie for plain sums, and where tables of a file must have values as far as the grid goes, in nm.
const PLAIN_NM: [f64; 2] = [390.0, 730.0];
/// Largest step of plain sums, in nm.
const PLAIN_STEP_NM: f64 = 10.0;
/// Range of the CIE tables that are built in, in nm.
const TABLES_NM: [f64; 2] = [360.0, 780.0];

impl ColourSystem {
    /// Any grid has a conversion; whether it means a colour is for [`Self::doubt`] and [`Self::require`] to say.
    ///
    /// # Errors
    /// A table of the user's own that does not cover the grid; an illuminant or observer that sees nothing.
    pub fn new(grid: &WavelengthGrid, convention: Convention) -> Result<Self, ColourError> {
        let observer = convention.observer.tables()?;
        let illuminant = match &convention.illuminant {
            Illuminant::D65 if fault::active(Fault::IlluminantSwap) => &Illuminant::E,
            Illuminant::E if fault::active(Fault::IlluminantSwap) => &Illuminant::D65,
            illuminant => illuminant,
        };
        let tables = [illuminant.power()?, &observer.x_bar, &observer.y_bar, &observer.z_bar];
        let (low, high) = (grid.nm()[0], grid.nm()[grid.len() - 1]);
        let fine = uniform_step(grid).is_some_and(|step| step <= PLAIN_STEP_NM * (1.0 + 1e-9));
        let is_plain = fine && low <= PLAIN_NM[0] && high >= PLAIN_NM[1] && low >= TABLES_NM[0] && high <= TABLES_NM[1];
        // As far as all tables go, and as every nanometre has it.
        let within = |[low, high]: [f64; 2]| {
            let range = tables.iter().filter_map(|table| table.range_nm());
            range.fold([low, high], |[low, high], [from, to]| [low.max(from), high.min(to)])
        };
        let [from, to] = within(TABLES_NM);
        for needed in [low.max(PLAIN_NM[0]), high.min(PLAIN_NM[1])] {
            if (PLAIN_NM[0]..=PLAIN_NM[1]).contains(&needed) {
                tables.iter().try_for_each(|table| table.at(needed).map(|_| ()))?;
            }
        }
        let every_nm = (0..=(to - from).max(0.0) as usize).map(|i| from + i as f64).collect();
        let every_nm = WavelengthGrid::new(every_nm)?;
        let all = products(tables, &every_nm)?;
        let interpolation = SpectralInterpolation::of(grid);
        let mut weights = match is_plain {
            true => products(tables, grid)?,
            false => {
                let mut weights = vec![Vector3::zeros(); grid.len()];
                for (&nm, product) in every_nm.nm().iter().zip(&all) {
                    interpolation.weights(grid, nm, |i, w| weights[i] += w * product);
                }
                weights
            }
        };
        let sum: Vector3<f64> = weights.iter().sum();
        if sum.min() <= 0.0 {
            return Err(ColourError::Blind {
                low,
                high,
                convention: convention.to_string(),
                x: sum.x,
                y: sum.y,
                z: sum.z,
            });
        }
        for weight in &mut weights {
            *weight /= sum.y;
        }
        let white = sum / sum.y;
        let to_rgb = match convention.adaptation {
            Adaptation::None => convention.rgb.xyz_to_rgb(),
            Adaptation::Bradford => convention.rgb.xyz_to_rgb() * bradford(white, convention.rgb.white()),
        };
        let method = match is_plain {
            true => "plain sums over the wavelengths of the data".to_owned(),
            false => format!(
                "sums over every nm of {from}..{to} nm, {} interpolation of the data and their nearest value beyond \
                 the ends (ASTM E308)",
                interpolation.name()
            ),
        };
        Ok(Self {
            convention,
            weights,
            white,
            to_rgb,
            method,
            fitness: fitness(grid, &every_nm, &all),
        })
    }

    /// How the data become sums.
    pub fn method(&self) -> &str {
        &self.method
    }

    /// The notice of [`Self::doubt`].
    pub fn notice(&self) -> Option<String> {
        self.doubt().map(|why| format!("the colours are doubtful: {why}"))
    }

    /// Why the colours of this grid are doubtful, where they are: wavelengths too far apart, or too little of what the
    /// observer sees between the first and the last.
    pub fn doubt(&self) -> Option<&str> {
        match &self.fitness {
            Fitness::Sound => None,
            Fitness::Doubtful(why) | Fitness::None(why) => Some(why),
        }
    }

    /// # Errors
    /// A grid that cannot carry a colour: fewer than three wavelengths that the observer sees, or more than half of a
    /// colour-matching function outside.
    pub fn require(&self) -> Result<(), ColourError> {
        match &self.fitness {
            Fitness::None(why) => Err(ColourError::NoColour { why: why.clone() }),
            Fitness::Sound | Fitness::Doubtful(_) => Ok(()),
        }
    }

    pub fn convention(&self) -> &Convention {
        &self.convention
    }

    /// The perfect diffuser: the illuminant's own sum, Y = 1. White of Lab and of the adaptation.
    pub fn white(&self) -> Xyz {
        xyz_of(self.white)
    }

    /// Tristimulus values of a spectral brightness factor, one value a wavelength of the grid.
    ///
    /// # Panics
    /// If the number of values is not that of the grid's wavelengths.
    pub fn xyz(&self, beta: &[f64]) -> Xyz {
        assert_eq!(beta.len(), self.weights.len(), "one value a wavelength of the grid");
        let sum = self
            .weights
            .iter()
            .zip(beta)
            .fold(Vector3::zeros(), |sum: Vector3<f64>, (w, b)| sum + w * *b);
        xyz_of(sum)
    }

    pub fn linear_rgb(&self, xyz: Xyz) -> LinearRgb {
        LinearRgb((self.to_rgb * Vector3::new(xyz.x, xyz.y, xyz.z)).into())
    }

    /// CIE 15:2018, eqs. 8.3 to 8.11, with the exact constants ε = 216/24389, κ = 24389/27.
    pub fn lab(&self, xyz: Xyz) -> Lab {
        let f = |t: f64| {
            if t > 216.0 / 24389.0 {
                t.cbrt()
            } else {
                (24389.0 / 27.0 * t + 16.0) / 116.0
            }
        };
        let (x, y, z) = (
            f(xyz.x / self.white.x),
            f(xyz.y / self.white.y),
            f(xyz.z / self.white.z),
        );
        Lab([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])
    }

    /// Lab of linear RGB, the reverse of [`Self::linear_rgb`]; `None` if the RGB space cannot be inverted.
    pub fn lab_of_rgb(&self, rgb: LinearRgb) -> Option<Lab> {
        let to_xyz = self.to_rgb.try_inverse()?;
        Some(self.lab(xyz_of(to_xyz * Vector3::from(rgb.0))))
    }

    /// All of it. Panics as [`Self::xyz`] does.
    pub fn convert(&self, beta: &[f64]) -> Colour {
        let xyz = self.xyz(beta);
        let linear_rgb = self.linear_rgb(xyz);
        Colour {
            xyz,
            linear_rgb,
            lab: self.lab(xyz),
            in_gamut: linear_rgb.in_gamut(),
        }
    }

    /// What a unit of β at each wavelength adds to R, G, B and Y: the derivatives that carry a spectrum's errors to
    /// its colour.
    pub fn channel_weights(&self) -> Vec<[f64; 4]> {
        self.weights
            .iter()
            .map(|w| {
                let rgb = self.to_rgb * w;
                [rgb.x, rgb.y, rgb.z, w.y]
            })
            .collect()
    }
}

fn xyz_of(v: Vector3<f64>) -> Xyz {
    Xyz { x: v.x, y: v.y, z: v.z }
}

/// S x̄, S ȳ, S z̄ at each wavelength of a grid.
fn products([power, x, y, z]: [&Spectrum; 4], grid: &WavelengthGrid) -> Result<Vec<Vector3<f64>>, ColourError> {
    let power = power.on(grid)?;
    let read_at = match fault::active(Fault::ObserverShift) {
        true => &WavelengthGrid::new(grid.nm().iter().map(|nm| nm + 10.0).collect())?,
        false => grid,
    };
    let (x, y, z) = (x.on(read_at)?, y.on(read_at)?, z.on(read_at)?);
    let at = |i: usize| power.values()[i] * Vector3::new(x.values()[i], y.values()[i], z.values()[i]);
    Ok((0..grid.len()).map(at).collect())
}

/// `all` is S x̄, S ȳ, S z̄ at every nanometre.
fn fitness(grid: &WavelengthGrid, every_nm: &WavelengthGrid, all: &[Vector3<f64>]) -> Fitness {
    /// Share of a colour-matching function outside the data from which on a colour is doubtful, and from which on there
    /// is none.
    const OUTSIDE: [f64; 2] = [0.02, 0.5];
    /// Largest step that resolves the functions, in nm, where they are not almost 0.
    const STEP_NM: f64 = 20.0;
    const SEEN_NM: [f64; 2] = [400.0, 700.0];
    let nm = grid.nm();
    let (low, high) = (nm[0], nm[nm.len() - 1]);
    let whole: Vector3<f64> = all.iter().sum();
    let outside = every_nm
        .nm()
        .iter()
        .zip(all)
        .filter(|(at, _)| !(low..=high).contains(*at));
    let outside: Vector3<f64> = outside.map(|(_, product)| product).sum();
    let shares = outside.component_div(&whole);
    let gaps = nm
        .windows(2)
        .filter(|pair| pair[1] > SEEN_NM[0] && pair[0] < SEEN_NM[1]);
    let gap = gaps.map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    let seen = nm
        .iter()
        .filter(|nm| (TABLES_NM[0]..=TABLES_NM[1]).contains(*nm))
        .count();
    let mut why = Vec::new();
    if seen < 3 {
        why.push(format!(
            "{seen} of the wavelengths lie in {}..{} nm",
            TABLES_NM[0], TABLES_NM[1]
        ));
    } else if gap > STEP_NM * (1.0 + 1e-9) {
        why.push(format!(
            "the wavelengths are up to {} nm apart, where {STEP_NM} nm resolve the observer",
            rounded(gap)
        ));
    }
    let (function, share) =
        ["xbar", "ybar", "zbar"]
            .into_iter()
            .zip(shares.iter().copied())
            .fold(
                ("", 0.0),
                |largest, next| if next.1 > largest.1 { next } else { largest },
            );
    if share > OUTSIDE[0] {
        why.push(format!(
            "{} % of the colour-matching function {function} lie outside {} to {} nm, where the data are continued by \
             their nearest value",
            rounded(100.0 * share),
            rounded(low),
            rounded(high)
        ));
    }
    let why = why.join(", and ");
    match why.is_empty() {
        true => Fitness::Sound,
        false if seen < 3 || share > OUTSIDE[1] => Fitness::None(why),
        false => Fitness::Doubtful(why),
    }
}

fn rounded(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}
