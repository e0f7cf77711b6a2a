use super::Symmetry;
use crate::cloth::light::{Detector, HemisphereNodes};
use crate::formats::KlemsBasis;
use crate::geometry::Vec3;
use rand::{Rng, RngExt};

/// Cells of incident and outgoing directions of a full measurement, the same on both sides of the cloth. A cell below
/// the cloth is the cell above with z reversed.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// Beams from all nodes above the horizon; outgoing light is distributed over the four nodes around it.
    Nodes(HemisphereNodes),
    /// Means over pairs of patches. Light of incident patch k comes from the patch opposite in azimuth to k, as in
    /// [`crate::formats::KlemsMatrix`].
    Patches(KlemsBasis),
}

impl Cells {
    /// Number of cells of a hemisphere.
    pub fn count(&self) -> usize {
        match self {
            Self::Nodes(nodes) => nodes.count(),
            Self::Patches(basis) => basis.count(),
        }
    }

    /// Number of incident cells: the first ones of the hemisphere.
    pub fn incident(&self) -> usize {
        match self {
            Self::Nodes(nodes) => nodes.node(nodes.rings(), 0),
            Self::Patches(basis) => basis.count(),
        }
    }

    /// ∫ cosθ dω of a cell, sr: a scored fraction of the beam divided by it is f.
    pub fn projected_solid_angle(&self, cell: usize) -> f64 {
        match self {
            Self::Nodes(nodes) => nodes.projected_solid_angle(cell),
            Self::Patches(basis) => basis.projected_solid_angle(cell),
        }
    }

    /// Upward unit vector along a node or through the centre of a patch.
    pub fn centre(&self, cell: usize) -> Vec3 {
        match self {
            Self::Nodes(nodes) => {
                let [theta, phi] = nodes.angles_rad(cell);
                crate::formats::direction(theta, phi)
            }
            Self::Patches(basis) if cell == 0 => basis.direction(0, 0.0, 0.5),
            Self::Patches(basis) => basis.direction(cell, 0.5, 0.5),
        }
    }

    /// Upward unit vector towards the light of a batch. Over the batches it covers a patch uniformly in projected solid
    /// angle, by a lattice with a random shift from `rng`, which must be the same for each batch. The mean over batches
    /// is therefore unbiased, and their spread includes the variation of f over the patch.
    pub(super) fn towards_light(&self, cell: usize, batch: usize, batches: usize, mut rng: impl Rng) -> Vec3 {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        match self {
            Self::Nodes(_) => self.centre(cell),
            Self::Patches(basis) => {
                let [outwards, around]: [f64; 2] = rng.random();
                let outwards = (outwards + batch as f64 / batches as f64).fract();
                let around = (around + GOLDEN * batch as f64).fract();
                opposite(&basis.direction(cell, outwards, around))
            }
        }
    }

    /// As [`Self::centre`], towards the light of an incident cell.
    pub fn incident_centre(&self, cell: usize) -> Vec3 {
        match self {
            Self::Nodes(_) => self.centre(cell),
            Self::Patches(_) => opposite(&self.centre(cell)),
        }
    }

    /// Image of a cell under a symmetry. It holds for outgoing and incident cells alike, because symmetries commute
    /// with the reversal of a direction.
    pub(super) fn image(&self, cell: usize, symmetry: &Symmetry) -> usize {
        let mut d = symmetry.apply(&self.centre(cell));
        d.z = d.z.abs();
        match self {
            Self::Nodes(nodes) => nodes.nearest(&d),
            Self::Patches(basis) => basis.patch(&d),
        }
    }
}

fn opposite(d: &Vec3) -> Vec3 {
    Vec3::new(-d.x, -d.y, d.z)
}

/// Bins are the cells above the cloth, then those below.
impl Detector for Cells {
    fn bins(&self) -> usize {
        2 * self.count()
    }

    fn find(&self, direction: &Vec3, _: f64, mut found: impl FnMut(usize, f64)) {
        let up = direction.z > 0.0;
        let first = if up { 0 } else { self.count() };
        let upward = Vec3::new(direction.x, direction.y, direction.z.abs());
        match self {
            Self::Nodes(nodes) => nodes.share(&upward, |node, share| found(first + node, share)),
            Self::Patches(basis) => found(first + basis.patch(&upward), 1.0),
        }
    }
}
