//! Quasi-Newton steps within barriers.
//!
//! The barriers of the reference have exact second derivatives; those of objective and simulated motion are learnt
//! from gradients (Broyden, Fletcher, Goldfarb, Shanno, damped by Powell). The barriers become weaker by stages.

use sprung_core::linear::{factor, solve};

use super::problem::{Problem, Value};

/// Weights of the barriers, stage by stage.
pub(super) const BARRIERS: [f64; 4] = [0.3, 0.1, 0.03, 0.01];

/// A point of a search.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// Free numbers.
    pub(super) x: Vec<f64>,
    pub(super) objective: f64,
    /// Steps that were taken.
    pub(super) steps: usize,
}

/// Searches from a point within the limits.
///
/// - `barriers`: weights of the barriers, stage by stage.
/// - `go_on`: called with each better point after a step; the search ends when it returns `false`.
///
/// Returns `None` if the start is outside of the limits.
pub(super) fn search(
    problem: &mut Problem,
    start: &[f64],
    steps: usize,
    barriers: &[f64],
    go_on: &mut dyn FnMut(&Found) -> bool,
) -> Option<Found> {
    let mut learnt = Learnt::new(start.len());
    let mut x = start.to_vec();
    let first = problem.value(&x, *barriers.first()?)?;
    let mut best = Found {
        x: x.clone(),
        objective: first.objective,
        steps: 0,
    };
    for (stage, &barrier) in barriers.iter().enumerate() {
        let mut value = problem.value(&x, barrier)?;
        let until = steps * (stage + 1) / barriers.len();
        while best.steps < until {
            let direction = learnt.direction(&value);
            let slope: f64 = direction
                .iter()
                .zip(gradient(&value))
                .map(|(d, g)| d * g)
                .sum();
            if slope.is_nan() || slope > -1e-7 {
                break;
            }
            let Some((length, next)) =
                line_search(problem, (&x, &direction), barrier, &value, slope)
            else {
                if learnt.is_fresh {
                    break;
                }
                learnt = Learnt::new(start.len());
                continue;
            };
            let moved: Vec<f64> = direction.iter().map(|d| length * d).collect();
            for (x, by) in x.iter_mut().zip(&moved) {
                *x += by;
            }
            learnt.learn(&moved, &value.by_motion, &next.by_motion);
            value = next;
            best.steps += 1;
            if value.objective < best.objective {
                (best.objective, best.x) = (value.objective, x.clone());
            }
            if !go_on(&best) {
                return Some(best);
            }
        }
    }
    Some(best)
}

fn gradient(value: &Value) -> impl Iterator<Item = f64> {
    value
        .by_motion
        .iter()
        .zip(&value.by_reference)
        .map(|(a, b)| a + b)
}

/// Returns the length of a step that decreases the value enough, and the value there.
fn line_search(
    problem: &mut Problem,
    (x, direction): (&[f64], &[f64]),
    barrier: f64,
    value: &Value,
    slope: f64,
) -> Option<(f64, Value)> {
    let mut length = 1.0;
    for _ in 0..14 {
        let next: Vec<f64> = x
            .iter()
            .zip(direction)
            .map(|(x, d)| x + length * d)
            .collect();
        if let Some(next) = problem.value(&next, barrier)
            && next.total <= value.total + 1e-4 * length * slope
        {
            return Some((length, next));
        }
        length *= 0.5;
    }
    None
}

/// Second derivatives learnt from gradients.
#[derive(Clone, Debug)]
struct Learnt {
    matrix: Vec<f64>,
    count: usize,
    is_fresh: bool,
}

impl Learnt {
    fn new(count: usize) -> Self {
        let mut matrix = vec![0.0; count * count];
        for i in 0..count {
            matrix[i * count + i] = 1.0;
        }
        Self {
            matrix,
            count,
            is_fresh: true,
        }
    }

    /// Returns the step to the minimum of the quadratic model.
    fn direction(&self, value: &Value) -> Vec<f64> {
        let count = self.count;
        let mut matrix = self.matrix.clone();
        let mut first = 0;
        for bend in &value.bend {
            let size = (bend.len() as f64).sqrt().round() as usize;
            for i in 0..size {
                for k in 0..size {
                    matrix[(first + i) * count + first + k] += bend[i * size + k];
                }
            }
            first += size;
        }
        for i in 0..count {
            matrix[i * count + i] += 1e-9;
        }
        let mut direction: Vec<f64> = gradient(value).map(|g| -g).collect();
        if factor(&mut matrix, count) {
            solve(&matrix, &mut direction);
        }
        direction
    }

    fn learn(&mut self, moved: &[f64], before: &[f64], after: &[f64]) {
        let count = self.count;
        let change: Vec<f64> = after.iter().zip(before).map(|(a, b)| a - b).collect();
        let along: f64 = change.iter().zip(moved).map(|(y, s)| y * s).sum();
        let square: f64 = moved.iter().map(|s| s * s).sum();
        if self.is_fresh {
            let scale = (along / square).max(1e-2);
            for i in 0..count {
                self.matrix[i * count + i] = scale;
            }
            self.is_fresh = false;
        }
        let product: Vec<f64> = (0..count)
            .map(|i| {
                let row = &self.matrix[i * count..(i + 1) * count];
                row.iter().zip(moved).map(|(b, s)| b * s).sum()
            })
            .collect();
        let bend: f64 = product.iter().zip(moved).map(|(p, s)| p * s).sum();
        if !(bend.is_finite() && bend > 0.0) {
            return;
        }
        let keep = if along >= 0.2 * bend {
            1.0
        } else {
            0.8 * bend / (bend - along)
        };
        let change: Vec<f64> = (change.iter().zip(&product))
            .map(|(y, p)| keep * y + (1.0 - keep) * p)
            .collect();
        let along: f64 = change.iter().zip(moved).map(|(y, s)| y * s).sum();
        for i in 0..count {
            for k in 0..count {
                self.matrix[i * count + k] +=
                    change[i] * change[k] / along - product[i] * product[k] / bend;
            }
        }
    }
}
