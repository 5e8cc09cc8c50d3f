//! Words of a column's name, and their meaning.

use crate::description::Unit;

/// A word or a number of a name.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Token {
    /// Lower-case letters.
    Word(String),
    Number(u64),
}

/// Contents of a column, by the words of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sort {
    Time,
    Position,
    Deflection,
    Velocity,
    Torque,
    /// Torque of a sensor between gear and link.
    JointTorque,
    Current,
    Voltage,
    /// A quantity that identification does not use.
    Other,
}

/// Meaning of the words of a name.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Meaning {
    pub(super) sort: Option<Sort>,
    /// Evidence that it belongs to the motor: 2 by a word such as `motor`, 1 by a usual letter.
    pub(super) motor: u8,
    /// How clearly it belongs to the link.
    pub(super) link: u8,
    /// Whether it is commanded, computed or filtered, and not measured.
    pub(super) is_reference: bool,
    /// Whether it is computed from other quantities and no command, such as an external torque.
    pub(super) is_computed: bool,
    /// Whether it is only called u, the input of a controlled system: a torque, a current or a voltage.
    pub(super) is_input: bool,
    /// Its unit, if the name has one; with the word of the name.
    pub(super) unit: Option<&'static str>,
}

const TIME: &[&str] = &[
    "t",
    "time",
    "timestamp",
    "stamp",
    "ts",
    "clock",
    "zeit",
    "secs",
    "sec",
    "nsec",
    "zeitstempel",
    "temps",
    "tiempo",
    "tempo",
    "时间",
    "时间戳",
];
const POSITION: &[&str] = &[
    "q",
    "pos",
    "position",
    "positions",
    "angle",
    "angles",
    "ang",
    "theta",
    "th",
    "phi",
    "enc",
    "encoder",
    "count",
    "counts",
    "ticks",
    "qm",
    "ql",
    "jointangle",
    "winkel",
    "resolver",
    "lage",
    "stellung",
    "geber",
    "gelenkwinkel",
    "drehwinkel",
    "codeur",
    "posicion",
    "angulo",
    "posizione",
    "angolo",
    "位置",
    "角度",
    "编码器",
    "转角",
];
const VELOCITY: &[&str] = &[
    "vel",
    "velocity",
    "velocities",
    "speed",
    "speeds",
    "omega",
    "rate",
    "dq",
    "qd",
    "qdot",
    "dphi",
    "dtheta",
    "dot",
    "rpm",
    "velo",
    "geschwindigkeit",
    "drehzahl",
    "vitesse",
    "velocidad",
    "velocita",
    "速度",
    "转速",
];
const TORQUE: &[&str] = &[
    "tau",
    "torque",
    "torques",
    "effort",
    "efforts",
    "trq",
    "tq",
    "moment",
    "moments",
    "force",
    "forces",
    "frc",
    "drehmoment",
    "kraft",
    "couple",
    "par",
    "fuerza",
    "coppia",
    "forza",
    "力矩",
    "扭矩",
    "转矩",
];
const CURRENT: &[&str] = &[
    "i",
    "cur",
    "curr",
    "current",
    "currents",
    "amp",
    "amps",
    "iq",
    "ampere",
    "strom",
    "courant",
    "corriente",
    "corrente",
    "电流",
];
const VOLTAGE: &[&str] = &[
    "u", "volt", "volts", "voltage", "voltages", "spannung", "tension", "voltaje", "tensione",
    "电压",
];
const DEFLECTION: &[&str] = &["defl", "deflection", "deflections", "torsion", "windup"];
const OTHER: &[&str] = &[
    "temp",
    "temperature",
    "temperatures",
    "status",
    "mode",
    "error",
    "err",
    "flag",
    "flags",
    "fault",
    "warning",
    "seq",
    "sequence",
    "idx",
    "id",
    "index",
    "frame",
    "iteration",
    "sample",
    "cycle",
    "pwm",
    "duty",
    "power",
    "energy",
    "acc",
    "accel",
    "acceleration",
    "accelerations",
    "ddq",
    "qdd",
    "jerk",
    "imu",
    "gyro",
    "tcp",
    "load%",
    "humidity",
    "pressure",
    "stiffness",
    "damping",
    "gain",
    "temperatur",
    "fehler",
    "beschleunigung",
    "acceleracion",
    "aceleracion",
    "accelerazione",
    "温度",
    "加速度",
    "状态",
];
const REFERENCE: &[&str] = &[
    "ref",
    "reference",
    "references",
    "cmd",
    "cmptd",
    "cmpt",
    "computed",
    "command",
    "commands",
    "commanded",
    "des",
    "desired",
    "target",
    "targets",
    "goal",
    "set",
    "setpoint",
    "setpoints",
    "planned",
    "sp",
    "ff",
    "soll",
    "ext",
    "external",
    "contact",
    "grav",
    "gravity",
    "coriolis",
    "model",
    "est",
    "estimate",
    "estimated",
    "filt",
    "filtered",
    "d",
    "residual",
    "limit",
    "sollwert",
    "vorgabe",
    "consigne",
    "commande",
    "consigna",
    "referencia",
    "riferimento",
    "comando",
    "指令",
    "目标",
    "期望",
    "参考",
    "给定",
];
/// Words of [`REFERENCE`] for quantities that are computed and that no motor follows.
const COMPUTED: &[&str] = &[
    "ext", "external", "contact", "grav", "gravity", "coriolis", "residual", "limit",
];
const MOTOR: &[&str] = &[
    "motor",
    "motors",
    "mot",
    "rotor",
    "rotors",
    "drive",
    "drives",
    "m",
    "qm",
    "servo",
    "actuator",
    "actuators",
    "thetam",
    "antrieb",
    "moteur",
    "motore",
    "电机",
    "马达",
    "电动机",
];
const USUALLY_MOTOR: &[&str] = &["phi", "theta", "th"];
const LINK: &[&str] = &[
    "link",
    "links",
    "load",
    "out",
    "output",
    "ql",
    "l",
    "secondary",
    "absolute",
    "abs",
    "arm",
    "abtrieb",
    "abtriebs",
    "sortie",
    "bras",
    "salida",
    "brazo",
    "uscita",
    "braccio",
    "关节",
    "连杆",
    "负载",
    "输出",
];
const USUALLY_LINK: &[&str] = &["q"];

/// Words of units and the names that `experiment.toml` has for them.
const UNITS: &[(&str, &str)] = &[
    ("rad", "rad"),
    ("radian", "rad"),
    ("radians", "rad"),
    ("mrad", "mrad"),
    ("deg", "deg"),
    ("degs", "deg"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("grad", "deg"),
    ("turn", "turns"),
    ("turns", "turns"),
    ("rev", "turns"),
    ("revs", "turns"),
    ("rot", "turns"),
    ("count", "counts"),
    ("counts", "counts"),
    ("cnt", "counts"),
    ("cnts", "counts"),
    ("tick", "counts"),
    ("ticks", "counts"),
    ("inc", "counts"),
    ("incr", "counts"),
    ("incs", "counts"),
    ("pulses", "counts"),
    ("lsb", "counts"),
    ("raw", "counts"),
    ("m", "m"),
    ("mm", "mm"),
    ("um", "um"),
    ("nm", "N·m"),
    ("mnm", "mN·m"),
    ("n", "N"),
    ("kn", "kN"),
    ("a", "A"),
    ("amp", "A"),
    ("amps", "A"),
    ("ma", "mA"),
    ("v", "V"),
    ("mv", "mV"),
    ("s", "s"),
    ("sec", "s"),
    ("secs", "s"),
    ("seconds", "s"),
    ("ms", "ms"),
    ("msec", "ms"),
    ("us", "us"),
    ("usec", "us"),
    ("ns", "ns"),
    ("nsec", "ns"),
    ("min", "min"),
];

/// Splits a name at signs, between letters and digits, and before capitals after small letters.
pub(super) fn tokens(name: &str) -> Vec<Token> {
    let mut all = Vec::new();
    let mut word = String::new();
    let mut end = |word: &mut String| {
        if word.is_empty() {
            return;
        }
        let lower = without_accents(&word.to_lowercase());
        word.clear();
        all.push(match lower.parse() {
            Ok(number) => Token::Number(number),
            Err(_) => Token::Word(lower),
        });
    };
    let mut before = ' ';
    for (place, c) in name.char_indices() {
        let is_unit = || matches!(&*word, "m" | "k") && begins_with_unit(&name[place..]);
        let is_split = c.is_ascii_digit() != before.is_ascii_digit()
            || (c.is_uppercase() && before.is_lowercase() && !is_unit());
        if is_split || !c.is_alphanumeric() {
            end(&mut word);
        }
        match c {
            '°' => {
                word.push_str("deg");
                end(&mut word);
            }
            '%' => word.push(c),
            _ if c.is_alphanumeric() => word.push(c),
            _ => {}
        }
        before = c;
    }
    end(&mut word);
    all
}

/// Returns whether a unit with a prefix goes on: "A" in "mA", and not in "mAngle".
fn begins_with_unit(rest: &str) -> bool {
    let end = rest.find(|c: char| !c.is_alphanumeric());
    ["A", "V", "N", "Nm"].contains(&&rest[..end.unwrap_or(rest.len())])
}

/// Returns the words of a name, without numbers.
pub(super) fn words(tokens: &[Token]) -> Vec<&str> {
    (tokens.iter())
        .filter_map(|token| match token {
            Token::Word(word) => Some(word.as_str()),
            Token::Number(_) => None,
        })
        .collect()
}

impl Meaning {
    /// Returns the meaning of the words of a column's name.
    ///
    /// - `name`: tokens of the name without those of the joint; `topic`: words of the topic.
    pub(super) fn of(name: &[Token], topic: &[&str]) -> Self {
        let parts: Vec<&str> = words(name).into_iter().flat_map(parts).collect();
        let (rest, unit) = unit(&parts);
        let is = |list: &[&str], words: &[&str]| words.iter().any(|word| list.contains(word));
        let rate = rest.len() < parts.len() && unit.is_none();
        let sort = sort_of(&rest, rate).or_else(|| unit.and_then(sort_of_unit));
        let torque = matches!(sort, Some(Sort::Torque | Sort::Current | Sort::Voltage));
        let both = [&rest[..], topic].concat();
        let side = |clear: &[&str], usual: &[&str]| {
            if is(clear, &both) {
                2
            } else {
                u8::from(is(usual, &rest))
            }
        };
        Self {
            sort,
            motor: side(MOTOR, USUALLY_MOTOR),
            link: side(LINK, USUALLY_LINK),
            is_reference: is(REFERENCE, &both) || both.iter().any(|word| begins_command(word)),
            is_computed: is(COMPUTED, &both),
            is_input: sort == Some(Sort::Voltage) && unit.is_none() && !is(&VOLTAGE[1..], &rest),
            unit: unit.filter(|unit| fits(unit, sort, torque)),
        }
    }
}

/// Beginnings of words for commands, which recorders shorten in many ways: `cmded`, `commandedPos`.
const COMMANDS: [&str; 8] = [
    "cmd", "comman", "desir", "refer", "setp", "targ", "demand", "interpol",
];

fn begins_command(word: &str) -> bool {
    COMMANDS.iter().any(|begin| word.starts_with(begin))
}

/// Lists of words of all quantities and sides.
const LISTS: [&[&str]; 11] = [
    OTHER, DEFLECTION, VELOCITY, TORQUE, CURRENT, VOLTAGE, POSITION, TIME, REFERENCE, MOTOR, LINK,
];

/// Shortest known word of Latin letters that is looked for within another: a shorter one is there by chance.
const LEAST_PART: usize = 4;

/// Splits a compound such as `Motorposition` or `电机位置` into known words; another word remains as it is.
fn parts(word: &str) -> Vec<&str> {
    let known = || LISTS.iter().flat_map(|list| list.iter().copied());
    if known().any(|part| part == word) {
        return vec![word];
    }
    if !word.is_ascii() {
        // The longest word at each place, from the left.
        let mut found = Vec::new();
        let mut rest = word;
        while let Some(first) = rest.chars().next() {
            let begins = known().filter(|part| !part.is_ascii() && rest.starts_with(part));
            let longest = begins.max_by_key(|part| part.len());
            let length = longest.map_or(first.len_utf8(), str::len);
            found.extend(longest);
            rest = &rest[length..];
        }
        return if found.is_empty() { vec![word] } else { found };
    }
    let is_part = |part: &&str| part.len() >= LEAST_PART && part.is_ascii();
    let first = (known()
        .filter(is_part)
        .filter(|part| word.starts_with(part)))
    .max_by_key(|part| part.len());
    let last =
        (known().filter(is_part).filter(|part| word.ends_with(part))).max_by_key(|part| part.len());
    match (first, last) {
        (Some(first), Some(last)) if first.len() + last.len() <= word.len() => vec![first, last],
        // A time is named alone: "timeout" is none.
        (_, Some(last)) if !TIME.contains(&last) => vec![last],
        _ => vec![word],
    }
}

/// Letters without their accents.
const PLAIN: [(char, &str); 20] = [
    ('á', "a"),
    ('à', "a"),
    ('â', "a"),
    ('ã', "a"),
    ('é', "e"),
    ('è', "e"),
    ('ê', "e"),
    ('ë', "e"),
    ('í', "i"),
    ('ì', "i"),
    ('î', "i"),
    ('ó', "o"),
    ('ò', "o"),
    ('ô', "o"),
    ('õ', "o"),
    ('ú', "u"),
    ('ù', "u"),
    ('û', "u"),
    ('ñ', "n"),
    ('ç', "c"),
];

fn without_accents(word: &str) -> String {
    let plain = |c: char| PLAIN.iter().find(|(accented, _)| *accented == c);
    (word.chars())
        .map(|c| plain(c).map_or_else(|| c.to_string(), |(_, plain)| (*plain).to_owned()))
        .collect()
}

/// Separates the unit at the end of a name. A unit per time is removed as well, without unit.
fn unit<'a>(words: &[&'a str]) -> (Vec<&'a str>, Option<&'static str>) {
    let known = |word: &str| {
        UNITS
            .iter()
            .find(|(known, _)| *known == word)
            .map(|(_, unit)| *unit)
    };
    let without = |count: usize| words[..words.len() - count].to_vec();
    match words {
        [.., "n", "m"] => (without(2), Some("N·m")),
        [.., "mn", "m"] => (without(2), Some("mN·m")),
        [.., length, "per", "s" | "sec" | "min"] if known(length).is_some() => (without(3), None),
        [.., length, "s" | "sec" | "min"] if known(length).is_some() => (without(2), None),
        [.., "rads" | "degs" | "rpm"] => (words.to_vec(), None),
        [.., last] => match known(last) {
            Some(unit) => (without(1), Some(unit)),
            None => (words.to_vec(), None),
        },
        [] => (Vec::new(), None),
    }
}

/// - `rate`: whether the unit is one per time.
fn sort_of(rest: &[&str], rate: bool) -> Option<Sort> {
    let is = |list: &[&str]| rest.iter().any(|word| list.contains(word));
    let found = [
        (OTHER, Sort::Other),
        (DEFLECTION, Sort::Deflection),
        (VELOCITY, Sort::Velocity),
        (TORQUE, Sort::Torque),
        (CURRENT, Sort::Current),
        (VOLTAGE, Sort::Voltage),
        (POSITION, Sort::Position),
        (TIME, Sort::Time),
    ]
    .into_iter()
    .find(|(list, _)| is(list))
    .map(|(_, sort)| sort);
    match found {
        None | Some(Sort::Position) if rate => Some(Sort::Velocity),
        // A lone v or w is a velocity.
        None if matches!(rest, ["v" | "w"]) => Some(Sort::Velocity),
        found => found,
    }
}

fn sort_of_unit(unit: &'static str) -> Option<Sort> {
    Some(match unit {
        "rad" | "mrad" | "deg" | "turns" | "counts" | "mm" | "um" => Sort::Position,
        "N·m" | "mN·m" | "N" | "kN" => Sort::Torque,
        "A" | "mA" => Sort::Current,
        "V" | "mV" => Sort::Voltage,
        "s" | "ms" | "us" | "ns" => Sort::Time,
        _ => return None,
    })
}

/// Returns whether a unit is one of a quantity.
fn fits(unit: &&'static str, sort: Option<Sort>, torque: bool) -> bool {
    use crate::description::Dimension::{Angle, Current, Force, Length, Time, Torque, Voltage};
    let Ok(unit) = Unit::try_from((*unit).to_owned()) else {
        return false;
    };
    match (unit.dimension(), sort) {
        (Angle | Length, Some(Sort::Position | Sort::Deflection))
        | (Current, Some(Sort::Current))
        | (Voltage, Some(Sort::Voltage))
        | (Time, Some(Sort::Time))
        | (Torque | Force, Some(Sort::JointTorque)) => true,
        (Torque | Force, Some(Sort::Torque)) => torque,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meaning(name: &str) -> Meaning {
        Meaning::of(&tokens(name), &[])
    }

    #[test]
    fn names_of_usual_recorders_are_understood() {
        use Sort::{Current, Other, Position, Time, Torque, Velocity};
        for (name, sort, unit) in [
            ("t_s", Some(Time), Some("s")),
            ("timestamp", Some(Time), None),
            ("time [ms]", Some(Time), Some("ms")),
            ("q1_rad", Some(Position), Some("rad")),
            ("actual_q_0", Some(Position), None),
            ("actual_qd_0", Some(Velocity), None),
            ("actual_current_0", Some(Current), None),
            ("joint_1_temperature", Some(Other), None),
            ("tau_J_0", Some(Torque), None),
            ("axis3 torque (N·m)", Some(Torque), Some("N·m")),
            ("motor2_counts", Some(Position), Some("counts")),
            ("motorPos1", Some(Position), None),
            ("J1_vel_deg_s", Some(Velocity), None),
            ("axis1_deg_per_s", Some(Velocity), None),
            ("axis2_deg", Some(Position), Some("deg")),
            ("j4_A", Some(Current), Some("A")),
            ("elbow_pos_°", Some(Position), Some("deg")),
            ("weather", None, None),
            ("Zeit", Some(Time), None),
            ("Istposition Achse 3 [Grad]", Some(Position), Some("deg")),
            ("Motordrehmoment_2 [Nm]", Some(Torque), Some("N·m")),
            ("Drehzahl_1", Some(Velocity), None),
            ("courant moteur 2 (A)", Some(Current), Some("A")),
            ("couple_1", Some(Torque), None),
            ("posición_articulación_1 [°]", Some(Position), Some("deg")),
            ("par 3", Some(Torque), None),
            ("corrente_motore_2_mA", Some(Current), Some("mA")),
            ("angolo giunto 1 deg", Some(Position), Some("deg")),
            ("velocità_1", Some(Velocity), None),
            ("时间", Some(Time), None),
            ("电机位置1", Some(Position), None),
            ("关节1力矩", Some(Torque), None),
            ("电机电流2_A", Some(Current), Some("A")),
            ("i1_mA", Some(Current), Some("mA")),
            ("tau_m1_mNm", Some(Torque), Some("mN·m")),
            ("tau1 [mN·m]", Some(Torque), Some("mN·m")),
            ("mAngle1", Some(Position), None),
            ("timeout", None, None),
            ("positionerror_1", Some(Other), None),
        ] {
            let found = meaning(name);
            assert_eq!((found.sort, found.unit), (sort, unit), "{name}");
        }
    }

    #[test]
    fn sides_and_commands_are_understood() {
        for (name, motor, link, is_reference) in [
            ("motor_pos_1", 2, 0, false),
            ("phi1", 1, 0, false),
            ("q1", 0, 1, false),
            ("link_q_1", 0, 2, false),
            ("q_d_1", 0, 1, true),
            ("target_q_0", 0, 1, true),
            ("tau_ext_2", 0, 0, true),
            ("Motorposition1", 2, 0, false),
            ("Abtriebsposition1", 0, 2, false),
            ("Sollposition_1", 0, 0, true),
            ("position moteur 1", 2, 0, false),
            ("posizione uscita 1", 0, 2, false),
            ("电机位置1", 2, 0, false),
            ("关节位置1", 0, 2, false),
            ("目标位置1", 0, 0, true),
        ] {
            let found = meaning(name);
            let sides = (found.motor, found.link, found.is_reference);
            assert_eq!(sides, (motor, link, is_reference), "{name}");
        }
        let of_topic = Meaning::of(&tokens("position"), &["motor", "states"]);
        assert_eq!((of_topic.motor, of_topic.sort), (2, Some(Sort::Position)));
    }
}
