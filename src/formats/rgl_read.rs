//! The tensor file of the Realistic Graphics Lab (`.bsdf` of the RGL material database, Mitsuba's and pbrt's
//! `measured`): named arrays in one binary file, little-endian.

use std::collections::BTreeMap;

use super::byte_order::{is_implausible, swapped};
use super::error::{FormatError, remedy};
use super::rgl_arrays::{F32, MAGIC, RGL, U8};
use super::text::quoted;
use crate::goniometric::{
    Arrays, ChannelSet, Component, FileProvenance, Goniometric, Quantity, ReadNotice, Scatter, Side, Table, Warped,
};
use crate::number::shown;
use crate::spectrum::WavelengthGrid;

/// Element sizes by the file's type code.
const SIZES: [u8; 12] = [0, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8];

/// Incidences above it, 89.9 degrees, are those of the horizon.
const HORIZON_RAD: f32 = 1.569;

/// An array's place in the file.
struct Field {
    element: u8,
    shape: Vec<usize>,
    offset: usize,
    count: usize,
    /// Where the field is described.
    at: usize,
}

impl Field {
    /// Bytes.
    fn size(&self) -> usize {
        self.count * usize::from(SIZES[usize::from(self.element)])
    }
}

/// Reads little-endian numbers on from a place.
struct Cursor<'a> {
    path: &'a str,
    bytes: &'a [u8],
    position: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize, what: &str) -> Result<&'a [u8], FormatError> {
        let taken = self.bytes.get(self.position..).and_then(|rest| rest.get(..count));
        let taken = taken
            .ok_or_else(|| FormatError::byte(self.path, self.position, what, "the end of the file", remedy::DAMAGED))?;
        self.position += count;
        Ok(taken)
    }

    fn number<const N: usize>(&mut self, what: &str) -> Result<[u8; N], FormatError> {
        let mut word = [0; N];
        word.copy_from_slice(self.take(N, what)?);
        Ok(word)
    }
}

pub(super) fn read(path: &str, bytes: &[u8]) -> Result<Goniometric, FormatError> {
    let fields = fields(path, bytes)?;
    let file = File { path, bytes, fields };
    let theta_i = file.array("theta_i", &[None])?;
    let phi_i = file.array("phi_i", &[None])?;
    for (name, angles, low, high) in [("theta_i", &theta_i, -1e-4, 1.5709), ("phi_i", &phi_i, -3.1417, 6.2833)] {
        let ascending = angles.windows(2).all(|pair| pair[0] < pair[1]);
        if !ascending || angles.iter().any(|a| !(low..=high).contains(&f64::from(*a))) {
            let expected = format!("`{name}` in radians, ascending, from {low:.2} to {high:.2}");
            let ends = [angles[0], angles[angles.len() - 1]];
            let found = format!("{} angles from {} to {}", angles.len(), ends[0], ends[1]);
            let remedy = "sort the slices by angle, and give angles in radians";
            return Err(FormatError::file(path, expected, found, remedy));
        }
    }
    let (phis, thetas) = (Some(phi_i.len()), Some(theta_i.len()));
    let ndf = file.array("ndf", &[None, None])?;
    let sigma = file.array("sigma", &[None, None])?;
    let vndf = file.array("vndf", &[phis, thetas, None, None])?;
    let luminance_shape = file.shape("luminance")?;
    file.array("luminance", &[phis, thetas, None, None])?;
    let square = luminance_shape.last().copied();
    let (channels, values) = if file.fields.contains_key("spectra") {
        let wavelengths = file.array("wavelengths", &[None])?;
        let count = wavelengths.len();
        let nm = wavelengths.into_iter().map(f64::from).collect();
        let grid = WavelengthGrid::new(nm)
            .map_err(|e| FormatError::file(path, "ascending `wavelengths`", e.to_string(), remedy::WAVELENGTHS))?;
        let values = file.array("spectra", &[phis, thetas, Some(count), square, square])?;
        (ChannelSet::Wavelengths(grid), values)
    } else {
        if file.fields.contains_key("wavelengths") {
            return Err(FormatError::file(
                path,
                "`spectra` beside `wavelengths`",
                "no such array",
                "add the spectra, or remove `wavelengths` from an RGB file",
            ));
        }
        (
            ChannelSet::Rgb,
            file.array("rgb", &[phis, thetas, Some(3), square, square])?,
        )
    };
    let jacobian = match file.bytes_of("jacobian")? {
        [0] => false,
        [1] => true,
        other => {
            return Err(FormatError::file(
                path,
                "`jacobian` 0 or 1",
                format!("{} bytes, another value", other.len()),
                "write it as one byte: 1 where values are without the Jacobian of the warp, else 0",
            ));
        }
    };
    let mut warnings = Vec::new();
    let seen = file.mask(&theta_i, phi_i.len(), square.unwrap_or(0), &mut warnings)?;
    let description = String::from_utf8_lossy(file.bytes_of("description")?).into_owned();
    let arrays = Arrays {
        isotropic: phi_i.len() <= 2,
        phi_i: phi_i.into_iter().map(f64::from).collect(),
        theta_i: theta_i.into_iter().map(f64::from).collect(),
        ndf_shape: file.square_shape("ndf")?,
        ndf,
        sigma_shape: file.square_shape("sigma")?,
        sigma,
        vndf_shape: file.square_shape("vndf")?,
        vndf,
        size: square.unwrap_or(0),
        channels: channels.count(),
        values,
        seen,
        jacobian,
    };
    if arrays.size < 2 {
        let remedy = "write the arrays on a finer square";
        return Err(FormatError::file(
            path,
            "`luminance` of 2 x 2 nodes or more",
            "fewer",
            remedy,
        ));
    }
    let warped = Warped::new(arrays).map_err(|expected| {
        FormatError::file(
            path,
            expected,
            "others",
            "the file is no measurement as the format has it: export it again",
        )
    })?;
    if channels == ChannelSet::Rgb {
        warnings.push(ReadNotice::RgbPrimariesNotStated);
    }
    let name = if channels == ChannelSet::Rgb { "rgb" } else { "spectra" };
    let negative = warped.negative_above_horizon();
    if negative.count > 0 {
        if negative.sum >= negative.positive_sum {
            warnings.push(ReadNotice::MostlyNegative { array: name.into() });
        }
        warnings.push(ReadNotice::BelowZero {
            array: name.into(),
            count: negative.count,
            lowest: negative.lowest,
            rgb: channels == ChannelSet::Rgb,
        });
    }
    if let Some(words) = warped.symmetry() {
        warnings.push(ReadNotice::PartOfAzimuths { symmetry: words.into() });
    }
    let end = file
        .fields
        .values()
        .map(|field| field.offset + field.size())
        .max()
        .unwrap_or(0);
    // Arrays are aligned to 8 bytes, with zeros between them.
    let behind = bytes.get(end..).unwrap_or_default();
    if behind.len() >= 8 || behind.iter().any(|byte| *byte != 0) {
        warnings.push(ReadNotice::BytesBehindArrays {
            bytes: bytes.len() - end,
        });
    }
    let provenance = FileProvenance {
        source: None,
        statements: vec![("description".into(), description)],
        comments: Vec::new(),
    };
    Ok(Goniometric {
        format: RGL,
        provenance,
        components: vec![Component {
            scatter: Scatter::Reflection,
            side: Side::Front,
            quantity: Quantity::BsdfCosine,
            channels,
            table: Table::Warped(warped),
        }],
        warnings,
    })
}

fn fields(path: &str, bytes: &[u8]) -> Result<BTreeMap<String, Field>, FormatError> {
    let mut cursor = Cursor {
        path,
        bytes,
        position: 0,
    };
    if cursor.take(12, "the beginning of a tensor file")? != MAGIC {
        return Err(FormatError::byte(
            path,
            0,
            "the beginning of a tensor file",
            "another",
            remedy::DAMAGED,
        ));
    }
    let version = cursor.take(2, "version 1.0")?;
    if version != [1, 0] {
        let found = format!("version {}.{}", version[0], version[1]);
        let remedy = "write the file as version 1.0, which all its readers take";
        return Err(FormatError::byte(path, 12, "version 1.0", found, remedy));
    }
    let count = u32::from_le_bytes(cursor.number("the number of arrays")?);
    let mut fields = BTreeMap::new();
    for _ in 0..count {
        let at = cursor.position;
        let length = u16::from_le_bytes(cursor.number("the length of an array's name")?);
        let name = cursor.take(usize::from(length), "the name of an array")?;
        let name = std::str::from_utf8(name)
            .map_err(|_| FormatError::byte(path, at, "a name in UTF-8", "other bytes", remedy::DAMAGED))?;
        let dimensions = u16::from_le_bytes(cursor.number("a number of dimensions")?);
        let [element] = cursor.number::<1>("an element type")?;
        let size = SIZES.get(usize::from(element)).filter(|&&size| size > 0);
        let size = size.ok_or_else(|| {
            FormatError::byte(path, at, "an element type 1..11", element.to_string(), remedy::DAMAGED)
        })?;
        let offset = u64::from_le_bytes(cursor.number("the place of an array")?);
        let mut shape = Vec::new();
        for _ in 0..dimensions {
            let length = u64::from_le_bytes(cursor.number("the length of an axis")?);
            shape.push(usize::try_from(length).unwrap_or(usize::MAX));
        }
        let elements = shape.iter().try_fold(1usize, |product, &n| product.checked_mul(n));
        let end = elements
            .and_then(|n| n.checked_mul(usize::from(*size)))
            .and_then(|n| n.checked_add(usize::try_from(offset).ok()?));
        let (Some(elements), Some(true)) = (elements, end.map(|end| end <= bytes.len())) else {
            let expected = format!(
                "the array {} of shape {shape:?} from byte {offset} within the file",
                quoted(name)
            );
            return Err(FormatError::byte(
                path,
                at,
                expected,
                format!("a file of {} bytes", bytes.len()),
                remedy::CUT_SHORT,
            ));
        };
        let field = Field {
            element,
            shape,
            offset: offset as usize,
            count: elements,
            at,
        };
        if fields.insert(name.to_owned(), field).is_some() {
            return Err(FormatError::byte(
                path,
                at,
                "each array once",
                quoted(name),
                remedy::ONE_OF_TWO,
            ));
        }
    }
    Ok(fields)
}

struct File<'a> {
    path: &'a str,
    bytes: &'a [u8],
    fields: BTreeMap<String, Field>,
}

impl File<'_> {
    fn field(&self, name: &str, element: u8) -> Result<&Field, FormatError> {
        let field = self.fields.get(name);
        let field = field.ok_or_else(|| {
            let remedy = match name {
                "rgb" => {
                    "the file may be tensors of another kind than a measured BSDF; write `rgb`, or `spectra` and \
                          `wavelengths`"
                }
                _ => "the file may be tensors of another kind than a measured BSDF, which has this array",
            };
            FormatError::file(self.path, format!("an array `{name}`"), "none", remedy)
        })?;
        if field.element == element {
            return Ok(field);
        }
        let expected = format!("`{name}` of element type {element}");
        Err(FormatError::byte(
            self.path,
            field.at,
            expected,
            field.element.to_string(),
            "store values as 32-bit floats (type 10), texts and flags as bytes (type 1)",
        ))
    }

    fn shape(&self, name: &str) -> Result<&[usize], FormatError> {
        Ok(&self.field(name, F32)?.shape)
    }

    /// Rows and columns of an array's last two axes.
    fn square_shape(&self, name: &str) -> Result<[usize; 2], FormatError> {
        match self.shape(name)? {
            [.., rows, columns] if *rows >= 2 && *columns >= 2 => Ok([*rows, *columns]),
            _ => Err(FormatError::file(
                self.path,
                format!("`{name}` of 2 x 2 nodes or more"),
                "fewer",
                "write the array on a finer grid",
            )),
        }
    }

    fn bytes_of(&self, name: &str) -> Result<&[u8], FormatError> {
        let field = self.field(name, U8)?;
        Ok(&self.bytes[field.offset..field.offset + field.count])
    }

    /// Which nodes the instrument saw: one bit each, the highest of a byte first. `None` of files without the array,
    /// which the format does not demand.
    fn mask(
        &self,
        theta_i: &[f32],
        azimuths: usize,
        square: usize,
        warnings: &mut Vec<ReadNotice>,
    ) -> Result<Option<Vec<bool>>, FormatError> {
        if !self.fields.contains_key("valid") {
            return Ok(None);
        }
        let slice = square * square;
        let nodes = azimuths * theta_i.len() * slice;
        let bytes = self.bytes_of("valid")?;
        if bytes.len() != nodes.div_ceil(8) {
            warnings.push(ReadNotice::MaskNotUsed {
                nodes,
                bytes: bytes.len(),
            });
            return Ok(None);
        }
        let bit = |node: usize| bytes[node / 8] >> (7 - node % 8) & 1 == 1;
        let unseen = (0..nodes).filter(|&node| !bit(node)).count();
        if unseen > 0 {
            warnings.push(ReadNotice::UnseenNodes { unseen, nodes });
        }
        // No light falls on a sample from its horizon: the slice there continues the last measured one, whatever its
        // mask.
        let at_horizon = |node: usize| theta_i[node / slice % theta_i.len()] > HORIZON_RAD;
        if (0..nodes).any(|node| bit(node) && at_horizon(node)) {
            warnings.push(ReadNotice::ContinuedToHorizon);
        }
        Ok(Some((0..nodes).map(|node| bit(node) && !at_horizon(node)).collect()))
    }

    /// An array of finite values, 0 or more but for angles; lengths that are known must be these.
    fn array(&self, name: &str, lengths: &[Option<usize>]) -> Result<Vec<f32>, FormatError> {
        let field = self.field(name, F32)?;
        let fits = field.shape.len() == lengths.len()
            && field
                .shape
                .iter()
                .zip(lengths)
                .all(|(n, known)| *n > 0 && known.is_none_or(|known| *n == known));
        if !fits {
            let known = lengths.iter().map(|n| n.map_or("any".into(), |n| n.to_string()));
            let expected = format!("`{name}` of shape {}", known.collect::<Vec<_>>().join(" x "));
            return Err(FormatError::byte(
                self.path,
                field.at,
                expected,
                format!("{:?}", field.shape),
                "arrays must agree with `phi_i`, `theta_i`, `wavelengths` and `luminance`: export the file again",
            ));
        }
        let bytes = &self.bytes[field.offset..field.offset + 4 * field.count];
        let stored = bytes
            .chunks_exact(4)
            .map(|bytes| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
        // Densities may be tiny far from their peak; values of scattering are not.
        if matches!(name, "rgb" | "spectra") && is_implausible(stored.clone().map(f64::from)) {
            return Err(swapped(self.path, field.offset));
        }
        let mut values = Vec::with_capacity(field.count);
        for (index, value) in stored.enumerate() {
            if !value.is_finite() || (value < 0.0 && !matches!(name, "phi_i" | "rgb" | "spectra")) {
                let at = field.offset + 4 * index;
                return Err(FormatError::byte(
                    self.path,
                    at,
                    format!("a value of `{name}`, 0 or more"),
                    match value.is_finite() {
                        true => shown(f64::from(value)),
                        false => value.to_string(),
                    },
                    remedy::DAMAGED,
                ));
            }
            values.push(value);
        }
        Ok(values)
    }
}
