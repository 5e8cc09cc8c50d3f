//! Writes simulated logs with the columns that an experiment declares.

use std::fmt::Write as _;
use std::io::Write;

use sprung_core::covariate::Covariate;

use crate::columns::channels::Channels;
use crate::columns::mix::Mix;
use crate::columns::origin::TimeOrigin;
use crate::description::Quantity;

/// Writes samples as CSV under the names and units of the channels.
pub struct LogWriter<W: Write> {
    writer: csv::Writer<W>,
    channels: Channels,
    cells: Vec<String>,
}

impl<W: Write> LogWriter<W> {
    /// Writes the header line.
    ///
    /// # Errors
    ///
    /// The writer's error.
    pub fn new(write: W, channels: &Channels) -> Result<Self, std::io::Error> {
        let mut writer = csv::Writer::from_writer(write);
        let time = match &channels.time.origin {
            TimeOrigin::Column(name) => name.to_string(),
            TimeOrigin::Period(_) | TimeOrigin::Messages => "t_s".to_owned(),
        };
        let names = channels
            .all
            .iter()
            .map(|channel| channel.origin.pick.example());
        writer.write_record(std::iter::once(time).chain(names))?;
        Ok(Self {
            writer,
            cells: vec![String::new(); 1 + channels.all.len()],
            channels: channels.clone(),
        })
    }

    /// Writes one sample.
    ///
    /// - `q`, `phi`: link positions and motor positions, \[n\], rad on the output side.
    /// - `tau`, `spring`: torques of motors and springs, \[n\], N·m on the output side.
    /// - `motions`: readings of the sensor on the link of each joint, in their unit, \[n\]; empty without sensors.
    /// - `covariates`: of the joints, \[n × [`Covariate::COUNT`]\].
    ///
    /// # Errors
    ///
    /// The writer's error.
    pub fn write(
        &mut self,
        time: f64,
        [q, phi]: [&[f64]; 2],
        [tau, spring]: [&[f64]; 2],
        motions: &[[f64; 3]],
        covariates: &[f64],
    ) -> Result<(), std::io::Error> {
        let mixed = |mix: &Option<Mix>, values: Vec<f64>| match mix {
            Some(mix) => Mix::apply(&mix.back, &values),
            None => values,
        };
        let from_zero = |positions: &[f64]| -> Vec<f64> {
            (positions.iter().zip(&self.channels.offsets))
                .map(|(position, offset)| position - offset)
                .collect()
        };
        let q = from_zero(q);
        let phi = mixed(&self.channels.position_mix, from_zero(phi));
        let tau = mixed(&self.channels.torque_mix, tau.to_vec());
        let of_channels = self.channels.all.iter().map(|channel| {
            let i = channel.joint;
            let torques = [tau[i], spring[i]];
            let of_link = motions.get(i).copied().unwrap_or_default();
            let covariate = |kind| covariates[i * Covariate::COUNT + kind as usize];
            let value = (channel.quantity).shown([q[i], phi[i]], torques, of_link, covariate);
            value / channel.factor - channel.origin.offset
        });
        let values = std::iter::once(time / self.channels.time.factor).chain(of_channels);
        for (cell, value) in self.cells.iter_mut().zip(values) {
            cell.clear();
            write!(cell, "{value}").map_err(std::io::Error::other)?;
        }
        Ok(self.writer.write_record(&self.cells)?)
    }

    /// Writes the buffered rows.
    ///
    /// # Errors
    ///
    /// The writer's error.
    pub fn finish(mut self) -> Result<(), std::io::Error> {
        self.writer.flush()
    }
}

/// Writes samples of any quantities of the first joint as CSV.
pub struct SampleWriter<W: Write>(LogWriter<W>);

impl<W: Write> SampleWriter<W> {
    /// Writes the header line.
    ///
    /// # Errors
    ///
    /// The writer's error.
    pub fn new(write: W, channels: &Channels) -> Result<Self, std::io::Error> {
        Ok(Self(LogWriter::new(write, channels)?))
    }

    /// Writes one sample.
    ///
    /// - `value`: the value of a quantity in SI units on the output side.
    ///
    /// # Errors
    ///
    /// The writer's error.
    pub fn write(
        &mut self,
        time: f64,
        value: impl Fn(Quantity) -> f64,
    ) -> Result<(), std::io::Error> {
        let log = &mut self.0;
        let channels = &log.channels;
        let of_channels = channels.all.iter().map(|channel| {
            let zero = match channel.quantity {
                Quantity::DriveOn => 0.0,
                Quantity::LinkPosition
                | Quantity::LinkDeflection
                | Quantity::MotorPosition
                | Quantity::MotorTorque
                | Quantity::MotorTarget
                | Quantity::JointTorque
                | Quantity::Inertial(..)
                | Quantity::Covariate(_) => channels.offsets[channel.joint],
            };
            (value(channel.quantity) - zero) / channel.factor - channel.origin.offset
        });
        let values = std::iter::once(time / channels.time.factor).chain(of_channels);
        for (cell, value) in log.cells.iter_mut().zip(values) {
            cell.clear();
            write!(cell, "{value}").map_err(std::io::Error::other)?;
        }
        Ok(log.writer.write_record(&log.cells)?)
    }

    /// Writes the buffered rows.
    ///
    /// # Errors
    ///
    /// The writer's error.
    pub fn finish(self) -> Result<(), std::io::Error> {
        self.0.finish()
    }
}
