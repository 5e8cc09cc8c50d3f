//! Reduces the joints of the file to the joints that move in an experiment.

use sprung_core::chain::ChainJoint;
use sprung_core::spatial::BODY;

use super::body::Placement;
use super::error::UrdfError;
use super::robot::{Freedom, Joint, Mobility, TreeJoint, Urdf};

/// Place of a link or a joint: the moving joint that carries it (`None`: the base), and its frame in
/// that joint's frame.
#[derive(Clone, Copy)]
pub(super) struct Seat {
    pub(super) carrier: Option<usize>,
    pub(super) placement: Placement,
}

const BASE: Seat = Seat {
    carrier: None,
    placement: Placement::IDENTITY,
};

impl Urdf {
    /// Returns the tree of the named joints, in their order.
    ///
    /// All other joints are fixed at zero, and their bodies are merged into the body that carries
    /// them. Links that no named joint carries belong to the base and are left out. The frame of the
    /// base is that of the root link.
    ///
    /// - `moving`: names of joints; each joint comes before the joints that it carries.
    ///
    /// # Errors
    ///
    /// [`UrdfError`] if a joint does not exist, is fixed, mimics another, is listed twice, or is
    /// listed after a joint that it carries.
    pub fn tree(&self, moving: &[&str]) -> Result<Vec<TreeJoint>, UrdfError> {
        tree(self, moving)
    }

    /// Returns the bodies that the named joints carry besides those of the links that they move.
    ///
    /// # Errors
    ///
    /// The errors of [`tree`](Self::tree).
    pub fn carried(&self, moving: &[&str]) -> Result<Vec<CarriedBody>, UrdfError> {
        let chosen = choose(self, moving)?;
        let (_, seats) = seats(self, &chosen);
        let children: Vec<usize> = (chosen.iter())
            .map(|(at, _)| self.joints[*at].child)
            .collect();
        let bodies = self.links.iter().zip(seats).enumerate();
        Ok(bodies
            .filter(|(at, _)| !children.contains(at))
            .filter_map(|(_, (link, seat))| {
                Some(CarriedBody {
                    link: link.name.clone(),
                    carrier: seat.carrier?,
                    parameters: link.body.as_ref()?.parameters(&seat.placement),
                })
            })
            .collect())
    }
}

/// A body that is fixed to a link that moves.
#[derive(Clone, Debug)]
pub struct CarriedBody {
    /// Its link.
    pub link: String,
    /// Index of the joint that moves it.
    pub carrier: usize,
    /// Inertial parameters about the origin of that joint's frame, in its axes.
    pub parameters: [f64; BODY],
}

fn tree(urdf: &Urdf, moving: &[&str]) -> Result<Vec<TreeJoint>, UrdfError> {
    let chosen = choose(urdf, moving)?;
    let (joint_seats, link_seats) = seats(urdf, &chosen);
    let mut tree = Vec::with_capacity(chosen.len());
    for (k, &(at, freedom)) in chosen.iter().enumerate() {
        let joint = &urdf.joints[at];
        let seat = joint_seats[at];
        if let Some(carrier) = seat.carrier.filter(|carrier| *carrier >= k) {
            return Err(UrdfError::Order {
                file: urdf.file.clone(),
                carrier: moving[carrier].to_owned(),
                carried: joint.name.clone(),
            });
        }
        tree.push(TreeJoint {
            name: joint.name.clone(),
            link: urdf.links[joint.child].name.clone(),
            joint: ChainJoint {
                parent: seat.carrier,
                rotation: seat.placement.rotation,
                origin: seat.placement.origin,
                axis: freedom.axis,
                kind: freedom.kind,
            },
            inertial: None,
            limits: freedom.limits.known(),
        });
    }
    for (link, seat) in urdf.links.iter().zip(link_seats) {
        if let (Some(body), Some(carrier)) = (&link.body, seat.carrier) {
            let sum = tree[carrier].inertial.get_or_insert([0.0; 10]);
            for (sum, part) in sum.iter_mut().zip(body.parameters(&seat.placement)) {
                *sum += part;
            }
        }
    }
    Ok(tree)
}

/// Returns the indices of the named joints and their motion.
pub(super) fn choose<'a>(
    urdf: &'a Urdf,
    moving: &[&str],
) -> Result<Vec<(usize, &'a Freedom)>, UrdfError> {
    let file = || urdf.file.clone();
    let mut chosen: Vec<(usize, &Freedom)> = Vec::with_capacity(moving.len());
    for &name in moving {
        let Some(at) = urdf.joints.iter().position(|joint| joint.name == name) else {
            return Err(UrdfError::UnknownJoint {
                file: file(),
                name: name.to_owned(),
                movable: (urdf.movable.iter())
                    .map(|joint| joint.name.clone())
                    .collect(),
            });
        };
        let Joint { line, mobility, .. } = &urdf.joints[at];
        let (name, line) = (name.to_owned(), *line);
        match mobility {
            Mobility::Fixed => {
                return Err(UrdfError::FixedJoint {
                    file: file(),
                    line,
                    name,
                });
            }
            Mobility::Mimic { leader } => {
                return Err(UrdfError::MimicJoint {
                    file: file(),
                    line,
                    name,
                    leader: leader.clone(),
                });
            }
            Mobility::Own(_) if chosen.iter().any(|(other, _)| *other == at) => {
                return Err(UrdfError::ListedTwice { file: file(), name });
            }
            Mobility::Own(freedom) => chosen.push((at, freedom)),
        }
    }
    Ok(chosen)
}

/// Returns the seats of all joints and of all links.
pub(super) fn seats(urdf: &Urdf, chosen: &[(usize, &Freedom)]) -> (Vec<Seat>, Vec<Seat>) {
    let mut place = vec![None; urdf.joints.len()];
    for (k, (at, _)) in chosen.iter().enumerate() {
        place[*at] = Some(k);
    }
    let mut joints = Vec::with_capacity(urdf.joints.len());
    // The root is on the base; every other link is the child of one joint, and parents come first.
    let mut links = vec![BASE; urdf.links.len()];
    for (joint, moves) in urdf.joints.iter().zip(place) {
        let parent = links[joint.parent];
        let seat = Seat {
            carrier: parent.carrier,
            placement: parent.placement.then(&joint.placement),
        };
        joints.push(seat);
        links[joint.child] = match moves {
            Some(_) => Seat {
                carrier: moves,
                ..BASE
            },
            None => seat,
        };
    }
    (joints, links)
}
