//! `sprung new` writes an experiment that can be read unchanged, that runs once its log exists, and that overwrites no
//! file.

use std::path::{Path, PathBuf};

use serde_json::Value;
use tempfile::TempDir;

use crate::common::{Ran, contains, each, messages, program, sprung};

pub(crate) const ARM: &str = r#"<robot name="two joints">
<link name="base"/>
<link name="upper"><inertial><origin xyz="0.15 0 0"/><mass value="1.5"/>
  <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
<link name="lower"><inertial><origin xyz="0.1 0 0"/><mass value="0.5"/>
  <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.008" iyz="0" izz="0.008"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
  <axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="80" velocity="2"/></joint>
<joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
  <origin xyz="0.343 0 0"/><axis xyz="0 1 0"/></joint>
</robot>"#;

/// The same arm on a prismatic joint.
fn gantry() -> String {
    ARM.replace(
        "<joint name=\"shoulder\" type=\"revolute\"><parent link=\"base\"/>",
        "<link name=\"sled\"><inertial><mass value=\"4\"/>
  <inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/></inertial></link>
<joint name=\"slide\" type=\"prismatic\"><parent link=\"base\"/><child link=\"sled\"/></joint>
<joint name=\"shoulder\" type=\"revolute\"><parent link=\"sled\"/>",
    )
}

/// A working folder for commands.
pub(crate) struct Desk {
    folder: TempDir,
}

impl Desk {
    pub(crate) fn new() -> Self {
        Self {
            folder: TempDir::new().unwrap(),
        }
    }

    pub(crate) fn path(&self, file: &str) -> PathBuf {
        self.folder.path().join(file)
    }

    pub(crate) fn write(&self, file: &str, bytes: impl AsRef<[u8]>) {
        let path = self.path(file);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }

    pub(crate) fn read(&self, file: &str) -> String {
        std::fs::read_to_string(self.path(file)).unwrap()
    }

    pub(crate) fn json(&self, file: &str) -> Value {
        serde_json::from_str(&self.read(file)).unwrap()
    }

    /// Runs the program in the folder.
    pub(crate) fn run(&self, args: &[&str]) -> Ran {
        Ran::of(program().args(args).current_dir(self.folder.path()))
    }

    #[track_caller]
    pub(crate) fn succeeds(&self, args: &[&str]) -> String {
        self.run(args).ends(0).out.clone()
    }

    /// Checks that a command fails with a code and does not create a folder `new`; returns the message, with FOLDER for
    /// the folder.
    #[track_caller]
    pub(crate) fn refused(&self, args: &[&str], code: i32) -> String {
        let output = self.run(args);
        output.ends(code);
        let message = (output.err).replace(self.folder.path().to_str().unwrap(), "FOLDER");
        assert!(message.starts_with("error: "), "{message}");
        assert!(!self.path("new").exists(), "a failed run left a folder");
        message
    }

    /// Checks that a command fails with a code and a message.
    #[track_caller]
    pub(crate) fn fails(&self, args: &[&str], code: i32, fragments: &[&str]) {
        contains(&self.refused(args, code), fragments);
    }

    /// Checks that only the file of its log is missing in an experiment.
    fn lacks_only_its_log(&self, folder: &str) {
        self.fails(
            &["identify", folder],
            2,
            &["line ", "FILL IN file: only you know"],
        );
        let log = Path::new(folder).join("log.csv");
        let missing = format!("cannot read {}", log.display());
        self.fails(
            &["identify", folder, "--set", "log.file=log.csv"],
            4,
            &[&missing],
        );
    }

    /// Fills in the table of an experiment by its example, and checks that only the log is missing.
    fn lacks_only_table_and_log(&self, folder: &str) {
        self.fails(
            &["identify", folder],
            2,
            &["FILL IN dh_modified: only you know"],
        );
        let file = format!("{folder}/experiment.toml");
        let text = self.read(&file);
        let (head, table) = text.split_once("dh_modified = \"FILL IN\"\n").unwrap();
        let (table, rest) = table.split_once("#]\n").unwrap();
        let table: Vec<&str> = table.lines().map(|line| &line[1..]).collect();
        let table = table.join("\n");
        self.write(&file, format!("{head}{table}\n]\n{rest}"));
        self.lacks_only_its_log(folder);
    }
}

#[test]
fn tables_are_read_as_they_stand() {
    let desk = Desk::new();
    for joints in ["1", "2", "7"] {
        let folder = format!("arm-{joints}");
        let said = desk.succeeds(&["new", &folder, "--joints", joints]);
        contains(
            &said,
            &[
                &format!("{folder}/experiment.toml"),
                "FILL IN, because only you know it",
                ": dh_modified\n",
                ": file\n",
                &format!("sprung identify {folder}"),
            ],
        );
        desk.lacks_only_table_and_log(&folder);
        let text = desk.read(&format!("{folder}/experiment.toml"));
        assert_eq!(
            text.matches("[[robot.joint]]").count().to_string(),
            joints,
            "{text}"
        );
    }
}

#[test]
fn two_joints_if_nobody_says_how_many_and_quiet_is_quiet() {
    let desk = Desk::new();
    assert_eq!(desk.succeeds(&["new", "-q", "a/b/my arm"]), "");
    assert!(
        desk.read("a/b/my arm/experiment.toml")
            .contains("# joint2\n")
    );
    desk.lacks_only_table_and_log("a/b/my arm");
    let said = desk.succeeds(&["new", "my arm"]);
    assert!(said.ends_with("sprung identify 'my arm'\n"), "{said}");
}

#[test]
fn golden_robots_are_read_as_they_stand() {
    let desk = Desk::new();
    for (name, last) in [("arm7", "j7"), ("planar2r", "j2")] {
        let Some(file) = sprung_testing::golden(&format!("{name}.urdf")) else {
            return;
        };
        desk.succeeds(&["new", name, "--urdf", file.to_str().unwrap()]);
        contains(
            &desk.read(&format!("{name}/experiment.toml")),
            &[&format!("name = \"{name}\""), &format!("name = \"{last}\"")],
        );
        desk.lacks_only_its_log(name);
    }
}

#[test]
fn a_urdf_is_named_by_a_relative_path_if_it_lies_near() {
    let desk = Desk::new();
    let elsewhere = Desk::new();
    elsewhere.write("far.urdf", ARM);
    let far = elsewhere.path("far.urdf").canonicalize().unwrap();
    for (folder, file, expected) in [
        ("one", "arm.urdf", "../arm.urdf"),
        ("two", "models/arm.urdf", "../models/arm.urdf"),
        ("three", "three/meshes/arm.urdf", "meshes/arm.urdf"),
        (".", "arm.urdf", "arm.urdf"),
    ] {
        desk.write(file, ARM);
        desk.succeeds(&["new", folder, "--urdf", file]);
        contains(
            &desk.read(&format!("{folder}/experiment.toml")),
            &[&format!("\nurdf = \"{expected}\" ")],
        );
        desk.lacks_only_its_log(folder);
    }
    desk.succeeds(&["new", "four/deep/er", "--urdf", "arm.urdf"]);
    desk.succeeds(&["new", "five", "--urdf", far.to_str().unwrap()]);
    let absolute = desk.path("arm.urdf").canonicalize().unwrap();
    for (folder, path) in [("four/deep/er", absolute), ("five", far)] {
        contains(
            &desk.read(&format!("{folder}/experiment.toml")),
            &[&format!("\nurdf = {path:?}")],
        );
        desk.lacks_only_its_log(folder);
    }
}

/// Activates the commented nominal values, controller and twin.
fn with_a_twin(text: &str) -> String {
    let (head, twin) = text.split_once("#[controller]").unwrap();
    let twin = twin.lines().map(|line| match line.strip_prefix('#') {
        Some(rest) if !rest.starts_with(' ') || rest.starts_with("  ") => rest,
        _ => line,
    });
    let head = head.replace("#nominal = {", "nominal = {");
    format!(
        "{head}[controller]{}\n",
        twin.collect::<Vec<_>>().join("\n")
    )
}

#[test]
fn a_log_with_the_columns_of_the_file_is_identified() {
    for (urdf, slides) in [(ARM.to_owned(), false), (gantry(), true)] {
        let desk = Desk::new();
        desk.write("arm.urdf", &urdf);
        desk.succeeds(&["new", "new-arm", "--urdf", "arm.urdf"]);
        let written = desk.read("new-arm/experiment.toml");
        let written = written.replace("file = \"FILL IN\"", "file = \"log.csv\"");
        desk.write("new-arm/experiment.toml", &written);
        desk.write("twin/experiment.toml", with_a_twin(&written));
        desk.succeeds(&["simulate", "twin", "--out", "new-arm"]);
        let log = desk.read("new-arm/log.csv");
        let header = if slides {
            "t_s,q2_rad,q3_rad,q1_m,phi2_rad,phi3_rad,phi1_m,tau2_nm,tau3_nm,f1_n"
        } else {
            "t_s,q1_rad,q2_rad,phi1_rad,phi2_rad,tau1_nm,tau2_nm"
        };
        assert_eq!(log.lines().next(), Some(header));
        // The experiment is unchanged; only its log was added.
        let least = "identify.estimator=[\"least-squares\"]";
        let output = desk.run(&["identify", "new-arm", "--set", least]);
        let code = output.code;
        println!("{}{}", output.out, output.err);
        assert!(matches!(code, Some(0 | 1)), "{}", output.err);
        assert!(desk.path("new-arm/sprung-out/report.html").exists());
        desk.run(&["validate", "new-arm"])
            .has_a_result()
            .prints(&["same log"]);
    }
}

#[test]
fn nothing_is_overwritten() {
    let mut messages = messages("nothing_is_overwritten");
    let desk = Desk::new();
    desk.write("mine/experiment.toml", "my work");
    desk.write("a-file", "my work");
    for name in ["mine", "a-file", "mine/experiment.toml"] {
        messages.note(name, &desk.refused(&["new", name], 2));
    }
    for file in ["mine/experiment.toml", "a-file"] {
        assert_eq!(desk.read(file), "my work");
    }
    messages.compare();
}

#[cfg(unix)]
#[test]
fn links_are_not_overwritten() {
    let desk = Desk::new();
    std::fs::create_dir(desk.path("linked")).unwrap();
    std::os::unix::fs::symlink("nowhere", desk.path("linked/experiment.toml")).unwrap();
    desk.fails(&["new", "linked"], 2, &["exists already"]);
}

#[test]
fn wrong_urdf_files_and_arguments() {
    let mut messages = messages("wrong_urdf_files_and_arguments");
    let desk = Desk::new();
    let fixed = ARM.replace("\"revolute\"", "\"fixed\"");
    #[rustfmt::skip]
    let rows = [
        ("a mass in words", ARM.replace("<mass value=\"0.5\"/>", "<mass value=\"half\"/>")),
        ("no last tag", ARM.replace("</robot>", "")),
        ("no joint moves", fixed.replace("\"continuous\"", "\"fixed\"")),
        ("a name with a slash", ARM.replace("\"elbow\"", "\"arm/elbow\"")),
    ];
    each(rows, |(name, urdf)| {
        desk.write("arm.urdf", &urdf);
        let message = desk.refused(&["new", "new", "--urdf", "arm.urdf"], 2);
        messages.note(name, &message);
    });
    desk.write("arm.urdf", ARM);
    for (words, code) in [
        ("new new --urdf no.urdf", 4),
        ("new new --joints 0", 2),
        ("new new --joints 33", 2),
        ("new new --joints=-1", 2),
        ("new new --urdf arm.urdf --joints 2", 2),
        ("new", 2),
    ] {
        let args: Vec<&str> = words.split(' ').collect();
        messages.note(words, &desk.refused(&args, code));
    }
    messages.compare();
}

#[test]
fn help_shows_an_example_first() {
    let text = sprung(&["help", "new"]).out;
    assert!(text.starts_with("Example: sprung new my-arm"), "{text}");
    let words: Vec<&str> = text.split_whitespace().collect();
    let words = words.join(" ");
    assert!(
        words.contains("[default: that of the log, otherwise 2]"),
        "{text}"
    );
}
