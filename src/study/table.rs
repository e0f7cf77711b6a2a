//! Macros that turn tables into types: [`super::keys`] has a row a key, [`super::choices`] a row a word.

/// Structs of a study's sections from a row a key:
///
/// ```text
/// /// Meaning, in words that the study file, the docs and the messages have.
/// key: type = default, kind with range, "unit";
/// /// A key without a default: its type is an `Option`, its default `None`, and an example stands in the study file.
/// key: type = None, kind with range, "unit", example "TOML";
/// // A key that is described as that of another section.
/// key: type = None, as OtherSection, example "TOML";
/// ```
macro_rules! sections {
    ($(
        $(#[doc = $about:literal])+
        pub struct $section:ident {
            $(
                $(#[doc = $meaning:literal])*
                $key:ident: $type:ty = $default:expr, $(as $like:ident)? $($kind:expr, $unit:literal)?
                $(, example $example:literal)?;
            )+
        }
    )+) => {$(
        $(#[doc = $about])+
        // A section in brackets, as [medium], is no link.
        #[allow(rustdoc::broken_intra_doc_links)]
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct $section {
            $(
                $(#[doc = $meaning])*
                $(#[doc = concat!("Example: `", $example, "`.")] #[serde(skip_serializing_if = "Option::is_none")])?
                pub $key: $type,
            )+
        }

        impl Default for $section {
            fn default() -> Self {
                Self { $($key: $default),+ }
            }
        }

        impl $section {
            const MEANING: &'static str = concat!($($about),+).trim_ascii();
            const FIELDS: &'static [Field] = &[
                $(field!($key [$($meaning)*] [$($like)?] [$($kind, $unit)?] [$($example)?])),+
            ];
        }
    )+};
}

/// The [`Field`](super::fields::Field) of a row.
macro_rules! field {
    ($key:ident [$($meaning:literal)*] [] [$kind:expr, $unit:literal] [$($example:literal)?]) => {{
        // Rows name kinds without their enum; some are constants.
        #[allow(unused_imports)]
        use super::fields::ValueKind::*;
        Field {
            key: stringify!($key),
            meaning: concat!($($meaning),*).trim_ascii(),
            unit: $unit,
            kind: $kind,
            example: fields::first(&[$($example)?]),
        }
    }};
    ($key:ident [] [$like:ident] [] [$($example:literal)?]) => {
        Field {
            example: fields::first(&[$($example)?]),
            ..fields::same($like::FIELDS, stringify!($key))
        }
    };
}

/// The study itself: rows of the keys at the top level, then its sections in the order of the file.
macro_rules! study {
    (
        $(#[$about:meta])+
        pub struct $study:ident {
            $(
                $(#[doc = $meaning:literal])+
                $key:ident: $key_type:ty = $default:expr, $kind:expr, $unit:literal;
            )+
            $([$name:ident] $section:ident $(, unless $left_out:literal)?;)+
        }
    ) => {
        $(#[$about])+
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct $study {
            $($(#[doc = $meaning])+ pub $key: $key_type,)+
            $($(#[serde(skip_serializing_if = $left_out)])? pub $name: $section,)+
            #[serde(skip)]
            pub origin: Origin,
        }

        impl Default for $study {
            fn default() -> Self {
                Self {
                    $($key: $default,)+
                    $($name: Default::default(),)+
                    origin: Default::default(),
                }
            }
        }

        pub(super) const SECTIONS: &[Section] = &[
            Section {
                name: "",
                meaning: "",
                fields: &[$(field!($key [$($meaning)+] [] [$kind, $unit] [])),+],
            },
            $(Section {
                name: stringify!($name),
                meaning: $section::MEANING,
                fields: $section::FIELDS,
            }),+
        ];
    };
}

/// Enums of which each value is one word in a study.
macro_rules! choices {
    ($(
        $(#[$about:meta])+
        pub enum $choice:ident {
            $($(#[$meaning:meta])* $value:ident = $word:literal,)+
        }
    )+) => {$(
        $(#[$about])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        pub enum $choice {
            $($(#[$meaning])* #[serde(rename = $word)] $value,)+
        }

        impl $choice {
            /// What a study calls the values.
            pub const NAMES: &'static [&'static str] = &[$($word),+];
        }
    )+};
}
