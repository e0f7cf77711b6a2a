mod arguments;

use self::arguments::check_size;
use super::convert::OutputFormat;
use super::method::Method;
use super::notice::worded;
use super::{Failure, Options, Terminal, claim, in_words, inputs_of, study};
use serde::Serialize;
use specval::artefact::Identity;
use specval::formats::{self, Encoding, FileProvenance, Format, Goniometric, Side, WriteOptions};
use specval::output::{Destination, beside, write_all};
use specval::report::InputDigest;
use specval::rig::bsdf::{Cells, Colours, FullBsdf, FullMeasurement, HemisphericalRow, Symmetry, symmetries};
use specval::run::{FactorCloth, Plan, Stage, check_memory, volumetric_cloth};
use specval::study::{MethodChoice, Study};
use std::path::PathBuf;

pub use self::arguments::Arguments;

/// Particles of one incidence.
const PATHS: u64 = 200_000;

/// Where light that meets no yarn is in a Klems file.
const GAPS_IN_PATCHES: &str = "light straight through the gaps is on the diagonal of the transmission, its fraction \
                               over the projected solid angle of the patch";

/// How light is simulated, in files.
fn method_words(method: MethodChoice) -> &'static str {
    match method {
        MethodChoice::Volumetric => "volumetric, with the reflection of the yarns' surface",
        MethodChoice::RadianceFactor => "f* from yarn to yarn, with the reflection of the yarns' surface",
    }
}

#[derive(Serialize)]
struct Measured {
    output: String,
    /// None beside a stream.
    hemispherical_csv: Option<String>,
    format: &'static str,
    bytes: usize,
    incidences: usize,
    incidences_traced: usize,
    particles_per_incidence: usize,
    median_relative_error: Option<f64>,
    hemispherical: Vec<HemisphericalRow>,
    notices: Vec<String>,
}

/// All that decides about the numbers.
#[derive(Serialize)]
struct Settings<'a> {
    study: &'a Study,
    inputs: &'a [InputDigest],
}

/// Where the files of a full measurement go.
struct Files {
    output: Destination,
    hemispherical: Option<Destination>,
    errors: Option<Destination>,
}

/// Finds the places of all files, before any work; where the output is a stream there is none beside it.
fn claim_files(arguments: &Arguments, inputs: &[PathBuf], options: &Options) -> Result<(Files, Terminal), Failure> {
    let out = arguments.out.as_path();
    arguments.target(out)?;
    let beside = beside(out, ".hemispherical.csv");
    let is_file = Destination::find(out)?.is_file();
    let mut outputs = vec![out];
    outputs.extend(is_file.then_some(beside.as_path()));
    outputs.extend(arguments.errors.as_deref());
    let (places, terminal) = claim(&outputs, inputs, &arguments.replace, options)?;
    let mut places = places.into_iter();
    let output = places.next().map_or_else(|| Destination::find(out), Ok)?;
    let hemispherical = if is_file { places.next() } else { None };
    Ok((
        Files {
            output,
            hemispherical,
            errors: places.next(),
        },
        terminal,
    ))
}

pub fn run(full: &Arguments, options: &Options) -> Result<(), Failure> {
    let study = Method::study(full.method, full.study.as_deref(), options)?;
    let method = full.method.unwrap_or(Method::Volumetric).choice();
    let inputs = inputs_of(full.study.as_deref(), &study);
    let (files, terminal) = &claim_files(full, &inputs, options)?;
    let plan = &study::plan(study)?;
    for notice in plan.notices_before(Stage::Views)? {
        terminal.notice(&notice);
    }
    let out = files.output.path();
    let (OutputFormat { format, encoding }, scatter) = full.target(out)?;
    let batches = plan.direct_effort.batches;
    let particles = options.paths.map_or(PATHS, u64::from).div_ceil(batches as u64) as usize;
    let mut group = symmetries(&plan.cloth_spec, plan.weft.is_none(), true);
    if plan.fibres.is_some_and(|gloss| gloss.is_handed()) {
        group.retain(Symmetry::keeps_hand);
    }
    if full.no_fold {
        group.truncate(1);
    }
    let klems = format == Format::RADIANCE_XML;
    let cells = full.cells(format)?;
    let colours = full.colours(format);
    if !matches!(colours, Colours::Spectral) {
        plan.require_colour()?;
    }
    let smaller = if full.rgb {
        " or --to ssdd-binary"
    } else {
        ", --rgb or --to ssdd-binary"
    };
    check_size(&cells, format, encoding, &colours.channels(&plan.grid), smaller)?;
    if full.errors.is_some() {
        let spectra = Colours::Spectral.channels(&plan.grid);
        check_size(&cells, Format::CSV, Encoding::Text, &spectra, " or leave --errors out")?;
    }
    let measurement = FullMeasurement::new(cells, group, klems, batches, plan.study.seed, &plan.grid)?;
    let [incidences, bins] = measurement.size();
    let by_factor = method == MethodChoice::RadianceFactor;
    check_memory(
        &plan.study,
        Stage::Full {
            incidences,
            bins,
            by_factor,
        },
    )?;
    let bsdf = match method {
        MethodChoice::Volumetric => {
            let tracing = terminal.progress("tracing the cloth");
            let cloth = volumetric_cloth(plan, particles)?;
            let light = |beam: &_, cells: &Cells, batch| cloth.batch(beam, cells, batch);
            let bsdf = measurement.measure(light, &|share| tracing.advance(share));
            tracing.finish();
            bsdf
        }
        MethodChoice::RadianceFactor => {
            let tracing = terminal.progress("tracing the yarn");
            let cloth = FactorCloth::new(plan, particles, &|share| tracing.advance(share))?;
            tracing.finish();
            let following = terminal.progress("following light in the cloth");
            let light = |beam: &_, cells: &Cells, batch| cloth.batch(beam, cells, batch);
            let bsdf = measurement.measure(light, &|share| following.advance(share));
            following.finish();
            bsdf
        }
    };
    let incidences = bsdf.cells().incident() * bsdf.sides().len();
    let effort = BsdfEffort {
        incidences,
        batches,
        particles,
    };
    let provenance = provenance(plan, method, &bsdf, &effort)?;
    let mut colour_notices = Vec::new();
    let mut data = Goniometric {
        format,
        provenance,
        components: bsdf.components(colours, format == Format::CSV, &mut colour_notices)?,
        warnings: Vec::new(),
    };
    let writing = terminal.busy("writing the file");
    let written = formats::write(
        &data,
        format,
        &WriteOptions {
            scatter,
            encoding,
            side: None,
        },
    );
    writing.finish();
    let written = written?;
    let mut notices: Vec<String> = worded(&colour_notices).chain(worded(&written.notices)).collect();
    match format {
        Format::SDR | Format::SSDD => {}
        Format::RADIANCE_XML => notices.push(GAPS_IN_PATCHES.into()),
        _ => {
            let gaps = "light straight through the gaps is not in the file";
            notices.push(match &files.hemispherical {
                Some(place) => format!("{gaps}; its fraction is in {}", in_words(place.path())),
                None => gaps.to_owned(),
            });
        }
    }
    if files.hemispherical.is_none() {
        notices
            .push("hemispherical values are not written: they have a file beside the output, which is a stream".into());
    }
    let errors = match &files.errors {
        Some(place) => {
            data.components = bsdf.errors(true);
            let of_component = WriteOptions {
                scatter,
                ..WriteOptions::default()
            };
            Some((place, formats::write(&data, Format::CSV, &of_component)?.bytes))
        }
        None => None,
    };
    let rows = bsdf.hemispherical();
    let hemispherical = csv_of(&rows, &data.provenance.comments)?;
    let mut set = vec![(&files.output, written.bytes.as_slice())];
    set.extend(
        files
            .hemispherical
            .iter()
            .map(|place| (place, hemispherical.as_slice())),
    );
    set.extend(errors.iter().map(|(place, bytes)| (*place, bytes.as_slice())));
    write_all(&set)?;
    for notice in &notices {
        terminal.notice(notice);
    }
    let measured = Measured {
        output: in_words(out),
        hemispherical_csv: files.hemispherical.as_ref().map(|place| in_words(place.path())),
        format: format.name(),
        bytes: written.bytes.len(),
        incidences,
        incidences_traced: bsdf.incidences().len(),
        particles_per_incidence: particles * batches,
        median_relative_error: bsdf.median_relative_error(),
        hemispherical: rows,
        notices,
    };
    terminal.result(&measured, |m| {
        format!(
            "{} bytes of {} written to {}\n{} of {} incidences traced, {} particles each; median standard error of f \
             {}\n",
            m.bytes,
            m.format,
            m.output,
            m.incidences_traced,
            m.incidences,
            m.particles_per_incidence,
            percent(m.median_relative_error)
        )
    })
}

fn percent(share: Option<f64>) -> String {
    share.map_or("unknown".into(), |share| format!("{:.2} %", 100.0 * share))
}

fn csv_of(rows: &[HemisphericalRow], comments: &[String]) -> Result<Vec<u8>, Failure> {
    let text: String = comments.iter().map(|comment| format!("# {comment}\n")).collect();
    let mut csv = csv::Writer::from_writer(text.into_bytes());
    for row in rows {
        csv.serialize(row)?;
    }
    Ok(csv.into_inner()?)
}

struct BsdfEffort {
    incidences: usize,
    batches: usize,
    particles: usize,
}

/// What the file says of its making.
fn provenance(
    plan: &Plan,
    method: MethodChoice,
    bsdf: &FullBsdf,
    effort: &BsdfEffort,
) -> Result<FileProvenance, Failure> {
    let identity = Identity::new(
        plan.study.seed,
        &Settings {
            study: &plan.study,
            inputs: &plan.inputs,
        },
    )?;
    let digest = InputDigest::of("study", identity.value().to_string().as_bytes()).sha256;
    let software = format!("specval {}", env!("CARGO_PKG_VERSION"));
    let sides = if bsdf.sides().contains(&Side::Back) {
        "both sides"
    } else {
        "the front"
    };
    let comments = [
        format!("{software}, simulated woven cloth, {}", method_words(method)),
        format!("study SHA-256 {digest}, seed {}", plan.study.seed),
        format!(
            "{} incidences from {sides}, {} of them traced, the rest by the symmetry of the weave; {} batches of \
             {} particles each; median standard error of f {}",
            effort.incidences,
            bsdf.incidences().len(),
            effort.batches,
            effort.particles,
            percent(bsdf.median_relative_error())
        ),
        format!(
            "azimuths from the warp towards the weft, seen from the front; {}",
            match bsdf.cells() {
                Cells::Nodes(_) => "light straight through the gaps is no part of f",
                Cells::Patches(_) => GAPS_IN_PATCHES,
            }
        ),
    ];
    let statement = |name: &str, value: String| (name.to_owned(), value);
    Ok(FileProvenance {
        source: Some("Generated".into()),
        statements: vec![
            statement("name", format!("{software} cloth {}", &digest[..12.min(digest.len())])),
            statement("description", comments.join("; ")),
            statement("SOFTWARE", software.clone()),
            statement("SOURCE", "Generated".into()),
            statement("METHOD", method_words(method).into()),
            statement("STUDY_SHA256", digest.clone()),
            statement("SEED", plan.study.seed.to_string()),
            statement("BATCHES", effort.batches.to_string()),
            statement("PARTICLES", (effort.batches * effort.particles).to_string()),
        ],
        comments: comments.to_vec(),
    })
}
