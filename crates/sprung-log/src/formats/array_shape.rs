//! Rules that all files of arrays share: two sides, columns of equal length, no topics.

use super::table::Request;
use crate::error::LogError;
use crate::input_limits::COLUMNS;

/// Lengths of the two sides of a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sides {
    pub(super) rows: u64,
    pub(super) columns: u64,
}

impl Sides {
    /// Returns the sides of an array, of which those of length 1 are dropped.
    ///
    /// - `dimensions`: in MATLAB's order; their product does not overflow.
    ///
    /// # Errors
    ///
    /// The fault, as a predicate, if more than two sides are longer than 1.
    pub(super) fn of(dimensions: &[u64]) -> Result<Self, String> {
        let long: Vec<u64> = dimensions.iter().copied().filter(|n| *n != 1).collect();
        match long[..] {
            [] => Ok(Self {
                rows: 1,
                columns: 1,
            }),
            [rows] => Ok(Self { rows, columns: 1 }),
            [rows, columns] => Ok(Self { rows, columns }),
            _ => {
                let sides: Vec<String> = dimensions.iter().map(u64::to_string).collect();
                Err(format!(
                    "is an array of {}, and a log has two dimensions; reshape it to samples × columns \
                     and save that",
                    sides.join(" × ")
                ))
            }
        }
    }

    /// Whether the samples run along the second side: they run along the longer one.
    pub(super) fn lies(self) -> bool {
        self.columns > self.rows
    }

    /// Returns the length of the longer side.
    pub(super) fn samples(self) -> u64 {
        self.rows.max(self.columns)
    }

    /// Returns the length of the shorter side: the number of columns.
    pub(super) fn width(self) -> u64 {
        self.rows.min(self.columns)
    }

    /// Returns the names of the columns of an array as MATLAB writes them, `t`, `q(:,1)` or `q(1,:)`,
    /// with their indices from 0.
    pub(super) fn columns_of(self, array: &str) -> impl Iterator<Item = (String, u64)> + '_ {
        let width = self.width();
        (0..width).map(move |place| {
            let name = match (width, self.lies()) {
                (1, _) => array.to_owned(),
                (_, false) => format!("{array}(:,{})", place + 1),
                (_, true) => format!("{array}({},:)", place + 1),
            };
            (name, place)
        })
    }
}

/// Returns why an array is not read whose columns and those of the arrays before it exceed [`COLUMNS`].
pub(super) fn too_many(columns: u64) -> String {
    format!(
        "has {columns} columns, and with those of the arrays before it more than the {COLUMNS} that a log has at most; \
         save the log in a file of its own"
    )
}

/// Checks that no topic is requested: only bags have topics.
pub(super) fn no_topics(request: &Request<'_>) -> Result<(), LogError> {
    match request.topic {
        None => Ok(()),
        Some(topic) => Err(LogError::format(
            request.whole_file(),
            format!(" holds arrays and no topics, so there is no \"{topic}\"; name columns"),
        )),
    }
}

/// Checks that the wanted columns are of equal length, and returns it.
///
/// - `places`: indices of the wanted columns.
/// - `of`: name and length of a column by its index.
pub(super) fn same_rows<'a>(
    file: &str,
    places: &[usize],
    of: impl Fn(usize) -> (&'a String, u64),
) -> Result<u64, LogError> {
    let Some((first, rows)) = places.first().map(|&place| of(place)) else {
        return Ok(0);
    };
    for &place in places {
        let (name, count) = of(place);
        if count != rows {
            return Err(LogError::format(
                file,
                format!(
                    ": \"{first}\" has {rows} rows and \"{name}\" {count}; the channels of a log are of \
                     one length, or have a time of their own: {{ file = \"…\", column = \"{name}\", \
                     time = \"…\" }}"
                ),
            ));
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_of_length_one_do_not_count() {
        let sides = |dimensions: &[u64]| {
            let sides = Sides::of(dimensions)?;
            Ok::<_, String>((sides.rows, sides.columns))
        };
        assert_eq!(sides(&[100, 2]), Ok((100, 2)));
        assert_eq!(sides(&[2, 1, 100]), Ok((2, 100)));
        assert_eq!(sides(&[1, 1, 100]), Ok((100, 1)));
        assert_eq!(sides(&[1, 1]), Ok((1, 1)));
        let told = sides(&[100, 7, 2]).unwrap_err();
        assert!(told.contains("array of 100 × 7 × 2"), "{told}");
    }
}
