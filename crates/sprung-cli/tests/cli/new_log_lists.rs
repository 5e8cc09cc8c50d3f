//! `sprung new --log` takes elements of lists as columns.

use std::fs::File;
use std::sync::Arc;

use arrow_array::builder::{Float64Builder, ListBuilder, StringBuilder};
use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use parquet::arrow::ArrowWriter;

use crate::common::contains;
use crate::renamed_log::{begun, is_identified, recorded};

/// Writes positions and torques as lists, as a table of `JointState` messages has them.
fn lists(path: &std::path::Path, log: &[Vec<f64>], names: Option<[&str; 2]>) {
    let list = |columns: [&Vec<f64>; 2]| -> ArrayRef {
        let mut builder = ListBuilder::new(Float64Builder::new());
        for (k, value) in columns[0].iter().enumerate() {
            // With names the order may change from row to row.
            let swapped = names.is_some() && k % 2 == 1;
            let pair = [*value, columns[1][k]];
            let pair = if swapped { [pair[1], pair[0]] } else { pair };
            builder.values().append_slice(&pair);
            builder.append(true);
        }
        Arc::new(builder.finish())
    };
    let mut columns: Vec<(&str, ArrayRef)> = vec![
        ("stamp_s", Arc::new(Float64Array::from(log[0].clone()))),
        ("position", list([&log[1], &log[2]])),
        ("motor_position", list([&log[3], &log[4]])),
        ("effort", list([&log[5], &log[6]])),
    ];
    if let Some(names) = names {
        let mut builder = ListBuilder::new(StringBuilder::new());
        for k in 0..log[0].len() {
            let ordered = if k % 2 == 1 {
                [names[1], names[0]]
            } else {
                names
            };
            for name in ordered {
                builder.values().append_value(name);
            }
            builder.append(true);
        }
        columns.push(("name", Arc::new(builder.finish())));
    }
    let batch = RecordBatch::try_from_iter(columns).unwrap();
    let mut writer =
        ArrowWriter::try_new(File::create(path).unwrap(), batch.schema(), None).unwrap();
    writer.write(&batch).unwrap();
    writer.close().unwrap();
}

#[test]
fn lists_of_parquet_are_columns() {
    let (desk, log) = recorded();
    lists(&desk.path("plain.parquet"), &log, None);
    lists(
        &desk.path("named.parquet"),
        &log,
        Some(["shoulder", "elbow"]),
    );
    for file in ["plain.parquet", "named.parquet"] {
        let text = begun(&desk, file);
        assert!(!text.contains("= \"FILL IN\""), "{text}");
        is_identified(&desk);
        // One pattern represents the elements of a list.
        desk.write(
            "exp/experiment.toml",
            format!(
                "format = 1\n[robot]\nurdf = \"../arm.urdf\"\n[[robot.joint]]\nname = \"shoulder\"\n\
                 [[robot.joint]]\nname = \"elbow\"\n[log]\nfile = \"../{file}\"\ntime_s = \"stamp_s\"\n\
                 link_position_rad = \"position[*]\"\nmotor_position_rad = \"motor_position[*]\"\n\
                 motor_torque_nm = \"effort[*]\"\n"
            ),
        );
        is_identified(&desk);
        // The check shows which element it took.
        let said = desk.succeeds(&["check", "exp"]);
        let element = if file == "plain.parquet" {
            "1"
        } else {
            "elbow"
        };
        let shown = format!("effort[*][elbow] = effort[{element}]");
        contains(&said, &[&shown]);
        std::fs::remove_dir_all(desk.path("exp")).unwrap();
    }
}
