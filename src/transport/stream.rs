use rand::SeedableRng;
use rand_xoshiro::{SplitMix64, Xoshiro256PlusPlus, rand_core::Rng};

/// Purpose of random numbers; part of the stream's key, so that no two purposes share numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    Bssrdf = 1,
    Direct = 2,
    Camera = 3,
    Validation = 4,
    Energy = 5,
    Check = 6,
    Woven = 7,
    Bounces = 8,
    Incidence = 9,
    Locality = 10,
    Sights = 11,
    Straight = 12,
    Fit = 13,
}

/// The only source of random numbers. Each (seed, purpose, direction, batch, wavelength) has its own stream,
/// independent of threads and of the order of work.
pub struct Stream;

impl Stream {
    /// The key is folded into SplitMix64, whose outputs seed xoshiro256++, as Blackman & Vigna (2019) recommend. The
    /// probability that two of N streams start within 2⁶⁴ numbers of each other is below N² 2⁻¹⁹¹.
    pub fn open(seed: u64, purpose: Purpose, direction: usize, batch: usize, wavelength: usize) -> Xoshiro256PlusPlus {
        let mut key = seed;
        for part in [purpose as u64, direction as u64, batch as u64, wavelength as u64] {
            key = SplitMix64::seed_from_u64(key).next_u64() ^ part;
        }
        Xoshiro256PlusPlus::seed_from_u64(SplitMix64::seed_from_u64(key).next_u64())
    }
}

/// N xoshiro256++ generators side by side, stepped together.
#[derive(Clone, Debug)]
pub(super) struct LaneStream<const N: usize> {
    state: [[u64; N]; 4],
}

impl<const N: usize> LaneStream<N> {
    /// Each lane's state comes from a SplitMix64 that `stream` seeds.
    pub fn open(stream: &mut Xoshiro256PlusPlus) -> Self {
        let mut state = [[0; N]; 4];
        for lane in 0..N {
            let mut words = SplitMix64::seed_from_u64(stream.next_u64());
            state.iter_mut().for_each(|row| row[lane] = words.next_u64());
        }
        Self { state }
    }

    /// The next number of one lane.
    #[inline(always)]
    pub fn next(&mut self, lane: usize) -> u64 {
        let [s0, s1, s2, s3] = &mut self.state;
        let result = s0[lane].wrapping_add(s3[lane]).rotate_left(23).wrapping_add(s0[lane]);
        let t = s1[lane] << 17;
        s2[lane] ^= s0[lane];
        s3[lane] ^= s1[lane];
        s1[lane] ^= s2[lane];
        s0[lane] ^= s3[lane];
        s2[lane] ^= t;
        s3[lane] = s3[lane].rotate_left(45);
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_of_the_key_changes_the_stream() {
        let keys = [(1, 0, 0, 0), (2, 0, 0, 0), (1, 1, 0, 0), (1, 0, 1, 0), (1, 0, 0, 1)];
        let mut first: Vec<u64> = keys
            .iter()
            .map(|&(s, d, b, w)| Stream::open(s, Purpose::Direct, d, b, w).next_u64())
            .collect();
        first.push(Stream::open(1, Purpose::Bssrdf, 0, 0, 0).next_u64());
        let count = first.len();
        first.sort_unstable();
        first.dedup();
        assert_eq!(first.len(), count);
    }

    /// Golden value: a change of the scheme changes every result, so it must be deliberate.
    #[test]
    fn golden_stream() {
        let mut stream = Stream::open(1, Purpose::Direct, 2, 3, 4);
        assert_eq!(stream.next_u64(), 3872697235653849325);
    }

    /// Each lane equals the generator of the `rand_xoshiro` crate, seeded with the lane's state.
    #[test]
    fn lanes_are_xoshiro256plusplus() {
        let mut lanes = LaneStream::<4>::open(&mut Stream::open(7, Purpose::Validation, 0, 0, 0));
        let mut seed = [0u8; 32];
        for (bytes, row) in seed.chunks_exact_mut(8).zip(&lanes.state) {
            bytes.copy_from_slice(&row[2].to_le_bytes());
        }
        let mut reference = Xoshiro256PlusPlus::from_seed(seed);
        for _ in 0..100 {
            assert_eq!(lanes.next(2), reference.next_u64());
            lanes.next(0);
        }
    }
}
