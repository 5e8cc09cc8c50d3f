//! The report of a complete run: each table row fits the headings, and no text of the user becomes markup.

use sprung::demo;
use sprung::estimate::{Identified, identify};
use sprung::progress::Unheard;
use sprung::report::{Block, Contents, Document, compose, render};
use sprung::validate::{ChosenFor, ParameterSet, validate};

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
    // Two of the tables, delays and offsets, belong to the refinement.
    assert_eq!(tables, 10);
}

#[test]
fn values_stand_under_their_headings() {
    let (document, found) = report("robot");
    let table = document
        .sections
        .iter()
        .flat_map(|section| &section.blocks)
        .find_map(|block| match block {
            Block::Table(table) => Some(table),
            _ => None,
        })
        .unwrap();
    let column = |heading: &str| {
        (table.columns.iter())
            .position(|column| column.heading.starts_with(heading))
            .unwrap()
    };
    let stiffness = &table.rows[9].cells;
    assert!(stiffness[column("Parameter")].ends_with("joint1.stiffness"));
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
    assert!(html.contains("<figure class=\"bars\">"));
    assert!(html.contains(&format!("after {} runs of the filter", refinement.runs)));
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
