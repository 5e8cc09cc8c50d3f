//! Which combinations of inertial parameters any motion can reveal.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sprung_core::chain::Chain;
use sprung_core::links::{JointScratch, LengthError, PairScratch, Workspace, torque};
use sprung_core::spatial::{BODY, BODY_NAMES};

/// States that are drawn; each gives one row per joint.
const STATES: usize = 200;

/// Positions, velocities and accelerations are drawn up to this.
const LIMIT: f64 = 3.0;

/// Part of a column's length below which what is left of it counts as zero.
/// The gap at the rank was nine decades for every robot tried.
const TOLERANCE: f64 = 1e-9;

/// The inertial parameters that a robot's motion reveals.
///
/// Parameter `k` of link `j` has the index `10 j + k`.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseParameters {
    /// Parameters whose columns are independent, in order.
    pub independent: Vec<usize>,
    /// Parameters that only show in combination with these, or not at all.
    pub dependent: Vec<usize>,
    /// How much of each dependent parameter goes into each independent one,
    /// \[independent × dependent\].
    pub combination: Vec<Vec<f64>>,
}

impl BaseParameters {
    /// Finds them from the torque columns of random states.
    ///
    /// - `zero`: indices of parameters that are known to be zero.
    ///
    /// Columns are accepted in their order, from the base to the tips, which
    /// gives short combinations and the same ones every time.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if the memory did not fit the chain; it is made to fit.
    ///
    /// # Source
    ///
    /// Gautier's numerical method by QR, with a fixed order instead of
    /// pivoting.
    pub fn new(chain: &Chain<'_>, zero: &[usize]) -> Result<Self, LengthError> {
        let columns = random_columns(chain)?;
        let length = |v: &[f64]| dot(v, v).sqrt();
        let longest = columns.iter().map(|c| length(c)).fold(0.0, f64::max);
        let limit = TOLERANCE * (columns.len() as f64).sqrt();

        let mut basis: Vec<Vec<f64>> = Vec::new();
        // Components of the accepted columns on the basis: a triangle.
        let mut triangle: Vec<Vec<f64>> = Vec::new();
        let mut base = Self {
            independent: Vec::new(),
            dependent: Vec::new(),
            combination: Vec::new(),
        };
        let mut shares: Vec<Vec<f64>> = Vec::new();
        for (index, column) in columns.iter().enumerate() {
            if zero.contains(&index) {
                continue;
            }
            let (components, rest) = project(column, &basis);
            let own = length(column);
            if own > TOLERANCE * longest && length(&rest) > limit * own {
                let size = length(&rest);
                basis.push(rest.iter().map(|x| x / size).collect());
                let mut components = components;
                components.push(size);
                triangle.push(components);
                base.independent.push(index);
            } else {
                base.dependent.push(index);
                shares.push(if own > TOLERANCE * longest {
                    components
                } else {
                    Vec::new()
                });
            }
        }
        let count = base.independent.len();
        let solved: Vec<Vec<f64>> = shares
            .iter()
            .map(|share| back_substitute(&triangle, share, count))
            .collect();
        base.combination = (0..count)
            .map(|i| solved.iter().map(|column| column[i]).collect())
            .collect();
        Ok(base)
    }

    /// Returns the values of the base parameters.
    ///
    /// - `standard`: inertial parameters of all links, \[10n\].
    #[must_use]
    pub fn values(&self, standard: &[f64]) -> Vec<f64> {
        (self.independent.iter().zip(&self.combination))
            .map(|(&own, shares)| {
                let others = self.dependent.iter().zip(shares);
                standard[own] + others.map(|(&k, share)| share * standard[k]).sum::<f64>()
            })
            .collect()
    }

    /// Returns each base parameter in words, as in
    /// `link1.izz + 0.1176*link2.m`.
    ///
    /// - `links`: names of the links, \[n\].
    #[must_use]
    pub fn words(&self, links: &[String]) -> Vec<String> {
        let name = |k: usize| format!("{}.{}", links[k / BODY], BODY_NAMES[k % BODY]);
        (self.independent.iter().zip(&self.combination))
            .map(|(&own, shares)| {
                let mut words = name(own);
                for (&k, &share) in self.dependent.iter().zip(shares) {
                    if share != 0.0 {
                        let sign = if share < 0.0 { '-' } else { '+' };
                        let size = share.abs();
                        let factor = if (size - 1.0).abs() < TOLERANCE {
                            String::new()
                        } else {
                            format!("{}*", digits(size))
                        };
                        words = format!("{words} {sign} {factor}{}", name(k));
                    }
                }
                words
            })
            .collect()
    }
}

/// Four significant digits without trailing zeros.
fn digits(value: f64) -> String {
    let decimals = (3 - value.log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Returns the components on an orthonormal basis and what is left; twice, so
/// that round-off of the first time is taken out.
fn project(column: &[f64], basis: &[Vec<f64>]) -> (Vec<f64>, Vec<f64>) {
    let mut components = vec![0.0; basis.len()];
    let mut rest = column.to_vec();
    for _ in 0..2 {
        for (component, direction) in components.iter_mut().zip(basis) {
            let part = dot(&rest, direction);
            *component += part;
            for (x, d) in rest.iter_mut().zip(direction) {
                *x -= part * d;
            }
        }
    }
    (components, rest)
}

/// Solves for the combination of accepted columns that has these components.
fn back_substitute(triangle: &[Vec<f64>], components: &[f64], count: usize) -> Vec<f64> {
    let mut x = vec![0.0; count];
    for i in (0..components.len()).rev() {
        let known: f64 = (i + 1..components.len())
            .map(|j| triangle[j][i] * x[j])
            .sum();
        x[i] = (components[i] - known) / triangle[i][i];
    }
    let largest = x.iter().fold(1.0_f64, |m, v| m.max(v.abs()));
    for value in &mut x {
        if value.abs() < TOLERANCE * largest {
            *value = 0.0;
        }
    }
    x
}

/// Returns the torque columns of random states, one vector per parameter.
fn random_columns(chain: &Chain<'_>) -> Result<Vec<Vec<f64>>, LengthError> {
    let n = chain.joints().len();
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let (mut joints, mut pairs) = (
        vec![JointScratch::default(); n],
        vec![PairScratch::default(); n * n],
    );
    let mut workspace = Workspace {
        joints: &mut joints,
        pairs: &mut pairs,
    };
    let width = n * BODY;
    let mut rows = vec![0.0; n * width];
    let mut columns = vec![Vec::with_capacity(STATES * n); width];
    for _ in 0..STATES {
        let mut draw = || -> Vec<f64> {
            (0..n)
                .map(|_| LIMIT * (2.0 * rng.random::<f64>() - 1.0))
                .collect()
        };
        let (q, dq, ddq) = (draw(), draw(), draw());
        torque(chain, &q, &dq, &ddq, &mut workspace, &mut rows)?;
        for row in rows.chunks(width) {
            for (column, entry) in columns.iter_mut().zip(row) {
                column.push(*entry);
            }
        }
    }
    Ok(columns)
}

#[cfg(test)]
mod tests {
    use sprung_core::chain::{ChainJoint, DhRow};

    use super::*;

    const HALF: f64 = std::f64::consts::FRAC_PI_2;

    fn row(alpha: f64, a: f64, d: f64) -> DhRow {
        DhRow {
            alpha,
            a,
            d,
            theta: 0.0,
        }
    }

    fn modified(rows: &[DhRow]) -> Vec<ChainJoint> {
        (rows.iter().enumerate())
            .map(|(i, row)| ChainJoint::modified_dh(i.checked_sub(1), row))
            .collect()
    }

    fn classic(rows: &[DhRow]) -> Vec<ChainJoint> {
        (rows.iter().enumerate())
            .map(|(i, row)| {
                let parent = i.checked_sub(1);
                ChainJoint::classic_dh(parent, parent.map(|p| &rows[p]), row)
            })
            .collect()
    }

    fn count(joints: &[ChainJoint], gravity: [f64; 3]) -> usize {
        let chain = Chain::new(joints, gravity).unwrap();
        BaseParameters::new(&chain, &[]).unwrap().independent.len()
    }

    const DOWN: [f64; 3] = [0.0, 0.0, -9.81];
    const TILTED: [f64; 3] = [2.0, -1.5, -9.5];

    #[test]
    fn counts_are_those_of_the_literature() {
        let panda = modified(&[
            row(0.0, 0.0, 0.333),
            row(-HALF, 0.0, 0.0),
            row(HALF, 0.0, 0.316),
            row(HALF, 0.0825, 0.0),
            row(-HALF, -0.0825, 0.384),
            row(HALF, 0.0, 0.0),
            row(HALF, 0.088, 0.0),
        ]);
        assert_eq!(count(&panda, DOWN), 43);
        let iiwa = modified(&[
            row(0.0, 0.0, 0.36),
            row(-HALF, 0.0, 0.0),
            row(HALF, 0.0, 0.42),
            row(HALF, 0.0, 0.0),
            row(-HALF, 0.0, 0.4),
            row(-HALF, 0.0, 0.0),
            row(HALF, 0.0, 0.126),
        ]);
        assert_eq!(count(&iiwa, DOWN), 43);
        assert_eq!(count(&iiwa, TILTED), 45);
        let ur5 = classic(&[
            row(HALF, 0.0, 0.089_159),
            row(0.0, -0.425, 0.0),
            row(0.0, -0.392_25, 0.0),
            row(HALF, 0.0, 0.109_15),
            row(-HALF, 0.0, 0.094_65),
            row(0.0, 0.0, 0.0823),
        ]);
        assert_eq!(count(&ur5, DOWN), 36);
        let planar = modified(&[row(0.0, 0.0, 0.0), row(0.0, 0.343, 0.0)]);
        assert_eq!(count(&planar, DOWN), 4);
        assert_eq!(count(&planar, [0.0, -9.81, 0.0]), 6);
    }

    #[test]
    fn groupings_read_as_a_roboticist_writes_them() {
        let planar = modified(&[row(0.0, 0.0, 0.0), row(0.0, 0.343, 0.0)]);
        let chain = Chain::new(&planar, DOWN).unwrap();
        let links = ["link1".to_owned(), "link2".to_owned()];
        let base = BaseParameters::new(&chain, &[]).unwrap();
        assert_eq!(
            base.words(&links),
            [
                "link1.izz + 0.1176*link2.m",
                "link2.mx",
                "link2.my",
                "link2.izz"
            ]
        );
        // The paper's three parameters assume that link 2 is symmetric.
        let my2 = BODY + 2;
        let base = BaseParameters::new(&chain, &[my2]).unwrap();
        assert_eq!(base.independent, [9, 11, 19]);
        assert!(!base.dependent.contains(&my2));
    }

    #[test]
    fn base_parameters_give_the_torque_of_all_parameters() {
        let arm = classic(&[
            row(HALF, 0.1, 0.4),
            row(0.3, -0.4, 0.0),
            row(-HALF, 0.2, 0.1),
            row(HALF, 0.0, 0.3),
        ]);
        let chain = Chain::new(&arm, TILTED).unwrap();
        let base = BaseParameters::new(&chain, &[]).unwrap();
        let standard: Vec<f64> = (0..4 * BODY)
            .map(|k| (k as f64 * 0.7).sin() + 1.2)
            .collect();
        let values = base.values(&standard);
        let columns = random_columns(&chain).unwrap();
        for state in 0..columns[0].len() {
            let all: f64 = columns
                .iter()
                .zip(&standard)
                .map(|(c, x)| c[state] * x)
                .sum();
            let few: f64 = base
                .independent
                .iter()
                .zip(&values)
                .map(|(&k, x)| columns[k][state] * x)
                .sum();
            assert!((all - few).abs() < 1e-9 * (1.0 + all.abs()), "{all} {few}");
        }
    }
}
