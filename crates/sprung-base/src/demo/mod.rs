//! The experiment of the founding paper, ready to run.

/// The experiment file: robot, controllers, references and digital twin of the paper.
pub const EXPERIMENT: &str = include_str!("experiment.toml");

/// Parameters of the twin: column "proposed" of the paper's Table III.
pub const TRUTH: &str = include_str!("truth.toml");
