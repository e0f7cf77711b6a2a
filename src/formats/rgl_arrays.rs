//! The bytes of an RGL file without a warp.

use crate::goniometric::Format;

pub(super) const RGL: Format = Format::new("rgl");
pub(super) const MAGIC: &[u8] = b"tensor_file\0";
pub(super) const U8: u8 = 1;
pub(super) const F32: u8 = 10;

/// An array to be written.
enum Content<'a> {
    Bytes(&'a [u8]),
    Floats(&'a [f32]),
}

/// What [`write`] puts into a file, f cos θ_out over the half vector's unit square without a warp.
pub(super) struct Unwarped<'a> {
    pub(super) description: &'a str,
    pub(super) phi_i_rad: &'a [f32],
    pub(super) theta_i_rad: &'a [f32],
    pub(super) wavelengths_nm: Option<&'a [f32]>,
    /// Nodes along either side of the square.
    pub(super) size: usize,
    /// φ_i, θ_i, y, x.
    pub(super) luminance: &'a [f32],
    /// φ_i, θ_i, channel, y, x.
    pub(super) values: &'a [f32],
}

/// With ndf = 1, σ = 1/4 and a constant vndf the warp is the identity and the Jacobian's factor is 1, so that every
/// reader of the format finds the stored values themselves.
pub(super) fn write(content: &Unwarped) -> Vec<u8> {
    let slices = content.phi_i_rad.len() * content.theta_i_rad.len();
    let (phis, thetas, n) = (content.phi_i_rad.len(), content.theta_i_rad.len(), content.size);
    let channels = content.values.len() / (slices * n * n);
    let ones = vec![1.0f32; 4 * slices];
    let quarter = [0.25f32; 4];
    let mut fields: Vec<(&str, Vec<usize>, Content)> = vec![
        (
            "description",
            vec![content.description.len()],
            Content::Bytes(content.description.as_bytes()),
        ),
        ("phi_i", vec![phis], Content::Floats(content.phi_i_rad)),
        ("theta_i", vec![thetas], Content::Floats(content.theta_i_rad)),
        ("ndf", vec![2, 2], Content::Floats(&ones[..4])),
        ("sigma", vec![2, 2], Content::Floats(&quarter)),
        ("vndf", vec![phis, thetas, 2, 2], Content::Floats(&ones)),
        (
            "luminance",
            vec![phis, thetas, n, n],
            Content::Floats(content.luminance),
        ),
        ("jacobian", vec![1], Content::Bytes(&[1])),
    ];
    let shape = vec![phis, thetas, channels, n, n];
    match content.wavelengths_nm {
        Some(nm) => {
            fields.push(("wavelengths", vec![nm.len()], Content::Floats(nm)));
            fields.push(("spectra", shape, Content::Floats(content.values)));
        }
        None => fields.push(("rgb", shape, Content::Floats(content.values))),
    }
    let head: usize = fields
        .iter()
        .map(|(name, shape, _)| 13 + name.len() + 8 * shape.len())
        .sum();
    let mut offset = (MAGIC.len() + 6 + head).next_multiple_of(8);
    let mut file = MAGIC.to_vec();
    file.extend([1, 0]);
    file.extend((fields.len() as u32).to_le_bytes());
    let mut data = Vec::new();
    for (name, shape, content) in &fields {
        file.extend((name.len() as u16).to_le_bytes());
        file.extend(name.as_bytes());
        file.extend((shape.len() as u16).to_le_bytes());
        file.push(if matches!(content, Content::Bytes(_)) { U8 } else { F32 });
        file.extend((offset as u64).to_le_bytes());
        shape.iter().for_each(|&n| file.extend((n as u64).to_le_bytes()));
        let before = data.len();
        match content {
            Content::Bytes(bytes) => data.extend_from_slice(bytes),
            Content::Floats(values) => values.iter().for_each(|v| data.extend(v.to_le_bytes())),
        }
        // Some readers use the arrays in place and need them aligned.
        data.resize(data.len().next_multiple_of(8), 0);
        offset += data.len() - before;
    }
    file.resize(file.len().next_multiple_of(8), 0);
    file.extend(data);
    file
}
