//! Vectors in the repository, computed again by the programs that they come from.

use std::path::Path;

use serde_json::Value;

use super::python::Python;
use crate::files::json;
use crate::root;

/// Largest difference from a number in the repository, relative to the number or to 1: sums in another
/// order change last digits only.
const TOLERANCE: f64 = 1e-12;

/// Compares the outputs of the zero-phase filter.
pub(super) fn scipy(python: &Python) -> Option<()> {
    let again = python.folder.join("zero_phase.json");
    python.filter("crates/sprung/tests/fixtures/zero_phase.py", None, &again)?;
    same("crates/sprung/tests/fixtures/zero_phase.json", &again)
}

/// Compares torques, momenta and gravity of two arms.
pub(super) fn pinocchio(python: &Python) -> Option<()> {
    let file = "crates/sprung-core/tests/fixtures/chains.json";
    let again = python.folder.join("chains.json");
    let script = "crates/sprung-core/tests/fixtures/chains.py";
    python.filter(script, Some(&root().join(file)), &again)?;
    same(file, &again)
}

/// Compares two files of numbers.
fn same(file: &str, again: &Path) -> Option<()> {
    let [known, found] = [&root().join(file), again].map(json::<Value>);
    let mut numbers = 0;
    match compare(&known?, &found?, &mut numbers) {
        Ok(()) => {
            eprintln!("{numbers} numbers of {file} agree");
            (numbers > 0).then_some(())
        }
        Err(difference) => {
            eprintln!("── {} differs from {file}: {difference}", again.display());
            None
        }
    }
}

/// Compares numbers and the shapes of their containers; counts the numbers.
fn compare(known: &Value, found: &Value, numbers: &mut usize) -> Result<(), String> {
    match (known, found) {
        (Value::Object(a), Value::Object(b)) if a.keys().eq(b.keys()) => {
            a.iter().zip(b.values()).try_for_each(|((key, a), b)| {
                compare(a, b, numbers).map_err(|e| format!("{key}: {e}"))
            })
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => a
            .iter()
            .zip(b)
            .try_for_each(|(a, b)| compare(a, b, numbers)),
        (Value::Number(a), Value::Number(b)) => {
            *numbers += 1;
            let (a, b) = (
                a.as_f64().unwrap_or(f64::NAN),
                b.as_f64().unwrap_or(f64::NAN),
            );
            if (a - b).abs() <= TOLERANCE * a.abs().max(1.0) {
                Ok(())
            } else {
                Err(format!("{b} instead of {a}"))
            }
        }
        // Versions of programs.
        (Value::String(_), Value::String(_)) => Ok(()),
        (a, b) if a == b => Ok(()),
        _ => Err("it has another shape".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn numbers_and_shapes_are_compared() {
        let known = json!({"note": "SciPy 1", "cases": [[1.0, 2e6], null]});
        let compared = |found: Value| {
            let mut numbers = 0;
            compare(&known, &found, &mut numbers).map(|()| numbers)
        };
        let same = json!({"note": "SciPy 2", "cases": [[1.0 + 1e-13, 2e6 + 1e-7], null]});
        assert_eq!(compared(same), Ok(2));
        for other in [
            json!({"note": "", "cases": [[1.0 + 1e-11, 2e6], null]}),
            json!({"note": "", "cases": [[1.0], null]}),
            json!({"note": "", "cases": [[1.0, null], null]}),
            json!({"cases": [[1.0, 2e6], null]}),
        ] {
            assert!(compared(other.clone()).is_err(), "{other}");
        }
    }
}
