//! Faulty files beside the log.

use super::keys::USUAL;
use super::{Faulty, ROBOT, fixture};

fn of(name: &str, experiment: impl Into<Vec<u8>>, says: &[&'static str]) -> Faulty {
    Faulty {
        name: name.to_owned(),
        files: vec![
            ("experiment.toml".to_owned(), experiment.into()),
            ("plain.csv".to_owned(), fixture("plain.csv")),
        ],
        code: 2,
        says: says.to_vec(),
    }
}

fn with_urdf(name: &str, urdf: &[u8], says: &[&'static str]) -> Faulty {
    let experiment = format!(
        "format = 1\n[robot]\nname = \"r\"\nurdf = \"robot.urdf\"\n\
         [[robot.joint]]\nname = \"joint1\"\n[log]\nfile = \"plain.csv\"\n{USUAL}"
    );
    let mut faulty = of(name, experiment, says);
    faulty.files.push(("robot.urdf".to_owned(), urdf.to_vec()));
    faulty
}

#[rustfmt::skip]
pub(super) fn all() -> Vec<Faulty> {
    let log = format!("{ROBOT}[log]\nfile = \"plain.csv\"\n{USUAL}");
    let missing = format!("{ROBOT}[log]\nfile = \"plane.csv\"\n{USUAL}");
    let folder = format!("{ROBOT}[log]\nfile = \".\"\n{USUAL}");
    let mut latin = log.clone().into_bytes();
    latin.splice(0..0, b"# Gr\xfc\xdfe\n".iter().copied());
    let deep = format!("{log}x = {}1{}\n", "[".repeat(5000), "]".repeat(5000));
    let entities = b"<?xml version=\"1.0\"?><!DOCTYPE r [<!ENTITY a \"aaaa\"><!ENTITY b \
                     \"&a;&a;&a;&a;\">]><robot name=\"&b;\"/>";
    vec![
        of("an empty experiment", "", &["experiment.toml"]),
        of("an experiment that was cut off", &log[..log.len() - 30], &["experiment.toml"]),
        of("an experiment in Latin-1", latin, &["experiment.toml", "save it as UTF-8"]),
        of("an experiment of arrays in arrays", deep, &["experiment.toml"]),
        of("a log that is not there", missing, &["cannot read", "plane.csv"]).code(4),
        of("a log that is a folder", folder, &["a folder without .mcap or .db3 file"]).code(4),
        with_urdf("a URDF that was cut off", b"<robot name=\"r\"><link name=\"a\">", &["robot.urdf"]),
        with_urdf("a URDF without links", b"<robot name=\"r\"></robot>", &["robot.urdf"]),
        with_urdf("a URDF with entities", entities, &["robot.urdf"]),
        with_urdf("a URDF that is no XML", b"\x89PNG\r\n", &["robot.urdf"]).code(4),
    ]
}
