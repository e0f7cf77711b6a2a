//! Data into files.

use super::descriptor::{Content, Holds};
use super::notices::counted;
use super::options::WriteOptions;
use super::registry::{self, any_of};
use super::write::{WriteError, WriteNotice};
use crate::goniometric::{Component, Format, Goniometric, Scatter, Side, Table};

/// The bytes of a file, and what they do not hold as the source did.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    pub bytes: Vec<u8>,
    /// What is in it, in words.
    pub components: Vec<String>,
    pub notices: Vec<WriteNotice>,
}

/// Writes data as a file of a format.
///
/// # Errors
/// What the format cannot hold, and where the source has no value that the format needs.
pub fn write(data: &Goniometric, format: Format, options: &WriteOptions) -> Result<Written, WriteError> {
    let known = registry::descriptor(format);
    let writer = registry::writer(format)?;
    let chosen = chosen(data, format, writer.holds, options)?;
    let mut notices = Vec::new();
    let left_out = data.components.iter().filter(|c| !chosen.contains(c));
    let left_out: Vec<String> = left_out.map(Component::words).collect();
    if !left_out.is_empty() {
        notices.push(WriteNotice::ComponentsLeftOut { components: left_out });
    }
    if writer.holds != Holds::Sides && chosen.iter().any(|c| c.side == Side::Back) {
        notices.push(WriteNotice::SideNotStated { format });
    }
    let content = Content {
        format,
        component: chosen[0],
        components: &chosen,
        provenance: &data.provenance,
        encoding: options.encoding,
    };
    let bytes = (writer.write)(&content, &mut notices)?;
    if !writer.errors && chosen.iter().any(|c| states_errors(c)) {
        notices.push(WriteNotice::ErrorsLeftOut { format });
    }
    let most = known.most_bytes();
    if bytes.len() as u64 > most {
        notices.push(WriteNotice::TooLargeToRead {
            format,
            bytes: bytes.len(),
            most,
        });
    }
    Ok(Written {
        bytes,
        components: chosen.into_iter().map(Component::words).collect(),
        notices: counted(notices, |notice, times| WriteNotice::Several {
            notice: Box::new(notice),
            times,
        }),
    })
}

/// The components to write, at least one: those that the options choose and the format holds. A format that holds one
/// gets the reflection before the transmission unless the options choose. Light from the back is written into a format
/// that does not state the side only if the options choose it.
fn chosen<'a>(
    data: &'a Goniometric,
    format: Format,
    held: Holds,
    options: &WriteOptions,
) -> Result<Vec<&'a Component>, WriteError> {
    let is_specular = |c: &Component| matches!(c.table, Table::Specular(_));
    let holds = |c: &Component| match held {
        Holds::Fractions => is_specular(c),
        Holds::Reflection => !is_specular(c) && c.scatter == Scatter::Reflection,
        Holds::Kinds | Holds::Sides => true,
        Holds::Scattering => !is_specular(c),
    };
    let asked = |c: &Component| {
        let side = match held {
            Holds::Sides => options.side,
            _ => Some(options.side.unwrap_or(Side::Front)),
        };
        options.scatter.is_none_or(|scatter| c.scatter == scatter) && side.is_none_or(|side| c.side == side)
    };
    let mut fitting: Vec<&Component> = data.components.iter().filter(|c| holds(c) && asked(c)).collect();
    if held == Holds::Kinds {
        // A block of each kind.
        let mut kinds = Vec::new();
        fitting.retain(|c| {
            let kind = (c.scatter, is_specular(c));
            let is_first = !kinds.contains(&kind);
            kinds.push(kind);
            is_first
        });
    }
    // Beside scattering alone.
    let is_held = match held {
        Holds::Sides => fitting.iter().any(|c| !is_specular(c)),
        _ => !fitting.is_empty(),
    };
    if !is_held {
        let kind = match options.scatter {
            Some(Scatter::Reflection) => ", of reflection as was asked for",
            Some(Scatter::Transmission) => ", of transmission as was asked for",
            None => "",
        };
        let side = match (held, options.side) {
            (Holds::Sides, None) => "",
            (_, Some(Side::Back)) => ", of light from the back",
            _ => ", of light from the front",
        };
        let there: Vec<String> = data.components.iter().map(Component::words).collect();
        return Err(WriteError::CannotHold {
            format,
            holds: format!("{}{kind}{side}", held.words()),
            found: there.join("; "),
            remedy: format!(
                "choose one with --scatter and --side, or take a format that holds it: {} holds both sides, {} \
                 reflection and transmission",
                that_hold(Holds::Sides),
                that_hold(Holds::Kinds)
            ),
        });
    }
    if !held.several() {
        // The first one in the order of the source; sorting keeps it.
        fitting.sort_by_key(|c| c.scatter == Scatter::Transmission);
        fitting.truncate(1);
    }
    Ok(fitting)
}

/// The formats that hold so much.
fn that_hold(holds: Holds) -> String {
    let known = registry::all()
        .iter()
        .filter(|known| known.write.is_some_and(|writer| writer.holds == holds));
    any_of(&known.map(|known| known.format.name()).collect::<Vec<_>>())
}

fn states_errors(component: &Component) -> bool {
    matches!(&component.table, Table::Scattered(scattered) if scattered.states_errors())
}
