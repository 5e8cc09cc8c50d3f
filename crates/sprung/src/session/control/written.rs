//! A designed controller as part of an experiment file.

use std::fmt::Write;

use sprung_method::control::ControlDesign;

/// Returns the `[controller]` of an experiment file that runs a designed controller.
#[must_use]
pub fn controller_toml(design: &ControlDesign) -> String {
    let controller = &design.controller;
    let n = design.joints.len();
    let list = |all: &[f64]| {
        let all: Vec<String> = all.iter().map(|value| format!("{value:?}")).collect();
        format!("[{}]", all.join(", "))
    };
    let mut text = format!(
        "# {}: the controller of {}, for a period of {:?} s.\n[controller]\n",
        design.generator, design.robot, controller.period_s
    );
    if controller.has_feedforward {
        text += "kind = \"state-feedback\"\ngain = [\n";
        for row in &controller.gain {
            let _ = writeln!(text, "  {},", list(row));
        }
        text += "]\nfeedforward = \"identified\"\n";
        if let Some(speed) = controller.friction_compensation_speed_rad_per_s {
            let _ = writeln!(text, "friction_compensation_speed_rad_per_s = {speed:?}");
        }
    } else {
        let of = |order: usize| -> Vec<f64> {
            (0..n)
                .map(|i| controller.gain[i][(2 * order + 1) * n + i])
                .collect()
        };
        let _ = writeln!(
            text,
            "kind = \"pd\"\nkp_nm_per_rad = {}\nkd_nms_per_rad = {}",
            list(&of(0)),
            list(&of(1))
        );
    }
    let _ = writeln!(text, "velocity_window = {:?}", controller.velocity_window);
    if !controller.shaper.is_empty() {
        let all: Vec<String> = controller
            .shaper
            .iter()
            .map(|impulse| list(impulse))
            .collect();
        let _ = writeln!(text, "shaper = [{}]", all.join(", "));
    }
    text
}
