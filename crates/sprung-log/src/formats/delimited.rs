//! The form of a text of numbers: delimiter, decimal character, header, comments.

use crate::description::CsvForm;

/// Lines of data that determine the form.
const SAMPLED_LINES: usize = 50;

/// Most bytes of a unit below the name of a column.
const UNIT_BYTES: usize = 24;

/// Separator of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Delimiter {
    /// One byte.
    Byte(u8),
    /// Any number of blanks and tabs.
    Blanks,
}

/// Form of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Form {
    pub(super) delimiter: Delimiter,
    pub(super) decimal_comma: bool,
    pub(super) header: bool,
    pub(super) comment: u8,
    /// Names of the columns, if the last comment before the data contains them.
    pub(super) commented_names: Option<Vec<String>>,
    /// Units of the columns, if the second line has only texts; empty otherwise.
    pub(super) units: Vec<String>,
}

impl Form {
    /// Determines the form of a text.
    ///
    /// - `start`: the beginning of the text, in complete lines.
    /// - `said`: parts of the form that the experiment gives.
    pub(super) fn of(start: &str, said: &CsvForm) -> Self {
        let lines: Vec<&str> = start.lines().collect();
        let comment = said
            .comment
            .as_ref()
            .and_then(|text| text.bytes().next())
            .unwrap_or_else(|| comment_of(&lines));
        let is_comment = |line: &str| line.as_bytes().first() == Some(&comment);
        let data: Vec<&str> = (lines.iter().copied())
            .filter(|line| !line.trim().is_empty() && !is_comment(line))
            .take(SAMPLED_LINES)
            .collect();
        let delimiter = match said.delimiter.as_deref() {
            Some("space") => Delimiter::Blanks,
            Some("tab") => Delimiter::Byte(b'\t'),
            Some(one) => Delimiter::Byte(one.bytes().next().unwrap_or(b',')),
            None => delimiter_of(&data),
        };
        let decimal_comma = match said.decimal.as_deref() {
            Some(decimal) => decimal == ",",
            None => delimiter != Delimiter::Byte(b',') && has_decimal_commas(&data, delimiter),
        };
        let first = || {
            data.first()
                .into_iter()
                .flat_map(|line| cells(line, delimiter))
        };
        let width = first().count();
        let numbers = first()
            .filter(|cell| number(cell.as_bytes(), decimal_comma).is_some())
            .count();
        let above = (lines.iter()).take_while(|line| line.trim().is_empty() || is_comment(line));
        let commented = above
            .filter(|line| is_comment(line))
            .last()
            .map(|line| line[1..].trim())
            .filter(|names| cells(names, delimiter).count() == width)
            .map(|names| cells(names, delimiter).map(str::to_owned).collect());
        // If a comment contains the names, text in some cells of the first line does not make it a header.
        let header = (said.header).unwrap_or(match &commented {
            Some(_) => 2 * numbers < width,
            None => numbers < width || width == 0,
        });
        let commented_names = commented.filter(|_| !header);
        let units = if header {
            units_of(&data, delimiter, decimal_comma)
        } else {
            Vec::new()
        };
        Self {
            delimiter,
            decimal_comma,
            header,
            comment,
            commented_names,
            units,
        }
    }
}

/// Returns the units below the names: a line without numbers above a line of numbers; nothing without such a line.
fn units_of(data: &[&str], delimiter: Delimiter, decimal_comma: bool) -> Vec<String> {
    let [names, units, numbers, ..] = data else {
        return Vec::new();
    };
    let [names, units, numbers] =
        [names, units, numbers].map(|line| cells(line, delimiter).collect::<Vec<_>>());
    let is_number = |cell: &&str| number(cell.as_bytes(), decimal_comma).is_some();
    let is_said = |cell: &&str| !is_missing(cell.as_bytes()) && cell.len() <= UNIT_BYTES;
    let is_row = units.len() == names.len()
        && numbers.len() == names.len()
        && units
            .iter()
            .all(|cell| cell.is_empty() || (!is_number(cell) && is_said(cell)))
        && 2 * units.iter().filter(|cell| is_said(cell)).count() >= names.len()
        && 2 * numbers.iter().filter(|cell| is_number(cell)).count() > names.len();
    let units = units.into_iter().map(str::to_owned);
    if is_row { units.collect() } else { Vec::new() }
}

/// Words for a missing value, in lower case, as programs write them.
const MISSING_WORDS: [&[u8]; 6] = [b"", b"na", b"n/a", b"<na>", b"null", b"none"];

/// Returns whether a cell is empty or contains a word for a missing value. `NaN` is a number.
pub(super) fn is_missing(cell: &[u8]) -> bool {
    let cell = cell.trim_ascii();
    MISSING_WORDS
        .iter()
        .any(|word| cell.eq_ignore_ascii_case(word))
}

/// Returns the first character of comments.
fn comment_of(lines: &[&str]) -> u8 {
    let first = lines.iter().find(|line| !line.trim().is_empty());
    match first.and_then(|line| line.bytes().next()) {
        Some(b'%') => b'%',
        _ => b'#',
    }
}

/// Splits a line into cells; delimiters between quotes do not split.
fn cells(line: &str, delimiter: Delimiter) -> impl Iterator<Item = &str> {
    let (line, is_between): (&str, fn(char, char) -> bool) = match delimiter {
        Delimiter::Blanks => (line.trim(), |c, _| c == ' ' || c == '\t'),
        Delimiter::Byte(_) => (line, |c, byte| c == byte),
    };
    let byte = match delimiter {
        Delimiter::Byte(byte) => char::from(byte),
        Delimiter::Blanks => ' ',
    };
    let mut quoted = false;
    let all = line.split(move |c| {
        quoted ^= c == '"';
        !quoted && is_between(c, byte)
    });
    // Blanks that follow one another separate as one.
    all.filter(move |cell| delimiter != Delimiter::Blanks || !cell.is_empty())
        .map(|cell| cell.trim().trim_matches('"').trim())
}

/// Returns the first delimiter that divides most lines into as many cells as the first line. The comma is tried
/// last, because it may be the decimal character.
fn delimiter_of(data: &[&str]) -> Delimiter {
    let Some(first) = data.first() else {
        return Delimiter::Byte(b',');
    };
    let candidates = [b'\t', b';', b'|', b','].map(Delimiter::Byte);
    let agrees = |delimiter: &Delimiter| {
        let width = cells(first, *delimiter).count();
        let same = (data.iter()).filter(|line| cells(line, *delimiter).count() == width);
        width > 1 && 2 * same.count() > data.len()
    };
    let blanks = cells(first, Delimiter::Blanks).count() > 1 && agrees(&Delimiter::Blanks);
    let found = candidates.into_iter().find(agrees);
    // The name of a single column may contain blanks.
    let fallback = if blanks {
        Delimiter::Blanks
    } else {
        Delimiter::Byte(b',')
    };
    found.unwrap_or(fallback)
}

fn has_decimal_commas(data: &[&str], delimiter: Delimiter) -> bool {
    let is_number = |cell: &str, comma| number(cell.as_bytes(), comma).is_some();
    (data.iter().flat_map(|line| cells(line, delimiter)))
        .any(|cell| cell.contains(',') && is_number(cell, true))
}

/// Parses a cell as a number.
pub(super) fn number(cell: &[u8], decimal_comma: bool) -> Option<f64> {
    if !decimal_comma && let Ok(value) = fast_float2::parse(cell.trim_ascii()) {
        return Some(value);
    }
    // Other blanks, decimal commas, and cells that are no numbers.
    let text = std::str::from_utf8(cell).ok()?.trim();
    if !decimal_comma {
        return text.parse().ok();
    }
    if text.contains('.') {
        return None;
    }
    text.replacen(',', ".", 1).parse().ok()
}

/// Parses a date such as `2024-05-01T12:00:00.123456Z`; returns nanoseconds since 1970.
pub(super) fn date(cell: &[u8]) -> Option<i64> {
    let text = std::str::from_utf8(cell).ok()?.trim();
    let (day, rest) = (text.get(..10)?, text.get(10..)?);
    let mut parts = day.split('-').map(str::parse::<i64>);
    let (year, month, day) = (
        parts.next()?.ok()?,
        parts.next()?.ok()?,
        parts.next()?.ok()?,
    );
    if parts.next().is_some() || !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    let rest = rest.strip_prefix(['T', ' ', 't'])?.trim();
    // The time zone is ignored, because it shifts all samples by the same time.
    let end = rest
        .find(|c: char| !(c.is_ascii_digit() || ":.".contains(c)))
        .unwrap_or(rest.len());
    let mut clock = rest[..end].split(':');
    let (hours, minutes): (i64, i64) = (clock.next()?.parse().ok()?, clock.next()?.parse().ok()?);
    let (whole, fraction) = match clock.next().unwrap_or("0").split_once('.') {
        Some((whole, fraction)) => (whole.to_owned(), format!("{fraction:0<9}")),
        None => (clock_seconds(&rest[..end]), "0".to_owned()),
    };
    let seconds: i64 = whole.parse().ok()?;
    let nanoseconds: i64 = fraction.get(..9).unwrap_or(&fraction).parse().ok()?;
    // Days since 1970 in the Gregorian calendar; a year begins in March here.
    let (y, m) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let era = y.div_euclid(400);
    let of_era = y.rem_euclid(400);
    let days = era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + (153 * m + 2) / 5 + day
        - 719_469;
    let total = ((days * 24 + hours) * 60 + minutes) * 60 + seconds;
    total.checked_mul(1_000_000_000)?.checked_add(nanoseconds)
}

fn clock_seconds(clock: &str) -> String {
    clock.split(':').nth(2).unwrap_or("0").to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn form(text: &str) -> Form {
        Form::of(text, &CsvForm::default())
    }

    #[test]
    fn delimiters_and_decimals_show() {
        let german = form("t;q;p\n0,001;1,5;2,5\n0,002;1,6;2,7\n");
        assert_eq!(german.delimiter, Delimiter::Byte(b';'));
        assert!(german.decimal_comma && german.header);
        let tabs = form("0.0\t1\t2\n0.1\t3\t4\n");
        assert_eq!(tabs.delimiter, Delimiter::Byte(b'\t'));
        assert!(!tabs.header);
        let blanks = form("  0.0   1 2\n  0.1   3 4\n");
        assert_eq!(blanks.delimiter, Delimiter::Blanks);
        let plain = form("t,\"q, rad\"\n0,1\n1,2\n");
        assert_eq!(plain.delimiter, Delimiter::Byte(b','));
        assert!(plain.header && !plain.decimal_comma);
        // A row with too few cells does not change the delimiter.
        assert_eq!(form("t,q\n0,1\n1\n2,3\n").delimiter, Delimiter::Byte(b','));
    }

    #[test]
    fn names_may_stand_in_a_comment() {
        let numpy = form("# t q1\n0.0 1.0\n0.1 2.0\n");
        assert_eq!(numpy.commented_names.unwrap(), ["t", "q1"]);
        let with_text = form("#t,state,q\n0,idle,1\n1,busy,2\n");
        assert_eq!(with_text.commented_names.unwrap(), ["t", "state", "q"]);
        let matlab = form("% made by hand\nt,q\n0,1\n");
        assert_eq!((matlab.comment, matlab.header), (b'%', true));
        assert_eq!(matlab.commented_names, None);
    }

    #[test]
    fn dates_are_counted_in_nanoseconds() {
        assert_eq!(date(b"1970-01-01T00:00:00"), Some(0));
        assert_eq!(
            date(b"1970-01-02 00:00:00.000000001Z"),
            Some(86_400_000_000_001)
        );
        assert_eq!(
            date(b"2024-02-29T12:00:01.5+02:00"),
            Some(1_709_208_001_500_000_000)
        );
        assert_eq!(date(b"2024-02-29"), None);
        assert_eq!(date(b"1.5"), None);
    }
}
