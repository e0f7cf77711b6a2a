use super::Estimate;
use crate::fault::{self, Fault};
use std::fmt;
use std::marker::PhantomData;
use std::ops::{Index, IndexMut};

/// The fractions of a ledger: an enum that defines the ledger, its columns in tables and its arrays in files. Declared
/// with the macro `fractions!`.
pub trait FractionList: Copy + fmt::Debug + Eq + 'static {
    /// Every fraction, in the order of the arrays in files.
    const ALL: &'static [Self];

    /// Name in the headers of files.
    fn name(self) -> &'static str;

    /// Name of the column of its standard error.
    fn se_name(self) -> &'static str;

    /// Position in [`Self::ALL`].
    fn index(self) -> usize;
}

/// Declares the fractions of a ledger, one row each: meaning, variant, name in files.
macro_rules! fractions {
    (
        $(#[$about:meta])*
        $visibility:vis enum $list:ident { $($(#[$meaning:meta])* $fraction:ident = $name:literal,)+ }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $visibility enum $list { $($(#[$meaning])* $fraction),+ }

        impl $list {
            pub const COUNT: usize = [$($name),+].len();
        }

        impl $crate::transport::FractionList for $list {
            const ALL: &'static [Self] = &[$(Self::$fraction),+];

            fn name(self) -> &'static str {
                match self { $(Self::$fraction => $name),+ }
            }

            fn se_name(self) -> &'static str {
                match self { $(Self::$fraction => concat!($name, "_se")),+ }
            }

            fn index(self) -> usize {
                self as usize
            }
        }
    };
}
pub(crate) use fractions;

fractions! {
    /// Fractions of the flux that meets a yarn.
    pub enum Fraction {
        /// Reflected by the surface on the way in.
        Reflected = "reflected",
        /// Left without a scattering event.
        Ballistic = "ballistic",
        /// Left after one or more scattering events.
        Scattered = "scattered",
        /// Absorbed by particles or host.
        Absorbed = "absorbed",
        /// Weight that Russian roulette removed less what it added; 0 in the mean.
        RouletteNet = "roulette",
        /// Weight that the balance heuristic of shared paths removed less what it added, with the rounding errors of
        /// single precision; 0 in the mean, and exactly 0 for paths of one wavelength.
        MisNet = "mis_net",
    }
}

/// Energy ledger: the amount of each of the N fractions of a list, as sums over paths or as fractions of the incident
/// flux.
#[derive(Clone, Copy, PartialEq)]
pub struct LedgerOf<F, const N: usize> {
    amounts: [f64; N],
    list: PhantomData<F>,
}

/// Energy ledger of a yarn for one incident direction and wavelength.
pub type Ledger = LedgerOf<Fraction, { Fraction::COUNT }>;

impl<F: FractionList, const N: usize> LedgerOf<F, N> {
    /// A ledger with the amount that `of` gives for each fraction.
    pub fn new(mut of: impl FnMut(F) -> f64) -> Self {
        const { assert!(F::ALL.len() == N) };
        Self::from_amounts(std::array::from_fn(|k| of(F::ALL[k])))
    }

    /// Amounts in the order of the list.
    pub fn from_amounts(amounts: [f64; N]) -> Self {
        let list = PhantomData;
        Self { amounts, list }
    }

    /// Amounts in the order of the list.
    pub fn amounts(&self) -> [f64; N] {
        self.amounts
    }

    /// 1 − sum of all fractions; 0 to rounding for a closed ledger.
    pub fn residual(&self) -> f64 {
        1.0 - self.amounts.iter().sum::<f64>()
    }

    /// Adds the amounts of another ledger.
    pub fn add(&mut self, other: &Self) {
        for (sum, amount) in self.amounts.iter_mut().zip(other.amounts) {
            *sum += amount;
        }
    }

    /// Mean of equally weighted batches, and its standard errors.
    pub fn mean_and_se(batches: &[Self]) -> [Self; 2] {
        let of = |k: usize| Estimate::from_batches(batches.iter().map(|ledger| ledger.amounts[k]));
        let estimates: [Estimate; N] = std::array::from_fn(of);
        [
            Self::from_amounts(estimates.map(|estimate| estimate.value)),
            Self::from_amounts(estimates.map(|estimate| estimate.se)),
        ]
    }
}

impl Ledger {
    /// The ledger with all amounts times `factor`.
    pub fn scaled(&self, factor: f64) -> Self {
        let mut scaled = Self::from_amounts(self.amounts.map(|amount| amount * factor));
        if fault::active(Fault::HalfAbsorbed) {
            scaled[Fraction::Absorbed] *= 0.5;
        }
        scaled
    }

    /// Net weight that random sampling removed: Russian roulette and the balance heuristic together. 0 in the mean.
    pub fn sampling_net(&self) -> f64 {
        self[Fraction::RouletteNet] + self[Fraction::MisNet]
    }
}

impl<F, const N: usize> Default for LedgerOf<F, N> {
    fn default() -> Self {
        Self {
            amounts: [0.0; N],
            list: PhantomData,
        }
    }
}

impl<F: FractionList, const N: usize> Index<F> for LedgerOf<F, N> {
    type Output = f64;

    #[inline(always)]
    fn index(&self, fraction: F) -> &f64 {
        &self.amounts[fraction.index()]
    }
}

impl<F: FractionList, const N: usize> IndexMut<F> for LedgerOf<F, N> {
    #[inline(always)]
    fn index_mut(&mut self, fraction: F) -> &mut f64 {
        &mut self.amounts[fraction.index()]
    }
}

impl<F: FractionList, const N: usize> fmt::Debug for LedgerOf<F, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = F::ALL.iter().map(|fraction| fraction.name()).zip(self.amounts);
        f.debug_map().entries(named).finish()
    }
}

/// A column of a table of yarn ledgers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// One of the fractions. Exception: the column of [`Fraction::RouletteNet`] holds [`Ledger::sampling_net`], which
    /// includes [`Fraction::MisNet`]; the latter also has a column of its own.
    Fraction(Fraction),
    /// See [`LedgerOf::residual`].
    Residual,
}

impl Column {
    pub const COUNT: usize = Fraction::COUNT + 1;

    /// Every column in the order of `energy.csv`: the residual follows the net effect of all sampling, and fractions
    /// that were added to the list later come last.
    pub const ALL: [Self; Self::COUNT] = {
        let mut all = [Self::Residual; Self::COUNT];
        let mut k = 0;
        while k < Fraction::COUNT {
            let after_residual = k > Fraction::RouletteNet as usize;
            all[k + after_residual as usize] = Self::Fraction(<Fraction as FractionList>::ALL[k]);
            k += 1;
        }
        all
    };

    /// Name in the headers of files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fraction(fraction) => fraction.name(),
            Self::Residual => "residual",
        }
    }

    /// Name of the column of its standard error.
    pub fn se_name(self) -> &'static str {
        match self {
            Self::Fraction(fraction) => fraction.se_name(),
            Self::Residual => "residual_se",
        }
    }

    /// Value of the column for one ledger.
    pub fn of(self, ledger: &Ledger) -> f64 {
        match self {
            Self::Fraction(Fraction::RouletteNet) => ledger.sampling_net(),
            Self::Fraction(fraction) => ledger[fraction],
            Self::Residual => ledger.residual(),
        }
    }

    /// Values of all columns for the mean of equally weighted batches, with standard errors, in the order of
    /// [`Self::ALL`].
    pub fn estimates(batches: &[Ledger]) -> [Estimate; Self::COUNT] {
        let [mean, _] = Ledger::mean_and_se(batches);
        Self::ALL.map(|column| Estimate {
            value: column.of(&mean),
            se: Estimate::from_batches(batches.iter().map(|ledger| column.of(ledger))).se,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_have_the_fixed_order_of_energy_csv() {
        let names = Column::ALL.map(Column::name);
        let fixed = [
            "reflected",
            "ballistic",
            "scattered",
            "absorbed",
            "roulette",
            "residual",
        ];
        assert_eq!(names[..6], fixed);
        assert_eq!(names[6], "mis_net");
        assert!(
            Column::ALL
                .iter()
                .all(|column| column.se_name() == format!("{}_se", column.name()))
        );
    }

    #[test]
    fn column_of_roulette_holds_the_net_of_all_sampling() {
        let ledger = Ledger::new(|fraction| match fraction {
            Fraction::RouletteNet => 0.25,
            Fraction::MisNet => 0.125,
            _ => 0.0,
        });
        let of = Column::ALL.map(|column| column.of(&ledger));
        assert_eq!(of, [0.0, 0.0, 0.0, 0.0, 0.375, 0.625, 0.125]);
        let [.., roulette, _, _] = Column::estimates(&[ledger, Ledger::default()]);
        assert_eq!([roulette.value, roulette.se], [0.1875, 0.1875]);
    }
}
