//! `sprung excite`: a designed experiment, its files and its refusals.

use std::fs;

use serde_json::Value;

use crate::common::{
    Case, Ran, contains, f64_of, finding, list_of, messages, sprung, values_of, without_decimals,
};

const TORQUES: [&str; 2] = [
    "robot.joint.0.limits={torque_nm=4.8, deflection_rad=0.17}",
    "robot.joint.1.limits={torque_nm=0.42, deflection_rad=0.06}",
];

/// Settings of a short search.
const SHORT: [&str; 4] = [
    "excite.steps=5",
    "excite.starts=1",
    "excite.duration_s=5",
    "excite.harmonics=6",
];

/// Limits of the torques and settings of a short search.
fn short() -> Vec<&'static str> {
    [&TORQUES[..], &SHORT].concat()
}

/// Designs an experiment for the demo's arm into the folder `design` of a case.
fn excited(case: &Case, set: &[&str], more: &[&str]) -> Ran {
    let (experiment, out) = (case.path("experiment.toml"), case.path("design"));
    let mut args = vec!["excite", experiment.to_str().unwrap()];
    args.extend(["--out", out.to_str().unwrap()]);
    for setting in set {
        args.extend(["--set", setting]);
    }
    args.extend(more);
    sprung(&args)
}

fn designed(case: &Case, set: &[&str], more: &[&str]) -> Value {
    let output = excited(case, set, &[&["--json"], more].concat());
    output.ends(0);
    output.json()
}

/// Makes a designed motion the reference of a case.
fn follow(case: &Case, toml: &str) {
    let text = case.read("experiment.toml");
    let (before, after) = text.split_once("[controller.reference]").unwrap();
    let (_, after) = after.split_once("\n]\n").unwrap();
    case.write("experiment.toml", format!("{before}{toml}{after}"));
}

/// Returns the columns of a CSV file of numbers.
fn columns(text: &str) -> Vec<Vec<f64>> {
    let rows: Vec<Vec<f64>> = (text.lines().skip(1))
        .map(|line| line.split(',').map(|word| word.parse().unwrap()).collect())
        .collect();
    (0..rows[0].len())
        .map(|column| rows.iter().map(|row| row[column]).collect())
        .collect()
}

#[test]
fn the_files_hold_one_motion_from_rest_to_rest() {
    let case = Case::new();
    let start = "excite.start_rad=[0.05, -0.02]";
    let json = designed(&case, &[&TORQUES[..], &SHORT, &[start]].concat(), &[]);
    let read = |name: &str| case.read(&format!("design/{name}"));
    let (csv, yaml, toml) = (
        read("trajectory.csv"),
        read("trajectory.yaml"),
        read("reference.toml"),
    );
    assert!(csv.starts_with(
        "t_s,joint1_position_rad,joint1_velocity_rad_per_s,joint1_acceleration_rad_per_s2,joint2"
    ));
    let columns = columns(&csv);
    let last = columns[0].len() - 1;
    for joint in 0..2 {
        let [position, velocity, acceleration] = [1, 2, 3].map(|k| &columns[3 * joint + k]);
        assert!((position[0] - [0.05, -0.02][joint]).abs() < 1e-9);
        for end in [0, last] {
            assert!(velocity[end].abs() + acceleration[end].abs() < 1e-12);
        }
        // Each column is the derivative of the one before it.
        for t in (1..last).step_by(97) {
            let slope = (position[t + 1] - position[t - 1]) / 2e-3;
            assert!(
                (slope - velocity[t]).abs() < 1e-4,
                "{t}: {slope} {}",
                velocity[t]
            );
            let slope = (velocity[t + 1] - velocity[t - 1]) / 2e-3;
            assert!(
                (slope - acceleration[t]).abs() < 5e-3,
                "{t}: {slope} {}",
                acceleration[t]
            );
        }
        // The reference begins where the motion ends: each period ends at its beginning.
        let begin = f64_of(&json["motion"]["joints"][joint]["start_rad"]);
        assert!((position[last] - begin).abs() < 1e-8);
    }
    assert!(f64_of(&json["motion"]["approach_s"]) > 0.5);
    assert!(yaml.starts_with(
        "joint_names: [\"joint1\", \"joint2\"]\npoints:\n- positions: [0.05, -0.02]\n"
    ));
    assert_eq!(
        yaml.matches("accelerations:").count(),
        yaml.matches("time_from_start:").count()
    );
    // The twin follows the reference of the file.
    follow(&case, &toml);
    let (experiment, out) = (case.path("experiment.toml"), case.path("twin"));
    let args = [
        "simulate",
        experiment.to_str().unwrap(),
        "--expected-errors",
        "--json",
        "--out",
        out.to_str().unwrap(),
    ];
    let found = sprung(&[&args[..], &["--set", "simulate.duration_s=5"]].concat()).json();
    let errors = list_of(&found["expected_errors"]);
    // The twin of the demo has its true values, the design its nominal ones, without Coulomb friction.
    assert_eq!(errors.len(), list_of(&json["promise"]).len());
    assert!(
        errors
            .iter()
            .all(|error| f64_of(&error["standard_error"]) > 0.0)
    );
}

#[test]
fn every_limit_is_kept_and_some_are_used() {
    let case = Case::new();
    let json = designed(&case, &short(), &[]);
    assert_eq!(json["is_certified"], true);
    let limits = list_of(&json["limits"]);
    assert_eq!(limits.len(), 6);
    let used = |limit: &Value| f64_of(&limit["used_percent"]);
    assert!(
        limits.iter().all(|limit| used(limit) <= 100.0),
        "{limits:?}"
    );
    assert!(used(&limits[0]) > 60.0, "{limits:?}");
    contains(
        &case.read("design/excitation.html"),
        &["Designed experiment"],
    );
}

#[test]
fn the_same_seed_gives_the_same_files_on_any_number_of_threads() {
    let files = |threads: &str| {
        let case = Case::new();
        let set = [
            &TORQUES[..],
            &[
                "excite.steps=4",
                "excite.starts=3",
                "excite.duration_s=3",
                "excite.harmonics=4",
            ],
        ];
        designed(&case, &set.concat(), &["--threads", threads]);
        case.read("design/trajectory.csv")
    };
    assert_eq!(files("1"), files("2"));
}

#[test]
fn the_paper_s_reference_is_judged_in_the_same_table() {
    let case = Case::new();
    let truth = case.at("truth.toml");
    let more = ["--method", "paper", "--parameters", &truth];
    let json = designed(&case, &TORQUES, &more);
    // Eq. (29) needs 4.82 N·m, a little more than the limit.
    assert_eq!(json["is_certified"], false);
    assert_eq!(list_of(&json["promise"]).len(), 15);
    assert!(json["hold_out"].is_null());
    assert!(!case.path("design").join("hold-out.csv").exists());
    excited(&case, &TORQUES, &more).prints(&["limits are broken"]);
}

#[test]
fn a_given_motion_is_judged_as_the_design_that_made_it() {
    let case = Case::new();
    let set = short();
    let made = designed(&case, &set, &[]);
    let file = case.path("motion.toml");
    fs::copy(case.path("design").join("reference.toml"), &file).unwrap();
    let judged = designed(&case, &set, &["--reference", file.to_str().unwrap()]);
    assert_eq!(judged["method"], "reference");
    assert_eq!(judged["is_certified"], true);
    let errors = |excitation: &Value| -> Vec<f64> {
        let all = list_of(&excitation["promise"]).iter();
        all.map(|promised| f64_of(&promised["standard_error"]))
            .collect()
    };
    for (made, judged) in errors(&made).into_iter().zip(errors(&judged)) {
        assert!((made / judged - 1.0).abs() < 1e-6, "{made} {judged}");
    }
    for (text, expected) in [
        ("format = 1\n", "missing field `controller`"),
        (
            "[controller.reference]\nsines = []\n",
            "[controller.reference] has no sines",
        ),
        (
            "[controller.reference]\nsines = [{ joint = \"elbow\", amplitude_deg = 1.0, frequency_hz = 1.0, phase_deg = 0.0 }]\n",
            "controller.reference.sines.0.joint: the robot has no joint \"elbow\"",
        ),
        (
            "[controller.reference]\ncentre_deg = [1.0]\nsines = []\n",
            "controller.reference.centre_deg: centre_deg needs 2 finite numbers",
        ),
        (
            "[controller.reference]\nsines = [{ joint = \"joint1\", amplitude_deg = nan, frequency_hz = 1.0, phase_deg = 0.0 }]\n",
            "amplitude_deg must be finite",
        ),
        (
            "[controller.reference]\nsines = [{ joint = \"joint1\", amplitude_deg = 1.0, frequency_hz = 1e-9, phase_deg = 0.0 }]\n",
            "which is more than 1e7 samples",
        ),
        (
            "[controller.reference]\nsines = [\n\
             { joint = \"joint1\", amplitude_deg = 1.0, frequency_hz = 1.0, phase_deg = 0.0 },\n\
             { joint = \"joint1\", amplitude_deg = 1.0, frequency_hz = 3.14159265, phase_deg = 0.0 }]\n",
            "so the motion has no period",
        ),
    ] {
        fs::write(&file, text).unwrap();
        let output = excited(&case, &set, &["--reference", file.to_str().unwrap()]);
        let error = &output.err;
        assert_eq!(output.code, Some(2), "{text}: {error}");
        contains(error, &["motion.toml", expected]);
    }
}

#[test]
fn a_slow_motion_for_friction_is_designed_beside_the_motion() {
    let case = Case::new();
    let set = [&TORQUES[..], &SHORT, &["excite.slow_sweep_s=8"]].concat();
    let json = designed(&case, &set, &[]);
    assert_eq!(json["slow"]["harmonics"], serde_json::json!([1, 2, 3]));
    let more = list_of(&json["more"]).last().unwrap();
    assert_eq!(more["what"], "this motion and the slow one");
    assert!(f64_of(&more["factor"]) < 1.0, "{more}");
    let slow = case.path("design").join("slow.csv");
    let columns = columns(&fs::read_to_string(&slow).unwrap());
    assert_eq!(columns[0].last(), Some(&8.0));
    contains(&case.read("design/excitation.html"), &["The slow motion"]);
    // A design without it removes the file of an earlier design.
    designed(&case, &short(), &[]);
    assert!(!slow.exists());
}

#[test]
fn a_check_compares_the_recorded_motion_with_the_promise_of_its_design() {
    let case = Case::new();
    let set = short();
    let truth = case.at("truth.toml");
    let parameters = ["--parameters", &truth];
    designed(&case, &set, &parameters);
    let toml = case.read("design/reference.toml");
    follow(&case, &toml);
    let promised = |duration: &str| -> String {
        case.record("identification.csv", &["--set", duration]);
        let promise = "excite.promise=\"design/excitation.json\"";
        let json = case.run("check", &["--set", promise, "--json"]).json();
        finding(&json, "design-promise").unwrap().to_owned()
    };
    contains(
        &promised("simulate.duration_s=5"),
        &["tells as much as its design promised"],
    );
    contains(
        &promised("simulate.duration_s=1.5"),
        &["tells less than its design promised"],
    );
    // Laws that an identification added are no parameters of the declared model.
    let design = "design/excitation.json";
    let mut json = case.json(design);
    let promise = json["promise"].as_array_mut().unwrap();
    let mut law = promise[0].clone();
    law["name"] = "joint1.motor_stribeck".into();
    promise.push(law);
    case.write(design, json.to_string());
    assert!(promised("simulate.duration_s=5").contains("tells as much"));
    json["promise"].as_array_mut().unwrap().remove(3);
    case.write(design, json.to_string());
    for (promise, expected) in [
        ("truth.toml", "expected value at line 1"),
        (
            "design/excitation.json",
            "no value for joint1.rotor_inertia",
        ),
    ] {
        let set = format!("excite.promise=\"{promise}\"");
        case.run("check", &["--set", &set]).ends(2).tells(&[
            "is not the excitation.json of a design of this robot",
            expected,
        ]);
    }
}

#[test]
fn a_recorded_log_counts_beside_the_new_motion() {
    let case = Case::new();
    case.record("identification.csv", &[]);
    let log = case.at("identification.csv");
    let truth = case.at("truth.toml");
    let parameters = ["--parameters", &truth];
    let set = short();
    let alone = designed(&case, &set, &parameters);
    let more = [&parameters[..], &["--from-log", &log]].concat();
    let both = designed(&case, &set, &more);
    for (alone, both) in list_of(&alone["promise"])
        .iter()
        .zip(list_of(&both["promise"]))
    {
        let error = |promised: &Value| f64_of(&promised["standard_error"]);
        assert!(error(both) < error(alone), "{alone} {both}");
    }
}

/// A short log leaves much open: a motion that keeps the limits for the robots that it allows is smaller, so it promises
/// larger errors than one for the identified robot alone.
#[test]
fn a_motion_for_identified_values_keeps_the_limits_for_the_robots_of_the_posterior() {
    let case = Case::new().first_rows(500);
    let found = case.at("found");
    case.identify(&["--out", &found]);
    let json = case.json("found/identification.json");
    let result = &json["results"][0];
    assert_eq!(result["estimator"], "least-squares");
    case.write("values.toml", values_of(result, "value"));
    let with = |parameters: &str| {
        let parameters = ["--parameters", &case.at(parameters)];
        designed(&case, &short(), &parameters)
    };
    let (margins, none) = (with("found/identification.json"), with("values.toml"));
    let names_robots = |json: &Value| {
        json["assumed"]
            .to_string()
            .contains("4 robots that can exist")
    };
    assert!(
        names_robots(&margins) && !names_robots(&none),
        "{}",
        margins["assumed"]
    );
    let errors = |json: &Value| -> f64 {
        let of = |promise: &Value| f64_of(&promise["standard_error"]).ln();
        list_of(&json["promise"]).iter().map(of).sum()
    };
    assert!(
        errors(&margins) > errors(&none),
        "{} {}",
        errors(&margins),
        errors(&none)
    );
}

#[test]
fn a_first_motion_of_an_unknown_robot_needs_masses_and_limits_only() {
    let case = Case::new();
    let text = case.read("experiment.toml");
    let unknown = text
        .replace("stiffness = 9.0, rotor_inertia = 0.0628, ", "")
        .replace("stiffness = 4.0, rotor_inertia = 0.002575, ", "");
    case.write("experiment.toml", unknown);
    let set = short();
    excited(&case, &set, &[])
        .ends(2)
        .tells(&["joint1.stiffness", "--warm-up"]);
    let json = designed(&case, &set, &["--warm-up"]);
    assert_eq!(json["is_warm_up"], true);
    let assumed = json["assumed"].to_string();
    contains(&assumed, &["usual drives"]);
}

#[test]
fn faulty_limits_and_values_are_named() {
    let mut messages = messages("faulty_limits_and_values_are_named");
    let case = Case::new();
    let text = case.read("experiment.toml");
    let without: Vec<&str> = (text.lines().filter(|line| !line.starts_with("limits"))).collect();
    case.write("experiment.toml", without.join("\n"));
    let pd = "controller.kd_nms_per_rad=[-50.0, 0.01]";
    let far = [
        "robot.joint.0.limits={torque_nm=4.8, deflection_rad=0.17, position_rad=[-0.5, 0.5]}",
        "excite.start_rad=[2, 0]",
    ];
    for set in [
        vec![],
        vec!["robot.joint.0.limits={position_rad=[1, -1]}"],
        vec!["robot.joint.0.limits={torque_nm=-1}"],
        vec!["excite.base_frequency_hz=0.05"],
        vec!["excite.start_rad=[0]"],
        vec!["excite.harmonics=2"],
        vec!["excite.objective=\"best\""],
        [&TORQUES[..], &["excite.parameters=[\"link1.m\"]"]].concat(),
        [&TORQUES[..], &["excite.floor_m=0"]].concat(),
        [&TORQUES[..], &SHORT, &[pd]].concat(),
        [&TORQUES[1..], &SHORT, &far].concat(),
        [&TORQUES[..], &["robot.joint.0.nominal.stiffness=-3"]].concat(),
    ] {
        let output = excited(&case, &set, &[]);
        let message = case.message(&output);
        assert_eq!(output.code, Some(2), "{set:?}: {message}");
        assert!(!case.path("design").join("excitation.json").exists());
        let name = if set.is_empty() {
            "nothing".to_owned()
        } else {
            set.join(" ")
        };
        messages.note(&name, &without_decimals(&message));
    }
    messages.compare();
}

/// An arm of one joint whose weight needs 1 kg · 9.81 m/s² · 0.5 m in the horizontal pose.
const PENDULUM: &str = "<robot name='pendulum'><link name='base'/><link name='arm'><inertial><origin xyz='0.5 0 0'/>\
    <mass value='1'/><inertia ixx='0.01' iyy='0.01' izz='0.01' ixy='0' ixz='0' iyz='0'/></inertial></link>\
    <joint name='shoulder' type='revolute'><parent link='base'/><child link='arm'/><axis xyz='0 1 0'/>\
    <limit lower='-0.1' upper='0.1' effort='EFFORT' velocity='1'/></joint></robot>";

#[test]
fn a_limit_that_leaves_no_room_is_refused_with_one_that_does() {
    let mut messages = messages("a_limit_that_leaves_no_room_is_refused_with_one_that_does");
    let case = Case::new();
    let experiment = "format = 1\n[robot]\nname = \"pendulum\"\nurdf = \"arm.urdf\"\n[[robot.joint]]\nname = \"shoulder\"\n\
        transmission = \"rigid\"\nlimits = { acceleration_rad_per_s2 = 5.0 }\n\
        nominal = { rotor_inertia = 0.01, motor_viscous = 0.1, motor_coulomb = 0.05 }\n";
    case.write("experiment.toml", experiment);
    let at = |effort: &str| {
        case.write("arm.urdf", PENDULUM.replace("EFFORT", effort));
        excited(&case, &SHORT, &[])
    };
    for effort in ["2.0", "5.05"] {
        let output = at(effort);
        let error = case.message(&output);
        output.ends(2);
        messages.note(&format!("{effort} N·m"), &without_decimals(&error));
        let (_, wider) = error.split_once("raise the limit to ").unwrap();
        let output = at(wider.split_whitespace().next().unwrap());
        output.ends(0);
    }
    messages.compare();
}

#[test]
fn a_design_takes_the_identified_values_of_its_folder() {
    let case = Case::new();
    let experiment = case.at("experiment.toml");
    let file = &experiment;
    let excite = |more: &[&str]| {
        let random = ["excite", file, "--method", "random"];
        let set = SHORT.map(|setting| ["--set", setting]).concat();
        sprung(&[&random, &set[..], more].concat()).out
    };
    assert!(!excite(&[]).contains("identification.json"));
    let set = "identify.estimator=least-squares";
    sprung(&["identify", file, "--set", set]).ends(0);
    let report = case.path("sprung-out").join("report.html");
    let before = fs::read_to_string(&report).unwrap();
    assert!(excite(&[]).contains("identification.json are used"));
    // The report of the identification stays.
    assert_eq!(fs::read_to_string(&report).unwrap(), before);
    let first = excite(&["--warm-up"]);
    assert!(!first.contains("identification.json"), "{first}");
}
