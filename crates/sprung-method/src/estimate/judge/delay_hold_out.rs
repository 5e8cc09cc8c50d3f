//! Tests a delay by likelihood in a blocked cross-validation, before it is recommended.

use crate::finding::{Finding, Severity};
use crate::prepare::{DelayGain, Prepared};

/// Returns a finding about a late channel with the effect of its delay on the held-out error of the
/// motor torques. A delay that does not lower this error is not recommended. Other findings stay.
pub(in crate::estimate) fn with_held_out_delay(
    mut finding: Finding,
    prepared: &Prepared,
) -> Finding {
    let file = prepared.names().first();
    if let (Some(evidence), Some(file)) = (&mut finding.evidence, file)
        && evidence.file.is_empty()
    {
        evidence.file.clone_from(file);
    }
    let Some(gain) = gain(&finding, prepared) else {
        return finding;
    };
    let words = gain.words();
    if gain.is_lower() {
        finding.text = format!(
            "{}. With this delay the held-out error of the motor torques goes {words}",
            finding.text
        );
    } else {
        "delay-rejected".clone_into(&mut finding.code);
        finding.severity = Severity::Info;
        finding.setting = None;
        finding.text = format!(
            "{}; but with this delay the held-out error of the motor torques goes {words}, so sprung \
             does not recommend it. The confidence intervals contain its effect",
            finding.text
        );
        "nothing; a friction law or another effect may be missing in the model"
            .clone_into(&mut finding.remedy);
    }
    finding
}

fn gain(finding: &Finding, prepared: &Prepared) -> Option<DelayGain> {
    (finding.code == "late-channel").then_some(())?;
    let evidence = finding.evidence.as_ref()?;
    let (reading, column) = (prepared.reading(), evidence.column.as_ref()?);
    let channels = &reading.channels().all;
    let channel = (channels.iter()).position(|channel| channel.column == *column)?;
    DelayGain::of(prepared.excerpt(), reading, channel, evidence.value)
}
