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
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.as_bytes());
    let header = reader.headers().map_err(|error| error.to_string())?.clone();
    let column = |joint: &String| {
        let mut names = header.iter();
        names
            .position(|name| name == joint)
            .ok_or_else(|| format!("its first line has no column \"{joint}\""))
    };
    let columns: Vec<usize> = joints.iter().map(column).collect::<Result<_, _>>()?;
    let mut poses = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| error.to_string())?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut pose = Vec::with_capacity(columns.len());
        for ((column, joint), limits) in columns.iter().zip(joints).zip(limits) {
            let cell = record.get(*column).unwrap_or_default();
            let value = (cell.parse().ok()).filter(|value: &f64| value.is_finite());
            let value = value.ok_or_else(|| {
                format!("line {line}, column \"{joint}\": \"{cell}\" is no number")
            })?;
            if let Some([low, high]) = limits
                && !(*low..=*high).contains(&value)
            {
                return Err(format!(
                    "line {line}: {joint} = {value} rad is outside its limits, {low} to {high}"
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

#[cfg(test)]
mod tests {
    use super::poses;

    #[test]
    fn columns_have_any_order_and_faults_have_their_line() {
        let joints = ["a", "b"].map(str::to_owned);
        let limits = [None, Some([-1.0, 1.0])];
        let read = |text| poses(text, &joints, &limits);
        assert_eq!(
            read("time_s, b, a\n0, 0.5, 7\n\n1, -1, 8\n"),
            Ok(vec![vec![7.0, 0.5], vec![8.0, -1.0]])
        );
        for (text, word) in [
            ("", "no column \"a\""),
            ("a,c\n1,2\n", "no column \"b\""),
            ("a,b\n", "no row"),
            ("a,b\n1\n", "line 2, column \"b\": \"\" is no number"),
            ("a,b\n1,nan\n", "\"nan\" is no number"),
            (
                "a,b\n1,0\n1,1.5\n",
                "line 3: b = 1.5 rad is outside its limits, -1 to 1",
            ),
        ] {
            let found = read(text).unwrap_err();
            assert!(found.contains(word), "{text}: {found}");
        }
    }
}
