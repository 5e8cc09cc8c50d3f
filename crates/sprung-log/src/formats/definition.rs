//! Definitions of ROS 2 messages, as text (`.msg`).

use super::number::Number;
use crate::columns::names::listed;

/// Type of a field, or of the elements of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Base {
    Number(Number),
    Text,
    WideText,
    /// A message, by its index in [`Definition::types`].
    Message(usize),
}

/// Number of values of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Count {
    One,
    /// An array of fixed length.
    Fixed(usize),
    /// A sequence, bounded or not; each message contains its length.
    Any,
}

/// A field of a message.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) base: Base,
    pub(super) count: Count,
}

/// A message type and the types that it contains.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Definition {
    /// Fields of each type. The first type is that of the message.
    pub(super) types: Vec<Vec<Field>>,
}

/// Largest accepted depth of nested messages.
const MAX_NESTING: usize = 24;

/// Largest number of fields in the list that an error shows.
const MAX_LISTED_NUMBERS: usize = 1000;

/// Largest number of fields that the search for this list visits.
const MAX_VISITED_FIELDS: usize = 100 * MAX_LISTED_NUMBERS;

/// Definitions of common message types: bags from before ROS 2 Iron contain no definitions.
#[cfg(any(feature = "db3", test))]
const KNOWN: [(&str, &str); 6] = [
    (
        "sensor_msgs/msg/JointState",
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n",
    ),
    ("std_msgs/msg/Float64", "float64 data\n"),
    ("std_msgs/msg/Float32", "float32 data\n"),
    (
        "std_msgs/msg/Float64MultiArray",
        "std_msgs/MultiArrayLayout layout\nfloat64[] data\n",
    ),
    (
        "std_msgs/msg/Float32MultiArray",
        "std_msgs/MultiArrayLayout layout\nfloat32[] data\n",
    ),
    (
        "geometry_msgs/msg/WrenchStamped",
        "std_msgs/Header header\ngeometry_msgs/Wrench wrench\n",
    ),
];

/// Definitions of the message types that common types contain.
const INNER: &str = "
===
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
===
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
===
MSG: builtin_interfaces/Duration
int32 sec
uint32 nanosec
===
MSG: std_msgs/MultiArrayLayout
std_msgs/MultiArrayDimension[] dim
uint32 data_offset
===
MSG: std_msgs/MultiArrayDimension
string label
uint32 size
uint32 stride
===
MSG: geometry_msgs/Wrench
geometry_msgs/Vector3 force
geometry_msgs/Vector3 torque
===
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
";

impl Definition {
    /// Returns the built-in definition of a common message type.
    #[cfg(any(feature = "db3", test))]
    pub(super) fn known(kind: &str) -> Option<Self> {
        let (_, text) = KNOWN.iter().find(|(known, _)| *known == kind)?;
        Self::parse(kind, text).ok()
    }

    /// Parses the text of a definition, which also contains the definitions of nested types.
    ///
    /// # Errors
    ///
    /// The end of a sentence that begins with the name of the type.
    pub(super) fn parse(kind: &str, text: &str) -> Result<Self, String> {
        let mut sections: Vec<(String, String)> = vec![(short(kind), String::new())];
        let whole = format!("{text}\n{INNER}");
        for line in whole.lines() {
            if let Some(name) = line.strip_prefix("MSG:") {
                sections.push((short(name.trim()), String::new()));
            } else if !line.starts_with("===")
                && let Some((_, body)) = sections.last_mut()
            {
                body.push_str(line);
                body.push('\n');
            }
        }
        let names: Vec<String> = sections.iter().map(|(name, _)| name.clone()).collect();
        let types = (sections.iter())
            .map(|(name, body)| {
                let package = name.split('/').next().unwrap_or_default();
                let fields = body
                    .lines()
                    .filter_map(|line| field(line, package, &names).transpose());
                fields.collect::<Result<Vec<Field>, String>>()
            })
            .collect::<Result<Vec<_>, String>>()?;
        let definition = Self { types };
        let mut depths = vec![None; definition.types.len()];
        if definition.depth(0, 0, &mut depths) > MAX_NESTING {
            return Err("contains itself".to_owned());
        }
        // A message of no bytes could be repeated any number of times in a short file.
        let mut sizes = vec![None; definition.types.len()];
        if definition.least(0, &mut sizes) == 0 || sizes.contains(&Some(0)) {
            return Err("contains a message of no size".to_owned());
        }
        Ok(definition)
    }

    /// Returns the smallest size of a message, in bytes. The definition must not contain itself.
    ///
    /// - `known`: sizes of the types that were computed before, [types].
    fn least(&self, kind: usize, known: &mut [Option<usize>]) -> usize {
        if let Some(size) = known[kind] {
            return size;
        }
        let mut size = 0_usize;
        for field in &self.types[kind] {
            let one = match field.base {
                Base::Number(number) => number.size(),
                // The length of an empty text.
                Base::Text | Base::WideText => 4,
                Base::Message(inner) => self.least(inner, known),
            };
            size = size.saturating_add(match field.count {
                Count::One => one,
                Count::Fixed(count) => one.saturating_mul(count),
                Count::Any => 4,
            });
        }
        if self.types[kind].is_empty() {
            size = 1;
        }
        known[kind] = Some(size);
        size
    }

    /// Returns the depth of nested messages below a type.
    ///
    /// - `above`: number of messages around it.
    /// - `known`: depths of the types that were computed before, [types].
    fn depth(&self, kind: usize, above: usize, known: &mut [Option<usize>]) -> usize {
        if above > MAX_NESTING {
            return above;
        }
        if let Some(depth) = known[kind] {
            return depth;
        }
        let mut deepest = 0;
        for field in &self.types[kind] {
            if let Base::Message(inner) = field.base {
                deepest = deepest.max(1 + self.depth(inner, above + 1, known));
            }
        }
        known[kind] = Some(deepest);
        deepest
    }

    /// Returns whether a type has the fields of `builtin_interfaces/Time`.
    pub(super) fn is_time(&self, kind: usize) -> bool {
        let names: Vec<&str> = self.types[kind]
            .iter()
            .map(|field| field.name.as_str())
            .collect();
        names == ["sec", "nanosec"]
    }

    pub(super) fn field(&self, kind: usize, name: &str) -> Option<&Field> {
        self.types[kind].iter().find(|field| field.name == name)
    }

    /// Lists the paths of all numeric fields, at most [`MAX_LISTED_NUMBERS`].
    pub(super) fn leaves(&self) -> Vec<String> {
        let mut all = Vec::new();
        self.list(0, "", &mut all, &mut 0);
        all
    }

    /// - `seen`: number of fields that were visited.
    fn list(&self, kind: usize, path: &str, all: &mut Vec<String>, seen: &mut usize) {
        for field in &self.types[kind] {
            *seen += 1;
            if all.len() >= MAX_LISTED_NUMBERS || *seen > MAX_VISITED_FIELDS {
                return;
            }
            let name = format!("{path}{}", field.name);
            let name = match field.count {
                Count::One => name,
                _ if matches!(field.base, Base::Number(_)) => name,
                _ => format!("{name}[0]"),
            };
            match field.base {
                Base::Number(_) => all.push(name),
                Base::Message(inner) if self.is_time(inner) => all.push(name),
                Base::Message(inner) => self.list(inner, &format!("{name}."), all, seen),
                Base::Text | Base::WideText => {}
            }
        }
    }
}

/// Removes `/msg` from the name of a type.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// Parses a line; returns `None` for constants, comments and blank lines.
///
/// - `package`: package of the type that contains the field.
/// - `names`: names of all types of the definition.
fn field(line: &str, package: &str, names: &[String]) -> Result<Option<Field>, String> {
    let code = line.split('#').next().unwrap_or_default().trim();
    let Some((kind, rest)) = code.split_once(char::is_whitespace) else {
        return Ok(None);
    };
    let name = rest.split_whitespace().next().unwrap_or_default();
    let behind = rest.trim_start().strip_prefix(name).unwrap_or_default();
    // A constant has "=" after its name, a default value has a blank.
    if name.contains('=') || behind.trim_start().starts_with('=') {
        return Ok(None);
    }
    let (element, count) = match kind
        .strip_suffix(']')
        .and_then(|kind| kind.rsplit_once('['))
    {
        None => (kind, Count::One),
        Some((element, size)) => match size.parse() {
            Ok(size) => (element, Count::Fixed(size)),
            Err(_) => (element, Count::Any),
        },
    };
    let bounded = element.split("<=").next().unwrap_or_default();
    let base = match bounded {
        "float64" => Base::Number(Number::F64),
        "float32" => Base::Number(Number::F32),
        "int8" => Base::Number(Number::I8),
        "int16" => Base::Number(Number::I16),
        "int32" => Base::Number(Number::I32),
        "int64" => Base::Number(Number::I64),
        "uint8" | "byte" | "char" | "bool" => Base::Number(Number::U8),
        "uint16" => Base::Number(Number::U16),
        "uint32" => Base::Number(Number::U32),
        "uint64" => Base::Number(Number::U64),
        "string" => Base::Text,
        "wstring" => Base::WideText,
        other => {
            let full = if other == "Header" {
                "std_msgs/Header".to_owned()
            } else if other.contains('/') {
                short(other)
            } else {
                format!("{package}/{other}")
            };
            let place = names
                .iter()
                .position(|known| *known == full)
                .ok_or_else(|| {
                    let known: Vec<&str> = names.iter().map(String::as_str).collect();
                    format!(
                        "names {full}, which it does not define; it defines {}",
                        listed(&known)
                    )
                })?;
            Base::Message(place)
        }
    };
    Ok(Some(Field {
        name: name.to_owned(),
        base,
        count,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_fields_constants_or_comments() {
        let text = "# a comment\nuint8 IDLE=0\nuint8 BUSY = 1\nstring<=20 label \"none\"\n\
                    float64[3] force # N\nfloat32[<=4] spare\nMotor[] motors\nbool ok true\n\
                    ===\nMSG: my_robot/Motor\nint16 temperature\n";
        let definition = Definition::parse("my_robot/msg/State", text).unwrap();
        let names: Vec<&str> = definition.types[0]
            .iter()
            .map(|f| f.name.as_str())
            .collect();
        assert_eq!(names, ["label", "force", "spare", "motors", "ok"]);
        assert_eq!(definition.types[0][1].count, Count::Fixed(3));
        assert_eq!(definition.types[0][2].count, Count::Any);
        assert_eq!(definition.types[0][3].base, Base::Message(1));
        assert_eq!(
            definition.leaves(),
            ["force", "spare", "motors[0].temperature", "ok"]
        );
    }

    #[test]
    fn messages_that_contain_themselves_or_strangers_are_refused() {
        let error = Definition::parse("a/msg/B", "a/B[] inner\n").unwrap_err();
        assert_eq!(error, "contains itself");
        let error = Definition::parse("a/msg/B", "c/D inner\n").unwrap_err();
        assert!(
            error.starts_with("names c/D, which it does not define"),
            "{error}"
        );
        // 2^23 fields of zero bytes each, and 2^23 texts.
        let wide = |last: &str| {
            let inner: Vec<String> = (0..23)
                .map(|k| format!("a/P{k} x\na/P{k} y\n===\nMSG: a/P{k}\n"))
                .collect();
            Definition::parse("a/msg/B", &format!("{}{last}\n", inner.concat()))
        };
        assert_eq!(
            wide("float64[0] x").unwrap_err(),
            "contains a message of no size"
        );
        let texts = wide("string x").unwrap();
        assert!(texts.leaves().is_empty());
        for (kind, _) in KNOWN {
            assert!(Definition::known(kind).is_some(), "{kind}");
        }
    }
}
