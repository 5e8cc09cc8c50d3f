//! From base parameters back to the parameters of single links.

use faer::Mat;
use faer::linalg::solvers::Solve;
use sprung_core::spatial::BODY;

use super::result::{Determined, StandardParameter};
use crate::model::{Model, TreeLinks};

/// Returns inertial parameters of single links that agree with the base parameters in theta. They
/// are the nominal parameters (zero without a nominal value) with the smallest change. No motion of
/// the robot can distinguish them from other parameters with the same base parameters. Base
/// parameters that are not identifiable are not constrained.
///
/// Returns an empty list for a robot in closed form.
#[must_use]
pub fn standard_parameters(
    model: &Model,
    theta: &[f64],
    identifiable: &[bool],
) -> Vec<StandardParameter> {
    let Some(links) = model.links() else {
        return Vec::new();
    };
    let base = &links.base;
    let estimate = |index: usize| -> Option<f64> {
        let at = model.parameter_of(index)?;
        identifiable[at].then_some(theta[at])
    };
    // G π = π_base with G = [I Kc] in the order of the standard parameters.
    let nominal: Vec<f64> = (0..links.standard())
        .map(|index| links.nominal(index).unwrap_or(0.0))
        .collect();
    let known: Vec<(usize, f64)> = (base.independent.iter().enumerate())
        .filter_map(|(i, &index)| Some((i, estimate(index)?)))
        .collect();
    let entry = |i: usize, index: usize| -> f64 {
        if base.independent[i] == index {
            return 1.0;
        }
        let at = base.dependent.iter().position(|k| *k == index);
        at.map_or(0.0, |at| base.combination[i][at])
    };
    let g = Mat::from_fn(known.len(), links.standard(), |row, index| {
        entry(known[row].0, index)
    });
    let missing = Mat::from_fn(known.len(), 1, |row, _| {
        let (_, value) = known[row];
        value
            - (0..links.standard())
                .map(|index| g[(row, index)] * nominal[index])
                .sum::<f64>()
    });
    // G contains the identity, so it has full row rank.
    let gram = &g * g.transpose();
    let change = g.transpose() * gram.partial_piv_lu().solve(&missing);
    (0..links.standard())
        .filter(|index| *index < model.joint_count() * BODY)
        .map(|index| StandardParameter {
            name: links.name(index).to_owned(),
            unit: links.unit(index).to_owned(),
            value: nominal[index] + change[(index, 0)],
            nominal: links.nominal(index),
            determined: determined(links, index, estimate(index).is_some()),
        })
        .collect()
}

fn determined(links: &TreeLinks, index: usize, estimated: bool) -> Determined {
    let base = &links.base;
    if links.known.contains_key(&index) {
        return Determined::Known;
    }
    if let Some(i) = base.independent.iter().position(|own| *own == index) {
        return match (estimated, base.is_alone(i)) {
            (false, _) => Determined::Not,
            (true, true) => Determined::Alone,
            (true, false) => Determined::InCombination,
        };
    }
    let at = base.dependent.iter().position(|own| *own == index);
    match at {
        Some(at) if base.combination.iter().any(|row| row[at] != 0.0) => Determined::InCombination,
        _ => Determined::Not,
    }
}
