//! Reads the poses of a path.

use std::path::Path;

use crate::session::control_error::ControlError;
use crate::session::error::SessionError;
use crate::session::files::read_text;
use crate::session::load::Session;

impl Session {
    /// Reads the poses of a path: evenly spaced rows of a CSV file, at most `most`.
    ///
    /// - `joints`: names of the columns; `limits`: lowest and highest positions, \[n\].
    pub(super) fn path(
        &self,
        file: &Path,
        joints: &[String],
        limits: &[Option<[f64; 2]>],
        most: usize,
    ) -> Result<Vec<Vec<f64>>, SessionError> {
        let path = self.folder.join(file);
        let text = read_text(&*self.files, &path)?;
        let poses = poses(&text, joints, limits).map_err(|why| ControlError::Path {
            file: path.display().to_string(),
            why,
        })?;
        let last = poses.len() - 1;
        let count = most.min(poses.len());
        let place = |k: usize| {
            if count == 1 {
                0
            } else {
                k * last / (count - 1)
            }
        };
        Ok((0..count).map(|k| poses[place(k)].clone()).collect())
    }
}

fn poses(
    text: &str,
    joints: &[String],
    limits: &[Option<[f64; 2]>],
) -> Result<Vec<Vec<f64>>, String> {
    let mut lines = text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty());
    let (_, header) = lines.next().ok_or("the file is empty")?;
    let names: Vec<&str> = header
        .split(',')
        .map(|name| name.trim().trim_matches('"'))
        .collect();
    let columns = joints.iter().map(|joint| {
        let mut names = names.iter();
        names
            .position(|name| name == joint)
            .ok_or_else(|| format!("its first line has no column \"{joint}\""))
    });
    let columns: Vec<usize> = columns.collect::<Result<_, _>>()?;
    let mut poses = Vec::new();
    for (index, line) in lines {
        let line_number = index + 1;
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let mut pose = Vec::with_capacity(columns.len());
        for ((column, joint), limits) in columns.iter().zip(joints).zip(limits) {
            let cell = cells.get(*column).copied().unwrap_or_default();
            let value: f64 = (cell.parse().ok())
                .filter(|value: &f64| value.is_finite())
                .ok_or_else(|| {
                    format!("line {line_number}, column \"{joint}\": \"{cell}\" is no number")
                })?;
            if let Some([low, high]) = limits
                && !(*low..=*high).contains(&value)
            {
                return Err(format!(
                    "line {line_number}: {joint} = {value} rad is outside its limits, {low} to {high}"
                ));
            }
            pose.push(value);
        }
        poses.push(pose);
    }
    if poses.is_empty() {
        return Err("it has no row of positions".to_owned());
    }
    Ok(poses)
}
