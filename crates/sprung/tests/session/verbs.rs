//! Every verb to its end.

use sprung::session::{
    Parameters, Session, Usability, compare_files, find_identification, read_identification,
};
use sprung_base::progress::Unheard;

use crate::support::{SHORT, folder, owned, session, told};

#[test]
fn every_verb_runs_without_terminal_and_disk() {
    let session = session(&[]);
    let checked = session.check(&mut Unheard).unwrap();
    assert!(!checked.report.refused);
    assert_ne!(Usability::from(&checked.report), Usability::WrongLog);

    let found = session.identify(&mut Unheard).unwrap();
    assert_eq!(found.identification.results.len(), 1);
    let identification = &found.identification;
    assert_eq!(Usability::from(identification), Usability::Usable);
    let truth = session.twin(None, None).unwrap().truth();
    let stiffness = identification.results[0]
        .parameter("joint1.stiffness")
        .unwrap();
    let off = stiffness.value.unwrap() - truth["joint1.stiffness"];
    assert!(off.abs() < 4.0 * stiffness.standard_error.unwrap());

    let parameters = Parameters::from(identification.clone());
    let validated = session.validate(&parameters, &mut Unheard).unwrap();
    let runs: Vec<&str> = (validated.validation.runs.iter())
        .map(|run| run.name.as_str())
        .collect();
    assert_eq!(runs, ["direct", "prediction"]);

    // The twin with the identified parameters is recorded like any other.
    let twin = session.twin(None, Some(&parameters)).unwrap();
    let mut log = Vec::new();
    let samples = twin.write(&mut log, &mut Unheard).unwrap();
    assert_eq!(samples, 3000);
    assert!(log.starts_with(b"t_s,"));
}

#[test]
fn windows_of_logs_reach_every_verb() {
    let parts = "log.file=[{ path = \"identification.csv\", to_s = 1.5 }, \
                 { path = \"identification.csv\", from_s = 1.5, to_s = 2.5 }]";
    let predicted = "validate.prediction.log.file={ path = \"validation.csv\", to_index = 2000 }";
    let session = session(&[parts, predicted]);
    let checked = session.check(&mut Unheard).unwrap();
    let logs: Vec<(String, u64)> = (checked.report.logs.iter())
        .map(|log| (log.name(), log.samples))
        .collect();
    let names = [
        "identification.csv (to 1.5 s)",
        "identification.csv (from 1.5 s to 2.5 s)",
    ];
    assert_eq!(
        logs,
        [(names[0].to_owned(), 1500), (names[1].to_owned(), 1000)]
    );

    let found = session.identify(&mut Unheard).unwrap().identification;
    assert_eq!(found.files(), names.join(", "));
    let json = serde_json::to_value(&found).unwrap();
    let second = &json["further_logs"][0];
    assert_eq!(second["file"], "identification.csv");
    assert_eq!(second["window"]["from_s"], 1.5);
    assert_eq!(second["samples"], 1000);

    let parameters = Parameters::from(found);
    let validated = session.validate(&parameters, &mut Unheard).unwrap();
    let prediction = &validated.validation.runs[1];
    assert_eq!(
        (prediction.log.as_str(), prediction.samples),
        ("validation.csv (to sample 2000)", 2000)
    );
}

#[test]
fn files_on_disk_say_the_same_as_bytes_in_memory() {
    let folder = folder("same");
    let disk = Session::open(&folder, &owned(&SHORT)).unwrap();
    let mut on_disk = disk.identify(&mut Unheard).unwrap();
    let mut in_memory = session(&[]).identify(&mut Unheard).unwrap();
    for found in [&mut on_disk, &mut in_memory] {
        found.identification.log.file.clear();
        found.identification.findings.clear();
    }
    assert_eq!(told(&on_disk), told(&in_memory));
    assert!(disk.inputs().contains(&folder.join("experiment.toml")));
    assert!(disk.inputs().contains(&folder.join("validation.csv")));
    assert_eq!(disk.results_folder(), folder.join("sprung-out"));
}

#[test]
fn results_are_found_read_and_compared() {
    let folder = folder("compared");
    let out = folder.join("sprung-out");
    let nothing = find_identification(&out, &out).unwrap_err();
    assert!(nothing.to_string().contains("run sprung identify first"));

    let session = Session::open(&folder, &owned(&SHORT)).unwrap();
    let found = session.identify(&mut Unheard).unwrap();
    let write = |name: &str| {
        let text = serde_json::to_string(&found.identification).unwrap();
        std::fs::write(folder.join(name), text).unwrap();
    };
    write("sprung-out/identification.json");
    write("again.json");
    let file = find_identification(&out, &out).unwrap();
    assert_eq!(file, out.join("identification.json"));
    let read = Parameters::open(&file).unwrap();
    assert_eq!(read.sets.len(), 1);
    assert_eq!(read_identification(&folder).unwrap().path, file);

    let again = folder.join("again.json");
    let compared = compare_files(&[&folder, &again], &mut Unheard).unwrap();
    assert_eq!(compared.comparison.compared.len(), 2);
    assert_eq!(compared.files, [file.clone(), again]);
    let twice = compare_files(&[&folder, &file], &mut Unheard).unwrap_err();
    assert!(twice.to_string().contains("is given twice"), "{twice}");
}

#[test]
fn an_experiment_opened_twice_and_a_session_used_twice_say_the_same() {
    let (one, other) = (session(&[]), session(&[]));
    let first = told(&one.identify(&mut Unheard).unwrap());
    assert_eq!(first, told(&other.identify(&mut Unheard).unwrap()));
    one.check(&mut Unheard).unwrap();
    assert_eq!(first, told(&one.identify(&mut Unheard).unwrap()));
}
