//! Composes the summary of all joints, and one page per joint.

use super::contents::Contents;
use super::document::{Block, Fold, Section, Tone};
use super::groups::Joints;
use super::intervals::half_width;
use super::joint_figures::JointFigures;
use super::numbers::{dash_if_none, percent, significant};
use super::plots::slug;
use super::rows::rows;
use super::section::{findings, folded, section};
use super::tables;
use crate::estimate::{EstimateResult, Identification, Verdict};
use crate::finding::Finding;

/// Codes of findings about joints whose motion does not determine their parameters.
const HARDLY_MOVES: [&str; 2] = ["hardly-moves", "at-rest"];

/// Composes the table of all joints for a reader who decides; `None` without a result.
pub(super) fn summary(identification: &Identification) -> Option<Section> {
    let result = identification.results.first()?;
    let joints = Joints::of(identification);
    let value =
        |joint: &str, name: &str| dash_if_none(with_interval(result, &format!("{joint}.{name}")));
    let rating = |joint: &String| rating(identification, result, &joints, joint);
    let table = rows(joints.names())
        .text("Joint", |joint| joint)
        .text("Verdict", |joint| rating(joint).1)
        .text("Stiffness", |joint| value(joint, "stiffness"))
        .text("Coulomb friction, motor", |joint| value(joint, "motor_coulomb"))
        .text("Viscous friction, motor", |joint| value(joint, "motor_viscous"))
        .text("Torque error", |joint| {
            let mut promises = result.promise.iter();
            let torque = promises.find(|promise| promise.joint == *joint);
            let share = torque.map(|promise| promise.torque_error_nm / promise.torque_nm);
            dash_if_none(share.map(|share| percent(share, 2)))
        })
        .toned(|joint| rating(joint).0)
        .table_if_any(
            "One row per joint, with 95 % intervals. The last column is the promised error of the motor torque.",
        )?;
    Some(section("joints", "Joints", "", vec![Block::Table(table)]))
}

/// Returns the colour and the word of a joint.
fn rating(
    identification: &Identification,
    result: &EstimateResult,
    joints: &Joints,
    joint: &str,
) -> (Tone, &'static str) {
    let is_still = |finding: &Finding| {
        HARDLY_MOVES.contains(&finding.code.as_str()) && is_about(finding, joints, joint)
    };
    let doubted = &result.decision.parameters;
    let is_doubted = doubted.is_empty()
        || doubted
            .iter()
            .any(|parameter| joints.group(parameter) == joint);
    match result.verdict {
        _ if identification.findings.iter().any(is_still) => (Tone::Doubtful, "hardly moves"),
        Verdict::Unusable => (Tone::Bad, "unusable"),
        Verdict::Doubtful if is_doubted => (Tone::Doubtful, "doubtful"),
        Verdict::Good | Verdict::Doubtful => (Tone::Good, "good"),
    }
}

/// Returns a parameter with its unit and interval.
fn with_interval(result: &EstimateResult, name: &str) -> Option<String> {
    let mut parameters = result.parameters.iter();
    let parameter = parameters.find(|parameter| parameter.name == name)?;
    let value = significant(parameter.value?, 3);
    let half =
        half_width(parameter).map_or_else(String::new, |half| format!(" ± {}", percent(half, 2)));
    Some(format!("{value} {}{half}", parameter.unit))
}

/// Composes a page per joint: friction, spring, residual and its spectrum, parameters and findings.
pub(super) fn pages(identification: &Identification, contents: &Contents<'_>) -> Vec<Section> {
    let Some(result) = identification.results.first() else {
        return Vec::new();
    };
    let joints = Joints::of(identification);
    let page = |joint: &String| {
        let mut blocks: Vec<Block> = Vec::new();
        if let Some(fit) = contents.fit {
            let joint_figures = JointFigures::of(result, fit, joint);
            let figures = [
                joint_figures.friction,
                joint_figures.spring,
                joint_figures.residual,
                joint_figures.spectrum,
            ];
            blocks.extend(figures.into_iter().flatten().map(Block::Figure));
        }
        blocks.extend(
            tables::parameters(identification, contents.truth, Some(joint)).map(Block::Table),
        );
        let all = identification.findings.iter().chain(&result.warnings);
        blocks.extend(findings(
            all.filter(|finding| is_about(finding, &joints, joint)),
        ));
        let (_, word) = rating(identification, result, &joints, joint);
        folded(
            Fold::Screen,
            &format!("joint-{}", slug(joint)),
            &format!("Joint {joint}"),
            &format!("{word}: friction, spring, residual, parameters and findings of this joint."),
            blocks,
        )
    };
    joints.names().iter().map(page).collect()
}

/// Returns whether a finding concerns a parameter of a joint, or names the joint.
fn is_about(finding: &Finding, joints: &Joints, joint: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let is_named = |(at, found): (usize, &str)| {
        let before = finding.text[..at].chars().next_back();
        let after = finding.text[at + found.len()..].chars().next();
        !before.is_some_and(is_part) && !after.is_some_and(is_part)
    };
    (finding.parameters.iter()).any(|parameter| joints.group(parameter) == joint)
        || finding.text.match_indices(joint).any(is_named)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finding::Severity;
    use crate::named::Named;

    #[test]
    fn a_finding_is_about_the_joint_that_it_names_or_whose_parameter_it_concerns() {
        let rows = ["joint1.motor_nm", "joint10.motor_nm"];
        let rows: Named = rows.iter().map(|row| ((*row).to_owned(), 0.0)).collect();
        let joints = Joints::of_rows(&rows);
        let finding = |text: &str| Finding::new(Severity::Warning, "code", text.to_owned(), "");
        let about = |finding: &Finding| {
            ["joint1", "joint10"].map(|joint| is_about(finding, &joints, joint))
        };
        assert_eq!(about(&finding("joint10: late")), [false, true]);
        assert_eq!(about(&finding("joint1.stiffness is weak")), [true, false]);
        assert_eq!(about(&finding("subjoint1 is another")), [false, false]);
        let of_link = finding("weak").about(["link2.izz".to_owned()]);
        assert_eq!(about(&of_link), [false, true]);
    }
}
