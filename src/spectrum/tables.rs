//! Tables compiled into the program, parsed on first use and once: standard observers, illuminants, dyes, reflectances.
//!
//! Sources, units and licences: the `#` lines of `spectra/*.csv` and `spectra/README.md`.

use std::sync::LazyLock;

use super::error::SpectrumError;
use super::function::Spectrum;
use super::layout::{self, AllowedValues};
use super::naming::UnknownName;
pub use super::observer::ObserverTables;
use crate::text::CsvTable;

type Loaded<T> = LazyLock<Result<T, SpectrumError>>;
type Named = Vec<(String, Spectrum)>;

const OBSERVERS: [&str; 2] = ["cie1931-2deg", "cie1964-10deg"];

static CIE_1931: Loaded<ObserverTables> =
    LazyLock::new(|| observer_of(OBSERVERS[0], include_str!("../../spectra/cie1931-2deg.csv")));
static CIE_1964: Loaded<ObserverTables> =
    LazyLock::new(|| observer_of(OBSERVERS[1], include_str!("../../spectra/cie1964-10deg.csv")));
static ILLUMINANTS: Loaded<Named> = LazyLock::new(|| {
    let mut all = named("illuminant", include_str!("../../spectra/illuminants.csv"))?;
    all.push(("E".into(), Spectrum::Constant(1.0)));
    Ok(all)
});
static DYES: Loaded<Named> = LazyLock::new(|| {
    let mut all = named("dye", include_str!("../../spectra/preprint-red.csv"))?;
    all.extend(named("dye", include_str!("../../spectra/dyes.csv"))?);
    Ok(all)
});
static REFLECTANCES: Loaded<Named> =
    LazyLock::new(|| named("reflectance", include_str!("../../spectra/usgs-fabrics.csv")));

/// CIE standard observer `cie1931-2deg` or `cie1964-10deg`.
pub fn observer(name: &str) -> Result<&'static ObserverTables, SpectrumError> {
    let table = match OBSERVERS.iter().position(|known| *known == name) {
        Some(0) => &CIE_1931,
        Some(_) => &CIE_1964,
        None => return Err(UnknownName::new("observer", name, OBSERVERS).into()),
    };
    table.as_ref().map_err(Clone::clone)
}

/// Relative spectral power of the CIE illuminants `D65`, `D50`, `A`, `C` (300..780 nm) and `E` (1 everywhere).
pub fn illuminant(name: &str) -> Result<&'static Spectrum, SpectrumError> {
    find("illuminant", &ILLUMINANTS, name)
}

/// Relative absorption of a dye, dimensionless, about 1 at its peak. `preprint-red` covers 380..780 nm, the others
/// 390..730 nm; most are models, see the table's header.
pub fn dye(name: &str) -> Result<&'static Spectrum, SpectrumError> {
    find("dye", &DYES, name)
}

/// Names of [`dye`].
pub fn dye_names() -> Vec<&'static str> {
    let all = DYES.as_ref().map(Vec::as_slice).unwrap_or_default();
    all.iter().map(|(name, _)| name.as_str()).collect()
}

/// Measured reflectance 0..1 of a fabric (`usgs-nylon-red`, `usgs-cotton-white`), 390..780 nm.
pub fn reflectance(name: &str) -> Result<&'static Spectrum, SpectrumError> {
    find("reflectance", &REFLECTANCES, name)
}

fn find(kind: &'static str, table: &'static Loaded<Named>, name: &str) -> Result<&'static Spectrum, SpectrumError> {
    let all = table.as_ref().map_err(Clone::clone)?;
    all.iter()
        .find(|(known, _)| known == name)
        .map(|(_, spectrum)| spectrum)
        .ok_or_else(|| UnknownName::new(kind, name, all.iter().map(|(known, _)| known.as_str())).into())
}

fn observer_of(name: &'static str, csv: &str) -> Result<ObserverTables, SpectrumError> {
    let all = named(name, csv)?;
    let column = |title: &str| {
        all.iter()
            .find(|(known, _)| known == title)
            .map(|(_, spectrum)| spectrum.clone())
            .ok_or_else(|| UnknownName::new(name, title, all.iter().map(|(known, _)| known.as_str())))
    };
    Ok(ObserverTables {
        x_bar: column("xbar")?,
        y_bar: column("ybar")?,
        z_bar: column("zbar")?,
    })
}

/// `what` is how errors call these spectra.
fn named(what: &str, csv: &str) -> Result<Named, SpectrumError> {
    let table = CsvTable::parse(what, csv.as_bytes())?;
    let spectra = layout::by_wavelength(&table, 0, &AllowedValues::of(&..))?;
    Ok(spectra
        .into_iter()
        .map(|(title, samples)| {
            let name = format!("{what} {title}");
            (title, Spectrum::Table { name, samples })
        })
        .collect())
}
