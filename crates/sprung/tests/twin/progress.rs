//! How far an identification is, as it says while it runs.

use sprung::description::Estimator;
use sprung::estimate::{Progress, identify};

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
        let mut hear = |progress| said.push(progress);
        identify(&twin.experiment, &twin.model, &mut [source], &mut hear).unwrap()
    });
    let identification = &found.identification;
    let refinement = identification.results[0].refinement.as_ref().unwrap();
    let first_run = (said.iter()).position(|p| matches!(p, Progress::FilterRun { .. }));
    let (samples, runs) = said.split_at(first_run.unwrap());
    let all = identification.log.samples;
    assert_eq!(samples.last(), Some(&Progress::Samples(all)));
    assert_eq!(runs.len(), refinement.runs);
    for (i, progress) in runs.iter().enumerate() {
        let Progress::FilterRun { run, most } = *progress else {
            panic!("{progress:?} after the filter began")
        };
        assert_eq!(run, i + 1);
        assert!(run <= most);
    }
}
