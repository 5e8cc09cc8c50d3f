//! The complete pipeline from experiment to report, on the digital twin of the demo.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may panic, and prints what it measured"
)]

mod accelerometer;
mod arrays;
mod bristles;
mod golden;
mod gyroscope;
mod in_memory;
mod ladder;
mod laws;
mod linear;
mod logs;
mod many_logs;
mod motor_side;
mod paper;
mod progress;
mod refined;
mod report;
mod robots;
mod robust;
// The benchmark `accuracy` uses the same file.
#[path = "../../benches/accuracy/robots.rs"]
mod searches;
mod seven;
// The benchmark `springs` uses the same file.
#[path = "../../benches/springs/twin.rs"]
mod springs;
mod stability;
// The benchmark `stiff` uses the same file.
#[path = "../../benches/stiff/twin.rs"]
mod stiff;
mod stiff_springs;
mod support;
mod timing;
mod torque_sensor;
