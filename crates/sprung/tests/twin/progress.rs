//! Progress that an identification reports while it runs.

use sprung_base::progress::{Answer, Phase, Progress};
use sprung_method::estimate::identify;
use sprung_robot::Estimator;

use crate::in_memory::with_source;
use crate::support::Twin;

#[test]
fn samples_are_counted_then_runs_of_the_filter() {
    let mut twin = Twin::new();
    twin.experiment.identify.estimator = vec![Estimator::PredictionError];
    let mut settings = twin.experiment.simulate.clone().unwrap();
    settings.duration_s = 3.0;
    let mut said = Vec::new();
    let found = with_source(&twin.log(&settings), |source| {
        let mut hear = |progress: Progress| {
            said.push(progress);
            Answer::GoOn
        };
        identify(&twin.experiment, &twin.model, &mut [source], &mut hear).unwrap()
    });
    let identification = &found.identification;
    let refinement = identification.results[0].refinement.as_ref().unwrap();
    let place = |phase| (said.iter()).position(|p: &Progress| p.phase == phase);
    assert!(place(Phase::Preparing) < place(Phase::Reading));
    assert!(place(Phase::Reading) < place(Phase::Refining));
    assert!(place(Phase::Refining) < place(Phase::Examining));
    let of = |phase| said.iter().filter(move |p| p.phase == phase);
    let samples = of(Phase::Reading).next_back();
    let all = identification.log.samples;
    assert_eq!(samples.map(|progress| progress.done), Some(all));
    let runs: Vec<&Progress> = of(Phase::Refining).collect();
    assert_eq!(runs.len(), refinement.runs);
    for (i, progress) in runs.iter().enumerate() {
        assert_eq!(progress.done, i as u64 + 1);
        assert!(progress.total.is_some_and(|most| progress.done <= most));
    }
}
