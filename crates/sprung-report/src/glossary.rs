//! Composes the glossary: the meaning of the parameters and words of a report, with a sketch of a
//! joint.

use sprung_core::parameters::JointParameter;

use super::document::{Block, Drawing, Fold, Section};
use super::section::folded;
use crate::estimate::{Identification, ParameterEstimate};

const FLEXIBLE: &str = include_str!("assets/joint.svg");
const RIGID: &str = include_str!("assets/rigid-joint.svg");

/// Parameters of the links of a tree.
const LINKS: (&str, &str) = (
    "m, mx, my, mz, ixx, …",
    "Mass, first moments and inertias of a link in the frame of its joint. A sum with other links is \
     the combination that the motion determines.",
);

/// Parameters of the links of the paper's planar arm.
const PLANAR_LINKS: (&str, &str) = (
    "inertia_total, inertia, coupling",
    "Inertia of link 1 with all that it carries, inertia of link 2, and the first moment of link 2 \
     times the length of link 1, which couples both joints.",
);

/// Words of every report.
const WORDS: [(&str, &str); 5] = [
    (
        "standard error (s.e.)",
        "Typical size of the error of a value. The 95 % interval extends about two standard errors \
         to each side.",
    ),
    (
        "deflection",
        "Difference between the positions of link and motor, both after the gear: the twist of the \
         spring.",
    ),
    (
        "motor row, link row",
        "The two equations of a flexible joint. The motor row balances the torques at the rotor and \
         contains the measured torque. The link row balances the torques at the link.",
    ),
    (
        "filtered",
        "Both sides of an equation pass the same low-pass filter, so no acceleration has to be \
         measured.",
    ),
    (
        "promise",
        "Error that the result states for a new experiment of the same kind, as a root mean square.",
    ),
];

/// Composes the glossary of an identification.
pub(super) fn glossary(identification: &Identification) -> Option<Section> {
    let parameters = &identification.results.first()?.parameters;
    let of = |kind: JointParameter| {
        let suffix = format!(".{}", kind.name());
        move |parameter: &&ParameterEstimate| parameter.name.ends_with(&suffix)
    };
    let mut pairs = Vec::new();
    let is_of_joint = |parameter: &ParameterEstimate| {
        JointParameter::ALL
            .into_iter()
            .any(|kind| of(kind)(&parameter))
    };
    let (words, text) = if parameters.iter().any(|p| p.name.ends_with(".coupling")) {
        PLANAR_LINKS
    } else {
        LINKS
    };
    if !parameters.iter().all(is_of_joint) {
        pairs.push((words.to_owned(), text.to_owned()));
    }
    pairs.extend(JointParameter::ALL.into_iter().filter_map(|kind| {
        let found = parameters.iter().find(of(kind))?;
        Some((format!("{} [{}]", kind.name(), found.unit), meaning(kind)))
    }));
    let is_flexible =
        (parameters.iter()).any(|p| p.name.ends_with(JointParameter::Stiffness.name()));
    pairs.extend(WORDS.map(|(word, text)| (word.to_owned(), text.to_owned())));
    let (svg, kind) = if is_flexible {
        (FLEXIBLE, "flexible")
    } else {
        (RIGID, "rigid")
    };
    let drawing = Drawing {
        svg,
        caption: format!("A {kind} joint. All values hold after the gear."),
    };
    Some(folded(
        Fold::Screen,
        "glossary",
        "What the words mean",
        "The parameters of a joint, and the words of this report.",
        vec![Block::Drawing(drawing), Block::KeyValues(pairs)],
    ))
}

/// Returns the meaning of a parameter, with the side of the spring of a friction law.
fn meaning(kind: JointParameter) -> String {
    match kind {
        JointParameter::Friction(side, _) | JointParameter::Change(side, ..) => {
            let about = kind.about().trim_end_matches('.');
            format!("{about}, {} side.", side.name())
        }
        JointParameter::Stiffness => "Torque of the spring over its deflection.".to_owned(),
        JointParameter::RotorInertia
        | JointParameter::CubicStiffness
        | JointParameter::Damping
        | JointParameter::Hysteresis(_)
        | JointParameter::Preload
        | JointParameter::BackEmf
        | JointParameter::TorqueOffset => kind.about().to_owned(),
    }
}
