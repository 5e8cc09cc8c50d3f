//! The rows of the regression with a column for each unknown.
//!
//! A flexible joint has two rows, both with the motor torque on the right: the equation of the motor, and the sum of the equations
//! of motor and link. The equation of the link alone has no right-hand side, so a fault could shrink all its parameters.

use std::collections::{BTreeMap, BTreeSet};

use faer::Mat;
use rayon::prelude::*;
use sprung_core::drives::{Drive, Term};
use sprung_core::dynamics::momentum_and_rest;
use sprung_core::filter::{Discretization, FilterBank, FilterPair, FilterState, bank_len};
use sprung_core::friction::Scale;
use sprung_core::parameters::JointParameter;
use sprung_core::spatial::BODY;

use super::sliding::{Sliding, state_of};
use super::unknown::{Effect, JointScales, LawColumn, MotorSample, Place, Unknown};
use crate::description::RightHandSide;
use crate::model::{Model, Scratch};
use crate::preprocess::SignalBlock;
use crate::regression::Reading;

/// Relative weight of a sample whose filtered Coulomb friction passes a reversal: the filter of the positions smears it.
const REVERSAL_WEIGHT: f64 = 0.05;

/// Argument of `tanh(beta v)` up to which a sample belongs to a reversal.
const REVERSAL_ARGUMENT: f64 = 3.0;

/// Step of a state for its derivative, relative to the root mean square of the state.
const STATE_STEP: f64 = 1e-5;

/// Time constants of the filter of rows after which a reversal has no effect.
const TAIL: f64 = 3.0;

/// Returns the cut-off of the filter of rows, rad/s: that of the positions and torques, which removes the noise. A slower filter would
/// carry the error of a reversal over more samples.
pub(super) fn row_cutoff(reading: &Reading) -> f64 {
    std::f64::consts::TAU * reading.position_cutoff_hz()
}

/// One row, and the rows of the model of which it is the sum.
#[derive(Clone, Debug)]
pub(super) struct RowOf {
    pub(super) joint: usize,
    of_model: Vec<usize>,
    /// Joint of the motor torque on its right-hand side, and of the torque sensor with its sign.
    motor: Option<usize>,
    spring: Option<(usize, f64)>,
    /// Whether it contains the torque between motor and link.
    pub(super) has_spring: bool,
    /// Whether it contains the link.
    has_link: bool,
    /// Free parameters, as indices in theta.
    pub(super) columns: Vec<usize>,
}

impl RowOf {
    /// Returns the rows of a model.
    pub(super) fn all(model: &Model) -> Vec<Self> {
        let mut all = Vec::new();
        for joint in 0..model.joint_count() {
            let torque = model.torque_row(joint);
            if model.is_flexible(joint) {
                all.push(Self::new(model, joint, vec![torque]));
                if model.right_hand_side(joint) == RightHandSide::Zero {
                    all.push(Self::new(model, joint, vec![joint, torque]));
                } else {
                    all.push(Self::new(model, joint, vec![joint]));
                }
            } else {
                all.push(Self::new(model, joint, vec![joint]));
            }
        }
        all
    }

    fn new(model: &Model, joint: usize, of_model: Vec<usize>) -> Self {
        let is_sum = of_model.len() > 1;
        let mut columns: Vec<usize> = of_model
            .iter()
            .flat_map(|&row| model.row_columns(row))
            .copied()
            .collect();
        columns.sort_unstable();
        columns.dedup();
        let is_of_spring = |column: usize| {
            model.parameters()[column]
                .joint
                .is_some_and(|(kind, _)| kind.is_of_spring())
        };
        columns
            .retain(|&column| model.known(column).is_none() && !(is_sum && is_of_spring(column)));
        let torques = of_model
            .iter()
            .map(|&row| model.right_hand_side(row).torques());
        let (mut motor, mut spring) = (None, None);
        for [of_motor, of_spring] in torques {
            motor = motor.or(of_motor);
            spring = spring
                .or(of_spring.map(|joint| (joint, if of_motor.is_some() { -1.0 } else { 1.0 })));
        }
        Self {
            joint,
            has_spring: !is_sum && model.is_flexible(joint) && spring.is_none(),
            has_link: of_model.contains(&joint),
            of_model,
            motor,
            spring,
            columns,
        }
    }
}

/// Signals of an unknown per unit of its size, segment by segment.
pub(super) struct Direction {
    /// Index of the unknown.
    pub(super) unknown: usize,
    /// Joints whose signals it changes.
    pub(super) joints: Vec<usize>,
    /// Changes of the signals, one block for each segment; columns that do not change are empty.
    pub(super) segments: Vec<SignalBlock>,
    pub(super) has_rate: bool,
    /// Whether it is the factor of a torque.
    pub(super) scales_torque: bool,
}

/// A row with the columns of parameters and unknowns, sample by sample.
#[derive(Clone)]
pub(super) struct Row {
    pub(super) joint: usize,
    /// Index of each column: parameters by their place among the free ones, unknowns behind them.
    pub(super) columns: Vec<usize>,
    /// Columns and right-hand side, \[samples × (columns + 1)\].
    pub(super) values: Mat<f64>,
    /// Relative weights of samples.
    pub(super) reliable: Vec<f64>,
}

/// What forms the rows of one state of a log.
pub(super) struct Rows<'a> {
    pub(super) model: &'a Model,
    pub(super) reading: &'a Reading,
    pub(super) period: f64,
    /// First time of the log and its duration, s.
    pub(super) span: [f64; 2],
    pub(super) all: &'a [RowOf],
    /// Place of each parameter among the free ones.
    pub(super) places: &'a BTreeMap<usize, usize>,
    /// Samples at the ends of segments that are left out.
    pub(super) edge: usize,
    pub(super) wanted: Wanted<'a>,
}

/// The unknowns whose columns are formed; those of given directions always are.
#[derive(Clone, Copy)]
pub(super) enum Wanted<'a> {
    All,
    These(&'a [usize]),
}

impl Wanted<'_> {
    pub(super) fn contains(self, unknown: usize) -> bool {
        match self {
            Self::All => true,
            Self::These(these) => these.contains(&unknown),
        }
    }
}

/// Derivatives of a row by the position and velocity of links and motors at one sample.
struct Slopes {
    // [model rows × 4 n], of momentum and rest; then momentum and rest of each row.
    momentum: Vec<f64>,
    rest: Vec<f64>,
}

/// The regressor of one sample with its slopes.
struct Sampled {
    momentum: Vec<f64>,
    rest: Vec<f64>,
    drives: Vec<Drive>,
    slopes: Slopes,
    // Rest of each row by each change of gravity, \[changes × model rows\].
    by_gravity: Vec<f64>,
}

/// One row of a segment, as [`Row`] has it.
struct RowOfSegment {
    columns: Vec<usize>,
    values: Vec<f64>,
    reliable: Vec<f64>,
}

impl Rows<'_> {
    /// Forms all rows.
    ///
    /// - `directions`: of unknowns of channels.
    /// - `theta`: present parameters, \[p\].
    pub(super) fn form(
        &self,
        segments: &[SignalBlock],
        theta: &[f64],
        unknowns: &[Unknown],
        directions: &[Direction],
    ) -> Option<Vec<Row>> {
        let cutoff = row_cutoff(self.reading);
        let entries = FilterPair::new(cutoff, self.period, Discretization::Tustin).ok()?;
        let scales = self.scales(segments);
        let steps = self.steps(segments, directions);
        let gravities = self.gravities(unknowns);
        let parts: Vec<Vec<RowOfSegment>> = (segments.iter().enumerate())
            .map(|(s, signals)| {
                let segment = Sliding::new(self.model, signals);
                let sampled = self.sampled(&segment, theta, &steps, &gravities);
                (self.all.par_iter())
                    .map(|row| {
                        self.form_row(
                            row,
                            (s, &segment),
                            &sampled,
                            theta,
                            (unknowns, directions),
                            &scales,
                            &entries,
                        )
                    })
                    .collect()
            })
            .collect();
        let rows = (self.all.iter().enumerate()).map(|(r, row)| {
            let columns = parts.first()?[r].columns.clone();
            let width = columns.len() + 1;
            let values: Vec<f64> = parts
                .iter()
                .flat_map(|segment| segment[r].values.iter().copied())
                .collect();
            let reliable: Vec<f64> = parts
                .iter()
                .flat_map(|segment| segment[r].reliable.iter().copied())
                .collect();
            let samples = values.len() / width;
            Some(Row {
                joint: row.joint,
                columns,
                values: Mat::from_fn(samples, width, |i, j| values[i * width + j]),
                reliable,
            })
        });
        rows.collect()
    }

    /// Returns the scales of all joints.
    pub(super) fn scales(&self, segments: &[SignalBlock]) -> Vec<JointScales> {
        let rms = |of: &dyn Fn(&SignalBlock, usize) -> f64, mean: f64| {
            let all = segments
                .iter()
                .flat_map(|s| (0..s.len()).map(move |k| (s, k)));
            let (mut sum, mut count) = (0.0, 0.0);
            for (s, k) in all {
                sum += (of(s, k) - mean).powi(2);
                count += 1.0;
            }
            f64::sqrt(sum / f64::max(count, 1.0)).max(f64::MIN_POSITIVE.sqrt())
        };
        (0..self.model.joint_count())
            .map(|j| {
                let deflection = |s: &SignalBlock, k: usize| s.phi[j][k] - s.q[j][k];
                let all: f64 = segments
                    .iter()
                    .map(|s| (0..s.len()).map(|k| deflection(s, k)).sum::<f64>())
                    .sum();
                let mean = all / segments.iter().map(SignalBlock::len).sum::<usize>().max(1) as f64;
                JointScales {
                    sharpness: self.model.sharpness(j),
                    deflection: rms(&deflection, mean),
                    torque: rms(&|s, k| s.tau[j][k], 0.0),
                }
            })
            .collect()
    }

    /// Returns the states that some directions change, with their steps for derivatives.
    fn steps(&self, segments: &[SignalBlock], directions: &[Direction]) -> Vec<(usize, f64)> {
        let n = self.model.joint_count();
        let changed: BTreeSet<usize> = (directions.iter())
            .flat_map(|direction| (0..segments.len()).map(move |segment| (direction, segment)))
            .flat_map(|(direction, segment)| self.changed(direction, segment))
            .map(|(at, _)| at)
            .collect();
        let step = |at: usize| {
            let of = |s: &SignalBlock| [&s.q, &s.dq, &s.phi, &s.dphi][at / n][at % n].clone();
            let all: Vec<f64> = segments.iter().flat_map(of).collect();
            let squares = all.iter().map(|x| x * x).sum::<f64>();
            STATE_STEP * (squares / all.len().max(1) as f64).sqrt().max(1e-3)
        };
        changed.into_iter().map(|at| (at, step(at))).collect()
    }

    /// Returns the regressor and the slopes of all samples of a segment.
    fn sampled(
        &self,
        segment: &Sliding<'_>,
        theta: &[f64],
        steps: &[(usize, f64)],
        gravities: &[Model],
    ) -> Vec<Sampled> {
        let n = self.model.joint_count();
        let count = self.model.entries();
        let robot = self.model.robot();
        let bodies = self.model.bodies(theta);
        (0..segment.signals.len())
            .into_par_iter()
            .map_init(
                || (Scratch::new(n), vec![0.0; count], vec![0.0; count]),
                |(scratch, moved, moved_rest), k| {
                    let mut state = segment.state_at(k);
                    let rows = self.model.rows();
                    let (mut momentum, mut rest) = (vec![0.0; count], vec![0.0; count]);
                    write_entries(self.model, (&state, scratch), &mut momentum, &mut rest);
                    let mut slopes = Slopes {
                        momentum: Vec::new(),
                        rest: Vec::new(),
                    };
                    if !steps.is_empty() {
                        slopes.momentum.resize(rows * 4 * n, 0.0);
                        slopes.rest.resize(rows * 4 * n, 0.0);
                        let links = self.of_links(&bodies, &state, scratch);
                        let before: Vec<[f64; 2]> = (0..rows)
                            .map(|row| self.sums(row, theta, &momentum, &rest))
                            .collect();
                        moved.copy_from_slice(&momentum);
                        moved_rest.copy_from_slice(&rest);
                        for &(at, step) in steps {
                            let kept = state[at];
                            state[at] += step;
                            self.drives(&state, scratch, moved, moved_rest);
                            // Motors move only drives.
                            let moved_links =
                                (at < 2 * n).then(|| self.of_links(&bodies, &state, scratch));
                            state[at] = kept;
                            for (row, before) in before.iter().enumerate() {
                                let mut after = self.sums(row, theta, moved, moved_rest);
                                if let Some(moved) = moved_links.as_ref().filter(|_| row < n) {
                                    after[0] += moved[0][row] - links[0][row];
                                    after[1] += moved[1][row] - links[1][row];
                                }
                                slopes.momentum[row * 4 * n + at] = (after[0] - before[0]) / step;
                                slopes.rest[row * 4 * n + at] = (after[1] - before[1]) / step;
                            }
                        }
                    }
                    let mut by_gravity = Vec::with_capacity(gravities.len() * rows);
                    for gravity in gravities {
                        write_entries(gravity, (&state, scratch), moved, moved_rest);
                        by_gravity.extend((0..rows).map(|row| {
                            self.sums(row, theta, &momentum, moved_rest)[1]
                                - self.sums(row, theta, &momentum, &rest)[1]
                        }));
                    }
                    let state = state_of(&state, n);
                    Sampled {
                        momentum,
                        rest,
                        drives: (0..n).map(|joint| robot.drive(&state, joint)).collect(),
                        slopes,
                        by_gravity,
                    }
                },
            )
            .collect()
    }

    /// Returns the model with each change of gravity that is wanted, in the order of the unknowns.
    fn gravities(&self, unknowns: &[Unknown]) -> Vec<Model> {
        let wanted = (unknowns.iter().enumerate()).filter(|(at, _)| self.wanted.contains(*at));
        let changed = |unknown: &Unknown| match unknown.effect {
            Effect::Gravity(by) => {
                let gravity = self.model.gravity();
                let gravity = std::array::from_fn(|axis| gravity[axis] + by[axis]);
                Some(self.model.clone().with_gravity(gravity))
            }
            _ => None,
        };
        wanted.filter_map(|(_, unknown)| changed(unknown)).collect()
    }

    /// Returns the momenta of the links, and the rest of their rows, \[n\] each.
    fn of_links(
        &self,
        bodies: &[[f64; BODY]],
        state: &[f64],
        scratch: &mut Scratch,
    ) -> [Vec<f64>; 2] {
        let n = self.model.joint_count();
        let [mut momentum, mut rest] = [vec![f64::NAN; n], vec![f64::NAN; n]];
        // The lengths fit.
        let _ = momentum_and_rest(
            &self.model.regressor().links.chain,
            bodies,
            [&state[..n], &state[n..2 * n]],
            scratch.workspace().steps,
            [&mut momentum, &mut rest],
        );
        [momentum, rest]
    }

    /// Writes the entries of the drives of a state.
    fn drives(&self, state: &[f64], scratch: &mut Scratch, momentum: &mut [f64], rest: &mut [f64]) {
        let state = state_of(state, self.model.joint_count());
        let robot = self.model.regressor();
        if (robot.drives(&state, &mut scratch.workspace(), momentum, rest)).is_err() {
            momentum.fill(f64::NAN);
        }
    }

    /// Returns the momentum and the rest of a row of the model.
    fn sums(&self, row: usize, theta: &[f64], momentum: &[f64], rest: &[f64]) -> [f64; 2] {
        let range = self.model.row_entries(row);
        let columns = self.model.row_columns(row);
        [momentum, rest].map(|all| {
            (all[range.clone()].iter().zip(columns))
                .map(|(entry, &column)| entry * theta[column])
                .sum()
        })
    }

    /// Adds the entries of the free parameters of a row; returns momentum and rest of those with a known value.
    fn write_parameters(
        &self,
        row: &RowOf,
        sample: &Sampled,
        theta: &[f64],
        [momentum, rest]: [&mut [f64]; 2],
    ) -> [f64; 2] {
        let mut known = [0.0; 2];
        for &of in &row.of_model {
            let range = self.model.row_entries(of);
            for (entry, &column) in range.zip(self.model.row_columns(of)) {
                let (of_momentum, of_rest) = (sample.momentum[entry], sample.rest[entry]);
                if let Ok(at) = row.columns.binary_search(&column) {
                    momentum[at] += of_momentum;
                    rest[at] += of_rest;
                } else if self.model.known(column).is_some() {
                    known[0] += theta[column] * of_momentum;
                    known[1] += theta[column] * of_rest;
                }
            }
        }
        known
    }

    /// Returns the signals of a segment that a direction changes, each with its place among the slopes of a row.
    fn changed<'d>(&self, direction: &'d Direction, segment: usize) -> Vec<(usize, &'d [f64])> {
        let n = self.model.joint_count();
        let of = &direction.segments[segment];
        let of_joint = |joint: usize| {
            let rates = [&of.dq, &of.dphi].map(|columns| &columns[joint][..]);
            let [dq, dphi] = rates.map(|rate| if direction.has_rate { rate } else { &[] });
            let columns = [&of.q[joint][..], dq, &of.phi[joint][..], dphi];
            (columns.into_iter().enumerate()).map(move |(kind, column)| (kind * n + joint, column))
        };
        let all = direction.joints.iter().flat_map(|&joint| of_joint(joint));
        all.filter(|(_, column)| !column.is_empty()).collect()
    }

    /// Returns the change of momentum and rest of a row per unit of an unknown, at one sample.
    ///
    /// - `changed`: the signals that change.
    fn change_of(
        &self,
        row: &RowOf,
        sample: &Sampled,
        changed: &[(usize, &[f64])],
        k: usize,
    ) -> [f64; 2] {
        let width = 4 * self.model.joint_count();
        let mut sum = [0.0; 2];
        if changed.is_empty() {
            return sum;
        }
        for &of in &row.of_model {
            let momentum = &sample.slopes.momentum[of * width..(of + 1) * width];
            let rest = &sample.slopes.rest[of * width..(of + 1) * width];
            for &(at, column) in changed {
                sum[0] += momentum[at] * column[k];
                sum[1] += rest[at] * column[k];
            }
        }
        sum
    }

    /// Returns momentum and rest of a change of parameters in a row.
    fn change_by(&self, row: &RowOf, sample: &Sampled, by: &[f64]) -> [f64; 2] {
        (row.of_model.iter()).fold([0.0; 2], |sum, &of| {
            let more = self.sums(of, by, &sample.momentum, &sample.rest);
            [sum[0] + more[0], sum[1] + more[1]]
        })
    }

    /// Writes momentum and rest of changes of parameters and of gravity in a row at one sample, per unit of their sizes.
    fn write_changes(
        &self,
        row: &RowOf,
        sample: &Sampled,
        unknowns: &[(usize, &Unknown)],
        [momentum, rest]: [&mut [f64]; 2],
    ) {
        let mut by_gravity = sample.by_gravity.chunks(self.model.rows());
        for (i, (_, unknown)) in unknowns.iter().enumerate() {
            match &unknown.effect {
                Effect::Parameters(by) => {
                    [momentum[i], rest[i]] = self.change_by(row, sample, by);
                }
                Effect::Gravity(_) => {
                    let rests = by_gravity.next().unwrap_or_default();
                    rest[i] = row.of_model.iter().map(|&of| rests[of]).sum();
                }
                Effect::Channels(..) | Effect::Law { .. } | Effect::Sharpness(_) => {}
            }
        }
    }

    /// Writes the torques of laws and of sharpnesses in a row at one sample, per unit of their sizes.
    fn write_torques<'u>(
        &self,
        (row, unknowns): (&RowOf, impl Iterator<Item = &'u Unknown>),
        (signals, k): (&SignalBlock, usize),
        sample: &Sampled,
        (theta, scales): (&[f64], &[JointScales]),
        torques: &mut [f64],
    ) {
        let drives = &sample.drives;
        let [begin, duration] = self.span;
        let motor = MotorSample {
            share: (signals.time[k] - begin) / duration.max(f64::MIN_POSITIVE),
            period: 0.0,
            position: signals.phi[row.joint][k],
            velocity: signals.dphi[row.joint][k],
            torque: signals.tau[row.joint][k],
            scales: &scales[row.joint],
        };
        for (torque, unknown) in torques.iter_mut().zip(unknowns) {
            *torque = match &unknown.effect {
                Effect::Law {
                    column: LawColumn::Terms(terms),
                    ..
                } => (terms.iter())
                    .filter(|(term, _)| row.of_model.contains(&term.row))
                    .map(|(term, shape)| term.rest(&drives[term.joint], shape))
                    .sum(),
                Effect::Law {
                    column: LawColumn::Motor(of_motor),
                    ..
                } => of_motor.at(&motor),
                Effect::Law {
                    column: LawColumn::Gear(of_gear),
                    ..
                } => {
                    let stiffness = self.model.index(JointParameter::Stiffness, row.joint);
                    stiffness.map_or(0.0, |at| theta[at] * of_gear.at(&motor))
                }
                Effect::Sharpness(joint) => (self.terms_of(row, *joint))
                    .map(|term| {
                        let shape = self.model.shape(term.joint);
                        let by_log = term.by_log(Scale::Sharpness, &drives[term.joint], shape);
                        theta[term.column] * by_log
                    })
                    .sum(),
                Effect::Channels(..) | Effect::Parameters(_) | Effect::Gravity(_) => 0.0,
            };
        }
    }

    /// Forms one row of a segment; returns its columns, its values and the reliability of its samples.
    #[expect(
        clippy::too_many_arguments,
        reason = "a private function that two lines call"
    )]
    fn form_row(
        &self,
        row: &RowOf,
        (index, segment): (usize, &Sliding<'_>),
        sampled: &[Sampled],
        theta: &[f64],
        (unknowns, directions): (&[Unknown], &[Direction]),
        scales: &[JointScales],
        entries: &FilterPair,
    ) -> RowOfSegment {
        let signals = segment.signals;
        let base = row.columns.len();
        let acting: Vec<&Direction> = directions
            .iter()
            .filter(|direction| self.acts(row, direction))
            .collect();
        let changed: Vec<Vec<(usize, &[f64])>> = (acting.iter())
            .map(|direction| self.changed(direction, index))
            .collect();
        let laws: Vec<(usize, &Unknown)> = (unknowns.iter().enumerate())
            .filter(|(at, unknown)| self.wanted.contains(*at) && self.is_torque_of(row, unknown))
            .collect();
        let width = base + acting.len() + laws.len();
        let mut columns: Vec<usize> = row
            .columns
            .iter()
            .map(|column| self.places[column])
            .collect();
        let free = self.places.len();
        columns.extend(acting.iter().map(|direction| free + direction.unknown));
        columns.extend(laws.iter().map(|(unknown, _)| free + unknown));
        let mut bank = FilterBank::new(vec![0.0; bank_len(width)]);
        let mut torques = vec![FilterState::default(); acting.len()];
        let (mut of_rhs, mut of_known) = (FilterState::default(), FilterState::default());
        let (mut momentum, mut rest) = (vec![0.0; width], vec![0.0; width]);
        let samples = signals.len();
        let mut values = Vec::with_capacity((width + 1) * samples);
        let mut kept = Vec::new();
        for (k, sample) in sampled.iter().enumerate() {
            momentum.fill(0.0);
            rest.fill(0.0);
            let known = self.write_parameters(row, sample, theta, [&mut momentum, &mut rest]);
            for (i, (direction, changed)) in acting.iter().zip(&changed).enumerate() {
                let change = self.change_of(row, sample, changed, k);
                [momentum[base + i], rest[base + i]] = change;
                if !direction.has_rate {
                    momentum[base + i] = 0.0;
                }
            }
            if !laws.is_empty() {
                let unknowns = laws.iter().map(|(_, unknown)| *unknown);
                let torques = &mut rest[base + acting.len()..];
                self.write_torques(
                    (row, unknowns),
                    (signals, k),
                    sample,
                    (theta, scales),
                    torques,
                );
                let at = base + acting.len();
                self.write_changes(row, sample, &laws, [&mut momentum[at..], &mut rest[at..]]);
            }
            let filtered = bank.process(entries, &momentum, &rest);
            let of_known = entries.process(&mut of_known, known[0], known[1]);
            let is_kept = k >= self.edge && k + self.edge < samples;
            let from = values.len();
            if is_kept {
                values.extend_from_slice(filtered);
            }
            if is_kept {
                // The factor of a torque is judged by what the model says of it: its readings would vanish with their errors.
                let predicted: f64 = row
                    .columns
                    .iter()
                    .zip(&values[from..])
                    .map(|(&column, entry)| theta[column] * entry)
                    .sum();
                for i in (0..acting.len()).filter(|&i| acting[i].scales_torque) {
                    values[from + base + i] = -predicted - of_known;
                }
            }
            for (i, direction) in acting
                .iter()
                .enumerate()
                .filter(|(_, direction)| !direction.scales_torque)
            {
                let change = &direction.segments[index];
                if let Some(motor) = row.motor.filter(|&motor| !change.tau[motor].is_empty()) {
                    let by = entries.process(&mut torques[i], 0.0, change.tau[motor][k]);
                    if is_kept {
                        values[from + base + i] -= by;
                    }
                }
            }
            let mut rhs = row.motor.map_or(0.0, |motor| signals.tau[motor][k]);
            if let Some((joint, sign)) = row.spring {
                rhs += sign * signals.spring[joint].get(k).copied().unwrap_or_default();
            }
            let rhs = entries.process(&mut of_rhs, -known[0], rhs - known[1]);
            if is_kept {
                values.push(rhs);
                kept.push(k);
            }
        }
        let reliable = self.reliable(row, signals, &kept);
        RowOfSegment {
            columns,
            values,
            reliable,
        }
    }

    fn acts(&self, row: &RowOf, direction: &Direction) -> bool {
        let is_torque = direction.segments.iter().any(|segment| {
            segment
                .tau
                .iter()
                .any(|column| column.iter().any(|x| *x != 0.0))
        });
        if is_torque {
            return row
                .motor
                .is_some_and(|motor| direction.joints.contains(&motor));
        }
        let moves_links = || {
            direction
                .segments
                .iter()
                .any(|segment| (segment.q.iter().flatten()).any(|change| *change != 0.0))
        };
        direction.joints.contains(&row.joint)
            || self.model.robot().coupling.is_some()
            || row.has_link && moves_links()
    }

    /// Returns the terms of the friction of a joint in a row that have a sharpness.
    fn terms_of(&self, row: &RowOf, joint: usize) -> impl Iterator<Item = &Term> {
        self.model.robot().terms.iter().filter(move |term| {
            term.joint == joint
                && row.of_model.contains(&term.row)
                && matches!(term.what, JointParameter::Friction(..))
        })
    }

    fn is_torque_of(&self, row: &RowOf, unknown: &Unknown) -> bool {
        let (column, added) = match &unknown.effect {
            Effect::Channels(..) => return false,
            Effect::Gravity(_) => return row.motor.is_some() && row.has_link,
            Effect::Parameters(by) => {
                let mut columns = (row.of_model.iter()).flat_map(|&of| self.model.row_columns(of));
                return columns.any(|&column| by[column] != 0.0);
            }
            Effect::Sharpness(joint) => {
                return row.motor.is_some() && self.terms_of(row, *joint).next().is_some();
            }
            Effect::Law { column, added } => (column, added),
        };
        // A torque between motor and link is not in the sum of their equations.
        let is_of_spring = matches!(column, LawColumn::Gear(_))
            || added.as_ref().is_some_and(|added| added.of == "spring");
        let has = match column {
            LawColumn::Terms(terms) => {
                (terms.iter()).any(|(term, _)| row.of_model.contains(&term.row))
            }
            LawColumn::Motor(_) | LawColumn::Gear(_) => unknown.place == Place::Joint(row.joint),
        };
        has && row.motor.is_some() && (!is_of_spring || row.has_spring)
    }

    /// Returns the relative weights of some samples: small near reversals of a velocity in the row.
    fn reliable(&self, row: &RowOf, signals: &SignalBlock, kept: &[usize]) -> Vec<f64> {
        let half = 1.0 / self.reading.position_cutoff_hz();
        let before = (half / self.period).ceil() as usize;
        let behind = ((half + TAIL / row_cutoff(self.reading)) / self.period).ceil() as usize;
        let mut near = vec![false; signals.len()];
        let mut mark = |velocity: &[f64]| {
            let rms =
                (velocity.iter().map(|v| v * v).sum::<f64>() / velocity.len().max(1) as f64).sqrt();
            let sharpness = self.model.sharpness(row.joint);
            for k in 0..velocity.len() {
                let reverses = k > 0 && velocity[k] * velocity[k - 1] < 0.0;
                let is_slow = sharpness * rms > REVERSAL_ARGUMENT
                    && sharpness * velocity[k].abs() < REVERSAL_ARGUMENT;
                if reverses || is_slow {
                    let to = (k + behind + 1).min(near.len());
                    near[k.saturating_sub(before)..to].fill(true);
                }
            }
        };
        mark(&signals.dphi[row.joint]);
        if row.has_link {
            mark(&signals.dq[row.joint]);
        }
        kept.iter()
            .map(|&k| if near[k] { REVERSAL_WEIGHT } else { 1.0 })
            .collect()
    }
}

/// Writes the regressor of a state.
fn write_entries(
    model: &Model,
    (state, scratch): (&[f64], &mut Scratch),
    momentum: &mut [f64],
    rest: &mut [f64],
) {
    let state = state_of(state, model.joint_count());
    let written = (model.regressor()).regressor(&state, &mut scratch.workspace(), momentum, rest);
    if written.is_err() {
        momentum.fill(f64::NAN);
    }
}
