//! Values in which the friction laws of a model are not linear.

use std::collections::BTreeMap;

use sprung_core::friction::{Conditions, Scale, Shape};
use sprung_core::parameters::JointParameter;

use super::Model;

impl Model {
    /// Returns the joints with an unknown Stribeck velocity, which is to be searched.
    #[must_use]
    pub fn unknown_stribeck(&self) -> &[usize] {
        &self.fixed.unknown_stribeck
    }

    /// Returns the indices in theta of a joint's friction parameters whose laws have a scale.
    pub fn parameters_of(&self, scale: Scale, joint: usize) -> impl Iterator<Item = usize> {
        let has_scale = move |kind: JointParameter| matches!(kind, JointParameter::Friction(_, law) if law.scale() == scale);
        (self.parameters().iter().enumerate())
            .filter(move |(_, parameter)| {
                (parameter.joint).is_some_and(|(kind, other)| other == joint && has_scale(kind))
            })
            .map(|(index, _)| index)
    }

    /// Returns whether a joint has friction laws of a scale.
    #[must_use]
    pub fn has_law(&self, scale: Scale, joint: usize) -> bool {
        self.parameters_of(scale, joint).next().is_some()
    }

    /// Returns the constants in which the friction laws of a joint are not linear.
    #[must_use]
    pub fn shape(&self, joint: usize) -> &Shape {
        &self.shapes[joint]
    }

    /// Returns β of the Coulomb friction of a joint, s/rad (s/m).
    #[must_use]
    pub fn sharpness(&self, joint: usize) -> f64 {
        self.shapes[joint].sharpness
    }

    /// Returns the Stribeck velocity of a joint, rad/s (m/s).
    #[must_use]
    pub fn stribeck_velocity(&self, joint: usize) -> f64 {
        self.shapes[joint].stribeck_velocity
    }

    /// Returns a copy with another Stribeck velocity of a joint.
    #[must_use]
    pub fn with_stribeck(&self, joint: usize, velocity: f64) -> Self {
        let mut changed = self.clone();
        changed.set_stribeck(joint, velocity);
        changed
    }

    /// Replaces the Stribeck velocity of a joint, rad/s (m/s).
    pub fn set_stribeck(&mut self, joint: usize, velocity: f64) {
        self.shapes[joint].stribeck_velocity = velocity;
    }

    /// Returns the joints whose Stribeck velocity the refinement estimates: those whose velocity
    /// the description does not give.
    #[must_use]
    pub fn open_stribeck(&self) -> &[usize] {
        &self.open_stribeck
    }

    /// Returns a copy in which the refinement estimates the Stribeck velocities of these joints too.
    #[must_use]
    pub fn with_open_stribeck(mut self, joints: &[usize]) -> Self {
        self.open_stribeck.extend(joints);
        self.open_stribeck.sort_unstable();
        self.open_stribeck.dedup();
        self
    }

    /// Returns the joints whose sharpness of Coulomb friction the refinement estimates: those whose
    /// sharpness the description does not give.
    #[must_use]
    pub fn open_sharpness(&self) -> &[usize] {
        &self.fixed.open_sharpness
    }

    /// Replaces the value that scales friction laws of a joint.
    pub fn set_scale(&mut self, joint: usize, scale: Scale, value: f64) {
        self.shapes[joint].set(scale, value);
    }

    /// Returns the indices in theta of a joint's friction parameters whose laws jump at zero velocity.
    pub fn jumps(&self, joint: usize) -> impl Iterator<Item = usize> {
        let at_rest = Conditions::sliding(0.0, 0.0);
        let shape = self.shape(joint);
        let has_jump = move |kind: JointParameter| matches!(kind, JointParameter::Friction(_, law) if law.jump(&at_rest, shape).is_some());
        (self.parameters().iter().enumerate())
            .filter(move |(_, parameter)| {
                (parameter.joint).is_some_and(|(kind, other)| other == joint && has_jump(kind))
            })
            .map(|(index, _)| index)
    }

    /// Returns the joints for whose presliding friction a log must give the width, whether they have this friction or not.
    #[must_use]
    pub fn open_presliding(&self) -> &[usize] {
        &self.fixed.open_presliding
    }

    /// Returns the joints for whose hysteresis a log must give the width, whether they have a hysteresis or not.
    #[must_use]
    pub fn open_hysteresis(&self) -> &[usize] {
        &self.fixed.open_hysteresis
    }

    /// Returns the width of the widest element of presliding friction of a joint, rad (m); `None` if the
    /// joint has no presliding friction.
    #[must_use]
    pub fn presliding_width(&self, joint: usize) -> Option<f64> {
        let has = self.has_law(Scale::Presliding, joint);
        has.then(|| self.shapes[joint].presliding_width)
    }

    /// Returns the width of the widest element of the hysteresis of a joint's spring, rad (m); `None` if the spring has none.
    #[must_use]
    pub fn hysteresis_width(&self, joint: usize) -> Option<f64> {
        let first = self.index(JointParameter::Hysteresis(0), joint);
        first.map(|_| self.shapes[joint].hysteresis_width)
    }

    /// Returns the joints for whose play a log must give half width and centre.
    #[must_use]
    pub fn open_play(&self) -> &[usize] {
        &self.fixed.open_play
    }

    /// Returns half width and centre of the play of a joint's spring, rad (m); `None` without play.
    #[must_use]
    pub fn play(&self, joint: usize) -> Option<[f64; 2]> {
        let shape = &self.shapes[joint];
        (shape.play > 0.0).then_some([shape.play, shape.play_centre])
    }

    /// Replaces half width and centre of the play of a joint's spring, rad (m).
    pub fn set_play(&mut self, joint: usize, [half_width, centre]: [f64; 2]) {
        let shape = &mut self.shapes[joint];
        (shape.play, shape.play_centre) = (half_width, centre);
    }

    /// Returns a model with the plays of another one.
    #[must_use]
    pub fn with_plays_of(mut self, other: &Self) -> Self {
        for joint in 0..other.joint_count() {
            self.set_play(joint, other.play(joint).unwrap_or_default());
        }
        self
    }

    /// Returns a model with the velocities of the laws that another one has as well.
    #[must_use]
    pub fn with_velocities_of(mut self, other: &Self) -> Self {
        for joint in 0..other.joint_count() {
            if other.has_law(Scale::Stribeck, joint) {
                self.set_stribeck(joint, other.stribeck_velocity(joint));
            }
            let (shape, given) = (&mut self.shapes[joint], other.shape(joint));
            shape.presliding_width = given.presliding_width;
            shape.hysteresis_width = given.hysteresis_width;
        }
        self.with_open_stribeck(other.open_stribeck())
    }

    /// Replaces the width of the hysteresis of a joint's spring, rad (m).
    pub fn set_hysteresis_width(&mut self, joint: usize, width: f64) {
        self.shapes[joint].hysteresis_width = width;
    }

    /// Returns a copy with the sharpness and the velocities of friction laws in named values.
    #[must_use]
    pub fn shaped(&self, values: &BTreeMap<String, f64>) -> Self {
        let mut changed = self.clone();
        for (shape, name) in changed.shapes.iter_mut().zip(&self.fixed.names) {
            if let Some(velocity) = values.get(&stribeck_name(name)) {
                shape.stribeck_velocity = *velocity;
            }
            if let Some(width) = values.get(&presliding_name(name)) {
                shape.presliding_width = *width;
            }
            if let Some(width) = values.get(&hysteresis_name(name)) {
                shape.hysteresis_width = *width;
            }
            if let Some(half_width) = values.get(&play_name(name)) {
                shape.play = *half_width;
            }
            if let Some(centre) = values.get(&play_centre_name(name)) {
                shape.play_centre = *centre;
            }
            if let Some(sharpness) = values.get(&sharpness_name(name)) {
                shape.sharpness = *sharpness;
            }
        }
        changed
    }
}

/// Returns the name of a joint's Stribeck velocity among named values.
#[must_use]
pub fn stribeck_name(joint: &str) -> String {
    format!("{joint}.stribeck_velocity")
}

/// Returns the name of the width of presliding friction of a joint among named values.
#[must_use]
pub fn presliding_name(joint: &str) -> String {
    format!("{joint}.presliding_width")
}

/// Returns the name of the width of the hysteresis of a joint's spring among named values.
#[must_use]
pub fn hysteresis_name(joint: &str) -> String {
    format!("{joint}.hysteresis_width")
}

/// Returns the name of half the play of a joint's spring among named values.
#[must_use]
pub fn play_name(joint: &str) -> String {
    format!("{joint}.play_half_width")
}

/// Returns the name of the middle of the play of a joint's spring among named values.
#[must_use]
pub fn play_centre_name(joint: &str) -> String {
    format!("{joint}.play_centre")
}

/// Returns the name of the sharpness of a joint's Coulomb friction among named values.
#[must_use]
pub fn sharpness_name(joint: &str) -> String {
    format!("{joint}.coulomb_sharpness")
}
