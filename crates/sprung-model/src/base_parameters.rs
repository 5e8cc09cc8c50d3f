//! Finds the combinations of inertial parameters that motion can determine.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sprung_core::chain::Chain;
use sprung_core::linear::dot;
use sprung_core::links::{LengthError, torque};
use sprung_core::spatial::BODY;

use super::scratch::Scratch;

/// Number of random states; each gives one row per joint.
const RANDOM_STATES: usize = 60;

/// Largest absolute value of random positions, velocities and accelerations.
const STATE_LIMIT: f64 = 3.0;

/// Relative length below which the independent part of a column counts as zero. For every tested
/// robot the gap in length at the rank was nine decades; it was four decades for a file with right
/// angles of five digits, as in `rpy="1.5708 0 0"`.
const TOLERANCE: f64 = 1e-5;

/// The columns for the search for base parameters.
#[derive(Clone, Copy, Debug)]
pub struct Candidates<'a> {
    /// The tree of joints.
    pub chain: Chain<'a>,
    /// Motor positions per joint position, \[n × n\]; `None` without coupling.
    pub coupling: Option<&'a [f64]>,
    /// Whether each joint is rigid; the rotor of a rigid joint moves with the links.
    pub rigid: &'a [bool],
    /// Whether the torque of each motor contains an unknown constant and its joint is rigid.
    pub offset: &'a [bool],
    /// Parameters with known values, which appear in no combination.
    pub known: &'a [usize],
}

/// The inertial parameters that a robot's motion determines.
///
/// Parameter `k` of link `j` has the index `10 j + k`; the rotor of joint `i`
/// has the index `10 n + i`, and the constant torque of its motor `11 n + i`. Both are considered only
/// if the joint is rigid.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseParameters {
    /// Parameters with independent columns, in order.
    pub independent: Vec<usize>,
    /// Parameters that affect the motion only in combination with independent parameters, or not at
    /// all.
    pub dependent: Vec<usize>,
    /// Factor of each dependent parameter in the combination of each independent parameter,
    /// \[independent × dependent\].
    pub combination: Vec<Vec<f64>>,
}

impl BaseParameters {
    /// Finds the base parameters from the torque columns of random states.
    ///
    /// Columns are accepted in this order: links from the base to the tips, constant torques, rotors.
    /// It gives short combinations, and the same combinations in every run. The constant torque of a
    /// sliding joint that lifts its link is combined with the rotor, because the mass of the link
    /// shows by its weight and by its inertia.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if the memory did not fit the chain; this is not expected.
    ///
    /// # Source
    ///
    /// Gautier's numerical method by QR, with a fixed order instead of pivoting.
    pub fn new(candidates: &Candidates<'_>) -> Result<Self, LengthError> {
        let columns = random_columns(candidates)?;
        let length = |v: &[f64]| dot(v, v).sqrt();
        let longest = columns.iter().map(|c| length(c)).fold(0.0, f64::max);
        let limit = TOLERANCE * (columns.len() as f64).sqrt();

        let mut basis: Vec<Vec<f64>> = Vec::new();
        // Components of the accepted columns on the basis, a triangular matrix.
        let mut triangle: Vec<Vec<f64>> = Vec::new();
        let mut base = Self {
            independent: Vec::new(),
            dependent: Vec::new(),
            combination: Vec::new(),
        };
        let mut shares: Vec<Vec<f64>> = Vec::new();
        let n = candidates.rigid.len();
        let (links, rotors) = (n * BODY, n * BODY + n);
        for index in (0..links).chain(rotors..rotors + n).chain(links..rotors) {
            let column = &columns[index];
            if candidates.known.contains(&index) || column.is_empty() {
                continue;
            }
            let (components, rest) = project(column, &basis);
            let whole = length(column);
            if whole > TOLERANCE * longest && length(&rest) > limit * whole {
                let size = length(&rest);
                basis.push(rest.iter().map(|x| x / size).collect());
                let mut components = components;
                components.push(size);
                triangle.push(components);
                base.independent.push(index);
            } else {
                base.dependent.push(index);
                shares.push(if whole > TOLERANCE * longest {
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

    /// Returns whether a base parameter is a single standard parameter.
    #[must_use]
    pub fn is_alone(&self, base: usize) -> bool {
        (self.combination[base].iter()).all(|share| *share == 0.0)
    }

    /// Returns the values of the base parameters.
    ///
    /// - `standard`: inertial parameters of all links, \[10n\].
    #[must_use]
    pub fn values(&self, standard: &[f64]) -> Vec<f64> {
        (self.independent.iter().zip(&self.combination))
            .map(|(&index, shares)| {
                let others = self.dependent.iter().zip(shares);
                standard[index] + others.map(|(&k, share)| share * standard[k]).sum::<f64>()
            })
            .collect()
    }

    /// Returns a base parameter in words, as in `link1.izz + 0.1176*link2.m`.
    ///
    /// - `name`: returns the name of an inertial parameter from its index.
    #[must_use]
    pub fn words(&self, base: usize, name: impl Fn(usize) -> String) -> String {
        let mut words = name(self.independent[base]);
        for (&k, &share) in self.dependent.iter().zip(&self.combination[base]) {
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
    }
}

/// Formats a number with four significant digits and no trailing zeros.
fn digits(value: f64) -> String {
    let decimals = (3 - value.log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// Returns the components on an orthonormal basis and the remainder. The second projection removes
/// the round-off of the first.
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

/// Solves for the combination of accepted columns with these components.
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

/// Returns the torque columns of random states, one vector per parameter. The vector is empty for
/// the rotor of a flexible joint and for a torque without an unknown constant.
fn random_columns(candidates: &Candidates<'_>) -> Result<Vec<Vec<f64>>, LengthError> {
    let chain = &candidates.chain;
    let n = chain.joints().len();
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut scratch = Scratch::new(n);
    let width = n * BODY;
    let mut rows = vec![0.0; n * width];
    let mut columns = vec![Vec::with_capacity(RANDOM_STATES * n); width + 2 * n];
    for _ in 0..RANDOM_STATES {
        let mut draw = || -> Vec<f64> {
            (0..n)
                .map(|_| STATE_LIMIT * (2.0 * rng.random::<f64>() - 1.0))
                .collect()
        };
        let (q, dq, ddq) = (draw(), draw(), draw());
        torque(chain, &q, &dq, &ddq, &mut scratch.workspace(), &mut rows)?;
        for row in rows.chunks(width) {
            for (column, entry) in columns.iter_mut().zip(row) {
                column.push(*entry);
            }
        }
        let ratio = |motor: usize, joint: usize| match candidates.coupling {
            Some(ratios) => ratios[motor * n + joint],
            None => f64::from(u8::from(motor == joint)),
        };
        for motor in (0..n).filter(|motor| candidates.rigid[*motor]) {
            let turns: f64 = (0..n).map(|k| ratio(motor, k) * ddq[k]).sum();
            columns[width + motor].extend((0..n).map(|row| ratio(motor, row) * turns));
        }
        for motor in (0..n).filter(|motor| candidates.offset[*motor]) {
            columns[width + n + motor].extend((0..n).map(|row| ratio(motor, row)));
        }
    }
    Ok(columns)
}

#[cfg(test)]
mod tests {
    use sprung_core::chain::{ChainJoint, DhRow, JointKind};
    use sprung_core::spatial::BODY_NAMES;

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

    fn base(joints: &[ChainJoint], gravity: [f64; 3], known: &[usize]) -> BaseParameters {
        let candidates = Candidates {
            chain: Chain::new(joints, gravity).unwrap(),
            coupling: None,
            rigid: &vec![false; joints.len()],
            offset: &vec![false; joints.len()],
            known,
        };
        BaseParameters::new(&candidates).unwrap()
    }

    fn count(joints: &[ChainJoint], gravity: [f64; 3]) -> usize {
        base(joints, gravity, &[]).independent.len()
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
        // Angles with five digits do not increase the number of base parameters.
        let five = (HALF * 1e4).round() / 1e4;
        let rounded = classic(&[
            row(five, 0.0, 0.089_159),
            row(0.0, -0.425, 0.0),
            row(0.0, -0.392_25, 0.0),
            row(five, 0.0, 0.109_15),
            row(-five, 0.0, 0.094_65),
            row(0.0, 0.0, 0.0823),
        ]);
        assert_eq!(count(&rounded, DOWN), 36);
    }

    #[test]
    fn groupings_have_the_usual_form() {
        let planar = modified(&[row(0.0, 0.0, 0.0), row(0.0, 0.343, 0.0)]);
        let name = |k: usize| format!("link{}.{}", k / BODY + 1, BODY_NAMES[k % BODY]);
        let found = base(&planar, DOWN, &[]);
        let words: Vec<String> = (0..4).map(|i| found.words(i, name)).collect();
        assert_eq!(
            words,
            [
                "link1.izz + 0.1176*link2.m",
                "link2.mx",
                "link2.my",
                "link2.izz"
            ]
        );
        // The paper's three parameters assume a symmetric link 2.
        let my2 = BODY + 2;
        let found = base(&planar, DOWN, &[my2]);
        assert_eq!(found.independent, [9, 11, 19]);
        assert!(!found.dependent.contains(&my2));
    }

    #[test]
    fn the_rotor_of_a_lift_is_combined_with_its_mass_and_the_constant_torque_of_its_motor() {
        let lift = [ChainJoint {
            kind: JointKind::Prismatic,
            ..modified(&[row(0.0, 0.0, 0.0)])[0]
        }];
        let name = |k: usize| match k {
            0 => "m".to_owned(),
            10 => "rotor".to_owned(),
            11 => "offset".to_owned(),
            _ => format!("{k}"),
        };
        let words = |gravity: [f64; 3], offset: bool| -> Vec<String> {
            let candidates = Candidates {
                chain: Chain::new(&lift, gravity).unwrap(),
                coupling: None,
                rigid: &[true],
                offset: &[offset],
                known: &[],
            };
            let base = BaseParameters::new(&candidates).unwrap();
            (0..base.independent.len())
                .map(|i| base.words(i, name))
                .collect()
        };
        assert_eq!(words(DOWN, true), ["m + rotor", "offset - 9.81*rotor"]);
        assert_eq!(words(DOWN, false), ["m", "rotor"]);
        assert_eq!(words([0.0; 3], true), ["m + rotor", "offset"]);
    }

    #[test]
    fn base_parameters_give_the_torque_of_all_parameters() {
        let arm = classic(&[
            row(HALF, 0.1, 0.4),
            row(0.3, -0.4, 0.0),
            row(-HALF, 0.2, 0.1),
            row(HALF, 0.0, 0.3),
        ]);
        let rigid = [false, true, true, false];
        let mut coupling = [0.0; 16];
        (0..4).for_each(|i| coupling[5 * i] = 1.0);
        coupling[9] = 0.7;
        let candidates = Candidates {
            chain: Chain::new(&arm, TILTED).unwrap(),
            coupling: Some(&coupling),
            rigid: &rigid,
            offset: &rigid,
            known: &[],
        };
        let base = BaseParameters::new(&candidates).unwrap();
        let standard: Vec<f64> = (0..4 * BODY + 8)
            .map(|k| (k as f64 * 0.7).sin() + 1.2)
            .collect();
        let values = base.values(&standard);
        let columns = random_columns(&candidates).unwrap();
        for state in 0..columns[0].len() {
            let all: f64 = columns
                .iter()
                .zip(&standard)
                .filter_map(|(c, x)| Some(c.get(state)? * x))
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
