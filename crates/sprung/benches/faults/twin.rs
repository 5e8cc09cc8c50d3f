//! Logs of the demo's twin as tables, into which faults are injected.

use sprung_base::demo;
use sprung_base::progress::Unheard;
use sprung_log::Channels;
use sprung_method::simulate::{TwinSetup, record};
use sprung_model::{Model, Theta};
use sprung_robot::{self as description, Experiment, no_files};

/// The demo's experiment and the true parameters of its robot.
pub(crate) struct Demo {
    pub(crate) experiment: Experiment,
    model: Model,
    truth: Theta,
}

/// A log in memory.
#[derive(Clone)]
pub(crate) struct Table {
    header: String,
    /// Time, s.
    pub(crate) time: Vec<f64>,
    /// Values of the columns.
    pub(crate) columns: Vec<Vec<f64>>,
}

impl Demo {
    pub(crate) fn new() -> Self {
        let experiment = description::read("experiment.toml", demo::EXPERIMENT, &[], &mut no_files)
            .expect("the demo is right");
        let model = Model::new(&experiment).expect("the demo has a model");
        let truth = toml::from_str(demo::TRUTH).expect("the demo has its parameters");
        let truth = model.theta(&truth).expect("the demo has its parameters");
        Self {
            experiment,
            model,
            truth,
        }
    }

    /// Returns a log of the demo.
    ///
    /// - `part`: factor for the demo's amplitudes.
    pub(crate) fn table(&self, seed: u64, part: f64) -> Table {
        self.with(seed, part, |_| ())
    }

    /// Returns a log of the demo with encoders of `counts` counts per turn.
    pub(crate) fn with_counts(&self, seed: u64, counts: u32) -> Table {
        self.with(seed, 1.0, |settings| {
            settings.link_encoder_counts_per_turn = vec![counts; 2];
            settings.motor_encoder_counts_per_turn = vec![counts; 2];
        })
    }

    fn with(&self, seed: u64, part: f64, change: impl Fn(&mut description::Simulate)) -> Table {
        let mut settings = self.experiment.simulate.clone().expect("it has a twin");
        settings.seed = seed;
        change(&mut settings);
        let mut controller = self.experiment.controller.clone().expect("it has one");
        for sine in &mut controller.reference.sines {
            sine.amplitude_deg *= part;
        }
        let setup = TwinSetup {
            model: &self.model,
            theta: &self.truth,
            controller: &controller,
            settings: &settings,
        };
        let log = self.experiment.log.as_ref().expect("it has a log");
        let channels = Channels::new(&self.experiment.robot, log).expect("the demo is right");
        let mut text = Vec::new();
        record(&setup, &channels, &mut text, &mut Unheard).expect("the twin runs");
        Table::read(&String::from_utf8(text).expect("a log is text"))
    }
}

impl Table {
    fn read(text: &str) -> Self {
        let mut lines = text.lines();
        let header = lines.next().expect("a log has a header").to_owned();
        let width = header.split(',').count() - 1;
        let mut table = Self {
            header,
            time: Vec::new(),
            columns: vec![Vec::new(); width],
        };
        for line in lines {
            let mut cells = line.split(',').map(|cell| cell.parse().expect("a number"));
            table.time.push(cells.next().expect("a time"));
            for (column, value) in table.columns.iter_mut().zip(cells) {
                column.push(value);
            }
        }
        table
    }

    /// Returns the log as CSV.
    pub(crate) fn csv(&self) -> Vec<u8> {
        use std::fmt::Write;
        let mut text = format!("{}\n", self.header);
        for (k, time) in self.time.iter().enumerate() {
            write!(text, "{time}").expect("memory takes a log");
            for column in &self.columns {
                write!(text, ",{}", column[k]).expect("memory takes a log");
            }
            text.push('\n');
        }
        text.into_bytes()
    }

    /// Returns the log with a column delayed by a number of samples.
    pub(crate) fn delayed(&self, column: usize, samples: usize) -> Self {
        let mut late = self.clone();
        for (k, values) in late.columns.iter_mut().enumerate() {
            if k == column {
                values.truncate(self.time.len() - samples);
            } else {
                values.drain(..samples);
            }
        }
        late.time.truncate(self.time.len() - samples);
        late
    }

    /// Removes the rows for which `keep` returns false.
    pub(crate) fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        for values in self.columns.iter_mut().chain([&mut self.time]) {
            let mut k = 0;
            values.retain(|_| {
                k += 1;
                keep(k - 1)
            });
        }
    }

    /// Returns the difference between the largest and the smallest value of a column.
    pub(crate) fn range(&self, column: usize) -> f64 {
        let values = &self.columns[column];
        let fold = |pick: fn(f64, f64) -> f64| values.iter().copied().reduce(pick);
        fold(f64::max).expect("a log has samples") - fold(f64::min).expect("a log has samples")
    }
}
