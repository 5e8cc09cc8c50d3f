//! Decimated time series for files and plots.

use std::fmt::Write as _;

/// Several sets of curves with the same columns, each on its own time axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curves {
    /// Names of the columns, unit last.
    pub columns: Vec<String>,
    /// The sets, one per label.
    pub sets: Vec<CurveSet>,
}

/// Curves of one origin, as of one estimator.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveSet {
    /// Where the curves come from.
    pub label: String,
    /// Time, s.
    pub time: Vec<f64>,
    /// One vector per column; missing values are gaps.
    pub values: Vec<Vec<Option<f64>>>,
}

/// A file of curves cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line} of the curves is not one that sprung wrote")]
pub struct CurvesError {
    /// Line, from 1.
    pub line: usize,
}

impl Curves {
    /// Returns the set of a label.
    #[must_use]
    pub fn set(&self, label: &str) -> Option<&CurveSet> {
        self.sets.iter().find(|set| set.label == label)
    }

    /// Returns the curves as CSV: a first column with the label under the name
    /// `key`, the time, then the columns.
    #[must_use]
    pub fn to_csv(&self, key: &str) -> String {
        let mut text = format!("{key},time_s");
        for column in &self.columns {
            let _ = write!(text, ",{column}");
        }
        text.push('\n');
        for set in &self.sets {
            for (k, time) in set.time.iter().enumerate() {
                let _ = write!(text, "{},{time}", set.label);
                for values in &set.values {
                    match values[k] {
                        Some(value) => {
                            let _ = write!(text, ",{value}");
                        }
                        None => text.push(','),
                    }
                }
                text.push('\n');
            }
        }
        text
    }

    /// Reads what [`Curves::to_csv`] wrote.
    ///
    /// # Errors
    ///
    /// [`CurvesError`] at the first line that does not fit.
    pub fn from_csv(text: &str) -> Result<Self, CurvesError> {
        let mut lines = text.lines().enumerate();
        let header = lines.next().ok_or(CurvesError { line: 1 })?.1;
        let mut curves = Self {
            columns: header.split(',').skip(2).map(str::to_owned).collect(),
            sets: Vec::new(),
        };
        let width = curves.columns.len();
        for (i, line) in lines {
            let bad = || CurvesError { line: i + 1 };
            let cells: Vec<&str> = line.split(',').collect();
            let [label, time, rest @ ..] = &cells[..] else {
                return Err(bad());
            };
            if rest.len() != width {
                return Err(bad());
            }
            if curves.sets.last().is_none_or(|set| set.label != *label) {
                curves.sets.push(CurveSet {
                    label: (*label).to_owned(),
                    time: Vec::new(),
                    values: vec![Vec::new(); width],
                });
            }
            let Some(set) = curves.sets.last_mut() else {
                return Err(bad());
            };
            set.time.push(time.parse().map_err(|_| bad())?);
            for (values, cell) in set.values.iter_mut().zip(rest) {
                values.push(if cell.is_empty() {
                    None
                } else {
                    Some(cell.parse().map_err(|_| bad())?)
                });
            }
        }
        Ok(curves)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_keep_every_bit() {
        let set = |label: &str| CurveSet {
            label: label.to_owned(),
            time: vec![0.0, 0.1, 1.0 / 3.0],
            values: vec![
                vec![None, Some(1e-17), Some(-2.0)],
                vec![Some(0.1), None, Some(f64::MIN_POSITIVE)],
            ],
        };
        let curves = Curves {
            columns: vec!["a_rad".to_owned(), "b_nm".to_owned()],
            sets: vec![set("least-squares"), set("lsff")],
        };
        assert_eq!(Curves::from_csv(&curves.to_csv("estimator")), Ok(curves));
        assert_eq!(
            Curves::from_csv("x,time_s,a\nleast-squares,0,1,2"),
            Err(CurvesError { line: 2 })
        );
    }
}
