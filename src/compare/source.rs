//! What a report compares: any number of models, classical shadings and samples.

use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};
use std::sync::Arc;

/// Short name of a source in curves, errors and files.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(from = "String", into = "String")]
pub struct SourceId(Arc<str>);

impl SourceId {
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl From<&str> for SourceId {
    fn from(id: &str) -> Self {
        Self(id.into())
    }
}

impl From<String> for SourceId {
    fn from(id: String) -> Self {
        Self(id.into())
    }
}

impl From<SourceId> for String {
    fn from(id: SourceId) -> Self {
        id.0.as_ref().into()
    }
}

impl PartialEq<str> for SourceId {
    fn eq(&self, id: &str) -> bool {
        &*self.0 == id
    }
}

impl PartialEq<&str> for SourceId {
    fn eq(&self, id: &&str) -> bool {
        &*self.0 == *id
    }
}

impl Display for SourceId {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        f.pad(&self.0)
    }
}

/// What a source is in the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// A physical model, traced in Monte Carlo batches.
    Model,
    /// A formula that a renderer would use.
    Classical,
    /// A sample's readings, which the others are compared with.
    Measured,
}

impl Role {
    /// Id of the first source of this role. Files leave such an id out where it is the only possible one.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Model => "model",
            Self::Classical => "classical",
            Self::Measured => "measured",
        }
    }
}

/// One of the sources that a report compares.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Source {
    pub id: SourceId,
    pub role: Role,
    /// As legends name it.
    pub label: String,
}

impl Source {
    /// Source number `place` of its role, from 0: `model`, then `model-2`, `model-3`.
    pub fn numbered(role: Role, place: usize, label: impl Into<String>) -> Self {
        let id = match place {
            0 => role.id().into(),
            _ => format!("{}-{}", role.id(), place + 1).into(),
        };
        Self {
            id,
            role,
            label: label.into(),
        }
    }
}

/// Defaults of ids in files, and whether an id is one: see [`Role::id`].
macro_rules! first {
    ($($id:ident, $is:ident, $role:ident;)*) => {$(
        pub(crate) fn $id() -> SourceId {
            Role::$role.id().into()
        }

        pub(crate) fn $is(id: &SourceId) -> bool {
            *id == Role::$role.id()
        }
    )*};
}

first! {
    first_model, is_first_model, Model;
    first_classical, is_first_classical, Classical;
    first_sample, is_first_sample, Measured;
}
