use sprung::{demo, description, estimate::*, log::*, model::Model, simulate::*};
use std::collections::BTreeMap;
use std::time::Instant;
fn main() {
    let mut e = description::read(
        "e",
        demo::EXPERIMENT,
        &std::env::args().skip(1).collect::<Vec<_>>(),
    )
    .unwrap();
    let m = Model::new(&e.robot).unwrap();
    let t: BTreeMap<String, f64> = toml::from_str(demo::TRUTH).unwrap();
    let th = m.theta(&t).unwrap();
    let ch = Channels::new(&e.robot, e.log.as_ref().unwrap(), None).unwrap();
    let mut all: BTreeMap<String, Vec<Vec<f64>>> = BTreeMap::new();
    for seed in 0..10u64 {
        let mut tw = e.simulate.clone().unwrap();
        tw.seed = seed;
        let mut buf = vec![];
        record(
            &e.robot,
            &m,
            &th,
            e.controller.as_ref().unwrap(),
            &tw,
            &ch,
            &mut buf,
            &mut |_| (),
        )
        .unwrap();
        let b = std::sync::Arc::new(buf);
        let mut rd = || Ok(Box::new(std::io::Cursor::new(b.to_vec())) as Box<dyn std::io::Read>);
        for d in [
            description::DiscretizationName::Paper,
            description::DiscretizationName::Matched,
        ] {
            e.identify.discretization = d;
            let s = Instant::now();
            let id = identify(
                &e,
                &m,
                &mut LogSource {
                    name: "l".into(),
                    reader: &mut rd,
                },
                &mut |_| (),
            )
            .unwrap();
            let el = s.elapsed();
            if seed == 0 {
                println!(
                    "{:?} {:?}",
                    el,
                    id.identification
                        .results
                        .iter()
                        .map(|r| (
                            r.estimator.clone(),
                            r.elapsed_s,
                            r.condition_number,
                            r.condition_number_scaled,
                            r.verdict,
                            r.residual_rms.clone()
                        ))
                        .collect::<Vec<_>>()
                );
                if let Some(r) = id.identification.results.first() {
                    for p in &r.parameters {
                        println!("{} {:?} se {:?}", p.name, p.value, p.standard_error)
                    }
                    for w in &r.warnings {
                        println!("{} {}", w.code, w.text)
                    }
                }
            }
            for r in &id.identification.results {
                all.entry(format!("{} {}", r.estimator, d.name()))
                    .or_default()
                    .push(
                        r.parameters
                            .iter()
                            .zip(&th)
                            .map(|(p, t)| 100. * (p.value.unwrap_or(f64::NAN) / t - 1.))
                            .collect(),
                    );
            }
        }
    }
    for (k, v) in all {
        let mean: Vec<f64> = (0..15)
            .map(|i| v.iter().map(|x| x[i]).sum::<f64>() / v.len() as f64)
            .collect();
        let mut a: Vec<f64> = v.iter().flatten().map(|x| x.abs()).collect();
        a.sort_by(f64::total_cmp);
        println!("{k}: median {:.2} mean {:.1?}", a[a.len() / 2], mean);
    }
}
