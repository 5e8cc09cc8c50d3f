//! Tables of figures: the demo, and the motions for each parameter.

use serde_json::Value;

use super::{beside_the_demo, blocks, of_repository, run_commands};
use crate::common::demo;

const BENCHMARKS: &str = "docs/reference/benchmarks.md";
const MOTION: &str = "docs/how-to/what-motion-to-record.md";

/// Returns a parameter of a result.
fn parameter<'a>(result: &'a Value, name: &str) -> &'a Value {
    let all = result["parameters"].as_array().unwrap();
    (all.iter().find(|one| one["name"] == name)).unwrap_or_else(|| panic!("no {name}"))
}

/// Returns the cells of the rows of a table whose first cell begins with a backquote.
fn rows(section: &str) -> Vec<Vec<&str>> {
    let lines = section.lines().filter(|line| line.starts_with("| `"));
    lines
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect()
}

#[test]
fn the_demo_has_the_errors_of_the_table() {
    let page = of_repository(BENCHMARKS);
    let section = page.split("## The demo").nth(1).unwrap();
    let table = &blocks(section, "text")[0];
    let text = std::fs::read_to_string(demo().join("sprung-out/identification.json")).unwrap();
    let results: Value = serde_json::from_str(&text).unwrap();
    let results = results["results"].as_array().unwrap();
    let lines: Vec<Vec<&str>> = (table.lines().skip(1))
        .map(|line| line.split_whitespace().collect())
        .collect();
    assert_eq!(lines.len(), 15);
    for cells in lines {
        let number = |k: usize| cells[k].parse::<f64>().unwrap();
        let truth = number(2);
        for (k, result) in results.iter().enumerate() {
            let found = parameter(result, cells[0]);
            let [value, error] =
                ["value", "standard_error"].map(|key| found[key].as_f64().unwrap());
            // Another processor may round otherwise; a tenth of a standard error is no other result.
            let (shown, percent) = (number(3 + 2 * k), number(4 + 2 * k));
            assert!((shown - value).abs() <= 0.1 * error, "{cells:?} {value}");
            let off = 100.0 * (value / truth - 1.0);
            let limit = 10.0 * error / truth + 0.06;
            assert!((percent - off).abs() <= limit, "{cells:?} {off}");
        }
    }
}

#[test]
fn motions_have_the_standard_errors_of_the_table() {
    let page = of_repository(MOTION);
    let folder = beside_the_demo();
    let printed = run_commands(&page, folder.path());
    let header = (page.lines().find(|line| line.starts_with("| motion |"))).unwrap();
    let names: Vec<&str> = (header.split('`').skip(1).step_by(2)).collect();
    let rows = rows(page.split("| motion |").nth(1).unwrap());
    assert_eq!(rows.len(), printed.len());
    for (cells, table) in rows.iter().zip(&printed) {
        assert_eq!(cells.len(), names.len() + 1);
        for (cell, name) in cells[1..].iter().zip(&names) {
            let line = table
                .lines()
                .find(|line| line.trim_start().starts_with(name));
            let last = line.and_then(|line| line.split_whitespace().last());
            let [shown, now] = [cell, last.unwrap()].map(|text| text.parse::<f64>().unwrap());
            assert!(
                (shown / now - 1.0).abs() < 0.1,
                "{name}: {cells:?} on the page, now\n{table}"
            );
        }
    }
}
