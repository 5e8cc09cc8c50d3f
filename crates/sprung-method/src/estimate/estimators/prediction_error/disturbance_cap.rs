//! The cap of the slow disturbances in the search for levels.
//!
//! A disturbance at its cap moves with the white noise of its row: `σ_d = σ_w √(R T π f_d)`.

use super::levels::{Level, Levels, UnknownLevels};
use super::likelihood::Score;
use crate::estimate::statistics::ROUNDING;

/// Returns the disturbances that the cap holds: those at the cap that would grow. Moves their
/// logarithms to their upper bounds, so that they follow the cap.
///
/// - `gradient`: derivatives of the loss by the logarithms of the levels.
pub(super) fn held_by_cap(
    unknown: &UnknownLevels,
    levels: &Levels,
    gradient: &[f64],
    logarithms: &mut [f64],
) -> Vec<usize> {
    let rows = 0..levels.disturbance.len();
    rows.filter(|&row| {
        let index = unknown.index(Level::Disturbance(row));
        let (Some(at), Some(cap)) = (index, unknown.cap(levels, row)) else {
            return false;
        };
        let held = levels.disturbance[row] >= (1.0 - ROUNDING) * cap && gradient[at] < 0.0;
        if held {
            logarithms[at] = unknown.bounds[at].1.ln();
        }
        held
    })
    .collect()
}

/// Adds the derivatives by the disturbances of some rows to those by the levels that move them.
///
/// - `held`: rows whose disturbances are at their cap.
pub(super) fn follow_cap(unknown: &UnknownLevels, held: &[usize], score: &mut Score) {
    let count = unknown.all.len();
    for &row in held {
        let Some(from) = unknown.index(Level::Disturbance(row)) else {
            continue;
        };
        let Some(to) = unknown.index(Level::TorqueNoise(row)) else {
            continue;
        };
        let place = |i: usize, j: usize| i.max(j) * count + i.min(j);
        let information = &mut score.information;
        score.gradient[to] += score.gradient[from];
        for j in (0..count).filter(|j| *j != to && *j != from) {
            information[place(to, j)] += information[place(from, j)];
        }
        information[place(to, to)] +=
            2.0 * information[place(to, from)] + information[place(from, from)];
        score.gradient[from] = 0.0;
        for i in 0..count {
            information[place(i, from)] = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::estimators::prediction_error::level_search::score;
    use crate::estimate::estimators::prediction_error::levels::Disturbances;
    use crate::estimate::estimators::prediction_error::likelihood::{LevelLikelihood, Searched};
    use crate::estimate::estimators::prediction_error::tests::{Case, search_of};

    #[test]
    fn capped_disturbances_have_the_derivative_of_the_likelihood() {
        let case = Case::new();
        let (run, search) = search_of(&case, Disturbances::Capped(3.0));
        let searched = Searched::new(&case.measurements, 500);
        let likelihood = LevelLikelihood::new(&case.measurements, &run, &searched);
        let mut logs = search.logarithms(&case.levels);
        let levels = search.levels(&case.levels, &logs);
        let mut here = score(&likelihood, &search, &levels).unwrap();
        // Every disturbance at its cap counts as held, for any derivative.
        let downhill = vec![-1.0; logs.len()];
        let held = held_by_cap(&search, &levels, &downhill, &mut logs);
        assert!(!held.is_empty());
        follow_cap(&search, &held, &mut here);
        for i in 0..logs.len() {
            let at = |by: f64| {
                let mut logs = logs.clone();
                logs[i] += by;
                let levels = search.levels(&case.levels, &logs);
                score(&likelihood, &search, &levels).unwrap().loss
            };
            let difference = (at(1e-4) - at(-1e-4)) / 2e-4;
            let scale = here.information[i * (logs.len() + 1)].sqrt().max(1.0);
            let far = (here.gradient[i] - difference).abs();
            assert!(
                far < 1e-5 * scale,
                "level {i}: {} {difference}",
                here.gradient[i]
            );
        }
    }

    #[test]
    fn information_is_carried_over_by_the_chain_rule() {
        let case = Case::new();
        let (_, search) = search_of(&case, Disturbances::Capped(3.0));
        let count = search.all.len();
        let (row, from) = (2, search.index(Level::Disturbance(2)).unwrap());
        let entry = |i: usize, j: usize| 1.0 / (1.0 + (i + j) as f64) + f64::from(u8::from(i == j));
        let mut score = Score {
            loss: 0.0,
            gradient: vec![0.0; count],
            expected: vec![0.0; count],
            information: (0..count * count)
                .map(|at| entry(at / count, at % count))
                .collect(),
        };
        follow_cap(&search, &[row], &mut score);
        let moves = |i: usize, j: usize| match () {
            () if i == from => match search.all[j] {
                Level::TorqueNoise(noisy_row) if noisy_row == row => 1.0,
                Level::TorqueNoise(_)
                | Level::ReversalNoise(_)
                | Level::Disturbance(_)
                | Level::SensorNoise(_)
                | Level::Corner => 0.0,
            },
            () if i == j => 1.0,
            () => 0.0,
        };
        for i in 0..count {
            for j in 0..=i {
                let all = (0..count).flat_map(|k| (0..count).map(move |l| (k, l)));
                let expected: f64 = all
                    .map(|(k, l)| moves(k, i) * entry(k, l) * moves(l, j))
                    .sum();
                let found = score.information[i * count + j];
                assert!((found - expected).abs() < 1e-12, "{i} {j}");
            }
        }
    }
}
