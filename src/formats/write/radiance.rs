use std::collections::BTreeMap;
use std::fmt::Write;

use rayon::prelude::*;

use super::super::descriptor::Content;
use super::balance::Balance;
use super::sampling::{ChannelMap, Sampler, clipped};
use super::{WriteError, WriteNotice};
use crate::geometry::Vec3;
use crate::goniometric::{
    ChannelSet, Component, FileProvenance, Format, Hemisphere, Hemispherical, KlemsBasis, KlemsMatrix, Scatter, Side,
    SpecularTable, Table, angles_of, rounded_deg,
};

/// Points along either side of a patch that its mean is taken over, exiting and incident.
const EXITING: usize = 3;
const INCIDENT: usize = 2;
/// Fraction of a patch that the points of an integral have to cover for their mean to be that of the patch.
const COVERED: f64 = 0.5;

/// Klems matrices: the source's own, or means over the patches of Klems' full basis; Y, or X, Y, Z. Specular fractions
/// are on their diagonals.
pub(in crate::formats) fn write(content: &Content, notices: &mut Vec<WriteNotice>) -> Result<Vec<u8>, WriteError> {
    let (components, provenance) = (content.components, content.provenance);
    let mut matrices: Vec<(&Component, KlemsMatrix)> = Vec::new();
    for component in components {
        match &component.table {
            Table::Specular(_) => {}
            Table::Klems(matrix) => matrices.push((component, matrix.clone())),
            _ => matrices.push((component, averaged(component, content.format, notices)?)),
        }
    }
    for component in components {
        if let Table::Specular(table) = &component.table {
            let mut alike = matrices.iter_mut();
            let alike = alike.find(|(of, _)| (of.scatter, of.side) == (component.scatter, component.side));
            match alike {
                Some((_, matrix)) => on_diagonal(component, table, matrix, content.format, notices)?,
                None => notices.push(WriteNotice::SpecularLeftOut),
            }
        }
    }
    let Some((_, first)) = matrices.first() else {
        return Ok(Vec::new());
    };
    let bases = [first.incident().clone(), first.exiting().clone()];
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<WindowElement>\n<WindowElementType>System</WindowElementType>\n\
         <FileType>BSDF</FileType>\n<Optical>\n<Layer>\n",
    );
    // Writing to a string cannot fail. Radiance needs a width and a height other than 0.
    let _ = writeln!(
        text,
        "<Material><Name>{}</Name><Manufacturer>specval {}</Manufacturer><Thickness unit=\"Meter\">0.001</Thickness>\
         <Width unit=\"Meter\">1</Width><Height unit=\"Meter\">1</Height><DeviceType>Other</DeviceType></Material>",
        escaped(&name(provenance)),
        env!("CARGO_PKG_VERSION")
    );
    text += "<DataDefinition>\n<IncidentDataStructure>Columns</IncidentDataStructure>\n";
    let defined = if bases[0] == bases[1] { &bases[..1] } else { &bases[..] };
    defined.iter().for_each(|basis| define(&mut text, basis));
    text += "</DataDefinition>\n";
    let xyz = matrices.iter().all(|(_, matrix)| matrix.channels() == 3);
    let wavelengths: &[(&str, usize)] = if xyz {
        &[("CIE-X", 0), ("Visible", 1), ("CIE-Z", 2)]
    } else {
        &[("Visible", 1)]
    };
    for &(wavelength, channel) in wavelengths {
        for (component, matrix) in &matrices {
            let channel = if matrix.channels() == 1 { 0 } else { channel };
            block(&mut text, component, matrix, wavelength, channel);
        }
    }
    text += "</Layer>\n</Optical>\n</WindowElement>\n";
    Ok(text.into_bytes())
}

fn name(provenance: &FileProvenance) -> String {
    let stated = provenance
        .statements
        .iter()
        .find(|(name, _)| name.eq_ignore_ascii_case("name"));
    stated.map_or_else(|| "sample".to_owned(), |(_, name)| name.clone())
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn define(text: &mut String, basis: &KlemsBasis) {
    let _ = writeln!(
        text,
        "<AngleBasis>\n<AngleBasisName>{}</AngleBasisName>",
        escaped(&basis.name)
    );
    for (ring, ([low, high], patches)) in basis.rings().enumerate() {
        let centre = if ring == 0 { 0.0 } else { (low + high) / 2.0 };
        let _ = writeln!(
            text,
            "<AngleBasisBlock><Theta>{centre}</Theta><nPhis>{patches}</nPhis><ThetaBounds><LowerTheta>{low}</LowerTheta><UpperTheta>{high}</UpperTheta></ThetaBounds></AngleBasisBlock>"
        );
    }
    *text += "</AngleBasis>\n";
}

fn block(text: &mut String, component: &Component, matrix: &KlemsMatrix, wavelength: &str, channel: usize) {
    let (kind, data) = match component.scatter {
        Scatter::Reflection => ("Reflection", "BRDF"),
        Scatter::Transmission => ("Transmission", "BTDF"),
    };
    // The file's front is the side of −z.
    let side = if component.side == Side::Front { "Back" } else { "Front" };
    let _ = writeln!(
        text,
        "<WavelengthData>\n<LayerNumber>System</LayerNumber>\n<Wavelength \
         unit=\"Integral\">{wavelength}</Wavelength>\n<SourceSpectrum>CIE Illuminant D65 \
         1nm.ssp</SourceSpectrum>\n<DetectorSpectrum>ASTM E308 1931 \
         Y.dsp</DetectorSpectrum>\n<WavelengthDataBlock>\n<WavelengthDataDirection>{kind} \
         {side}</WavelengthDataDirection>\n<ColumnAngleBasis>{}</ColumnAngleBasis>\n<RowAngleBasis>{}</RowAngleBasis>\n<ScatteringDataType>{data}</ScatteringDataType>\n<ScatteringData>",
        escaped(&matrix.incident().name),
        escaped(&matrix.exiting().name)
    );
    for exiting in 0..matrix.exiting().count() {
        for incident in 0..matrix.incident().count() {
            let _ = write!(text, "{},", matrix.at(channel, incident, exiting));
        }
        *text += "\n";
    }
    *text += "</ScatteringData>\n</WavelengthDataBlock>\n</WavelengthData>\n";
}

/// Means of f over pairs of patches. Of an exiting patch it is ∫ f cos θ dω over it, by the points of the integral over
/// the hemisphere, so that hemispherical values stay those of the source; incident directions are even in projected
/// solid angle.
fn averaged(component: &Component, format: Format, notices: &mut Vec<WriteNotice>) -> Result<KlemsMatrix, WriteError> {
    let basis = KlemsBasis::named("LBNL/Klems Full").ok_or_else(|| WriteError::CannotHold {
        format,
        holds: "patches of Klems' full basis".into(),
        found: "no such basis".into(),
        remedy: "take another format".into(),
    })?;
    let sampler = Sampler::new(component, format)?;
    let map = ChannelMap::to_xyz(&component.channels, notices)?;
    let channels = if component.channels == ChannelSet::Monochrome {
        1
    } else {
        3
    };
    let count = basis.count();
    let exiting: Vec<Vec<Vec3>> = (0..count).map(|patch| inside(&basis, patch, EXITING)).collect();
    let weight = 1.0 / (INCIDENT * INCIDENT) as f64;
    let towards = |light: &Vec3| Vec3::new(-light.x, -light.y, light.z);
    // Of an isotropic source the hemispheres at one polar angle are one, turned.
    let mut polar: BTreeMap<u64, f64> = BTreeMap::new();
    if component.is_isotropic() {
        let lights = (0..count).flat_map(|incident| inside(&basis, incident, INCIDENT));
        let angles = lights.map(|light| angles_of(&towards(&light)).0);
        angles.for_each(|theta_i| {
            polar.entry(polar_key(theta_i)).or_insert(theta_i);
        });
    }
    let shared: BTreeMap<u64, Hemisphere> = polar
        .into_par_iter()
        .map(|(key, theta_i)| (key, component.hemisphere(theta_i, 0.0)))
        .collect();
    let columns: Vec<(Vec<f64>, Balance)> = (0..count)
        .into_par_iter()
        .map(|incident| {
            let mut balance = Balance::default();
            let mut column = vec![0.0; channels * count];
            for light in inside(&basis, incident, INCIDENT) {
                let omega_in = towards(&light);
                let (theta_i, phi_i) = angles_of(&omega_in);
                let own;
                let (hemisphere, turn_rad) = match shared.get(&polar_key(theta_i)) {
                    Some(shared) => (shared, phi_i),
                    None => {
                        own = component.hemisphere(theta_i, phi_i);
                        (&own, 0.0)
                    }
                };
                let means = patch_means(
                    &basis,
                    &sampler,
                    &exiting,
                    &omega_in,
                    (hemisphere, turn_rad),
                    &mut balance,
                )?;
                for (out, f) in means.iter().enumerate() {
                    for (channel, f) in map.apply(f).into_iter().enumerate() {
                        column[channel * count + out] += weight * f;
                    }
                }
            }
            Ok((column, balance))
        })
        .collect::<Result<_, WriteError>>()?;
    let mut values = vec![0.0; channels * count * count];
    let mut balance = Balance::default();
    for (incident, (column, of_column)) in columns.into_iter().enumerate() {
        balance.merge(of_column);
        for (at, f) in column.into_iter().enumerate() {
            values[at * count + incident] = f;
        }
    }
    clipped(&mut values, notices);
    notices.push(WriteNotice::PatchMeans);
    sampler.notice(notices);
    balance.notice(notices);
    Ok(KlemsMatrix::new(basis.clone(), basis, values))
}

/// Polar angles that differ by rounding alone have one key.
fn polar_key(theta_i: f64) -> u64 {
    (theta_i * 1e9).round() as u64
}

/// Means of f over exiting patches, one value a channel, of light from a direction, whose hemisphere is to be turned.
fn patch_means(
    basis: &KlemsBasis,
    sampler: &Sampler,
    exiting: &[Vec<Vec3>],
    omega_in: &Vec3,
    (hemisphere, turn_rad): (&Hemisphere, f64),
    balance: &mut Balance,
) -> Result<Vec<Vec<f64>>, WriteError> {
    let channels = sampler.channels();
    let (theta_i, _) = angles_of(omega_in);
    let mut integrals = vec![vec![0.0; channels]; basis.count()];
    let mut covered = vec![0.0; basis.count()];
    hemisphere.visit(turn_rad, |omega_out, projected, values| {
        let patch = basis.patch(omega_out);
        covered[patch] += projected;
        integrals[patch].iter_mut().zip(values).for_each(|(sum, f)| *sum += f);
    });
    let mut means = Vec::with_capacity(basis.count());
    for (patch, mut integral) in integrals.into_iter().enumerate() {
        // Too few points to know the patch by, or a table that has none.
        if covered[patch] < COVERED * basis.projected_solid_angle(patch) {
            integral = vec![0.0; channels];
            for omega_out in &exiting[patch] {
                let f = sampler.bsdf(omega_in, omega_out)?;
                integral.iter_mut().zip(f).for_each(|(sum, f)| *sum += f);
            }
            covered[patch] = exiting[patch].len() as f64;
        } else {
            sampler.measured(exiting[patch].len());
        }
        integral.iter_mut().for_each(|f| *f /= covered[patch]);
        means.push(integral);
    }
    let sum = |channel: usize| -> f64 {
        let patches = means.iter().enumerate();
        patches
            .map(|(patch, f)| f[channel] * basis.projected_solid_angle(patch))
            .sum()
    };
    let table = Hemispherical {
        values: (0..channels).map(sum).collect(),
        errors: vec![0.0; channels],
        measured: 1.0,
    };
    let factors = balance.factors(rounded_deg(theta_i), hemisphere.total(), Some(&table), channels);
    for f in &mut means {
        f.iter_mut().zip(&factors).for_each(|(f, factor)| *f *= factor);
    }
    Ok(means)
}

/// Adds a fraction to the diagonal of a matrix: it goes into the one patch opposite to that of the light, where it is
/// fraction / ∫ cosθ dω.
fn on_diagonal(
    component: &Component,
    fractions: &SpecularTable,
    matrix: &mut KlemsMatrix,
    format: Format,
    notices: &mut Vec<WriteNotice>,
) -> Result<(), WriteError> {
    let map = ChannelMap::to_xyz(&component.channels, notices)?;
    let basis = matrix.incident().clone();
    if *matrix.exiting() != basis {
        notices.push(WriteNotice::SpecularWithoutDiagonal);
        return Ok(());
    }
    let ends = |nodes: &[f64]| [nodes[0], nodes[nodes.len() - 1]];
    let [first, last] = ends(fractions.incidence().nodes_rad());
    let mut beyond = false;
    for patch in 0..basis.count() {
        let per_sr = 1.0 / ((INCIDENT * INCIDENT) as f64 * basis.projected_solid_angle(patch));
        for exiting in inside(&basis, patch, INCIDENT) {
            let (theta, phi) = angles_of(&Vec3::new(-exiting.x, -exiting.y, exiting.z));
            let held = theta.clamp(first, last);
            beyond |= held != theta;
            let fraction = fractions.fraction(held, phi).ok_or_else(|| WriteError::NotMeasured {
                format,
                theta_i_deg: theta.to_degrees(),
                theta_o_deg: theta.to_degrees(),
                phi_o_deg: phi.to_degrees(),
            })?;
            let values = map.apply(&fraction);
            for channel in 0..matrix.channels() {
                let value = match (values.len(), matrix.channels()) {
                    (1, _) => values[0],
                    // Of X, Y, Z the photometric one.
                    (_, 1) => values[1],
                    _ => values[channel],
                };
                matrix.add(channel, patch, patch, value * per_sr);
            }
        }
    }
    notices.push(WriteNotice::SpecularOnDiagonal);
    if beyond {
        notices.push(WriteNotice::SpecularBeyond);
    }
    Ok(())
}

/// Directions all over a patch, n x n, even in projected solid angle.
fn inside(basis: &KlemsBasis, patch: usize, n: usize) -> Vec<Vec3> {
    let share = |k: usize| (k as f64 + 0.5) / n as f64;
    (0..n * n)
        .map(|k| basis.direction(patch, share(k / n), share(k % n)))
        .collect()
}
