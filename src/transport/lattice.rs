use rand_xoshiro::{Xoshiro256PlusPlus, rand_core::Rng};

/// Evenly spread points of the unit cube, one a path: the additive recurrence whose steps are the powers of the root of
/// x^(d+1) = x + 1 (Roberts 2018), started at a random point, so that each point alone is even in the cube and a mean
/// over them is unbiased. In fixed point, exact for any number of paths.
#[derive(Clone, Debug)]
pub(super) struct Lattice<const D: usize> {
    at: [u64; D],
    step: [u64; D],
}

impl<const D: usize> Lattice<D> {
    pub fn open(stream: &mut Xoshiro256PlusPlus) -> Self {
        let mut root = 2.0f64;
        for _ in 0..64 {
            root = (1.0 + root).powf(1.0 / (D as f64 + 1.0));
        }
        let mut fraction = 1.0;
        Self {
            at: std::array::from_fn(|_| stream.next_u64()),
            step: std::array::from_fn(|_| {
                fraction /= root;
                (fraction * 2f64.powi(64)) as u64
            }),
        }
    }

    /// The next point, coordinates in [0, 1).
    #[inline]
    pub fn next(&mut self) -> [f64; D] {
        std::array::from_fn(|k| {
            self.at[k] = self.at[k].wrapping_add(self.step[k]);
            super::lane_math::unit(self.at[k])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::{Purpose, Stream};

    /// Every coordinate fills its strata: n points leave none of n/3 intervals empty; pairs fill a grid likewise.
    #[test]
    fn points_are_evenly_spread() {
        let mut lattice = Lattice::<6>::open(&mut Stream::open(1, Purpose::Validation, 0, 0, 0));
        let points: Vec<[f64; 6]> = (0..3000).map(|_| lattice.next()).collect();
        for k in 0..6 {
            let mut counts = vec![0; 1000];
            points.iter().for_each(|p| counts[(p[k] * 1000.0) as usize] += 1);
            assert!(counts.iter().all(|&c| (1..=6).contains(&c)), "coordinate {k}");
            for j in 0..k {
                let mut counts = vec![0; 100];
                points
                    .iter()
                    .for_each(|p| counts[(p[k] * 10.0) as usize * 10 + (p[j] * 10.0) as usize] += 1);
                assert!(
                    counts.iter().all(|&c| (15..=45).contains(&c)),
                    "coordinates {j}, {k}: {counts:?}"
                );
            }
        }
    }
}
