//! Records of MCAP and messages of ROS 2, byte by byte. The corpus of faulty files of the command line uses them too.

pub(crate) const JOINT_STATE: &str = "std_msgs/Header header\nstring[] name\nfloat64[] position\n\
                           float64[] velocity\nfloat64[] effort\n";

pub(crate) fn text(text: &str) -> Vec<u8> {
    let length = u32::try_from(text.len()).unwrap();
    [&length.to_le_bytes()[..], text.as_bytes()].concat()
}

/// A record of MCAP.
pub(crate) fn record(kind: u8, parts: &[&[u8]]) -> Vec<u8> {
    let body = parts.concat();
    [&[kind][..], &(body.len() as u64).to_le_bytes(), &body].concat()
}

/// A file with one topic of a type and its messages: time, data.
pub(crate) fn bag(kind: &str, encoding: &str, messages: &[(u64, Vec<u8>)]) -> Vec<u8> {
    let mut records = topic(kind, JOINT_STATE, encoding);
    for (time, data) in messages {
        records.extend(message(*time, data));
    }
    file_of(&records)
}

/// A topic "/states" and its type.
pub(crate) fn topic(kind: &str, definition: &str, encoding: &str) -> Vec<u8> {
    let one = 1_u16.to_le_bytes();
    let schema = [&one[..], &text(kind), &text("ros2msg"), &text(definition)];
    let channel = [&one[..], &one, &text("/states"), &text(encoding), &[0; 4]];
    [record(3, &schema), record(4, &channel)].concat()
}

/// A message on that topic.
pub(crate) fn message(time: u64, data: &[u8]) -> Vec<u8> {
    let (one, time) = (1_u16.to_le_bytes(), time.to_le_bytes());
    record(5, &[&one, &[0; 4], &time, &time, data])
}

/// A file of these records.
pub(crate) fn file_of(records: &[u8]) -> Vec<u8> {
    [
        &b"\x89MCAP0\r\n"[..],
        &record(1, &[&[0; 8]]),
        records,
        &record(15, &[&[0; 4]]),
        &record(2, &[&[0; 20]]),
        b"\x89MCAP0\r\n",
    ]
    .concat()
}

/// A message in CDR.
#[derive(Default)]
pub(crate) struct Cdr(pub(crate) Vec<u8>);

impl Cdr {
    pub(crate) fn pad(&mut self, size: usize) {
        self.0.resize(self.0.len().next_multiple_of(size), 0);
    }

    pub(crate) fn word(&mut self, word: u32) {
        self.pad(4);
        self.0.extend(word.to_le_bytes());
    }

    pub(crate) fn text(&mut self, text: &str) {
        self.word(u32::try_from(text.len() + 1).unwrap());
        self.0.extend(text.bytes().chain([0]));
    }

    pub(crate) fn numbers(&mut self, numbers: &[f64]) {
        self.word(u32::try_from(numbers.len()).unwrap());
        for number in numbers {
            self.pad(8);
            self.0.extend(number.to_le_bytes());
        }
    }
}

pub(crate) fn joint_state(
    nanoseconds: u32,
    names: &[&str],
    position: &[f64],
    effort: &[f64],
) -> Vec<u8> {
    let mut cdr = Cdr::default();
    cdr.word(0);
    cdr.word(nanoseconds);
    cdr.text("base");
    cdr.word(u32::try_from(names.len()).unwrap());
    for name in names {
        cdr.text(name);
    }
    cdr.numbers(position);
    cdr.numbers(&[]);
    cdr.numbers(effort);
    [&[0, 1, 0, 0][..], &cdr.0].concat()
}
