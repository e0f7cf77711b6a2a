/// Equal sectors of the circle, counted from the x axis towards y. A point's sector is found by comparisons with the
/// tangents of the edges, which is many times faster than its angle.
#[derive(Clone, Debug, PartialEq)]
pub struct Sectors {
    /// Tangents of the edges inside the first quadrant.
    tangents: Vec<f64>,
}

impl Sectors {
    /// `None` unless `count` is a multiple of 4, at least 4.
    pub fn new(count: usize) -> Option<Self> {
        (count >= 4 && count.is_multiple_of(4)).then(|| Self::of_quadrants(count / 4))
    }

    /// `count` sectors in each quadrant.
    pub(super) fn of_quadrants(count: usize) -> Self {
        let tangent = |k: usize| (std::f64::consts::FRAC_PI_2 * k as f64 / count as f64).tan();
        Self {
            tangents: (1..count).map(tangent).collect(),
        }
    }

    /// Number of sectors of the circle.
    pub fn count(&self) -> usize {
        4 * (self.tangents.len() + 1)
    }

    /// Sector of a point; on an edge either of the two.
    #[inline(always)]
    pub fn sector(&self, x: f64, y: f64) -> usize {
        let (right, up) = (usize::from(x > 0.0), usize::from(y >= 0.0));
        let quadrant = [2, 3, 1, 0][right + 2 * up];
        // Rotate the quadrant onto the first.
        let odd = quadrant & 1 == 1;
        let (a, b) = (x.abs(), y.abs());
        let (a, b) = (if odd { b } else { a }, if odd { a } else { b });
        let edges: usize = self.tangents.iter().map(|t| usize::from(b >= t * a)).sum();
        quadrant * (self.tangents.len() + 1) + edges
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn sectors_are_those_of_the_angle() {
        for count in [4, 8, 24, 36] {
            let sectors = Sectors::new(count).unwrap();
            assert_eq!(sectors.count(), count);
            for i in 0..20_000 {
                let angle = (i as f64 + 0.5) / 20_000.0 * TAU;
                let expected = (angle / TAU * count as f64) as usize;
                assert_eq!(
                    sectors.sector(0.3 * angle.cos(), 0.3 * angle.sin()),
                    expected,
                    "{angle}"
                );
            }
        }
        assert!(Sectors::new(6).is_none() && Sectors::new(0).is_none());
    }
}
