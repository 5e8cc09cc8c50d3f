//! Searches a log and applies what was found to the preparation of an identification or a check.

use std::collections::BTreeMap;

use super::added_law::{may_add_laws, with_added_laws};
use super::confirmed_laws::{joint, sharpened, with_confirmed_laws, with_found};
use super::found::{Found, Telling, with_whole_waves};
use super::gauge::{relative, with_rival_torques};
use super::kinds::finding;
use super::result::{AddedLaw, CompetingUnknown, UnknownResult, UnknownStatus};
use super::settle::{Settlement, settle};
use super::sizes::accuracy_of_gain;
use super::unknown::{Kind, Place};
use crate::description::{Delay, EncoderOffset, Experiment};
use crate::finding::Finding;
use crate::log::{Channels, Signal};
use crate::model::Model;
use crate::prepare::{Excerpt, FoundGain, PrepareError, Prepared, fit_rows};
use crate::progress::Listener;
use crate::regression::Reading;
use sprung_core::parameters::JointParameter;

/// Prepared logs with what was found in the first of them.
#[derive(Clone, Debug)]
pub(crate) struct Settled {
    pub(crate) prepared: Prepared,
    pub(crate) unknowns: Vec<UnknownResult>,
    pub(crate) about: AboutUnknowns,
    /// As of [`Settlement`].
    pub(super) faultless: Option<Excerpt>,
}

/// What is said of the unknowns of a log.
#[derive(Clone, Debug, Default)]
pub struct AboutUnknowns {
    pub(crate) findings: Vec<Finding>,
    /// Part of the torques that stays unexplained on held-out parts (root mean square over the rows); `None` if none was sought.
    pub(crate) unexplained: Option<f64>,
}

impl Settled {
    /// Nothing was found.
    pub(crate) fn without(prepared: Prepared) -> Self {
        Self {
            prepared,
            unknowns: Vec::new(),
            about: AboutUnknowns::default(),
            faultless: None,
        }
    }
}

/// Searches the first log and applies what needs no decision. Returns `None` for a log that cannot be searched.
///
/// # Errors
///
/// As of [`prepare`](crate::prepare::prepare), but for those of reading.
pub(super) fn searched(
    prepared: &Prepared,
    progress: &mut dyn Listener,
) -> Result<Option<Settled>, PrepareError> {
    let settlement = settle(
        prepared.experiment(),
        &prepared.examined(),
        prepared.excerpt(),
    );
    let Some(Settlement {
        found,
        unexplained,
        faultless,
        doubt,
    }) = settlement
    else {
        return Ok(None);
    };
    let channels = prepared.reading().channels().clone();
    let period = prepared.excerpt().period();
    let model = prepared.reading().model();
    let found = with_rival_torques(relative(found, &channels, period), &channels, model);
    let mut found = with_whole_waves(confirmed(found, prepared));
    for gain in found.iter_mut().filter(|one| is_asked_gain(one, prepared)) {
        if let Place::Channel(of) = gain.place {
            let accuracy = accuracy_of_gain(&channels.all[of], 1.0 + gain.value);
            gain.standard_error = gain.standard_error.hypot(accuracy);
        }
    }
    // The least expected first.
    let rank = |one: &Found| match one.kind {
        Kind::Timing => 3,
        _ if status(one, prepared) == UnknownStatus::Estimated => 2,
        Kind::Law => 1,
        _ => 0,
    };
    found.sort_by_key(rank);
    found = with_confirmed_laws(found, prepared);
    let (unknowns, mut about) = told(&found, prepared);
    about.unexplained = Some(unexplained);
    let is_doubted =
        (found.iter()).any(|one| one.kind == Kind::Delay || is_asked_gain(one, prepared));
    let prepared = applied(prepared.clone(), (&found, &unknowns), progress)?;
    let prepared = prepared.with_doubt(if is_doubted { doubt } else { BTreeMap::new() });
    Ok(Some(Settled {
        prepared,
        unknowns,
        about,
        faultless,
    }))
}

/// Returns the results about what was found, and the findings.
pub(super) fn told(found: &[Found], prepared: &Prepared) -> (Vec<UnknownResult>, AboutUnknowns) {
    let channels = prepared.reading().channels();
    let file = prepared.names().first().cloned().unwrap_or_default();
    let names = prepared.reading().model().joints().to_vec();
    let (mut unknowns, mut findings) = (Vec::new(), Vec::new());
    for one in found {
        let columns = columns(one.place, channels);
        let estimated = prepared.factors().gains.iter();
        let estimated = estimated.filter(|gain| columns.contains(&&*gain.column));
        let mut given = (prepared.experiment().log.iter()).flat_map(|log| log.gain.keys());
        // The line of a finding is multiplied by a number of the file when it is completed.
        let is_given = given.any(|column| columns.contains(&&**column));
        let telling = Telling {
            found: one,
            gain: (estimated.map(|gain| gain.value).next()).or(is_given.then_some(1.0)),
            columns,
            joint: joint(one.place, channels).map_or("", |joint| &names[joint]),
            file: &file,
            status: status(one, prepared),
            is_addable: is_addable(one, prepared),
            excerpt: prepared.excerpt(),
            moves: None,
        };
        unknowns.push(result(&telling));
        // An offset that the description estimates needs no finding; a gain has one among the estimated factors.
        let is_silent = matches!(one.kind, Kind::Offset | Kind::Gain);
        if telling.status != UnknownStatus::Estimated || !is_silent {
            findings.extend(finding(&telling));
        }
    }
    let about = AboutUnknowns {
        findings,
        unexplained: None,
    };
    (unknowns, about)
}

/// A delay that raises the residual of the torques of its joint by this factor is contradicted.
const CONTRADICTED: f64 = 1.05;

/// Returns the unknowns without delays that the regression with the filters of the description contradicts. The
/// search has slower filters, in which a delay resembles an inertia.
fn confirmed(found: Vec<Found>, prepared: &Prepared) -> Vec<Found> {
    let reading = prepared.examined();
    let is_tested =
        |one: &Found| one.kind == Kind::Delay && status(one, prepared) == UnknownStatus::Applied;
    if !found.iter().any(is_tested) {
        return found;
    }
    let joints: Vec<usize> = (0..reading.model().joint_count()).collect();
    let late = reading.with_delays(&with_found(&reading, &found));
    let fits = [&reading, &late].map(|reading| fit_rows(prepared.excerpt(), reading, &joints));
    let [Some(without), Some(with)] = fits else {
        return found;
    };
    let rise =
        |joint: usize| (with[joint].relative_residual() / without[joint].relative_residual()).ln();
    let channels = reading.channels();
    let is_confirmed = |one: &Found| {
        let of_place = |of: &usize| joint(one.place, channels).is_none_or(|joint| joint == *of);
        let rises: Vec<f64> = (joints.iter().copied().filter(of_place))
            .map(rise)
            .collect();
        rises.iter().sum::<f64>() <= CONTRADICTED.ln() * rises.len() as f64
    };
    (found.into_iter())
        .filter(|one| !is_tested(one) || is_confirmed(one))
        .collect()
}

fn is_asked_gain(one: &Found, prepared: &Prepared) -> bool {
    one.kind == Kind::Gain && status(one, prepared) == UnknownStatus::Estimated
}

/// Returns the columns of a place; of a joint that of its torque.
pub(super) fn columns(place: Place, channels: &Channels) -> Vec<&str> {
    let is_of = |i: usize, joint: usize| match place {
        Place::Joint(of) => joint == of && channels.all[i].quantity.signal() == Signal::Torque,
        Place::Channel(_) | Place::All(_) | Place::Robot => place.contains(i, channels),
    };
    let all = (channels.all.iter().enumerate()).filter(|(i, channel)| is_of(*i, channel.joint));
    all.map(|(_, channel)| channel.column.as_str()).collect()
}

/// Returns whether sprung may add a law by itself. Damping of a spring has the same column as a delay of its deflection.
fn is_addable(found: &Found, prepared: &Prepared) -> bool {
    let is_told = |law: &AddedLaw| !law.law.is_empty() && law.law != "damping";
    found.law.as_ref().is_some_and(is_told) && prepared.reading().channels().inertial.is_none()
}

fn status(found: &Found, prepared: &Prepared) -> UnknownStatus {
    let reading = prepared.reading();
    let may_add = joint(found.place, reading.channels())
        .is_some_and(|joint| may_add_laws(prepared.experiment(), joint));
    let (is_asked, has_preload) = match found.place {
        Place::Channel(at) => {
            let channel = &reading.channels().all[at];
            let preload = reading
                .model()
                .index(JointParameter::Preload, channel.joint);
            let is_asked = match found.kind {
                Kind::Gain => channel.open_gain,
                _ => channel.delay == Some(Delay::Estimate),
            };
            (is_asked, preload.is_some())
        }
        Place::All(_) | Place::Joint(_) | Place::Robot => (false, false),
    };
    let is_refused = found.kind == Kind::Offset
        && reading.settings().encoder_offset == Some(EncoderOffset::None);
    match found.kind {
        Kind::Delay | Kind::Gain if is_asked => UnknownStatus::Estimated,
        Kind::Offset if has_preload => UnknownStatus::Estimated,
        Kind::Law if is_addable(found, prepared) && may_add => UnknownStatus::Applied,
        kind if kind.is_applied() && !is_refused => UnknownStatus::Applied,
        _ => UnknownStatus::Found,
    }
}

/// Returns the result about an unknown that only the likelihood shows, and its finding.
///
/// - `moves`: which parameter would move with it.
pub(crate) fn by_likelihood(
    found: &Found,
    (reading, excerpt): (&Reading, &Excerpt),
    moves: &str,
) -> (UnknownResult, Option<Finding>) {
    let channels = reading.channels();
    let names = reading.model().joints();
    let telling = Telling {
        found,
        gain: None,
        columns: columns(found.place, channels),
        joint: joint(found.place, channels).map_or("", |joint| &names[joint]),
        file: "",
        status: UnknownStatus::Found,
        is_addable: false,
        excerpt,
        moves: Some(moves),
    };
    (result(&telling), finding(&telling))
}

fn result(of: &Telling<'_>) -> UnknownResult {
    let found = of.found;
    UnknownResult {
        id: found.id.clone(),
        kind: found.kind.name().to_owned(),
        place: match found.kind {
            Kind::TimeScale => "time".to_owned(),
            Kind::Law
            | Kind::Ripple
            | Kind::TransmissionError
            | Kind::WarmUp
            | Kind::Sharpness
            | Kind::Friction
            | Kind::Stiffness
            | Kind::Play
            | Kind::Load => of.joint.to_owned(),
            Kind::Delay
            | Kind::Timing
            | Kind::Gain
            | Kind::Offset
            | Kind::Drift
            | Kind::LostCounts
            | Kind::Eccentricity
            | Kind::Saturation => of.columns.join(", "),
        },
        value: found.value,
        standard_error: found.standard_error,
        unit: found.unit.to_owned(),
        begins_s: found.begins,
        law: found.law.clone(),
        status: of.status,
        competing: (found.competing.iter())
            .map(|rival| CompetingUnknown {
                id: rival.id.clone(),
                correlation: rival.correlation,
            })
            .collect(),
        effect: found.gain,
    }
}

/// Returns the preparation with the delays and laws that were found, and with the zero between two encoders as a parameter.
pub(super) fn applied(
    prepared: Prepared,
    (found, unknowns): (&[Found], &[UnknownResult]),
    progress: &mut dyn Listener,
) -> Result<Prepared, PrepareError> {
    let gains: Vec<FoundGain> = (found.iter())
        .filter(|one| is_asked_gain(one, &prepared))
        .map(|one| FoundGain {
            column: columns(one.place, prepared.reading().channels()).concat(),
            value: 1.0 + one.value,
            standard_error: one.standard_error,
        })
        .collect();
    let has_gains = !gains.is_empty();
    let prepared = prepared.with_gains(gains);
    let delays = with_found(prepared.reading(), found);
    let channels = prepared.reading().channels().clone();
    let mut experiment = with_added_laws(prepared.experiment(), unknowns);
    for one in found.iter().filter(|one| one.kind == Kind::Delay) {
        for (i, channel) in channels.all.iter().enumerate() {
            // The refinement estimates the delay of a channel again, and the timing of all torques by itself.
            if one.place.contains(i, &channels)
                && channel.delay.is_none()
                && let Some(log) = &mut experiment.log
            {
                log.delay_s.insert(channel.column.clone(), Delay::Estimate);
            }
        }
    }
    let is_applied = |one: &&Found| status(one, &prepared) == UnknownStatus::Applied;
    let needs_offset = (found.iter().filter(is_applied)).any(|one| one.kind == Kind::Offset);
    if needs_offset {
        experiment.identify.encoder_offset = Some(EncoderOffset::Estimate);
    }
    let has_sharpness = found.iter().any(|one| one.kind == Kind::Sharpness);
    let needs_model = needs_offset || unknowns.iter().any(|one| one.used_law().is_some());
    if delays == prepared.reading().delays() && !needs_model && !has_sharpness && !has_gains {
        return Ok(prepared);
    }
    let model = if needs_model {
        let open = open_velocities(prepared.experiment(), unknowns);
        (Model::new(&experiment).ok()).map(|model| model.with_open_stribeck(&open))
    } else {
        None
    };
    let model = model.unwrap_or_else(|| prepared.reading().model().clone());
    let model = sharpened(model, found, &channels);
    let again = prepared.again(&experiment, &model, progress)?;
    let reading = again.reading().with_delays(&delays);
    Ok(again.with_reading(reading))
}

/// Returns the joints that get Stribeck friction of a velocity which the description does not give.
fn open_velocities(experiment: &Experiment, unknowns: &[UnknownResult]) -> Vec<usize> {
    let is_added = |name: &str| {
        unknowns.iter().any(|one| {
            let velocity = one.used_law().and_then(|law| law.stribeck_velocity);
            one.place == name && velocity.is_some()
        })
    };
    (experiment.robot.joint.iter().enumerate())
        .filter(|(_, joint)| joint.stribeck_velocity_rad_per_s.is_none() && is_added(&joint.name))
        .map(|(index, _)| index)
        .collect()
}
