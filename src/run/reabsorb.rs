use super::{NoticeKind, Plan, Reabsorbed, ReabsorptionNotice, RunError, Systematic, YarnArtefact};
use crate::report::EnergyRow;
use crate::study::{MediumSection, Study};
use crate::transport::Fraction;
use crate::yarn::{ByLength, LengthBins, Reabsorption, Reweighted, Support};
use std::fmt;

/// Fractions of the ledger that leave the yarn and are kept by path length.
const LEAVING: [Fraction; 2] = [Fraction::Ballistic, Fraction::Scattered];

const LEAST_SHARE: f64 = 0.05;
const LEAST_OPEN_SHARE: f64 = 0.01;
const OPEN_GROWTH: f64 = 0.5;
const SCATTERING_CHANGE: f64 = 0.02;

impl NoticeKind {
    /// Value and fraction of the light concerned at one wavelength, if the notice applies there.
    fn judge(self, support: &Support, scattering: f64) -> Option<(f64, f64)> {
        let (due, value, share) = match self {
            Self::FewPathsCount => (
                support.unsupported >= LEAST_SHARE,
                support.effective_share,
                support.unsupported,
            ),
            Self::BinsTooWide => (
                support.systematic_rules >= LEAST_SHARE,
                support.systematic,
                support.systematic_rules,
            ),
            Self::OpenBin => (
                support.open_bin >= LEAST_OPEN_SHARE && support.open_bin_growth >= OPEN_GROWTH,
                support.open_bin_growth,
                support.open_bin,
            ),
            Self::Scattering => (scattering.abs() > SCATTERING_CHANGE, scattering, 1.0),
        };
        due.then_some((value, share))
    }
}

impl fmt::Display for ReabsorptionNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (nm, share) = (self.wavelength_nm, 100.0 * self.share_of_light);
        match self.kind {
            NoticeKind::FewPathsCount => write!(
                f,
                "few of the paths still count: {:.1} % at {nm} nm, where cells with {share:.0} % of the light are left \
                 with less than 10 %",
                100.0 * self.value
            ),
            NoticeKind::BinsTooWide => write!(
                f,
                "the bins of path length are too wide for the change: systematic error {:.1} % at {nm} nm, more than \
                 the statistical one for {share:.0} % of the light",
                100.0 * self.value
            ),
            NoticeKind::OpenBin => write!(
                f,
                "light comes back from paths longer than the bins reach: {share:.0} % of it at {nm} nm, with a change \
                 over {:.2} mean lengths",
                self.value
            ),
            NoticeKind::Scattering => write!(
                f,
                "the dye changes scattering too: mu_s by {:+.1} % at {nm} nm, right for the first scattering only",
                100.0 * self.value
            ),
        }?;
        if self.wavelengths > 1 {
            write!(f, " (the worst of {} wavelengths)", self.wavelengths)?;
        }
        write!(f, "; trace the new medium to be sure")
    }
}

/// Changes the absorption of a trace to that of another medium without tracing. `source_sha256` is the digest to
/// record.
///
/// f* of the direct simulation and the ledger are re-weighted along their path lengths, and the tables by path length
/// likewise, for a further change. Reflected light and the nets of sampling do not change; absorbed light closes the
/// ledger. The BSSRDF and the f* summed from it have no path lengths and are removed.
///
/// # Errors
/// A study or input files that are no longer those of the artefact, the same medium, one that [`Reabsorption::new`]
/// refuses.
pub fn reabsorb(
    mut artefact: YarnArtefact,
    source_sha256: String,
    medium: MediumSection,
) -> Result<YarnArtefact, RunError> {
    let settings = &artefact.layout.settings;
    if medium == settings.study.medium {
        return Err(RunError::Reabsorption {
            expected: "a medium that absorbs otherwise",
            found: "the artefact's own".into(),
            remedy: "give another kappa_peak, dye or host_mu_a_per_mm",
        });
    }
    let traced = Plan::new(settings.study.clone())?;
    let known = &settings.medium;
    if traced.inputs != settings.inputs
        || !agree(traced.yarn.medium.mu_a_per_mm(), &known.mu_a_per_mm)
        || !agree(traced.yarn.medium.mu_s_per_mm(), &known.mu_s_per_mm)
    {
        return Err(RunError::Reabsorption {
            expected: "the dye, tables and sample that the artefact was made with",
            found: "files of other content in their places".into(),
            remedy: "put them back as they were, or trace again",
        });
    }
    let wanted = Plan::new(Study {
        medium,
        ..settings.study.clone()
    })?;
    let bins = LengthBins::from_edges(artefact.layout.axes.length_edges_mm.clone())?;
    let change = Reabsorption::new(bins, &traced.yarn.medium, &wanted.yarn.medium)?;

    let mut systematic = artefact.systematic.take().unwrap_or_else(|| Systematic {
        direct: vec![0.0; artefact.tables.direct.mean.len()],
        energy: vec![0.0; 2 * artefact.layout.incident.traced() * artefact.layout.wavelengths()],
    });
    let by_length = &mut artefact.tables.by_length;
    let support = change.table(
        &mut artefact.tables.direct.mean,
        &mut artefact.tables.direct.se,
        ByLength {
            mean: &mut by_length.mean,
            se: &mut by_length.se,
            moment_mm: &mut by_length.moment_mm,
        },
        &mut systematic.direct,
    )?;
    let energy = change.energy(
        &mut artefact.tables.energy_by_length.mean,
        &mut artefact.tables.energy_by_length.se,
    )?;
    let wavelengths = artefact.layout.wavelengths();
    let incident = artefact.layout.incident;
    let mut light = vec![[0.0; 2]; energy.len()];
    for (i, row) in artefact.energy.iter_mut().enumerate() {
        let (wavelength, direction) = (i / incident.len(), i % incident.len());
        let traced = incident.representative(direction).0 * wavelengths + wavelength;
        change_row(row, &energy[traced]);
        light[traced] = LEAVING.map(|fraction| row[fraction].value);
    }
    for (i, error) in systematic.energy.iter_mut().enumerate() {
        let of = &energy[i / 2][i % 2];
        *error = (f64::from(*error) * of.ratio + of.systematic * light[i / 2][i % 2]) as f32;
    }

    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
            [low.min(x), high.max(x)]
        })
    };
    let changes = change.changes();
    let record = Reabsorbed {
        source_sha256,
        from: traced.study.medium,
        mu_a_change_per_mm: range(&mut changes.iter().map(|c| c.mu_a_per_mm)),
        mu_s_change: range(&mut changes.iter().map(|c| c.scattering - 1.0)),
        notices: notices(&change, &support),
    };
    let medium = &mut artefact.layout.settings.medium;
    medium.mu_s_per_mm = wanted.yarn.medium.mu_s_per_mm().to_vec();
    medium.mu_a_per_mm = wanted.yarn.medium.mu_a_per_mm().to_vec();
    let settings = &mut artefact.layout.settings;
    settings.study = wanted.study;
    settings.inputs = wanted.inputs;
    settings.reabsorbed.push(record);
    artefact.tables.summed = None;
    artefact.tables.bssrdf = None;
    artefact.systematic = Some(systematic);
    Ok(artefact)
}

/// Whether coefficients agree to the accuracy of another C library.
fn agree(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && std::iter::zip(a, b).all(|(a, b)| (a - b).abs() <= 1e-9 * a.abs().max(b.abs()))
}

/// `changes` are those of [`LEAVING`].
fn change_row(row: &mut EnergyRow, changes: &[Reweighted; 2]) {
    let leaving = |row: &EnergyRow| {
        let [ballistic, scattered] = LEAVING.map(|fraction| row[fraction]);
        (ballistic.value + scattered.value, ballistic.se.hypot(scattered.se))
    };
    let (before, se_before) = leaving(row);
    for (fraction, change) in std::iter::zip(LEAVING, changes) {
        row[fraction].value *= change.ratio;
        row[fraction].se *= change.se_ratio;
    }
    let (after, se_after) = leaving(row);
    // What no longer leaves was absorbed, and its error moves with that of what leaves.
    let absorbed = &mut row[Fraction::Absorbed];
    absorbed.value += before - after;
    if se_before > 0.0 {
        absorbed.se *= se_after / se_before;
    }
}

fn notices(change: &Reabsorption, support: &[Support]) -> Vec<ReabsorptionNotice> {
    let kinds = [
        NoticeKind::FewPathsCount,
        NoticeKind::BinsTooWide,
        NoticeKind::OpenBin,
        NoticeKind::Scattering,
    ];
    let of_kind = |kind: NoticeKind| {
        let due: Vec<(f64, f64, f64)> = std::iter::zip(change.changes(), support)
            .filter_map(|(at, support)| {
                let (value, share) = kind.judge(support, at.scattering - 1.0)?;
                Some((at.wavelength_nm, value, share))
            })
            .collect();
        let severity = |(_, value, share): &(f64, f64, f64)| match kind {
            NoticeKind::FewPathsCount => *share,
            _ => value.abs(),
        };
        let worst = due.iter().max_by(|a, b| severity(a).total_cmp(&severity(b)))?;
        Some(ReabsorptionNotice {
            kind,
            wavelength_nm: worst.0,
            value: worst.1,
            share_of_light: worst.2,
            wavelengths: due.len(),
        })
    };
    kinds.into_iter().filter_map(of_kind).collect()
}
