//! Composes the report of an identification, of a validation, or of both, section by section.

use super::contents::Contents;
use super::document::{Block, Document, Fold, Section};
use super::numbers::{or_dash, significant};
use super::overview::overview;
use super::section::{findings, folded, section};
use super::verdict::Head;
use super::{
    glossary, joints, laws, payload, plots, refinement, robot_tables, settings, springs, stability,
    tables, unknowns, validation_tables,
};
use crate::curves::Curves;
use crate::estimate::Identification;
use crate::finding::{Finding, Severity};
use crate::validate::Validation;

/// Composes a report.
#[must_use]
pub fn compose(contents: &Contents<'_>) -> Document {
    let validation = contents.validation.map(|(validation, _)| validation);
    let head = Head::of(contents.identification, validation);
    let mut document = Document {
        verdict: head.badge,
        summary: head.summary,
        reason: head.reason,
        avoid: head.avoid,
        what_to_do: head.what_to_do,
        ..Document::default()
    };
    if let Some(identification) = contents.identification {
        document.generator.clone_from(&identification.generator);
        document.title.clone_from(&identification.robot);
        let logs = || identification.logs();
        document.subtitle = format!(
            "Parameters identified from {} ({} samples, {} s)",
            identification.files(),
            logs().map(|log| log.samples).sum::<u64>(),
            significant(logs().map(|log| log.duration_s).sum(), 4)
        );
    } else if let Some(validation) = validation {
        document.generator.clone_from(&validation.generator);
        document.title.clone_from(&validation.robot);
        "Validation of given parameters".clone_into(&mut document.subtitle);
    }
    let sections = &mut document.sections;
    sections.extend(contents.identification.and_then(joints::summary));
    sections.extend(overview(contents));
    if let Some(identification) = contents.identification {
        sections.extend(laws::applied(identification));
        sections.extend(unknowns::unknowns(&identification.unknowns));
        sections.extend(parameters(identification, contents));
        sections.push(warnings(identification));
    }
    if let Some((validation, curves)) = contents.validation {
        let fold = match contents.identification {
            Some(_) => Fold::Screen,
            None => Fold::Open,
        };
        sections.push(validation_section(validation, fold));
        sections.extend(signals(validation, curves));
    }
    if let Some(identification) = contents.identification {
        sections.extend(joints::pages(identification, contents));
        sections.extend(estimators(identification, contents));
        sections.extend(payload::payloads(identification));
        sections.extend(links(identification));
        sections.extend(stability::parts(identification));
        sections.extend(
            contents
                .trace
                .map(|trace| traces(identification, trace, contents)),
        );
        sections.extend(contents.fit.map(|fit| fit_section(identification, fit)));
        sections.extend(cross_checks(identification));
        sections.extend(springs::springs(identification));
        sections.extend(springs::sensed(identification));
        sections.extend(springs::rigid(identification));
        sections.extend(laws::laws(identification));
        sections.extend(refinement::refinement(identification));
        sections.push(conditioning(identification));
        sections.extend(cutoff(identification));
        sections.extend(glossary::glossary(identification));
    }
    sections.extend(settings::settings(contents));
    document
}

fn parameters(identification: &Identification, contents: &Contents<'_>) -> Option<Section> {
    let mut blocks = vec![Block::Table(tables::parameters(
        identification,
        contents.truth,
        None,
    )?)];
    blocks.extend(robot_tables::encoder_offsets(identification).map(Block::Table));
    Some(section(
        "parameters",
        "Parameters",
        "Each value with its standard error (s.e.), the typical size of its error.",
        blocks,
    ))
}

fn estimators(identification: &Identification, contents: &Contents<'_>) -> Option<Section> {
    let table = tables::estimators(identification, contents.truth)?;
    Some(folded(
        Fold::Detail,
        "estimators",
        "All estimators",
        "Other methods computed the same parameters from the same log. The report above is about \
         the first one.",
        vec![Block::Table(table)],
    ))
}

/// Composes the section that compares the result with the same parameters by other routes.
fn cross_checks(identification: &Identification) -> Option<Section> {
    let mut blocks = Vec::new();
    if let Some(table) = tables::motor_rows(identification) {
        blocks.push(Block::Paragraph(
            "The motor row of a joint contains the measured torque, which fixes the scale of its \
             parameters. The link rows have no right-hand side, so noise shrinks the parameters of \
             links and springs. If the two stiffnesses differ, look for delays and noise of the link \
             positions."
                .to_owned(),
        ));
        blocks.push(Block::Table(table));
    }
    if let Some(table) = tables::cross_checks(identification) {
        blocks.push(Block::Paragraph(
            "The cross-checks have other error sources. The two-stage fit and the scale-invariant \
             fit cannot shrink links and springs together. If all methods agree, the remaining error \
             sources are those that they share: the equations, the delays and the friction law."
                .to_owned(),
        ));
        blocks.push(Block::Table(table));
    }
    (!blocks.is_empty()).then(|| {
        folded(
            Fold::Detail,
            "cross-checks",
            "Cross-checks",
            "The same parameters by other routes through the equations. Values that agree do not \
             depend on the route.",
            blocks,
        )
    })
}

fn warnings(identification: &Identification) -> Section {
    let mut blocks = Vec::new();
    if let Some(found) = findings(&identification.findings) {
        blocks.push(Block::Paragraph("About the log:".to_owned()));
        blocks.push(found);
    }
    for (at, result) in identification.results.iter().enumerate() {
        // The report begins with the sentence about the first result.
        let sentence = match at {
            0 => "",
            _ => &result.decision.sentence,
        };
        if sentence.is_empty() && result.warnings.is_empty() {
            continue;
        }
        blocks.push(Block::Paragraph(
            format!("About {}: {sentence}", result.estimator)
                .trim_end()
                .to_owned(),
        ));
        blocks.extend(findings(&result.warnings));
    }
    if blocks.is_empty() {
        blocks.push(Block::Paragraph("There are no findings.".to_owned()));
    }
    let first = identification.results.first().into_iter();
    let deciding = first
        .flat_map(|result| &result.warnings)
        .chain(&identification.findings);
    let (counts, is_above_notes) = counted(deciding);
    Section {
        fold: if is_above_notes {
            Fold::Open
        } else {
            Fold::Detail
        },
        ..section(
            "warnings",
            "Findings",
            &format!(
                "About the log and the first result: {counts}. A serious finding makes the result \
                 unusable, a warning makes it doubtful. Notes do not change the verdict.",
            ),
            blocks,
        )
    }
}

/// Returns the numbers of findings by severity in words, and whether any is more than a note.
fn counted<'a>(findings: impl IntoIterator<Item = &'a Finding>) -> (String, bool) {
    let [mut serious, mut warnings, mut notes] = [0, 0, 0];
    for finding in findings {
        match finding.severity {
            Severity::Info => notes += 1,
            Severity::Warning => warnings += 1,
            Severity::Serious | Severity::Error => serious += 1,
        }
    }
    let parts = [
        (serious, "serious finding"),
        (warnings, "warning"),
        (notes, "note"),
    ];
    let words = parts.map(|(count, word)| {
        let plural = if count == 1 { "" } else { "s" };
        format!("{count} {word}{plural}")
    });
    (words.join(", "), serious + warnings > 0)
}

fn traces(identification: &Identification, trace: &Curves, contents: &Contents<'_>) -> Section {
    folded(
        Fold::Detail,
        "traces",
        "Parameters over time",
        "The estimate from the log up to each time. A settled value no longer depends on the length \
         of the log. A value that still drifts or oscillates is not reliable.",
        vec![Block::Figure(plots::traces(
            identification,
            trace,
            contents.truth,
        ))],
    )
}

fn validation_section(validation: &Validation, fold: Fold) -> Section {
    let mut blocks = Vec::new();
    for run in &validation.runs {
        blocks.push(Block::Table(validation_tables::predictions(run)));
        if run.simulated {
            blocks.push(Block::Table(validation_tables::errors(run)));
        }
        let of_sets = run.sets.iter().flat_map(|set| &set.findings);
        blocks.extend(findings(run.findings.iter().chain(of_sets)));
    }
    folded(
        fold,
        "validation",
        "Validation",
        "The model predicts logs that were not used to fit it. sprung computes torques and \
         deflections from the measured motion and compares their errors with the promised ones. With \
         a controller it also simulates the closed loop from rest.",
        blocks,
    )
}

/// Composes the section with the signals of simulated loops; `None` without simulations.
fn signals(validation: &Validation, curves: &Curves) -> Option<Section> {
    let runs = validation.runs.iter().filter(|run| run.simulated);
    let figures = runs.flat_map(|run| plots::validation(run, curves));
    let blocks: Vec<Block> = figures.map(Block::Figure).collect();
    (!blocks.is_empty()).then(|| {
        folded(
            Fold::Detail,
            "signals",
            "Measured and simulated signals",
            "Each signal of the simulated closed loop beside the measured one, and their difference.",
            blocks,
        )
    })
}

fn fit_section(identification: &Identification, fit: &Curves) -> Section {
    folded(
        Fold::Detail,
        "fit",
        "Fit of the regression",
        "Filtered torque and deflection: as measured, and as the model computes them from the \
         measured motion. The difference shows effects that the model lacks.",
        vec![Block::Figure(plots::fit(identification, fit))],
    )
}

fn conditioning(identification: &Identification) -> Section {
    let mut pairs = Vec::new();
    if let Some(result) = identification.results.first() {
        let rank = format!("{} of {}", result.rank, result.parameters.len());
        pairs.push(("Rank of the regressor".to_owned(), rank));
        let mut add = |name: &str, number| pairs.push((name.to_owned(), or_dash(number, 4)));
        add("Condition number", result.condition_number);
        add(
            "Condition number, columns scaled",
            result.condition_number_scaled,
        );
        for row in &result.motor_rows {
            let name = format!("Condition number of {}'s motor row", row.joint);
            add(&name, row.condition_number);
        }
    }
    let mut blocks = vec![
        Block::KeyValues(pairs),
        Block::Table(tables::residuals(identification)),
    ];
    blocks.extend(tables::excitation(identification).map(Block::Table));
    folded(
        Fold::Detail,
        "conditioning",
        "Excitation and conditioning",
        "These figures show how well the motion distinguishes the parameters. A scaled condition \
         number below 100 is good. The residuals are root mean squares over the whole log.",
        blocks,
    )
}

/// Composes the section about the choice of the position cut-off and the estimates at other
/// cut-offs.
fn cutoff(identification: &Identification) -> Option<Section> {
    let choice = identification.settings.position_cutoff_choice.as_ref()?;
    let mut blocks = vec![Block::Paragraph(format!(
        "{} Hz: {}.",
        significant(identification.settings.position_cutoff_hz, 3),
        choice.reason
    ))];
    blocks.extend(stability::held_out(choice).map(Block::Bars));
    blocks.extend(robot_tables::cutoffs(identification, choice).map(Block::Table));
    Some(folded(
        Fold::Detail,
        "cutoff",
        "Cut-off of the positions",
        "Before the fit, a low-pass filter removes the noise of the encoders. A low cut-off smears reversals of direction, so the fit confuses inertia with friction. A \
         high cut-off passes the noise of the encoders. If estimates change much with the cut-off, \
         one of these errors is near.",
        blocks,
    ))
}

/// Composes the section about the standard parameters of the links of a tree.
fn links(identification: &Identification) -> Option<Section> {
    let result = identification.results.first()?;
    let lumped = robot_tables::lumped(result);
    let standard = robot_tables::standard(result)?;
    let mut blocks = Vec::new();
    if !lumped.is_empty() {
        blocks.push(Block::Paragraph(
            "The motion determines only combinations of the links' masses, first moments and \
             inertias:"
                .to_owned(),
        ));
        blocks.push(Block::KeyValues(lumped));
    }
    blocks.push(Block::Table(standard));
    Some(folded(
        Fold::Screen,
        "links",
        "Links",
        "Parameters of each link for a simulator or a controller: masses [m], first moments [mx, my, \
         mz] and inertias about the origin of each joint's frame, in its axes.",
        blocks,
    ))
}
