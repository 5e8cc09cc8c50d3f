//! Each kind of unknown is found in a log that has it, with its size.

use crate::report;
use crate::twin::{Demo, Table};

/// Column of `q2_rad` and of the time.
const Q2: usize = 1;

/// A damage of a log, and the unknown that it must give: kind, size, and the largest error of the size.
struct Damage {
    kind: &'static str,
    size: f64,
    tolerance: f64,
    apply: fn(&mut Table),
}

const DAMAGES: [Damage; 5] = [
    // A correction adds the size, so it has the opposite sign of the fault.
    Damage {
        kind: "offset",
        size: -0.02,
        tolerance: 0.002,
        apply: |table| table.columns[Q2].iter_mut().for_each(|q| *q += 0.02),
    },
    Damage {
        kind: "drift",
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
        size: 0.02,
        tolerance: 0.004,
        apply: |table| table.columns[Q2].iter_mut().for_each(|q| *q *= 1.02),
    },
    Damage {
        kind: "delay",
        size: 0.02,
        tolerance: 0.002,
        apply: |table| {
            table.columns[Q2].rotate_right(20);
            let first = table.columns[Q2][20];
            table.columns[Q2][..20].fill(first);
        },
    },
];

#[test]
fn each_kind_is_found_alone_with_its_size() {
    let demo = Demo::new();
    for Damage {
        kind,
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
        assert!(
            found.place == "q2_rad" || *kind == "gain" && found.place == "phi2_rad",
            "{found:#?}"
        );
        // The log tells a factor of one encoder only against the other.
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
