//! Keys of `[log]` that read the fixtures, and any file made like them.

#![allow(unreachable_pub, reason = "a library of fuzz targets gives them out")]

/// Columns with the usual names.
pub const USUAL: &str = r#"
time_s = "t_s"
link_position_rad = "q*_rad"
motor_position_rad = ["phi1_rad", "phi2_rad"]
motor_torque_nm = "tau*_nm"
"#;

/// Fields of records.
pub const RECORDS: &str = r#"
time_s = "t"
link_position_rad = "q[:,*]"
motor_position_rad = "phi[:,*]"
motor_torque_nm = "tau[:,*]"
"#;

/// Members of an archive.
pub const ARRAYS: &str = r#"
time_s = "t"
link_position_rad = "q[:,*]"
motor_position_rad = ["phi[0,:]", "phi[1,:]"]
motor_torque_nm = "tau[:,*]"
"#;

/// Fields of structures.
pub const MATLAB: &str = r#"
time_s = "data.time"
link_position_rad = "data.link.q(:,*)"
motor_position_rad = "data.signals(1).values(:,*)"
motor_torque_nm = "data.signals(2).values(:,*)"
"#;

/// Columns with numbers.
pub const NUMBERS: &str = "
time_s = 1
link_position_rad = [2, 3]
motor_position_rad = [4, 5]
motor_torque_nm = [6, 7]
";

/// Topics of a bag.
pub const TOPICS: &str = r#"
link_position = { topic = "/joint_states", unit = "rad" }
motor_position = { topic = "/motor_states", unit = "rad" }
motor_torque = { topic = "/motor_states", field = "effort", unit = "N·m" }
"#;

/// One topic for all.
pub const STATES: &str = r#"
link_position = { topic = "/states", unit = "rad" }
motor_position = { topic = "/states", unit = "rad" }
motor_torque = { topic = "/states", field = "effort", unit = "N·m" }
"#;
