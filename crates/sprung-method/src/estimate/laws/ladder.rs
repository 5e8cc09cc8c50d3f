//! The ladder of laws: one change at a time, the change with the largest held-out gain.

use super::candidates::{Candidate, Tier};
use super::normal::{Fits, Normal};
use crate::estimate::statistics::{MAX_ITERATIONS, NEGLIGIBLE_SHARE, SIGNIFICANT_SIGMAS};

/// Least gain in the link row alone. The row contains no measured torque, and the steps of two
/// encoders leave an offset in it.
const MIN_LINK_GAIN: f64 = 0.2;

/// Least torque of a change, as a fraction of the joint's torque, and least part of it that no other law explains. On a
/// log without noise even the smearing of the filters adds laws.
const LEAST_TORQUE_SHARE: f64 = 0.01;
const LEAST_OWN_SHARE: f64 = 0.002;

/// Two changes are equivalent if the second one gains at least this fraction of the first, less by at most
/// [`SIGNIFICANT_SIGMAS`] standard deviations of the difference, and less than [`NEGLIGIBLE_SHARE`] after it.
const ALIKE_SHARE: f64 = 0.8;

/// One change.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rung {
    /// Index of the candidate.
    pub(super) candidate: usize,
    /// Decrease of the held-out residual of the joint's rows, as a fraction.
    pub(super) gain: f64,
    /// Standard deviation of the gain over the parts of the log.
    pub(super) scatter: f64,
    /// Held-out residual of the torque rows relative to the torque, with the change.
    pub(super) held_out: f64,
    /// Velocity of Stribeck friction with the largest gain, rad/s (m/s).
    pub(super) stribeck_velocity: Option<f64>,
    /// Candidates that explain the same.
    pub(super) alike: Vec<usize>,
}

/// Gain of a candidate: sum over the parts of the decrease of the squared residual of its joint's
/// rows, as a fraction of this residual.
struct Gain {
    candidate: usize,
    of_squares: f64,
    scatter: f64,
    of_parts: Vec<f64>,
    /// Whether the gain is large enough in one of the rows, and the torque of the change is large enough beside the joint's torque.
    is_large: bool,
    /// Whether the change explains more than nuisances do.
    beats_nuisances: bool,
}

impl Gain {
    /// - `least`: least decrease of the root mean square.
    fn counts(&self, least: f64) -> bool {
        self.beats_nuisances && self.is_clear(least)
    }

    /// Returns whether the gain is large and no chance.
    fn is_clear(&self, least: f64) -> bool {
        self.is_large
            && self.of_root() >= least
            && self.of_squares > SIGNIFICANT_SIGMAS * self.scatter
    }

    /// Returns whether another change gains nearly as much.
    fn is_like(&self, other: &Self) -> bool {
        let parts = self.of_parts.iter().zip(&other.of_parts);
        let less: Vec<f64> = parts.map(|(part, other)| part - other).collect();
        other.of_squares >= ALIKE_SHARE * self.of_squares
            && less.iter().sum::<f64>() <= SIGNIFICANT_SIGMAS * deviation_of_sum(&less)
    }

    /// Returns the decrease of the root mean square.
    fn of_root(&self) -> f64 {
        1.0 - (1.0 - self.of_squares).max(0.0).sqrt()
    }
}

/// The ladder with the changes that were made.
pub(super) struct Ladder<'a> {
    normal: &'a Normal,
    candidates: &'a [Candidate],
    /// Link row and torque row of each joint; equal for a rigid joint.
    rows: &'a [[usize; 2]],
    /// Unknowns of no law. A change has to gain beside them, too.
    nuisances: &'a [usize],
    fits: Fits,
    fits_with_nuisances: Fits,
    /// Unknowns of the changes that were made.
    probes: Vec<usize>,
    pub(super) rungs: Vec<Rung>,
    /// Held-out residual of the torque rows without a change, relative to the torque.
    pub(super) before: f64,
}

impl<'a> Ladder<'a> {
    /// Returns a ladder without changes; `None` if a fit fails.
    pub(super) fn new(
        normal: &'a Normal,
        (candidates, nuisances): (&'a [Candidate], &'a [usize]),
        rows: &'a [[usize; 2]],
    ) -> Option<Self> {
        let fits = normal.fit(&[])?;
        let fits_with_nuisances = normal.fit(nuisances)?;
        let mut ladder = Self {
            normal,
            candidates,
            rows,
            nuisances,
            fits,
            fits_with_nuisances,
            probes: Vec::new(),
            rungs: Vec::new(),
            before: 0.0,
        };
        ladder.before = ladder.held_out();
        Some(ladder)
    }

    /// Climbs over the candidates that `may` allows. A tier ends when none of its changes is
    /// significant.
    ///
    /// - `least`: least gain of a change.
    pub(super) fn climb(
        &mut self,
        (tiers, least): (&[Tier], f64),
        may: impl Fn(&Candidate) -> bool,
    ) {
        for tier in tiers {
            while self.rungs.len() < MAX_ITERATIONS {
                let gains = self.gains(|candidate| candidate.tier() == *tier && may(candidate));
                let best = (gains.iter().filter(|gain| gain.counts(least)))
                    .max_by(|a, b| a.of_squares.total_cmp(&b.of_squares));
                let Some(best) = best else { break };
                let velocity = self.best_velocity(best, &gains);
                let rivals = self.rivals(best, &may);
                if !self.add(best, velocity) {
                    break;
                }
                self.mark_alike(rivals);
            }
        }
    }

    /// Returns the other named laws of the joint that gain nearly as much as a change.
    fn rivals(&self, best: &Gain, may: impl Fn(&Candidate) -> bool) -> Vec<usize> {
        let chosen = &self.candidates[best.candidate];
        let gains = self.gains(|other| {
            other.joint == chosen.joint
                && other.tier() != Tier::Residual
                && !other.is_variant_of(chosen)
                && may(other)
        });
        (gains.iter().filter(|gain| gain.is_clear(NEGLIGIBLE_SHARE)))
            .filter(|gain| best.is_like(gain))
            .map(|gain| gain.candidate)
            .collect()
    }

    /// Returns the velocity of Stribeck friction with the largest gain: the vertex of a parabola
    /// through the best velocity and its two neighbours, over the logarithms of the velocities.
    fn best_velocity(&self, best: &Gain, gains: &[Gain]) -> Option<f64> {
        let chosen = &self.candidates[best.candidate];
        let velocity = chosen.stribeck_velocity?;
        let variants: Vec<(f64, f64)> = (gains.iter())
            .filter_map(|gain| {
                let other = &self.candidates[gain.candidate];
                let velocity = other.stribeck_velocity?;
                other
                    .is_variant_of(chosen)
                    .then(|| (velocity.ln(), gain.of_squares))
            })
            .collect();
        let at = variants.iter().position(|(log, _)| *log >= velocity.ln())?;
        if at == 0 || at + 1 == variants.len() {
            return Some(velocity);
        }
        let [(x0, y0), (x1, y1), (x2, y2)] = [variants[at - 1], variants[at], variants[at + 1]];
        let (before, after) = ((x1 - x0) * (y1 - y2), (x1 - x2) * (y1 - y0));
        let vertex = x1 - 0.5 * ((x1 - x0) * before - (x1 - x2) * after) / (before - after);
        let inside = vertex > x0 && vertex < x2;
        Some(if inside { vertex.exp() } else { velocity })
    }

    /// Makes a change; returns false if the fit with it fails.
    fn add(&mut self, best: &Gain, stribeck_velocity: Option<f64>) -> bool {
        let mut probes = self.probes.clone();
        probes.extend(&self.candidates[best.candidate].unknowns);
        let with_nuisances = [self.nuisances, &probes].concat();
        let fitted = (self.normal.fit(&probes)).zip(self.normal.fit(&with_nuisances));
        let Some((fits, beside)) = fitted else {
            return false;
        };
        (self.probes, self.fits, self.fits_with_nuisances) = (probes, fits, beside);
        self.rungs.push(Rung {
            candidate: best.candidate,
            gain: best.of_root(),
            scatter: 0.5 * best.scatter,
            held_out: self.held_out(),
            stribeck_velocity,
            alike: Vec::new(),
        });
        true
    }

    /// Records the rivals of the last change that have no gain after it.
    fn mark_alike(&mut self, mut rivals: Vec<usize>) {
        rivals.retain(|&rival| {
            let rest = self.gain(rival, &self.candidates[rival]);
            rest.is_none_or(|rest| rest.of_root() < NEGLIGIBLE_SHARE)
        });
        if let Some(rung) = self.rungs.last_mut() {
            rung.alike = rivals;
        }
    }

    /// Returns the gains of all candidates that are allowed and not yet chosen.
    fn gains(&self, may: impl Fn(&Candidate) -> bool) -> Vec<Gain> {
        (self.candidates.iter().enumerate())
            .filter(|(_, candidate)| may(candidate) && !self.has(candidate))
            .filter_map(|(index, candidate)| self.gain(index, candidate))
            .collect()
    }

    fn has(&self, candidate: &Candidate) -> bool {
        (self.rungs.iter()).any(|rung| self.candidates[rung.candidate].is_variant_of(candidate))
    }

    fn gain(&self, index: usize, candidate: &Candidate) -> Option<Gain> {
        let [link, motor] = self.rows[candidate.joint];
        let rows: &[usize] = if link == motor {
            &[link]
        } else {
            &[link, motor]
        };
        let (squares, added) = self.normal.with(&self.fits, &candidate.unknowns, rows)?;
        let total = |row: usize| -> f64 { self.fits.squares.iter().map(|part| part[row]).sum() };
        let totals: Vec<f64> = rows.iter().map(|&row| total(row)).collect();
        let of_parts: Vec<f64> = (self.fits.squares.iter().zip(&squares))
            .map(|(before, after)| {
                let shares = rows.iter().zip(after).zip(&totals);
                let shares = shares.map(|((&row, after), total)| (before[row] - after) / total);
                shares.sum::<f64>() / rows.len() as f64
            })
            .collect();
        let of_squares: f64 = of_parts.iter().sum();
        let mut gains = (0..rows.len()).map(|i| {
            let after: f64 = squares.iter().map(|part| part[i]).sum();
            (1.0 - (after / totals[i]).sqrt(), rows[i] == motor)
        });
        let torque = self.normal.torque_squares(motor).sqrt();
        let is_practical = added >= LEAST_TORQUE_SHARE * torque;
        of_squares.is_finite().then(|| Gain {
            is_large: is_practical
                && gains.any(|(gain, of_torque)| {
                    gain >= if of_torque {
                        NEGLIGIBLE_SHARE
                    } else {
                        MIN_LINK_GAIN
                    }
                }),
            // Every gear has an offset, viscous and Coulomb friction, so these laws come before nuisance parameters.
            beats_nuisances: candidate.tier() == Tier::Essential
                || is_practical && self.beats_nuisances(candidate, rows, torque),
            candidate: index,
            of_squares,
            scatter: deviation_of_sum(&of_parts),
            of_parts,
        })
    }

    /// Returns whether a change explains more than nuisances do.
    fn beats_nuisances(&self, candidate: &Candidate, rows: &[usize], torque: f64) -> bool {
        let fits = &self.fits_with_nuisances;
        let with = self.normal.with(fits, &candidate.unknowns, rows);
        let Some((after, _)) = with else {
            return false;
        };
        let before = fits
            .squares
            .iter()
            .flat_map(|part| rows.iter().map(|&row| part[row]));
        let before: f64 = before.sum();
        let left: f64 = after.iter().flatten().sum();
        left.sqrt() <= (1.0 - NEGLIGIBLE_SHARE) * before.sqrt()
            && (before - left).max(0.0).sqrt() >= LEAST_OWN_SHARE * torque
    }

    /// Returns the held-out residual of the torque rows relative to the torque: the root mean square
    /// over the joints with torque.
    fn held_out(&self) -> f64 {
        let mut torque_rows: Vec<usize> = self.rows.iter().map(|rows| rows[1]).collect();
        torque_rows.dedup();
        let shares: Vec<f64> = (torque_rows.into_iter())
            .map(|row| (row, self.normal.torque_squares(row)))
            .filter(|(_, torque)| *torque > 0.0)
            .map(|(row, torque)| {
                let left: f64 = self.fits.squares.iter().map(|part| part[row]).sum();
                left / torque
            })
            .collect();
        (shares.iter().sum::<f64>() / shares.len().max(1) as f64).sqrt()
    }
}

/// Returns the standard deviation of the sum of independent numbers by their scatter.
fn deviation_of_sum(parts: &[f64]) -> f64 {
    let count = parts.len() as f64;
    let mean = parts.iter().sum::<f64>() / count;
    let squares: f64 = parts.iter().map(|part| (part - mean).powi(2)).sum();
    (squares * count / (count - 1.0)).sqrt()
}
