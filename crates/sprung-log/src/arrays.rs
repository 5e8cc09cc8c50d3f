//! Columns of numbers in memory, which serve as a log without a file.

use std::fmt::{self, Write};
use std::ops::Range;
use std::sync::Arc;

use sha2::{Digest, Sha256};

/// Most rows of a digest.
const DIGESTED: usize = 2048;

/// Borrowed or owned numbers: a `Vec`, a slice behind an `Arc`, or an array of another language
/// whose owner lives as long as this value.
type Lent<T> = Arc<dyn AsRef<[T]> + Send + Sync>;

/// The numbers of one column. Clones share the numbers.
#[derive(Clone)]
pub enum Array {
    /// Floating point numbers.
    Float(Lent<f64>),
    /// Integers, such as encoder counts or times in ns; they are read exactly.
    Integer(Lent<i64>),
    /// A column of a matrix of floating point numbers.
    Column(Column),
}

/// A column of a matrix that is stored row by row.
#[derive(Clone)]
pub struct Column {
    matrix: Lent<f64>,
    place: usize,
    width: usize,
}

impl Column {
    fn len(&self) -> usize {
        let numbers = (*self.matrix).as_ref().len();
        if self.place < self.width {
            numbers / self.width
        } else {
            0
        }
    }

    /// Returns its numbers in some rows.
    pub(crate) fn rows(&self, rows: Range<usize>) -> impl Iterator<Item = f64> {
        let range = rows.start * self.width..rows.end * self.width;
        let numbers = (*self.matrix).as_ref().get(range).unwrap_or(&[]);
        numbers
            .iter()
            .skip(self.place)
            .step_by(self.width.max(1))
            .copied()
    }
}

impl Array {
    /// Returns a column of floating point numbers without copying them.
    #[must_use]
    pub fn float(numbers: impl AsRef<[f64]> + Send + Sync + 'static) -> Self {
        Self::Float(Arc::new(numbers))
    }

    /// Returns a column of integers without copying them.
    #[must_use]
    pub fn integer(numbers: impl AsRef<[i64]> + Send + Sync + 'static) -> Self {
        Self::Integer(Arc::new(numbers))
    }

    /// Returns the columns of a matrix without copying it.
    ///
    /// - `matrix`: \[rows × columns\], row by row.
    #[must_use]
    pub fn columns(matrix: impl AsRef<[f64]> + Send + Sync + 'static, columns: usize) -> Vec<Self> {
        let matrix: Lent<f64> = Arc::new(matrix);
        let of = |column| Column {
            matrix: Arc::clone(&matrix),
            place: column,
            width: columns,
        };
        (0..columns)
            .map(|column| Self::Column(of(column)))
            .collect()
    }

    /// Returns the number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Float(numbers) => (**numbers).as_ref().len(),
            Self::Integer(numbers) => (**numbers).as_ref().len(),
            Self::Column(column) => column.len(),
        }
    }

    /// Returns whether there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the bytes of the number in a row; zeros behind the end.
    fn bytes(&self, row: usize) -> [u8; 8] {
        let float = |number: Option<f64>| number.unwrap_or_default().to_le_bytes();
        match self {
            Self::Float(numbers) => float((**numbers).as_ref().get(row).copied()),
            Self::Integer(numbers) => {
                let number = (**numbers).as_ref().get(row).copied();
                number.unwrap_or_default().to_le_bytes()
            }
            Self::Column(column) => float(column.rows(row..row + 1).next()),
        }
    }
}

impl fmt::Debug for Array {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Float(_) => write!(f, "Float({} rows)", self.len()),
            Self::Integer(_) => write!(f, "Integer({} rows)", self.len()),
            Self::Column(_) => write!(f, "Column({} rows)", self.len()),
        }
    }
}

impl From<Vec<f64>> for Array {
    fn from(numbers: Vec<f64>) -> Self {
        Self::float(numbers)
    }
}

impl From<Vec<i64>> for Array {
    fn from(numbers: Vec<i64>) -> Self {
        Self::integer(numbers)
    }
}

/// Named columns of equal length. Clones share the numbers.
#[derive(Clone, Debug, Default)]
pub struct Arrays {
    names: Vec<String>,
    arrays: Vec<Array>,
}

/// Error of columns that cannot form a log.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ArraysError {
    /// Two columns have different lengths.
    #[error(
        "column \"{first}\" has {rows} rows and column \"{other}\" {other_rows}; the columns of a log \
         are of one length"
    )]
    Unequal {
        /// Name of the first column.
        first: String,
        /// Length of the first column.
        rows: usize,
        /// Name of the first column of another length.
        other: String,
        /// Length of that column.
        other_rows: usize,
    },
    /// A column is given twice.
    #[error("column \"{column}\" is given twice; give one of them another name")]
    Twice {
        /// Name of the column.
        column: String,
    },
}

impl Arrays {
    /// Returns columns as a log.
    ///
    /// - `columns`: names and numbers. An experiment names the same columns in `[log]`, with their
    ///   units.
    ///
    /// # Errors
    ///
    /// [`ArraysError`] if columns differ in length or share a name.
    pub fn new<N, A>(columns: impl IntoIterator<Item = (N, A)>) -> Result<Self, ArraysError>
    where
        N: Into<String>,
        A: Into<Array>,
    {
        let mut all = Self::default();
        for (name, array) in columns {
            all.push(name.into(), array.into())?;
        }
        Ok(all)
    }

    fn push(&mut self, name: String, array: Array) -> Result<(), ArraysError> {
        if self.names.contains(&name) {
            return Err(ArraysError::Twice { column: name });
        }
        if let (Some(first), Some(of_first)) = (self.names.first(), self.arrays.first())
            && of_first.len() != array.len()
        {
            return Err(ArraysError::Unequal {
                first: first.clone(),
                rows: of_first.len(),
                other: name,
                other_rows: array.len(),
            });
        }
        self.names.push(name);
        self.arrays.push(array);
        Ok(())
    }

    /// Returns the names of the columns.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns a column by its index among the names.
    #[must_use]
    pub fn array(&self, place: usize) -> Option<&Array> {
        self.arrays.get(place)
    }

    /// Returns the number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.arrays.first().map_or(0, Array::len)
    }

    /// Returns whether there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns a name that logs with the same numbers share: hexadecimal digits of a digest of their
    /// lengths and of at most 2048 rows.
    #[must_use]
    pub fn digest(&self) -> String {
        let mut digest = Sha256::new();
        let rows = self.len();
        digest.update(rows.to_le_bytes());
        let step = rows.div_ceil(DIGESTED).max(1);
        for array in &self.arrays {
            for row in (0..rows).step_by(step) {
                digest.update(array.bytes(row));
            }
        }
        let all = digest.finalize();
        all[..4].iter().fold(String::new(), |mut text, byte| {
            // Writing to a string cannot fail.
            let _ = write!(text, "{byte:02x}");
            text
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_unequal_length_are_named() {
        let columns = [("t", vec![0.0, 1.0]), ("q", vec![0.0])];
        let error = Arrays::new(columns).unwrap_err().to_string();
        let expected = "column \"t\" has 2 rows and column \"q\" 1; the columns of a log are of one \
                        length";
        assert_eq!(error, expected);
    }

    #[test]
    fn a_column_is_given_once() {
        let columns = [("t", vec![0.0]), ("t", vec![1.0])];
        let error = Arrays::new(columns).unwrap_err().to_string();
        assert_eq!(
            error,
            "column \"t\" is given twice; give one of them another name"
        );
    }

    #[test]
    fn the_columns_of_a_matrix_share_its_numbers() {
        let matrix = vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let columns = Array::columns(matrix, 2);
        let numbers = |column: &Array, rows: Range<usize>| match column {
            Array::Column(column) => column.rows(rows).collect::<Vec<f64>>(),
            Array::Float(_) | Array::Integer(_) => Vec::new(),
        };
        assert_eq!(columns[1].len(), 3);
        assert_eq!(numbers(&columns[0], 0..3), [1.0, 3.0, 5.0]);
        assert_eq!(numbers(&columns[1], 1..2), [4.0]);
        assert!(Array::columns(vec![1.0], 0).is_empty());
    }

    #[test]
    fn logs_with_the_same_numbers_share_their_digest() {
        let of = |matrix: Vec<f64>| {
            let columns = Array::columns(matrix, 2).into_iter();
            Arrays::new(["q", "p"].into_iter().zip(columns))
                .unwrap()
                .digest()
        };
        let single = Arrays::new([("a", vec![1.0, 3.0]), ("b", vec![2.0, 4.0])]).unwrap();
        assert_eq!(of(vec![1.0, 2.0, 3.0, 4.0]), single.digest());
        assert_ne!(of(vec![1.0, 2.0, 3.0, 5.0]), single.digest());
        assert_eq!(single.digest().len(), 8);
    }

    #[test]
    fn numbers_are_lent_and_shared() {
        let numbers: Arc<[f64]> = Arc::from(vec![1.0, 2.0]);
        let arrays = Arrays::new([("q", Array::float(Arc::clone(&numbers)))]).unwrap();
        let again = arrays.clone();
        assert_eq!((again.len(), Arc::strong_count(&numbers)), (2, 2));
    }
}
