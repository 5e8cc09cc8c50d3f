//! Columns of a quantity: names of columns, or tables with units and factors.

use std::fmt;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::{Deserialize, Deserializer};

use super::robot::Side;
use super::units::Unit;

/// A column by its name, or by its number from 1.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, JsonSchema)]
#[schemars(untagged)]
pub enum ColumnName {
    /// Its name; a `*` stands for the number or the name of the joint.
    Name(String),
    /// Its place in the file, from 1.
    Number(usize),
}

impl Default for ColumnName {
    fn default() -> Self {
        Self::Name(String::new())
    }
}

impl ColumnName {
    /// Returns whether it is a name with a `*`.
    #[must_use]
    pub fn is_pattern(&self) -> bool {
        matches!(self, Self::Name(name) if name.contains('*'))
    }
}

impl fmt::Display for ColumnName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name(name) => f.write_str(name),
            Self::Number(number) => write!(f, "{number}"),
        }
    }
}

impl<'de> Deserialize<'de> for ColumnName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl serde::de::Visitor<'_> for Visitor {
            type Value = ColumnName;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name of a column or its number from 1")
            }

            fn visit_str<E>(self, name: &str) -> Result<ColumnName, E> {
                Ok(ColumnName::Name(name.to_owned()))
            }

            fn visit_i64<E: serde::de::Error>(self, number: i64) -> Result<ColumnName, E> {
                number_from_1(number).map(ColumnName::Number)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

fn number_from_1<E: serde::de::Error>(number: i64) -> Result<usize, E> {
    usize::try_from(number)
        .ok()
        .filter(|number| *number > 0)
        .ok_or_else(|| {
            E::custom(format!(
                "columns are numbered from 1, there is no column {number}"
            ))
        })
}

/// One value for all joints, or one for each.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "one value, or a list with one for each joint")]
pub enum PerJoint<T> {
    /// The same value for all joints.
    One(T),
    /// One value for each joint.
    Each(Vec<T>),
}

impl<T: Clone> PerJoint<T> {
    /// Returns the value of joint `i`, from 0; `None` behind the end of a list.
    #[must_use]
    pub fn get(&self, i: usize) -> Option<T> {
        match self {
            Self::One(value) => Some(value.clone()),
            Self::Each(values) => values.get(i).cloned(),
        }
    }

    /// Returns the length of the list; `None` for one value for all joints.
    #[must_use]
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::One(_) => None,
            Self::Each(values) => Some(values.len()),
        }
    }
}

/// A column or a field of a topic, and the conversion of its readings:
/// `sign · unit · gain · (reading + offset)`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Column {
    /// Another file of the same recording; relative to the experiment file.
    pub file: Option<PathBuf>,
    /// Name or number of the column; a name with `*` or a list stands for all joints.
    pub column: Option<PerJoint<ColumnName>>,
    /// Topic of a bag.
    pub topic: Option<String>,
    /// Field of the topic's messages; `position` or `effort` if absent.
    pub field: Option<PerJoint<String>>,
    /// Names of the joints in the messages; the names in `[robot]` if absent.
    pub joint_names: Option<Vec<String>>,
    /// Column, or field of the messages, with the time of these readings. If absent, the rows of
    /// another file match the rows of the log one by one; the time of a message is its stamp, or
    /// its time of receipt if it has no stamp.
    pub time: Option<ColumnName>,
    /// Unit of the readings.
    pub unit: Option<Unit>,
    /// Side of the gearbox on which the readings were taken.
    pub side: Option<Side>,
    /// Counts of an encoder per turn.
    pub counts_per_turn: Option<PerJoint<f64>>,
    /// 1, or -1 for a reversed direction.
    pub sign: Option<PerJoint<f64>>,
    /// Added to each reading, in the unit of the reading.
    pub offset: Option<PerJoint<f64>>,
    /// Factor of each reading.
    pub gain: Option<PerJoint<f64>>,
    /// Range of a counter that rolls over, in the unit of the reading; sprung unwraps the readings.
    pub wrap: Option<PerJoint<f64>>,
    /// Position at the first sample, rad, or the name of a column that contains it in rad; for
    /// encoders without an absolute zero.
    pub starts_at_rad: Option<PerJoint<StartsAt>>,
}

/// The position at the first sample.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a position in rad, or the name of a column")]
pub enum StartsAt {
    /// Known, rad.
    Position(f64),
    /// The first value of another column, in rad.
    Column(String),
}

impl Column {
    /// Returns a column in the unit of its key.
    #[must_use]
    pub fn named(name: ColumnName) -> Self {
        Self {
            column: Some(PerJoint::One(name)),
            ..Self::default()
        }
    }

    /// Returns the number of columns that it names.
    #[must_use]
    pub(super) fn entries(&self) -> usize {
        let columns = self.column.as_ref().and_then(PerJoint::count);
        let fields = self.field.as_ref().and_then(PerJoint::count);
        columns.or(fields).unwrap_or(1)
    }

    /// Returns whether it may represent several joints: a pattern, a list or a topic.
    #[must_use]
    pub fn spreads(&self) -> bool {
        let pattern = matches!(&self.column, Some(PerJoint::One(name)) if name.is_pattern());
        let listed = matches!(&self.column, Some(PerJoint::Each(_)))
            || matches!(&self.field, Some(PerJoint::Each(_)));
        pattern || listed || self.topic.is_some()
    }
}

/// The columns of a quantity: one per joint, or one entry for all joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns(pub Vec<Column>);

impl Columns {
    /// Returns the entry for all joints; `None` if each joint has an entry.
    #[must_use]
    pub fn spread(&self) -> Option<&Column> {
        match &self.0[..] {
            [one] if one.spreads() => Some(one),
            _ => None,
        }
    }

    /// Returns the entry of a joint, and the joint's place in this entry.
    ///
    /// - `i`: place of the joint among the joints with this quantity, from 0.
    #[must_use]
    pub fn of(&self, i: usize) -> Option<(&Column, usize)> {
        match self.spread() {
            Some(all) => Some((all, i)),
            None => Some((self.0.get(i)?, 0)),
        }
    }

    /// Returns the name of column `i`, for messages and as the key of `sign`, `gain` and `delay_s`.
    ///
    /// - `default_field`: field of the messages of a topic, if the entry has no field.
    #[must_use]
    pub fn label(&self, i: usize, default_field: &str) -> String {
        let Some((column, i)) = self.of(i) else {
            return String::new();
        };
        match &column.topic {
            Some(topic) => {
                let field = column.field.as_ref().and_then(|field| field.get(i));
                format!("{topic}.{}", field.as_deref().unwrap_or(default_field))
            }
            None => (column.column.as_ref())
                .and_then(|name| name.get(i))
                .map_or_else(String::new, |name| name.to_string()),
        }
    }
}

impl Columns {
    /// Returns the names of the column of one joint: its own name, and the name that all columns of
    /// its entry share.
    ///
    /// - `i`: place of the joint among the joints with this quantity; `joint`: its name.
    #[must_use]
    pub fn labels(&self, i: usize, joint: &str, default_field: &str) -> (String, String) {
        let common = self.label(i, default_field);
        let of_joint = self.of(i).and_then(|(column, place)| {
            let in_messages = (column.joint_names.as_ref())
                .and_then(|names| names.get(place))
                .map_or(joint, String::as_str);
            match (&column.topic, &column.column) {
                (Some(_), _) => {
                    let field = column.field.as_ref().and_then(|field| field.get(place));
                    let whole = field.is_some_and(|field| field.contains('['));
                    (!whole).then(|| in_messages.to_owned())
                }
                (None, name) => {
                    let pattern = name.as_ref()?.get(place)?.is_pattern();
                    (self.spread().is_some() && pattern).then(|| joint.to_owned())
                }
            }
        });
        let label = of_joint.map_or_else(|| common.clone(), |name| format!("{common}[{name}]"));
        (label, common)
    }
}

impl<'de> Deserialize<'de> for Columns {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = Columns;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of columns, one per joint, or one entry for all of them")
            }

            fn visit_str<E>(self, name: &str) -> Result<Columns, E> {
                Ok(Columns(vec![Column::named(ColumnName::Name(
                    name.to_owned(),
                ))]))
            }

            fn visit_i64<E: serde::de::Error>(self, number: i64) -> Result<Columns, E> {
                let number = number_from_1(number)?;
                Ok(Columns(vec![Column::named(ColumnName::Number(number))]))
            }

            fn visit_map<A: serde::de::MapAccess<'de>>(self, map: A) -> Result<Columns, A::Error> {
                Column::deserialize(MapAccessDeserializer::new(map)).map(|one| Columns(vec![one]))
            }

            fn visit_seq<A: serde::de::SeqAccess<'de>>(
                self,
                mut list: A,
            ) -> Result<Columns, A::Error> {
                let mut all = Vec::new();
                while let Some(Columns(one)) = list.next_element()? {
                    if one.len() != 1 {
                        return Err(serde::de::Error::custom("a list of columns within another"));
                    }
                    all.extend(one);
                }
                Ok(Columns(all))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "describes the schema of one column")]
enum OneColumn {
    Name(ColumnName),
    Table(Box<Column>),
}

#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "describes the schema of columns")]
enum OneOrManyColumns {
    One(OneColumn),
    Many(Vec<OneColumn>),
}

impl JsonSchema for Columns {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Columns".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        OneOrManyColumns::json_schema(generator)
    }
}
