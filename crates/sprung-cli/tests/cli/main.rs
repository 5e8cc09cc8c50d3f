//! The program as a user runs it.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "these are tests")]

mod arm;
mod axes;
mod bad_experiment;
mod bad_joints;
mod bad_log;
mod bad_request;
mod bad_robot;
mod browser;
mod check;
mod code;
mod common;
mod compare;
mod control;
mod corpus;
mod cut_off;
mod drift;
mod excite;
mod expected_errors;
mod export;
mod folders;
mod formats;
mod from_robot_and_log;
mod grouped;
mod hostile;
mod joints_by_content;
mod killed;
mod links_alone;
#[path = "../../../sprung-log/tests/formats/mcap_bytes.rs"]
mod mcap_bytes;
mod meanings;
mod missing_values;
mod motor_side;
mod new;
mod new_log;
mod new_log_bags;
mod new_log_lists;
mod outputs;
mod pages;
mod pasted;
mod payload;
mod physical;
mod real_machine;
mod recorders;
mod refined;
mod renamed_log;
mod robots;
mod servo;
mod seven_joints;
mod shapes;
mod terminal;
mod timing;
mod trust;
mod verdict;
mod watch;
