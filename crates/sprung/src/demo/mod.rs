//! The paper's experiment, ready to run.

/// The experiment: robot, controllers, references and twin of the paper.
pub const EXPERIMENT: &str = include_str!("experiment.toml");

/// Parameters of the twin: column "proposed" of the paper's Table III.
pub const TRUTH: &str = include_str!("truth.toml");
