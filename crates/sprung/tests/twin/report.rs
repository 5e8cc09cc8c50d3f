//! The report of a complete run: each table row fits the headings, and no text of the user becomes markup.

use sprung_base::demo;
use sprung_base::progress::Unheard;
use sprung_method::estimate::{Identified, identify};
use sprung_method::validate::{ChosenFor, ParameterSet, validate};
use sprung_report::{Block, Contents, Document, compose, render};
use sprung_testing::contains;

use crate::in_memory::with_source;
use crate::support::Twin;

fn report(name: &str) -> (Document, Identified) {
    let mut twin = Twin::new();
    name.clone_into(&mut twin.experiment.robot.name);
    twin.experiment.validate.truncate(1);
    let mut settings = twin.experiment.simulate.clone().unwrap();
    settings.duration_s = 4.0;
    let (experiment, model) = (&twin.experiment, &twin.model);
    let (found, validated) = with_source(&twin.log(&settings), |source| {
        let mut sources = [vec![source]];
        let found = identify(experiment, model, &mut sources[0], &mut Unheard).unwrap();
        let sets = ParameterSet::of(&found.identification);
        let none = ChosenFor::default();
        let validated =
            validate(experiment, model, &sets, &none, &mut sources, &mut Unheard).unwrap();
        (found, validated)
    });
    let contents = Contents {
        identification: Some(&found.identification),
        trace: Some(&found.trace),
        fit: Some(&found.fit),
        validation: Some((&validated.validation, &validated.curves)),
        truth: Some(&toml::from_str(demo::TRUTH).unwrap()),
        command: "sprung </script>",
        experiment: demo::EXPERIMENT,
    };
    (compose(&contents), found)
}

#[test]
fn every_row_has_a_cell_for_every_heading() {
    let (document, _) = report("robot");
    let mut tables = 0;
    for block in document.sections.iter().flat_map(|section| &section.blocks) {
        if let Block::Table(table) = block {
            tables += 1;
            assert!(!table.rows.is_empty(), "{}", table.caption);
            for row in &table.rows {
                assert_eq!(row.cells.len(), table.columns.len(), "{}", table.caption);
            }
        }
    }
    // That of the joints, one for each of the two joints, and two of the refinement: delays and offsets.
    assert_eq!(tables, 11 + 1 + 2);
}

#[test]
fn values_stand_under_their_headings() {
    let (document, found) = report("robot");
    let table = document
        .sections
        .iter()
        .flat_map(|section| &section.blocks)
        .find_map(|block| match block {
            Block::Table(table) if table.columns[0].heading == "Parameter" => Some(table),
            _ => None,
        })
        .unwrap();
    let column = |heading: &str| {
        (table.columns.iter())
            .position(|column| column.heading.starts_with(heading))
            .unwrap()
    };
    let name = column("Parameter");
    let row = |end: &str| (table.rows.iter()).position(|row| row.cells[name].ends_with(end));
    let at = row("joint1.stiffness").unwrap();
    let stiffness = &table.rows[at].cells;
    // Each joint has a heading above its parameters.
    let [(0, first), (second, other)] = &table.headings[..] else {
        panic!("{:?}", table.headings)
    };
    assert_eq!((first.as_str(), other.as_str()), ("joint1", "joint2"));
    assert!(at < *second && row("link2.coupling") == Some(*second));
    assert_eq!(stiffness[column("Unit")], "N·m/rad");
    assert_eq!(stiffness[column("Nominal")], "9");
    assert_eq!(stiffness[column("True")], "9.35873");
    let result = &found.identification.results[0];
    let value = result.parameters[9].value.unwrap();
    let shown: f64 = stiffness[column(&result.estimator)]
        .split(' ')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    assert!((shown / value - 1.0).abs() < 1e-4);
}

#[test]
fn the_first_screen_shows_motion_and_intervals() {
    let (document, found) = report("robot");
    let labels = |document: &Document| -> Vec<String> {
        let Block::Figure(figure) = &document.sections[1].blocks[0] else {
            panic!("no figure")
        };
        figure
            .panels
            .iter()
            .map(|panel| panel.y_label.clone())
            .collect()
    };
    let of_joints = |quantities: [&str; 2]| {
        let joints = ["joint1", "joint2"].iter();
        joints
            .flat_map(|joint| quantities.map(|quantity| format!("{joint} {quantity}")))
            .collect::<Vec<_>>()
    };
    // With a simulated loop its motion is shown, without one the fit.
    let simulated = of_joints(["link position [rad]", "torque [N·m]"]);
    assert_eq!(labels(&document), simulated);
    let truth = toml::from_str(demo::TRUTH).unwrap();
    let document = compose(&Contents {
        identification: Some(&found.identification),
        fit: Some(&found.fit),
        truth: Some(&truth),
        ..Contents::default()
    });
    let fitted = of_joints(["torque [N·m]", "deflection [rad]"]);
    assert_eq!(labels(&document), fitted);
    let [Block::Figure(figure), Block::Intervals(intervals)] = &document.sections[1].blocks[..]
    else {
        panic!("not a figure and intervals")
    };
    let result = &found.identification.results[0];
    for (panel, joint) in figure.panels.iter().zip([0, 0, 1, 1]) {
        let [measured, predicted] = &panel.series[..] else {
            panic!("two curves")
        };
        let rms = |values: &[f64]| {
            let squares: f64 = values.iter().map(|x| x * x).sum();
            (squares / values.len() as f64).sqrt()
        };
        let pairs = measured.values.iter().zip(&predicted.values);
        let errors: Vec<f64> = pairs.map(|(a, b)| a.unwrap() - b.unwrap()).collect();
        // The fit is closer than the promise for another log.
        let promise = &result.promise[joint];
        let promised = if panel.y_label.contains("torque") {
            promise.torque_error_nm
        } else {
            promise.deflection_error_rad.unwrap()
        };
        assert!(rms(&errors) < 1.5 * promised, "{}", panel.y_label);
        let measured: Vec<f64> = measured.values.iter().flatten().copied().collect();
        assert!(rms(&errors) < 0.2 * rms(&measured), "{}", panel.y_label);
        assert!(panel.note.ends_with(" % explained"), "{}", panel.note);
    }
    assert_eq!(intervals.rows.len(), result.parameters.len());
    assert_eq!(intervals.names.len(), 2);
    let stiffness = intervals
        .rows
        .iter()
        .find(|row| row.label == "stiffness")
        .unwrap();
    assert_eq!(stiffness.group, "joint1");
    let [low, high] = result.parameter("joint1.stiffness").unwrap().ci95.unwrap();
    let value = result.parameter("joint1.stiffness").unwrap().value.unwrap();
    let ends = stiffness.marks[0].unwrap().interval.unwrap();
    // Both ends have the same scale as the true value.
    let truth = stiffness.marks[1].unwrap().at;
    let scale = (high - low) / value / (ends[1] - ends[0]);
    assert!((value * (1.0 + truth * scale) / 9.35873 - 1.0).abs() < 1e-9);
}

#[test]
fn a_refinement_has_its_section() {
    let (document, found) = report("robot");
    let result = &found.identification.results[0];
    assert_eq!(result.estimator, "prediction-error");
    let refinement = result.refinement.as_ref().unwrap();
    let section = (document.sections.iter().find(|s| s.id == "refinement")).unwrap();
    let bars = section.blocks.iter().find_map(|block| match block {
        Block::Bars(bars) => Some(bars),
        _ => None,
    });
    let bars = bars.unwrap();
    assert_eq!(bars.rows.len(), refinement.disturbances.len());
    for (row, level) in bars.rows.iter().zip(&refinement.disturbances) {
        // Link torques are not measured, so they have no white noise.
        assert_eq!(row.bars[0].is_some(), level.torque_noise_nm > 0.0);
        let length = row.bars[1].as_ref().unwrap().length;
        let decades = 3.0 * length - 4.0;
        let share = level.disturbance_nm / level.torque_nm;
        assert!((decades - share.log10()).abs() < 1e-9, "{decades} {share}");
    }
    let delays = section.blocks.iter().find_map(|block| match block {
        Block::Intervals(intervals) => Some(intervals),
        _ => None,
    });
    // One per column of the log: four positions and two torques.
    assert_eq!(delays.unwrap().rows.len(), 6);
    let html = render(&document).unwrap();
    contains(&html, &["<figure class=\"bars\">"]);
    contains(
        &html,
        &[&format!("after {} runs of the filter", refinement.runs)],
    );
}

#[test]
fn text_of_the_user_cannot_break_out() {
    let (document, _) = report("<img src=x onerror=alert(1)>");
    let html = render(&document).unwrap();
    assert!(!html.contains("<img src=x"));
    assert!(!html.contains("sprung </script>"));
    assert_eq!(
        html.matches("</script>").count(),
        html.matches("<script").count()
    );
    for outside in ["src=\"http", "href=\"http", "@import", "url(http"] {
        assert!(!html.contains(outside), "{outside}");
    }
}

#[test]
fn friction_and_spring_of_a_joint_are_the_torque_that_the_other_terms_leave() {
    let (_, found) = report("robot");
    let result = &found.identification.results[0];
    let column = |label: &str, name: &str| -> Vec<f64> {
        let at = found
            .fit
            .columns
            .iter()
            .position(|column| column == name)
            .unwrap();
        let values = &found.fit.set(label).unwrap().values[at];
        values.iter().map(|value| value.expect(name)).collect()
    };
    let of = |name: &str| column(&result.estimator, name);
    for joint in ["joint1", "joint2"] {
        let name = |what: &str| format!("{joint}.{what}");
        let measured = column("measured", &name("motor_nm"));
        let (fitted, deflection) = (
            of(&name("motor_nm")),
            column("measured", &name("deflection_rad")),
        );
        let (friction, left) = (of(&name("friction_nm")), of(&name("friction_measured_nm")));
        let (spring, left_for_spring) = (of(&name("spring_nm")), of(&name("spring_measured_nm")));
        let speed = of(&name("friction_velocity_rad_per_s"));
        // The demo's springs have no preload.
        let stiffness = result.parameter(&name("stiffness")).unwrap().value.unwrap();
        for at in 0..measured.len() {
            let residual = measured[at] - fitted[at];
            assert!((left[at] - friction[at] - residual).abs() < 1e-9);
            let of_spring = (left_for_spring[at] - spring[at]).abs() - residual.abs();
            assert!(of_spring.abs() < 1e-9, "{of_spring}");
            // The law of Hooke.
            let hooke = spring[at] - stiffness * deflection[at];
            assert!(hooke.abs() < 1e-9, "{hooke}");
        }
        // Friction takes power, beyond the reversals.
        let fastest = speed
            .iter()
            .fold(0.0_f64, |most, speed| most.max(speed.abs()));
        let fast = (0..speed.len()).filter(|&at| speed[at].abs() > 0.3 * fastest);
        for at in fast {
            assert!(
                friction[at] * speed[at] > 0.0,
                "{} {}",
                friction[at],
                speed[at]
            );
        }
        assert!(
            of(&name("friction_half_width_nm"))
                .iter()
                .all(|half| *half >= 0.0)
        );
    }
}
