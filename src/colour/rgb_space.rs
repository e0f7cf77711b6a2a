use crate::fault::{self, Fault};
use nalgebra::{Matrix3, Vector3};

use super::{LinearRgb, RgbSpace};

/// Bradford cone responses of XYZ (Lam 1985; ICC.1:2022 annex E).
const BRADFORD: Matrix3<f64> = Matrix3::new(
    0.8951, 0.2664, -0.1614, //
    -0.7502, 1.7135, 0.0367, //
    0.0389, -0.0685, 1.0296,
);

impl RgbSpace {
    /// Linear RGB → XYZ; RGB (1, 1, 1) is the space's white with Y = 1.
    pub(super) fn rgb_to_xyz(self) -> Matrix3<f64> {
        match self {
            Self::Srgb => from_primaries([(0.64, 0.33), (0.30, 0.60), (0.15, 0.06)], (0.3127, 0.3290)),
            // The CIE defines this space by the matrix itself.
            Self::CieRgb => Matrix3::new(
                0.49, 0.31, 0.20, //
                0.17697, 0.81240, 0.01063, //
                0.0, 0.01, 0.99,
            ),
            Self::Ntsc => from_primaries([(0.67, 0.33), (0.21, 0.71), (0.14, 0.08)], (0.31006, 0.31616)),
        }
    }

    pub(super) fn xyz_to_rgb(self) -> Matrix3<f64> {
        let matrix = inverse(&self.rgb_to_xyz());
        if fault::active(Fault::RgbTransposed) {
            matrix.transpose()
        } else {
            matrix
        }
    }

    /// XYZ of RGB (1, 1, 1).
    pub(super) fn white(self) -> Vector3<f64> {
        self.rgb_to_xyz() * Vector3::repeat(1.0)
    }

    /// Luminance Y of a colour given in this space: the Y row of RGB → XYZ. Of RGB values that were adapted it is the
    /// luminance under the space's white, not under the illuminant.
    pub fn luminance(self, rgb: LinearRgb) -> f64 {
        let row = self.luminance_row();
        row[0] * rgb.0[0] + row[1] * rgb.0[1] + row[2] * rgb.0[2]
    }

    /// Luminance of the three primaries; they sum to 1.
    pub fn luminance_row(self) -> [f64; 3] {
        let m = self.rgb_to_xyz();
        [m[(1, 0)], m[(1, 1)], m[(1, 2)]]
    }
}

/// Linear Bradford adaptation of XYZ seen under `from` to `to`.
pub(super) fn bradford(from: Vector3<f64>, to: Vector3<f64>) -> Matrix3<f64> {
    let gains = (BRADFORD * to).component_div(&(BRADFORD * from));
    inverse(&BRADFORD) * Matrix3::from_diagonal(&gains) * BRADFORD
}

/// Columns are the primaries, scaled so that their sum is the white.
fn from_primaries(primaries: [(f64, f64); 3], white: (f64, f64)) -> Matrix3<f64> {
    let xyz = |(x, y): (f64, f64)| Vector3::new(x / y, 1.0, (1.0 - x - y) / y);
    let columns = Matrix3::from_columns(&primaries.map(xyz));
    columns * Matrix3::from_diagonal(&(inverse(&columns) * xyz(white)))
}

/// Inverse by cofactors; the matrices here are constants far from singular.
fn inverse(m: &Matrix3<f64>) -> Matrix3<f64> {
    let [r0, r1, r2] = [0, 1, 2].map(|i| m.row(i).transpose());
    let columns = [r1.cross(&r2), r2.cross(&r0), r0.cross(&r1)];
    let determinant = r0.dot(&columns[0]);
    Matrix3::from_columns(&columns) / determinant
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The exact matrices of `tests/data/colour/rgb_matrices.csv`, 17 digits.
    fn reference(space: &str, direction: &str) -> Matrix3<f64> {
        let text = include_str!("../../tests/data/colour/rgb_matrices.csv");
        let start = format!("{space},{direction},");
        let row = text.lines().find_map(|l| l.strip_prefix(&start)).unwrap();
        Matrix3::from_row_iterator(row.split(',').map(|v| v.parse::<f64>().unwrap()))
    }

    #[test]
    fn matrices_agree_with_exact_arithmetic() {
        for (space, name) in [
            (RgbSpace::Srgb, "srgb"),
            (RgbSpace::CieRgb, "ciergb"),
            (RgbSpace::Ntsc, "ntsc"),
        ] {
            let forward = (space.rgb_to_xyz() - reference(name, "rgb_to_xyz")).abs().max();
            let back = (space.xyz_to_rgb() - reference(name, "xyz_to_rgb")).abs().max();
            assert!(forward < 1e-15 && back < 4e-15, "{name} {forward:e} {back:e}");
        }
        assert_eq!(BRADFORD, reference("bradford_cone", "xyz_to_lms"));
        let e_to_d65 = bradford(Vector3::repeat(1.0), RgbSpace::Srgb.white());
        let difference = (e_to_d65 - reference("bradford_E111_to_D65_3127_3290", "xyz_to_xyz"))
            .abs()
            .max();
        assert!(difference < 1e-15, "{difference:e}");
    }
}
