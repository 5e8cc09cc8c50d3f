//! Each kind of unknown is found in a log that has it, with its size.

use crate::report;
use crate::twin::{Demo, Table};

/// Columns of `q2_rad`, `tau1_nm` and `tau2_nm`.
const Q2: usize = 1;
const TAU1: usize = 4;
const TAU2: usize = 5;

/// A damage of a log, and the unknown that it must give: kind, places that mean the same, size, and the largest error of the size.
struct Damage {
    kind: &'static str,
    places: &'static [&'static str],
    size: f64,
    tolerance: f64,
    apply: fn(&mut Table),
}

const DAMAGES: [Damage; 7] = [
    // A correction adds the size, so it has the opposite sign of the fault.
    Damage {
        kind: "offset",
        places: &["q2_rad"],
        size: -0.02,
        tolerance: 0.002,
        apply: |table| table.columns[Q2].iter_mut().for_each(|q| *q += 0.02),
    },
    Damage {
        kind: "drift",
        places: &["q2_rad"],
        size: -0.02,
        tolerance: 0.002,
        apply: |table| {
            let count = table.columns[Q2].len() as f64;
            let samples = table.columns[Q2].iter_mut().enumerate();
            samples.for_each(|(k, q)| *q += 0.02 * k as f64 / count);
        },
    },
    Damage {
        kind: "lost-counts",
        places: &["q2_rad"],
        size: -0.01,
        tolerance: 0.001,
        apply: |table| {
            table.columns[Q2]
                .iter_mut()
                .skip(7000)
                .for_each(|q| *q += 0.01);
        },
    },
    Damage {
        kind: "gain",
        // The log tells a factor of one encoder only against the other.
        places: &["q2_rad", "phi2_rad"],
        size: 0.02,
        tolerance: 0.004,
        apply: |table| table.columns[Q2].iter_mut().for_each(|q| *q *= 1.02),
    },
    Damage {
        kind: "delay",
        places: &["q2_rad"],
        size: 0.02,
        tolerance: 0.002,
        apply: |table| {
            table.columns[Q2].rotate_right(20);
            let first = table.columns[Q2][20];
            table.columns[Q2][..20].fill(first);
        },
    },
    Damage {
        kind: "saturation",
        places: &["tau2_nm"],
        size: 0.03,
        tolerance: 0.012,
        apply: |table| {
            let torques = &mut table.columns[TAU2];
            let squares = torques.iter().map(|torque| torque * torque).sum::<f64>();
            let mean_square = squares / torques.len() as f64;
            for torque in torques {
                *torque += 0.03 * torque.powi(3) / mean_square;
            }
        },
    },
    Damage {
        kind: "law",
        places: &["joint1"],
        size: 0.3,
        tolerance: 0.02,
        apply: |table| (table.columns[TAU1].iter_mut()).for_each(|torque| *torque += 0.3),
    },
];

#[test]
fn each_kind_is_found_alone_with_its_size() {
    let demo = Demo::new();
    for Damage {
        kind,
        places,
        size,
        tolerance,
        apply,
    } in &DAMAGES
    {
        let mut table = demo.table(1, 1.0);
        apply(&mut table);
        let report = report(&demo.experiment, &table);
        let [found] = &report.unknowns[..] else {
            panic!("{kind}: {:#?}", report.unknowns);
        };
        assert_eq!(found.kind, *kind, "{found:#?}");
        assert!(places.contains(&found.place.as_str()), "{found:#?}");
        let value = if *kind == "gain" {
            found.value.abs()
        } else {
            found.value
        };
        assert!((value - size).abs() < *tolerance, "{found:#?}");
        assert!(
            found.standard_error > 0.0 && found.effect > 0.0,
            "{found:#?}"
        );
    }
}
