//! Other meanings of columns: a sign, a unit, or two columns exchanged. They are no unknowns of a size, so a refit tells them.

use crate::log::{Channels, LogBlock, Signal};

/// A change of the meaning of columns.
#[derive(Clone, Debug)]
pub(super) enum Meaning {
    /// Channels have another factor.
    Factor(Vec<usize>, f64),
    /// Two channels are exchanged.
    Exchanged(usize, usize),
    /// All channels of two joints are exchanged.
    Joints(Vec<(usize, usize)>),
}

impl Meaning {
    /// Applies it to samples.
    pub(super) fn apply(&self, block: &mut LogBlock) {
        match self {
            Self::Factor(channels, factor) => {
                for &channel in channels {
                    (block.values[channel].iter_mut()).for_each(|value| *value *= factor);
                }
            }
            Self::Exchanged(one, two) => block.values.swap(*one, *two),
            Self::Joints(pairs) => pairs
                .iter()
                .for_each(|(one, two)| block.values.swap(*one, *two)),
        }
    }

    /// Returns all other meanings of the columns of some joints. They may be exchanged with those of any joint: with the columns of
    /// another joint, one may explain its torques by chance.
    pub(super) fn all(channels: &Channels, joints: &[usize]) -> Vec<Self> {
        let signals = [Signal::Link, Signal::Motor, Signal::Torque];
        let mut all = Vec::new();
        for &joint in joints {
            for signal in signals {
                let Some(channel) = channels.telling(signal, joint) else {
                    continue;
                };
                all.push(Self::Factor(vec![channel], -1.0));
                if signal == Signal::Torque {
                    all.extend([1e3, 1e-3].map(|factor| Self::Factor(vec![channel], factor)));
                } else if channels.turns[joint] {
                    let degree = 1_f64.to_radians();
                    let factors = [degree, degree.recip()];
                    all.extend(factors.map(|factor| Self::Factor(vec![channel], factor)));
                }
            }
            let telling = |signal: Signal, joint: usize| channels.telling(signal, joint);
            if let (Some(link), Some(motor)) =
                (telling(Signal::Link, joint), telling(Signal::Motor, joint))
            {
                all.push(Self::Exchanged(link, motor));
                // The direction of a joint, with its torque or without.
                all.push(Self::Factor(vec![link, motor], -1.0));
                if let Some(torque) = telling(Signal::Torque, joint) {
                    all.push(Self::Factor(vec![link, motor, torque], -1.0));
                }
            }
            let others =
                (0..channels.turns.len()).filter(|other| *other > joint || !joints.contains(other));
            for other in others {
                let pairs: Vec<(usize, usize)> = signals
                    .iter()
                    .filter_map(|&signal| Some((telling(signal, joint)?, telling(signal, other)?)))
                    .collect();
                all.extend(pairs.iter().map(|&(one, two)| Self::Exchanged(one, two)));
                all.push(Self::Joints(pairs));
            }
        }
        all
    }
}
