//! Short, unique names of results.

/// Returns a name for each of `results`, which are pairs of file and estimator. The name is the
/// differing part of the path, the estimator, or both.
pub(super) fn labels(results: &[(&str, &str)]) -> Vec<String> {
    let mut files: Vec<&str> = Vec::new();
    for (file, _) in results {
        if !files.contains(file) {
            files.push(file);
        }
    }
    let short = distinct(&files);
    let same_estimator = results.iter().all(|(_, name)| *name == results[0].1);
    let mut labels: Vec<String> = Vec::new();
    for (file, estimator) in results {
        let at = files.iter().position(|known| known == file).unwrap_or(0);
        let label = match (files.len(), same_estimator) {
            (1, _) => (*estimator).to_owned(),
            (_, true) => short[at].clone(),
            (_, false) => format!("{} {estimator}", short[at]),
        };
        let duplicates = labels.iter().filter(|known| **known == label).count();
        labels.push(match duplicates {
            0 => label,
            more => format!("{label} ({})", more + 1),
        });
    }
    labels
}

/// Returns the paths without their common first folders and their common last names.
fn distinct(files: &[&str]) -> Vec<String> {
    let split: Vec<Vec<&str>> = (files.iter())
        .map(|file| {
            let parts = file.split(['/', '\\']);
            parts.filter(|part| !matches!(*part, "" | ".")).collect()
        })
        .collect();
    let all = |of: &dyn Fn(&[&str]) -> Option<String>| {
        let first = split.first().and_then(|parts| of(parts));
        first.is_some() && split.iter().all(|parts| of(parts) == first)
    };
    let shortest = split.iter().map(Vec::len).min().unwrap_or(0);
    let before = (0..shortest)
        .take_while(|&k| all(&|parts| parts.get(k).map(|part| (*part).to_owned())))
        .count();
    let after = (0..shortest.saturating_sub(before))
        .take_while(|&k| {
            all(&|parts| {
                let at = parts.len().checked_sub(k + 1)?;
                parts.get(at).map(|part| (*part).to_owned())
            })
        })
        .count();
    (split.iter().zip(files))
        .map(|(parts, file)| {
            let kept = &parts[before.min(parts.len())..parts.len().saturating_sub(after)];
            match kept {
                [] => (*file).to_owned(),
                kept => kept.join("/").trim_end_matches(".json").to_owned(),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::labels;

    #[test]
    fn names_are_short_and_differ() {
        let ls = "least-squares";
        let made = |results: &[(&str, &str)]| labels(results).join(" | ");
        assert_eq!(
            made(&[
                ("d/run1/sprung-out/identification.json", ls),
                ("d/run2/sprung-out/identification.json", ls)
            ]),
            "run1 | run2"
        );
        assert_eq!(
            made(&[("a.json", ls), ("a.json", "lsff")]),
            "least-squares | lsff"
        );
        assert_eq!(
            made(&[("a.json", ls), ("a.json", "lsff"), ("x/b.json", ls)]),
            "a least-squares | a lsff | x/b least-squares"
        );
        // The first path is the end of the second path.
        assert_eq!(
            made(&[
                ("identification.json", ls),
                ("other/identification.json", ls)
            ]),
            "identification.json | other"
        );
        assert_eq!(
            made(&[("a.json", ls), ("a.json", ls)]),
            "least-squares | least-squares (2)"
        );
    }
}
