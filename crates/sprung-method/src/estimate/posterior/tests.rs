use super::*;
use crate::description::{self, no_files};
use crate::estimate::result::{EstimateResult, Identification};
use crate::model::Model;

#[test]
fn tmp_panda() {
    let text = std::fs::read_to_string("/work/shared/data/franka_panda/experiment.toml").unwrap();
    let experiment = description::read("panda", &text, &[], &mut no_files).unwrap();
    let model = Model::new(&experiment).unwrap();
    let found: Identification = serde_json::from_str(
        &std::fs::read_to_string("/tmp/post_try/panda/identification.json").unwrap(),
    )
    .unwrap();
    let result: &EstimateResult = &found.results[0];
    let t = std::time::Instant::now();
    let posterior = Posterior::new(&model, &experiment.identify.physical, result).unwrap();
    println!("new {:?}", t.elapsed());
    let t = std::time::Instant::now();
    let samples = posterior.sample(1000, 1).unwrap();
    println!(
        "sample {:?} {:?} {}",
        t.elapsed(),
        samples.method,
        samples.effective
    );
    println!(
        "{:?}\n{:?}",
        samples.undetermined, samples.undetermined_standard
    );
    let moments = |of: &dyn Fn(usize) -> f64| {
        let n = samples.theta.len() as f64;
        let m = (0..samples.theta.len()).map(of).sum::<f64>() / n;
        let v = (0..samples.theta.len())
            .map(|i| (of(i) - m).powi(2))
            .sum::<f64>()
            / n;
        let c = (1..samples.theta.len())
            .map(|i| (of(i) - m) * (of(i - 1) - m))
            .sum::<f64>()
            / n
            / v;
        (m, v.sqrt(), c)
    };
    for (k, own) in result.parameters.iter().enumerate() {
        let (m, s, c) = moments(&|i| samples.theta[i][k]);
        println!(
            "{:30.30} value {:9.4} ± {:8.4} [{:9.4} {:9.4}] uncon {:9.4} ± {:8.4}  draws {m:9.4} ± {s:8.4} corr {c:5.2}",
            own.name,
            own.value.unwrap(),
            own.standard_error.unwrap(),
            own.ci95.unwrap()[0],
            own.ci95.unwrap()[1],
            own.unconstrained.unwrap(),
            own.error_by_equations().unwrap()
        );
    }
    for k in (0..70).filter(|k| k % 10 < 5).chain(70..77) {
        let (m, s, c) = moments(&|i| samples.standard[i][k]);
        println!(
            "{:20} {:8.4} draws {m:8.4} ± {s:8.4} corr {c:5.2}",
            samples.standard_parameters[k], result.standard_parameters[k].value
        );
    }
}
