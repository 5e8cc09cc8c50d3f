//! Springs of a robot on whose links alone a log is taken, by deflections and joint torques.

use super::undetermined::by_deflections;
use crate::description::{Experiment, Log, Quantity};
use crate::estimate::errors::IdentifyError;
use crate::estimate::result::{RigidJoint, SensedSpring};
use crate::finding::{Finding, Severity};
use crate::log::LogSource;
use crate::model::Model;
use crate::prepare::prepare;
use crate::progress::{Listener, Phase};
use crate::regression::read_through;

/// Springs of joints without motor torque.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::estimate) struct Sensed {
    /// Springs that the logs determine.
    pub(in crate::estimate) springs: Vec<SensedSpring>,
    /// Joints whose spring the logs leave open.
    pub(in crate::estimate) open: Vec<RigidJoint>,
}

impl Sensed {
    /// Reads the logs again, with the motor positions that the equations of the links do not need.
    ///
    /// # Errors
    ///
    /// [`IdentifyError`] if the columns of the motors cannot be read, or the caller stops the run.
    pub(in crate::estimate) fn new(
        experiment: &Experiment,
        sources: &mut [LogSource<'_>],
        progress: &mut dyn Listener,
    ) -> Result<Self, IdentifyError> {
        let has_motors = (experiment.log.iter().flat_map(Log::given))
            .any(|(key, _)| key.quantity == Quantity::MotorPosition);
        if !experiment.is_on_link_side() || !has_motors {
            return Ok(Self::default());
        }
        let experiment = experiment.with_motors();
        let model = Model::new(&experiment).map_err(IdentifyError::Start)?;
        let prepared = prepare(&experiment, &model, sources, progress)?;
        let reading = prepared.reading();
        let passed = read_through(reading, sources, &mut (), Phase::Reading, progress)?;
        let mut sensed = Self::default();
        for (spring, correlation) in by_deflections(reading, &passed.system) {
            let joint = &model.joints()[spring.joint];
            let compliance = spring.compliance.between(correlation);
            if compliance.is_open() || compliance.value <= 0.0 {
                sensed.open.push(compliance.described(joint, None));
                continue;
            }
            let (stiffness, standard_error) = compliance.stiffness();
            sensed.springs.push(SensedSpring {
                joint: joint.clone(),
                stiffness_nm_per_rad: stiffness,
                standard_error_nm_per_rad: standard_error,
                ci95_nm_per_rad: compliance.interval(),
            });
        }
        Ok(sensed)
    }

    /// Returns the finding that names what the logs of links alone leave unknown.
    pub(in crate::estimate) fn finding(&self, experiment: &Experiment) -> Option<Finding> {
        let springs = if self.springs.is_empty() && self.open.is_empty() {
            "rotor inertias, springs and friction of the motors stay unknown"
        } else {
            "rotor inertias and friction of the motors stay unknown; springs follow from deflections and joint torques"
        };
        experiment.is_on_link_side().then(|| {
            Finding::new(
                Severity::Info,
                "links-alone",
                format!(
                    "the log has joint torques and no motor torques, so the equations are those of the links, and \"motor \
                     torque\" means the joint torque: {springs}"
                ),
                "add the motor torques or currents to [log] if the drive records them",
            )
        })
    }
}
