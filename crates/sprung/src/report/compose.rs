//! Composes the report of an identification, of a validation, or of both, section by section.

use std::collections::BTreeMap;

use super::document::{Badge, Block, Document, Section, Tone};
use super::numbers::{or_dash, significant};
use super::section::{section, shown};
use super::{laws, plots, refinement, robot_tables, stability, tables, validation_tables};
use crate::curves::Curves;
use crate::estimate::{EstimateResult, Identification, LogInfo, Verdict};
use crate::validate::{RunResult, Validation};

/// Contents of a report.
#[derive(Clone, Copy, Debug, Default)]
pub struct Contents<'a> {
    /// The identification.
    pub identification: Option<&'a Identification>,
    /// Every parameter over time.
    pub trace: Option<&'a Curves>,
    /// Filtered right-hand sides over time.
    pub fit: Option<&'a Curves>,
    /// The validation and its signals.
    pub validation: Option<(&'a Validation, &'a Curves)>,
    /// True parameters of a simulated robot, by name.
    pub truth: Option<&'a BTreeMap<String, f64>>,
    /// The command that made the report.
    pub command: &'a str,
    /// The experiment file.
    pub experiment: &'a str,
}

/// Composes a report.
#[must_use]
pub fn compose(contents: &Contents<'_>) -> Document {
    let mut sections = Vec::new();
    let mut document = Document::default();
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
        if let Some(first) = identification.results.first() {
            document.verdict = Some(badge(first));
            document.summary.clone_from(&first.decision.sentence);
        }
        sections.push(parameters(identification, contents));
        sections.push(warnings(identification));
        sections.extend(
            contents
                .trace
                .map(|trace| traces(identification, trace, contents)),
        );
    }
    if let Some((validation, curves)) = contents.validation {
        if document.title.is_empty() {
            document.title.clone_from(&validation.robot);
            document.generator.clone_from(&validation.generator);
            "Validation of given parameters".clone_into(&mut document.subtitle);
        }
        let sentence = validation.sentence();
        document.summary = match document.summary.as_str() {
            "" => sentence,
            decision => format!("{decision} {sentence}"),
        };
        let is_broken =
            |run: &RunResult| (run.sets.first()).is_some_and(|set| set.promise_kept == Some(false));
        if let Some(badge) = &mut document.verdict
            && validation.runs.iter().any(is_broken)
        {
            badge.text.push_str(", promise broken");
            if badge.tone == Tone::Good {
                badge.tone = Tone::Doubtful;
            }
        }
        sections.push(validation_section(validation, curves));
    }
    if let Some(identification) = contents.identification {
        sections.extend(contents.fit.map(|fit| fit_section(identification, fit)));
        sections.extend(laws::laws(identification));
        sections.extend(refinement::refinement(identification));
        sections.push(conditioning(identification));
        sections.extend(cutoff(identification));
        sections.extend(stability::parts(identification));
        sections.extend(links(identification));
    }
    sections.push(settings(contents));
    document.sections = sections;
    document
}

fn badge(result: &EstimateResult) -> Badge {
    Badge {
        tone: match result.verdict {
            Verdict::Good => Tone::Good,
            Verdict::Doubtful => Tone::Doubtful,
            Verdict::Unusable => Tone::Bad,
        },
        text: format!("{}: {}", result.estimator, result.verdict.word()),
    }
}

fn parameters(identification: &Identification, contents: &Contents<'_>) -> Section {
    let table = tables::parameters(identification, contents.truth);
    let mut blocks = vec![Block::Table(table)];
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
             fit cannot shrink links and springs together. Instrumental variables, if requested, do \
             not square the noise of the positions. If all methods agree, the remaining error \
             sources are those that they share: the equations, the delays and the friction law."
                .to_owned(),
        ));
        blocks.push(Block::Table(table));
    }
    blocks.extend(robot_tables::encoder_offsets(identification).map(Block::Table));
    section(
        "parameters",
        "Parameters",
        "Each value with its standard error. A dash means that the log does not determine the \
         value, or that the value was not given.",
        blocks,
    )
}

fn warnings(identification: &Identification) -> Section {
    let mut blocks = Vec::new();
    if !identification.findings.is_empty() {
        blocks.push(Block::Paragraph("About the log:".to_owned()));
        blocks.push(Block::Findings(
            identification.findings.iter().map(shown).collect(),
        ));
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
        if !result.warnings.is_empty() {
            blocks.push(Block::Findings(result.warnings.iter().map(shown).collect()));
        }
    }
    if blocks.is_empty() {
        blocks.push(Block::Paragraph("There are no findings.".to_owned()));
    }
    section(
        "warnings",
        "Findings and verdicts",
        "A serious finding about the log or about a result makes the result unusable, a warning \
         makes it doubtful. Notes do not change the verdict.",
        blocks,
    )
}

fn traces(identification: &Identification, trace: &Curves, contents: &Contents<'_>) -> Section {
    section(
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

fn validation_section(validation: &Validation, curves: &Curves) -> Section {
    let mut blocks = Vec::new();
    for run in &validation.runs {
        blocks.push(Block::Table(validation_tables::predictions(run)));
        if run.simulated {
            blocks.push(Block::Table(validation_tables::errors(run)));
        }
        let of_sets = run.sets.iter().flat_map(|set| &set.findings);
        let findings: Vec<_> = run.findings.iter().chain(of_sets).map(shown).collect();
        if !findings.is_empty() {
            blocks.push(Block::Findings(findings));
        }
        if run.simulated {
            blocks.extend(
                plots::validation(run, curves)
                    .into_iter()
                    .map(Block::Figure),
            );
        }
    }
    section(
        "validation",
        "Validation",
        "For each parameter set, sprung computes torques and deflections from the measured motion, \
         and compares their errors with those that the identification promises. With a controller it \
         also simulates the closed loop from rest, and compares the simulated signals with the log.",
        blocks,
    )
}

fn fit_section(identification: &Identification, fit: &Curves) -> Section {
    section(
        "fit",
        "Fit of the regression",
        "Filtered motor torque: as measured, and as the model computes it from the measured motion. \
         The difference shows effects that the model lacks.",
        vec![Block::Figure(plots::fit(identification, fit))],
    )
}

fn conditioning(identification: &Identification) -> Section {
    let mut pairs = Vec::new();
    if let Some(result) = identification.results.first() {
        pairs.push((
            "Rank of the regressor".to_owned(),
            format!("{} of {}", result.rank, result.parameters.len()),
        ));
        pairs.push((
            "Condition number".to_owned(),
            or_dash(result.condition_number, 4),
        ));
        pairs.push((
            "Condition number, columns scaled".to_owned(),
            or_dash(result.condition_number_scaled, 4),
        ));
        for row in &result.motor_rows {
            pairs.push((
                format!("Condition number of {}'s motor row", row.joint),
                or_dash(row.condition_number, 4),
            ));
        }
    }
    for result in &identification.results {
        if let Some(fit) = &result.simulation {
            pairs.push((
                format!("Cost per sample of {}", result.estimator),
                format!(
                    "{} over {} samples, after {} iterations (about 1 if the loop is exactly known)",
                    significant(fit.cost_per_sample, 4),
                    fit.samples,
                    fit.iterations
                ),
            ));
        }
    }
    let mut blocks = vec![
        Block::KeyValues(pairs),
        Block::Table(tables::residuals(identification)),
    ];
    blocks.extend(tables::excitation(identification).map(Block::Table));
    section(
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
    Some(section(
        "cutoff",
        "Cut-off of the positions",
        "A low cut-off smears reversals of direction, so the fit confuses inertia with friction. A \
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
    Some(section(
        "links",
        "Links",
        "Masses [m], first moments [mx, my, mz] and inertias about the origin of each joint's frame, \
         in its axes.",
        blocks,
    ))
}

/// Returns the number of samples and the treatment of their times, as text.
fn samples(log: &LogInfo) -> String {
    let taken = match (log.sampling.as_str(), log.cycle_s) {
        ("on-cycle", Some(cycle)) => format!(
            "{}, taken at multiples of {} s",
            log.samples,
            significant(cycle, 4)
        ),
        ("as-stamped", _) => format!("{}, taken when stamped", log.samples),
        _ => format!("{}, even", log.samples),
    };
    let counts = [
        (log.interpolated, "interpolated"),
        (log.dropped, "missing, at most three in a row"),
        (log.repeated, "written twice"),
        (log.without_value, "without a value, left out"),
        (log.frozen, "that repeat the preceding sample"),
        (log.gaps, "gaps"),
    ];
    let counted = (counts.into_iter())
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| format!("{count} {what}"));
    let all: Vec<String> = std::iter::once(taken).chain(counted).collect();
    all.join("; ")
}

fn settings(contents: &Contents<'_>) -> Section {
    let mut pairs = Vec::new();
    if let Some(identification) = contents.identification {
        let used = &identification.settings;
        let log = &identification.log;
        pairs.extend([
            ("Sampling period".to_owned(), format!("{} s", log.period_s)),
            (
                "Largest jitter".to_owned(),
                format!("{} % of the period", significant(log.jitter_percent, 2)),
            ),
            ("Samples".to_owned(), samples(log)),
            (
                "Filter pair".to_owned(),
                format!(
                    "λ = {} rad/s, {}",
                    used.filter_cutoff_rad_per_s, used.discretization
                ),
            ),
            (
                "Zero-phase position filter".to_owned(),
                format!(
                    "Butterworth, order {}, {} Hz",
                    used.position_filter_order, used.position_cutoff_hz
                ),
            ),
        ]);
        for (column, delay) in &log.delay_s {
            let error = delay
                .standard_error
                .map_or_else(String::new, |error| format!(" ± {}", significant(error, 2)));
            pairs.push((
                format!("Delay of {column}"),
                format!("{}{error} s", significant(delay.value, 4)),
            ));
        }
        for (column, sign) in &log.sign {
            pairs.push((
                format!("Sign of {column}"),
                format!(
                    "{}, log-likelihood +{} against the other",
                    sign.value,
                    significant(sign.log_likelihood, 3)
                ),
            ));
        }
        for (column, gain) in &log.gain {
            pairs.push((
                format!("Gain of {column}"),
                format!(
                    "{} ± {}",
                    significant(gain.value, 5),
                    significant(gain.standard_error, 2)
                ),
            ));
        }
        for result in &identification.results {
            pairs.push((
                format!("Time for {}", result.estimator),
                format!("{} s", significant(result.elapsed_s, 2)),
            ));
        }
    }
    section(
        "settings",
        "Settings",
        "The command and the experiment file that made this report.",
        vec![
            Block::KeyValues(pairs),
            Block::Code(contents.command.to_owned()),
            Block::Code(contents.experiment.to_owned()),
        ],
    )
}
