//! The arm of the paper with nominal values that are off by a factor of two: a first small motion, a second one with
//! the identified values, and a design with true values.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sprung::session::{ExciteMethod, ExciteRequest, Parameters};
use sprung_base::demo;
use sprung_base::progress::Unheard;
use sprung_method::excite::Excited;
use sprung_testing::Figure;

use super::two::{identified, limits, nominal, paper_peaks, truth, with_reference};
use super::{errors, excite, judged, mean_ratio, reference, session, session_with};

/// Factor of wrong values.
const OFF: f64 = 2.0;

pub(crate) fn run(robots: u64) {
    let peaks = paper_peaks();
    let limits = limits(&peaks, 1.0, 1.0);
    let with = |values: &[(String, f64)]| {
        let mut set = nominal(values);
        set.extend(limits.iter().cloned());
        set
    };
    let truth = truth();
    // Judges a motion on the true robot.
    let of_truth = |reference: &str| -> Excited {
        let session = session_with(demo::EXPERIMENT, &with(&truth), demo::TRUTH, reference);
        judged(&session).expect("a judged motion")
    };
    let known = session(demo::EXPERIMENT, &with(&truth), demo::TRUTH);
    let best = excite(&known, ExciteMethod::Optimal, None).expect("a motion");
    let best = of_truth(&reference(&known, &best));
    let mut worst: f64 = 0.0;
    for seed in 1..=robots {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut factor = || if rng.random_bool(0.5) { OFF } else { 1.0 / OFF };
        // One factor for the inertias of the links keeps the robot possible.
        let of_links = factor();
        let wrong: Vec<(String, f64)> = (truth.iter())
            .map(|(name, value)| {
                let of_joint = factor();
                let factor = if name.starts_with("link") {
                    of_links
                } else {
                    of_joint
                };
                (name.clone(), factor * value)
            })
            .collect();
        let mut set = with(&wrong);
        set.push(format!("excite.value_error={}", OFF - 1.0));
        let unknown = session(demo::EXPERIMENT, &set, demo::TRUTH);
        let request = ExciteRequest {
            is_warm_up: true,
            ..ExciteRequest::default()
        };
        let first = (unknown.excite(&request, None, &mut Unheard)).expect("a first motion");
        let first = reference(&unknown, &first);
        let found = identified(&with_reference(&first), seed);
        let values = Parameters::from(found.identification);
        let unknown = session(demo::EXPERIMENT, &with(&wrong), demo::TRUTH);
        let second =
            excite(&unknown, ExciteMethod::Optimal, Some(&values)).expect("a second motion");
        let used = |excited: &Excited| excited.excitation.limits[0].used_percent;
        let (first, second) = (of_truth(&first), of_truth(&reference(&unknown, &second)));
        println!(
            "{seed}: standard errors of the first motion {:.2}, of the second {:.3} times those of the design with true values; \
             limits of the true robot used to {:.0} and {:.1} %",
            mean_ratio(&errors(&first), &errors(&best)),
            mean_ratio(&errors(&second), &errors(&best)),
            used(&first),
            used(&second)
        );
        worst = worst.max(mean_ratio(&errors(&second), &errors(&best)));
    }
    let text = format!(
        "nominal values off by a factor of two, two rounds, the worst of {robots} robots: standard errors over those of a \
         design with true values"
    );
    Figure::lower("rounds", &text, worst, "times").note();
}
