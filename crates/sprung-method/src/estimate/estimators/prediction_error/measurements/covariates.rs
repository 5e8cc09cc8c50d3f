//! Covariates of friction.

use sprung_core::covariate::Covariate;

use super::read::RawSegment;
use crate::log::Channels;
use crate::model::Model;

/// Returns the covariates of the joints minus their references, \[samples × n × covariates\]; empty if
/// no friction depends on any.
///
/// - `delays`: delay of each channel, s; `begin`: index of the first sample.
pub(super) fn covariates(
    raw: &RawSegment,
    model: &Model,
    channels: &Channels,
    delays: &[f64],
    (begin, samples): (usize, usize),
) -> Vec<f64> {
    if channels.covariates.is_empty() {
        return Vec::new();
    }
    let width = model.joint_count() * Covariate::COUNT;
    let mut excess = vec![0.0; samples * width];
    for own in &channels.covariates {
        let source = channels.of_covariate(own.covariate, own.joint);
        let of_sample = |k: usize| match source {
            None => raw.begin + (begin + k) as f64 * raw.period,
            Some(channel) => {
                let values = &raw.values[channel];
                let lead = begin as f64 + delays[channel] / raw.period;
                values[(k + lead.round().max(0.0) as usize).min(values.len() - 1)]
            }
        };
        let place = own.joint * Covariate::COUNT + own.covariate as usize;
        for (k, of_sample_k) in excess.chunks_mut(width).enumerate() {
            of_sample_k[place] = of_sample(k) - own.reference;
        }
    }
    excess
}
