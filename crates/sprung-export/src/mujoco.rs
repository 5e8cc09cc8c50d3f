//! Fields of the model that MuJoCo compiles from an MJCF.
//!
//! MuJoCo numbers bodies as the file names them, after the world, and each body of the file has one joint.

use super::error::ExportError;
use super::mjcf::{armature, order, rotor_body};
use super::principal::principal;
use super::robot::{Form, Friction, MOTOR, ROTOR, SPRING, StandardJoint, StandardRobot};
use super::standard::standard;
use super::write::Request;

/// Names of the objects of the fields, in the order of their indices.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MujocoNames {
    /// Bodies, the world first.
    pub bodies: Vec<String>,
    /// Joints, one for each degree of freedom.
    pub joints: Vec<String>,
    /// Tendons, which are the springs.
    pub tendons: Vec<String>,
}

/// All fields of a compiled model that depend on the values of the robot, without those that MuJoCo computes from them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MujocoFields {
    /// kg, \[nbody\].
    pub body_mass: Vec<f64>,
    /// Centres of mass, m, \[nbody\].
    pub body_ipos: Vec<[f64; 3]>,
    /// Principal axes, w, x, y, z, \[nbody\].
    pub body_iquat: Vec<[f64; 4]>,
    /// Principal moments about the centre of mass, kg·m², the largest first, \[nbody\].
    pub body_inertia: Vec<[f64; 3]>,
    /// kg·m² (kg), \[nv\].
    pub dof_armature: Vec<f64>,
    /// N·m·s/rad (N·s/m), \[nv\].
    pub dof_damping: Vec<f64>,
    /// N·m (N), \[nv\].
    pub dof_frictionloss: Vec<f64>,
    /// N·m/rad (N/m), \[ntendon\].
    pub tendon_stiffness: Vec<f64>,
    /// N·m·s/rad (N·s/m), \[ntendon\].
    pub tendon_damping: Vec<f64>,
}

/// Returns the fields of the model that MuJoCo compiles from the MJCF of a robot, and their names.
///
/// # Errors
///
/// [`ExportError`] if the values are not those of a possible robot.
pub fn mujoco(request: &Request<'_>) -> Result<(MujocoNames, MujocoFields), ExportError> {
    let robot = standard(request.experiment, request.model, request.values)?.robot;
    Ok((names(&robot, request.form), fields(&robot, request.form)))
}

/// Returns the joints whose spring is written.
fn springs(robot: &StandardRobot, form: Form) -> impl Iterator<Item = &StandardJoint> {
    (robot.joints.iter()).filter(move |joint| joint.has_spring(form))
}

fn names(robot: &StandardRobot, form: Form) -> MujocoNames {
    let links = order(robot).into_iter().map(|i| &robot.joints[i]);
    let mut bodies = vec!["world".to_owned()];
    bodies.extend(links.clone().map(|joint| joint.link.clone()));
    bodies.extend(springs(robot, form).map(|joint| format!("{}{ROTOR}", joint.name)));
    let mut joints: Vec<String> = links.map(|joint| joint.name.clone()).collect();
    joints.extend(springs(robot, form).map(|joint| format!("{}{MOTOR}", joint.name)));
    let tendons = springs(robot, form).map(|joint| format!("{}{SPRING}", joint.name));
    MujocoNames {
        bodies,
        joints,
        tendons: tendons.collect(),
    }
}

fn fields(robot: &StandardRobot, form: Form) -> MujocoFields {
    let mut fields = MujocoFields::default();
    let unturned = [1.0, 0.0, 0.0, 0.0];
    fields.add_body(0.0, [0.0; 3], unturned, [0.0; 3]);
    for i in order(robot) {
        let joint = &robot.joints[i];
        let body = joint.inertial();
        let (moments, axes) = principal(&body.inertia);
        fields.add_body(body.mass, body.centre, axes, moments);
        fields.add_joint(armature(joint, form), joint.friction(form));
    }
    for joint in springs(robot, form) {
        let (mass, inertia) = rotor_body(joint);
        fields.add_body(mass, [0.0; 3], unturned, [inertia; 3]);
        fields.add_joint(0.0, joint.drive.motor);
        fields.tendon_stiffness.push(joint.drive.stiffness);
        fields.tendon_damping.push(joint.drive.damping);
    }
    fields
}

impl MujocoFields {
    fn add_body(&mut self, mass: f64, centre: [f64; 3], axes: [f64; 4], moments: [f64; 3]) {
        self.body_mass.push(mass);
        self.body_ipos.push(centre);
        self.body_iquat.push(axes);
        self.body_inertia.push(moments);
    }

    fn add_joint(&mut self, armature: f64, friction: Friction) {
        self.dof_armature.push(armature);
        self.dof_damping.push(friction.viscous);
        self.dof_frictionloss.push(friction.coulomb);
    }
}
