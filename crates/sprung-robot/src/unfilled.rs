//! Places of an experiment file that the user has not filled in.

use toml::de::{DeTable, DeValue};

use super::keys::Misfit;

/// Value of a key in a new experiment that only the user knows.
pub const FILL_IN: &str = "FILL IN";

/// Returns an error for the first place that is not filled in.
pub(super) fn check(table: &DeTable<'_>) -> Result<(), Misfit> {
    let mut first: Option<(usize, Misfit)> = None;
    in_table(table, &mut first);
    first.map_or(Ok(()), |(_, misfit)| Err(misfit))
}

fn in_table(table: &DeTable<'_>, first: &mut Option<(usize, Misfit)>) {
    for (key, value) in table {
        in_value(key.get_ref(), value, first);
    }
}

/// - `key`: the key of the value, or of the list that contains it.
#[expect(clippy::wildcard_enum_match_arm, reason = "numbers are filled in")]
fn in_value(key: &str, value: &toml::Spanned<DeValue<'_>>, first: &mut Option<(usize, Misfit)>) {
    match value.get_ref() {
        DeValue::String(text) if text.trim_start().starts_with(FILL_IN) => {
            let span = value.span();
            if first.as_ref().is_none_or(|(start, _)| span.start < *start) {
                let message = format!(
                    "{FILL_IN} {key}: only you know this value; write it in place of \"{text}\". The comment \
                     above the line says what is needed"
                );
                let misfit = Misfit {
                    span: Some(span.clone()),
                    message,
                    code: None,
                };
                *first = Some((span.start, misfit));
            }
        }
        DeValue::Array(list) => list.iter().for_each(|one| in_value(key, one, first)),
        DeValue::Table(table) => in_table(table, first),
        _ => {}
    }
}
