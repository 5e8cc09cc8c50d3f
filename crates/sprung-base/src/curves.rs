//! Decimated time series for files and plots.

/// Sets of curves with common columns; each set has its own time axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curves {
    /// Names of the columns, each with its unit at the end.
    pub columns: Vec<String>,
    /// The sets, one per label.
    pub sets: Vec<CurveSet>,
}

/// Curves of one source, for example of one estimator.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveSet {
    /// Source of the curves.
    pub label: String,
    /// Time, s.
    pub time: Vec<f64>,
    /// One vector per column; `None` is a gap.
    pub values: Vec<Vec<Option<f64>>>,
}

/// Error of reading a file of curves.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line} of the curves is not one that sprung wrote")]
pub struct CurvesError {
    /// Line, from 1.
    pub line: usize,
}

impl Curves {
    /// Name of the last column of a file whose values are still being refined; its cells are the status.
    pub const STATUS_COLUMN: &'static str = "status";

    /// Returns the set of a label.
    #[must_use]
    pub fn set(&self, label: &str) -> Option<&CurveSet> {
        self.sets.iter().find(|set| set.label == label)
    }

    /// Returns the curves as CSV: first a column `key` with the label, then the time, then the
    /// columns.
    #[must_use]
    pub fn to_csv(&self, key: &str) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let mut digits = zmij::Buffer::new();
        let mut row = csv::ByteRecord::new();
        row.push_field(key.as_bytes());
        row.push_field(b"time_s");
        row.extend(&self.columns);
        // Writing to a vector cannot fail.
        let _ = writer.write_byte_record(&row);
        for set in &self.sets {
            for (k, time) in set.time.iter().enumerate() {
                row.clear();
                row.push_field(set.label.as_bytes());
                row.push_field(digits.format(*time).as_bytes());
                for values in &set.values {
                    let value = values.get(k).copied().flatten();
                    let cell = value.map_or("", |value| digits.format(value));
                    row.push_field(cell.as_bytes());
                }
                let _ = writer.write_byte_record(&row);
            }
        }
        let bytes = writer.into_inner().unwrap_or_default();
        String::from_utf8_lossy(&bytes).into_owned()
    }

    /// Reads curves in the form that [`Curves::to_csv`] writes.
    ///
    /// # Errors
    ///
    /// [`CurvesError`] at the first faulty line: a cell is not a number, or the time does not
    /// increase.
    pub fn from_csv(text: &str) -> Result<Self, CurvesError> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let header = reader.headers().map_err(|_| CurvesError { line: 1 })?;
        let mut curves = Self {
            columns: (header.iter().skip(2))
                .filter(|name| *name != Self::STATUS_COLUMN)
                .map(str::to_owned)
                .collect(),
            sets: Vec::new(),
        };
        let number = |cell: &str| cell.parse::<f64>().ok().filter(|value| value.is_finite());
        for (i, record) in reader.records().enumerate() {
            let bad = || CurvesError { line: i + 2 };
            let record = record.map_err(|_| bad())?;
            let mut cells = record.iter();
            let (label, time) = cells.next().zip(cells.next()).ok_or_else(bad)?;
            if curves.sets.last().is_none_or(|set| set.label != *label) {
                curves.sets.push(CurveSet {
                    label: label.to_owned(),
                    time: Vec::new(),
                    values: vec![Vec::new(); curves.columns.len()],
                });
            }
            let set = curves.sets.last_mut().ok_or_else(bad)?;
            let time = number(time).ok_or_else(bad)?;
            if set.time.last().is_some_and(|before| *before >= time) {
                return Err(bad());
            }
            set.time.push(time);
            for (values, cell) in set.values.iter_mut().zip(cells) {
                let value = match cell {
                    "" => None,
                    text => Some(number(text).ok_or_else(bad)?),
                };
                values.push(value);
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
            sets: vec![set("least-squares"), set("lsff (a, b set to 0)")],
        };
        assert_eq!(Curves::from_csv(&curves.to_csv("estimator")), Ok(curves));
        for damaged in [
            "x,time_s,a\nleast-squares,0,1,2",
            "x,time_s,a\nleast-squares,nan,1",
            "x,time_s,a\nleast-squares,0,one",
        ] {
            assert_eq!(Curves::from_csv(damaged), Err(CurvesError { line: 2 }));
        }
        let refining = "x,time_s,a,status\nlsff,0,1,refining\nlsff,0.5,2,refining";
        let curves = Curves::from_csv(refining).unwrap();
        assert_eq!(curves.columns, ["a"]);
        assert_eq!(curves.sets[0].values, [[Some(1.0), Some(2.0)]]);
        let falling = "x,time_s,a\nlsff,1,1\nlsff,0.5,1";
        assert_eq!(Curves::from_csv(falling), Err(CurvesError { line: 3 }));
    }
}
