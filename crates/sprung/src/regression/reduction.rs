//! Rows of any number of samples, folded into a bounded number of factors.

use faer::Mat;

use super::filtered::FilteredSample;
use super::triangle::Triangle;
use crate::model::{Model, ROWS};

/// Factors kept at most; consecutive ones are merged beyond.
const STRETCHES: usize = 512;

/// Samples in a stretch at first.
const FIRST_STRETCH: u64 = 16;

/// Rows gathered before they are factored, at most.
const GATHER: usize = 2048;

/// Consecutive samples, reduced: one factor per row of the regressor.
#[derive(Clone, Debug)]
struct Stretch {
    end_time: f64,
    factors: Vec<Triangle>,
}

/// Folds filtered samples into triangular factors as they come.
///
/// Each row of the regressor touches few parameters, so each is reduced by
/// itself in its own columns; the factors are put side by side when the system
/// is solved.
#[derive(Clone, Debug)]
pub struct Reduction {
    gathered: Vec<Mat<f64>>,
    rows: usize,
    current: Option<Stretch>,
    in_current: u64,
    stretch: u64,
    done: Vec<Stretch>,
    samples: u64,
    last_time: f64,
}

impl Reduction {
    /// Returns a reduction that has seen nothing.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        Self {
            gathered: (0..ROWS)
                .map(|row| Mat::zeros(GATHER, model.row_columns(row).len() + 1))
                .collect(),
            rows: 0,
            current: None,
            in_current: 0,
            stretch: FIRST_STRETCH,
            done: Vec::new(),
            samples: 0,
            last_time: 0.0,
        }
    }

    /// Takes the next sample.
    pub fn push(&mut self, sample: &FilteredSample) {
        for (gathered, (_, row, rhs)) in self.gathered.iter_mut().zip(sample.rows()) {
            for (column, entry) in row.iter().enumerate() {
                gathered[(self.rows, column)] = *entry;
            }
            gathered[(self.rows, row.len())] = rhs;
        }
        self.rows += 1;
        self.in_current += 1;
        self.samples += 1;
        self.last_time = sample.time;
        if self.in_current == self.stretch {
            self.close();
        } else if self.rows == GATHER {
            self.factor();
        }
    }

    /// Returns what remains of the log.
    #[must_use]
    pub fn finish(mut self) -> System {
        if self.in_current > 0 {
            self.close();
        }
        System {
            stretches: self.done,
            samples: self.samples,
        }
    }

    fn factor(&mut self) {
        if self.rows == 0 {
            return;
        }
        let rows = std::mem::take(&mut self.rows);
        let factors = self
            .gathered
            .iter_mut()
            .map(|gathered| Triangle::of_rows(gathered.as_mut().subrows_mut(0, rows)))
            .collect();
        let new = Stretch {
            end_time: self.last_time,
            factors,
        };
        self.current = Some(match self.current.take() {
            None => new,
            Some(before) => join(&before, &new),
        });
    }

    fn close(&mut self) {
        self.factor();
        self.in_current = 0;
        self.done.extend(self.current.take());
        if self.done.len() == STRETCHES {
            self.done = self
                .done
                .chunks(2)
                .map(|pair| match pair {
                    [a, b] => join(a, b),
                    _ => pair[0].clone(),
                })
                .collect();
            self.stretch *= 2;
        }
    }
}

fn join(a: &Stretch, b: &Stretch) -> Stretch {
    Stretch {
        end_time: b.end_time,
        factors: (a.factors.iter().zip(&b.factors))
            .filter_map(|pair| Triangle::merge([pair.0, pair.1]))
            .collect(),
    }
}

/// The stacked filtered regression of a whole log, reduced.
#[derive(Clone, Debug)]
pub struct System {
    stretches: Vec<Stretch>,
    samples: u64,
}

impl System {
    /// Returns the number of samples.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Returns one factor per row of the regressor for the whole log; nothing
    /// if the log is empty.
    #[must_use]
    pub fn whole(&self) -> Option<Vec<Triangle>> {
        self.groups(1).pop()
    }

    /// Returns the factors of at most `count` consecutive parts of about equal
    /// length.
    #[must_use]
    pub fn groups(&self, count: usize) -> Vec<Vec<Triangle>> {
        let size = self.stretches.len().div_ceil(count.max(1)).max(1);
        self.stretches
            .chunks(size)
            .map(|chunk| {
                (0..ROWS)
                    .filter_map(|row| Triangle::merge(chunk.iter().map(|s| &s.factors[row])))
                    .collect()
            })
            .collect()
    }

    /// Returns the factors of the log up to ever later times, in s.
    pub fn growing(&self) -> impl Iterator<Item = (f64, Vec<Triangle>)> {
        let mut so_far: Option<Stretch> = None;
        self.stretches.iter().map(move |stretch| {
            let joined = match &so_far {
                None => stretch.clone(),
                Some(before) => join(before, stretch),
            };
            so_far = Some(joined.clone());
            (joined.end_time, joined.factors)
        })
    }
}
