//! Assigns the columns of a log to the quantities of a robot's joints.

use sprung_core::chain::JointKind;

use super::blocks::blocks;
use super::by_content::{count, joined};
use super::error::ChooseError;
use super::families::{Family, families, shortened};
use super::positions::{Positions, positions, size, slopes};
use super::read::Survey;
use super::robots::several;
use super::slopes::Slope;
use super::times::time;
use super::torques::{Torques, held, joint_torques, torques, with_sensors};
use super::units::{Reading, absolute, by_slope, of_torques};
use super::words::{Sort, Token, tokens, words};
use super::write::{Conversion, lines, number};
use crate::description::{Chosen, ChosenJoint, ChosenLine, FILL_IN, JointOfStart, quoted};

/// Assigns the columns of a log to quantities.
///
/// - `joints`: the joints of the robot; `mimics`: names of joints that follow others; `files`: paths of the logs for the
///   experiment.
///
/// # Errors
///
/// [`ChooseError`] if no column belongs to a joint of the arm.
pub fn choose(
    survey: &Survey,
    (joints, mimics): (&[JointOfStart], &[String]),
    files: &[String],
) -> Result<Chosen, ChooseError> {
    let robots = several(survey);
    if !robots.is_empty() {
        return Err(ChooseError::SeveralRobots {
            file: survey.file.clone(),
            topics: robots,
        });
    }
    let all = blocks(survey, Some(joints.len()))
        .unwrap_or_else(|| joined(survey, families(survey, joints, mimics), joints.len()));
    let all = with_sensors(survey, all);
    let of_joints: Vec<&Family> = all
        .iter()
        .filter(|family| family.problem.is_none())
        .collect();
    let is_clock = |family: &&Family| family.meaning.sort == Some(Sort::Time);
    let problems: Vec<&Family> = (all.iter())
        .filter(|family| family.problem.is_some() && !is_clock(family))
        .filter(|family| {
            let is_ambiguous = family
                .problem
                .as_ref()
                .is_some_and(|problem| problem.is_ambiguous);
            family.columns.len() > 1 || is_ambiguous
        })
        .collect();
    if of_joints.is_empty() && problems.iter().all(|family| family.meaning.sort.is_none()) {
        return Err(no_joint(survey, joints));
    }
    let torque = torques(survey, &all, joints);
    let positions = positions(survey, &all, torque.family);
    let decided = Decided {
        survey,
        robot: joints,
        all: &all,
        positions,
        torque,
        joint_torque: joint_torques(survey, &all),
    };
    let (of_gripper, of_arm): (Vec<usize>, Vec<usize>) =
        (decided.joints().into_iter()).partition(|&joint| joints[joint].gripper.is_some());
    if of_arm.is_empty() && !of_gripper.is_empty() {
        let reasons = of_gripper.iter().map(|&joint| &joints[joint]);
        let named = |joint: &JointOfStart| {
            format!(
                "{} ({})",
                joint.name,
                joint.gripper.as_deref().unwrap_or_default()
            )
        };
        return Err(ChooseError::OnlyGripper {
            file: survey.file.clone(),
            joints: reasons.map(named).collect::<Vec<_>>().join(", "),
        });
    }
    if of_arm.is_empty() && problems.is_empty() {
        return Err(ChooseError::NothingMoves {
            file: survey.file.clone(),
        });
    }
    Ok(decided.chosen((&of_arm, &of_gripper), files, &problems))
}

/// Returns the number of joints by the positions of a log: their largest family; `None` if the names
/// of the columns have no numbers.
#[must_use]
pub fn joint_count(survey: &Survey) -> Option<usize> {
    if let Some(blocks) = blocks(survey, None) {
        return blocks.first().map(|block| block.columns.len());
    }
    let all = families(survey, &[], &[]);
    let positions: Vec<&Family> = (all.iter())
        .filter(|family| family.meaning.sort == Some(Sort::Position))
        .collect();
    let numbers = |family: &&Family| -> Vec<Token> {
        let (source, column) = family.columns[0];
        let all = tokens(&survey.sources[source].columns[column].name);
        (all.into_iter())
            .filter(|token| matches!(token, Token::Number(_)))
            .collect()
    };
    // Columns with the same number belong to one joint.
    let share_a_number = || {
        let mut of_positions = positions.iter().map(numbers);
        let first = of_positions.next().filter(|numbers| !numbers.is_empty());
        first.is_some_and(|first| of_positions.all(|other| other == first))
    };
    match positions.iter().map(|family| family.columns.len()).max() {
        Some(1) if positions.len() > 1 && !share_a_number() => count(survey, &all),
        largest => largest,
    }
}

fn no_joint(survey: &Survey, joints: &[JointOfStart]) -> ChooseError {
    let names: Vec<String> = joints.iter().map(|joint| joint.name.clone()).collect();
    let columns = survey.all_names();
    let mut best: Option<(f64, &String, &String)> = None;
    for joint in &names {
        let wanted: Vec<String> = words_of(joint);
        for column in &columns {
            let words = words_of(column);
            let Some(near) = (wanted.iter().filter(|word| word.len() > 2))
                .flat_map(|word| words.iter().map(|other| strsim::jaro_winkler(word, other)))
                .max_by(f64::total_cmp)
            else {
                continue;
            };
            if best.as_ref().is_none_or(|(most, ..)| near > *most) {
                best = Some((near, joint, column));
            }
        }
    }
    let nearest = best
        .filter(|(near, ..)| *near > 0.75)
        .map_or_else(String::new, |(_, joint, column)| {
            format!("; the nearest names are \"{column}\" and {joint}")
        });
    let is_bag = survey.sources.iter().any(|source| source.topic.is_some());
    ChooseError::NoJoint {
        file: survey.file.clone(),
        joints: shortened(&names),
        has: if is_bag { "Topics" } else { "Columns" },
        columns: shortened(&columns),
        nearest,
    }
}

fn words_of(name: &str) -> Vec<String> {
    words(&tokens(name))
        .into_iter()
        .map(str::to_owned)
        .collect()
}

/// Returns the joints of a family among some joints.
fn joints_in(family: &Family, joints: &[usize]) -> Vec<usize> {
    let all = joints.iter().copied();
    all.filter(|&joint| family.of[joint].is_some()).collect()
}

/// The chosen families of a log.
struct Decided<'a> {
    survey: &'a Survey,
    robot: &'a [JointOfStart],
    all: &'a [Family],
    positions: Positions,
    torque: Torques,
    /// Index of the family of the joint torque sensors.
    joint_torque: Option<usize>,
}

/// Columns of some joints for one quantity.
#[derive(Clone, Copy)]
struct Part<'a> {
    /// The key without its unit.
    stem: &'a str,
    family: &'a Family,
    joints: &'a [usize],
}

/// Units of the positions, and gear ratios.
#[derive(Default)]
struct Readings {
    motor: Option<Reading>,
    link: Option<Reading>,
}

impl Decided<'_> {
    fn family(&self, index: Option<usize>) -> Option<&Family> {
        index.map(|index| &self.all[index])
    }

    /// Returns the joints of the log: those with a motor position and a torque.
    fn joints(&self) -> Vec<usize> {
        let has = |family: Option<&Family>, joint: usize| {
            family.is_none_or(|family| family.of[joint].is_some())
        };
        let motor = self.family(self.positions.motor);
        let torque = self.family(self.torque.family);
        let beside = self.family(self.torque.beside);
        let has_beside = |joint: usize| beside.is_some_and(|family| family.of[joint].is_some());
        if motor.is_none() && torque.is_none() {
            let named: Vec<usize> = (0..self.robot.len())
                .filter(|&joint| {
                    (self.all.iter()).any(|family| {
                        family.meaning.sort == Some(Sort::Position) && family.of[joint].is_some()
                    })
                })
                .collect();
            return named;
        }
        (0..self.robot.len())
            .filter(|&joint| has(motor, joint) && (has(torque, joint) || has_beside(joint)))
            .collect()
    }

    fn chosen(
        &self,
        (of_arm, of_gripper): (&[usize], &[usize]),
        files: &[String],
        problems: &[&Family],
    ) -> Chosen {
        let list: Vec<String> = files.iter().map(|file| quoted(file)).collect();
        let file = match &list[..] {
            [one] => one.clone(),
            _ => format!("[{}]", list.join(", ")),
        };
        let mut chosen = Chosen {
            lines: vec![ChosenLine::new("file", file, "")],
            joints: (of_arm.iter())
                .map(|&joint| ChosenJoint {
                    joint,
                    lines: Vec::new(),
                })
                .collect(),
            left_out: (0..self.robot.len())
                .filter(|joint| !of_arm.contains(joint) && !of_gripper.contains(joint))
                .map(|joint| self.robot[joint].name.clone())
                .collect(),
            grippers: (of_gripper.iter().map(|&joint| &self.robot[joint]))
                .filter_map(|joint| Some((joint.name.clone(), joint.gripper.clone()?)))
                .collect(),
            remarks: self.survey.joined.clone(),
            held: self.held(of_arm),
        };
        chosen.lines.extend(time(self.survey, self.all));
        if self.lacks_values(of_arm) {
            let why = "Some samples have no value; they are left out";
            chosen.lines.push(ChosenLine::new("nan", "\"gap\"", why));
        }
        let readings = self.readings(of_arm);
        self.springs(of_arm, &mut chosen);
        self.position_lines(of_arm, &readings, &mut chosen);
        self.torque_lines(of_arm, &readings, &mut chosen);
        self.joint_torque_lines(of_arm, &mut chosen);
        chosen.remarks.extend(self.unused(of_arm, problems));
        chosen
    }

    /// Returns for how many samples the torques keep their values, in words.
    fn held(&self, joints: &[usize]) -> Option<String> {
        let family = self.family(self.torque.family)?;
        let runs: Option<Vec<usize>> = (joints.iter().filter_map(|&joint| family.of[joint]))
            .map(|place| held(self.survey, place))
            .collect();
        let runs = runs?;
        match (runs.iter().min()?, runs.iter().max()?) {
            (1, 1) => Some("The torques of this log change with each sample".to_owned()),
            (least, most) if least == most => Some(format!(
                "The torques of this log keep each value for {most} samples, so the period of the controller is {most} \
                 times that of the log"
            )),
            _ => None,
        }
    }

    /// Returns whether a column of the joints has samples without a value.
    fn lacks_values(&self, joints: &[usize]) -> bool {
        let used = [
            self.positions.motor,
            self.positions.link,
            self.torque.family,
            self.torque.beside,
        ];
        let columns = (used.into_iter().flatten()).flat_map(|family| {
            joints
                .iter()
                .filter_map(move |&joint| self.all[family].of[joint])
        });
        columns
            .map(|(source, column)| &self.survey.sources[source].columns[column])
            .any(|column| column.figures.count < column.values.len())
    }

    /// Returns the units of the positions.
    fn readings(&self, joints: &[usize]) -> Readings {
        let of = (self.robot, joints);
        let (motor, link) = (
            self.family(self.positions.motor),
            self.family(self.positions.link),
        );
        let Some(motor) = motor else {
            return Readings::default();
        };
        let Some(link) = link else {
            let is_motor = motor.meaning.motor > 1;
            return Readings {
                motor: Some(absolute(self.survey, motor, of, is_motor)),
                link: None,
            };
        };
        let both = joints_in(link, joints);
        let of_both = (self.robot, &both[..]);
        let torque = self.family(self.torque.family);
        let of_link = absolute(self.survey, link, of_both, false);
        let in_si = |slopes: Vec<Option<Slope>>, reading: &Reading| -> Vec<Option<Slope>> {
            let size = |joint: usize| {
                let k = both.iter().position(|&other| other == joint);
                k.map_or(1.0, |k| size(Some(reading.conversion.units[k])))
            };
            let scaled = |(joint, slope): (usize, Option<Slope>)| {
                slope.map(|slope| Slope {
                    value: slope.value / size(joint),
                    error: slope.error / size(joint),
                })
            };
            slopes.into_iter().enumerate().map(scaled).collect()
        };
        if of_link.open.is_none() {
            let slopes = in_si(slopes(self.survey, (motor, link), torque), &of_link);
            let of_motor = (both.len() == joints.len())
                .then(|| by_slope(self.survey, motor, of, &slopes))
                .flatten();
            let of_motor = of_motor
                .unwrap_or_else(|| absolute(self.survey, motor, of, motor.meaning.motor > 1));
            return Readings {
                motor: Some(of_motor),
                link: Some(of_link),
            };
        }
        // The unit of the links is open; that of the motors may show it.
        let of_motor = absolute(self.survey, motor, of_both, true);
        let known = of_motor.open.is_none() && of_motor.gears.is_none();
        let by_motor = known.then(|| {
            let slopes = in_si(slopes(self.survey, (link, motor), torque), &of_motor);
            by_slope(self.survey, link, of_both, &slopes)
        });
        Readings {
            link: Some(by_motor.flatten().unwrap_or(of_link)),
            motor: Some(of_motor),
        }
    }

    /// Writes the transmissions: joints without a link position are rigid.
    fn springs(&self, joints: &[usize], chosen: &mut Chosen) {
        let link = self.family(self.positions.link.or(self.positions.deflection));
        for (k, &joint) in joints.iter().enumerate() {
            let has_link = match link {
                Some(family) => family.of[joint].is_some(),
                None => self.positions.is_open,
            };
            if !has_link && !self.is_on_link_side(joints) {
                let why = "The log has one position of this joint, so its spring cannot be seen";
                let line = ChosenLine::new("transmission", "\"rigid\"", why);
                chosen.joints[k].lines.push(line);
            }
        }
    }

    fn position_lines(&self, joints: &[usize], readings: &Readings, chosen: &mut Chosen) {
        let why = &self.positions.why;
        if self.positions.is_open {
            let kind = joints.first().map(|&joint| self.robot[joint].kind);
            let (unit, remark) = self.unit_of(Sort::Position, &["rad", "m", "deg"]);
            let (link, motor) = match (kind, unit) {
                (Some(JointKind::Prismatic), _) => ("link_position_m", "motor_position_m"),
                (_, Some("deg")) => ("link_position_deg", "motor_position_deg"),
                _ => ("link_position_rad", "motor_position_rad"),
            };
            let why = &format!("{why}{}{remark}", self.problem_of(&[Sort::Position]));
            chosen.lines.push(ChosenLine::open(motor, why.clone()));
            if self.positions.are_links_open {
                chosen.lines.push(ChosenLine::open(link, ""));
            }
            return;
        }
        if let (Some(index), Some(reading)) = (self.positions.link, &readings.link) {
            let family = &self.all[index];
            let both = joints_in(family, joints);
            let part = Part {
                stem: "link_position",
                family,
                joints: &both[..],
            };
            self.quantity(part, reading, why, chosen);
        }
        if let (Some(index), None) = (self.positions.deflection, self.positions.link) {
            let family = &self.all[index];
            let both = joints_in(family, joints);
            let of = (self.robot, &both[..]);
            let reading = absolute(self.survey, family, of, false);
            let part = Part {
                stem: "link_deflection",
                family,
                joints: &both[..],
            };
            self.quantity(
                part,
                &reading,
                "Deflections, link minus motor position",
                chosen,
            );
        }
        if let (Some(index), Some(reading)) = (self.positions.motor, &readings.motor) {
            let why = if self.positions.link.is_some() {
                ""
            } else {
                why.as_str()
            };
            let is_of_links = self.positions.link.is_none() && self.is_on_link_side(joints);
            let part = Part {
                stem: if is_of_links {
                    "link_position"
                } else {
                    "motor_position"
                },
                family: &self.all[index],
                joints,
            };
            self.quantity(part, reading, why, chosen);
            Self::gears(reading, chosen);
        }
    }

    /// Writes the lines of a quantity.
    ///
    /// - `why`: why these columns; the reason of their unit follows.
    fn quantity(&self, part: Part<'_>, reading: &Reading, why: &str, chosen: &mut Chosen) {
        let reasons: Vec<&str> = [
            why,
            &reading.why,
            reading.open.as_deref().unwrap_or_default(),
        ]
        .into_iter()
        .filter(|reason| !reason.is_empty())
        .collect();
        let why = reasons.join(". ");
        let is_counts = reading.conversion.units.contains(&"counts");
        let mut conversion = reading.conversion.clone();
        if reading.open.is_some() && !is_counts {
            conversion.units.fill(FILL_IN);
        }
        let joints = (self.robot, part.joints);
        let family = (part.stem, part.family);
        let joint_lines = lines(self.survey, family, joints, &conversion, &why);
        chosen.lines.extend(joint_lines);
    }

    fn gears(reading: &Reading, chosen: &mut Chosen) {
        let Some(gears) = &reading.gears else {
            return;
        };
        chosen
            .lines
            .push(ChosenLine::new("motor_position_side", "\"motor\"", ""));
        for (joint, gear) in chosen.joints.iter_mut().zip(gears) {
            joint.lines.push(match gear {
                Some(gear) => ChosenLine::new("gear_ratio", number(gear.ratio), &*gear.why),
                None => ChosenLine::open(
                    "gear_ratio",
                    "FILL IN the gear ratio, motor turns per joint turn: the motor positions were taken before \
                     the gearbox",
                ),
            });
        }
    }

    fn torque_lines(&self, joints: &[usize], readings: &Readings, chosen: &mut Chosen) {
        let Some(family) = self.family(self.torque.family) else {
            if self.is_on_link_side(joints) {
                return;
            }
            let problem = self.problem_of(&[Sort::Torque, Sort::Current, Sort::Voltage]);
            let (_, remark) = self.unit_of(Sort::Torque, &["N·m", "N"]);
            let why = format!("{}{problem}{remark}", self.torque.why);
            let line = ChosenLine::open("motor_torque_nm", why);
            chosen.lines.push(line);
            return;
        };
        let beside = self.family(self.torque.beside);
        for family in std::iter::once(family).chain(beside) {
            let of_family = joints_in(family, joints);
            self.lines_of_torque(family, (joints, &of_family), readings, chosen);
        }
    }

    /// Writes the lines of a family of torques, currents or voltages.
    ///
    /// - `joints`: the joints of the log, and those of the family.
    fn lines_of_torque(
        &self,
        family: &Family,
        (joints, of_family): (&[usize], &[usize]),
        readings: &Readings,
        chosen: &mut Chosen,
    ) {
        let (stem, usual) = match family.meaning.sort {
            Some(Sort::Current) => ("motor_current", Some("A")),
            Some(Sort::Voltage) => ("drive_voltage", Some("V")),
            _ => ("motor_torque", None),
        };
        let mut conversion: Conversion = of_torques(family, self.robot, of_family, usual);
        let mut why = self.torque.why.clone();
        let reversed = readings.motor.as_ref().map(|motor| &motor.conversion.signs);
        let sign = |joint: &usize| {
            let place = joints.iter().position(|other| other == joint);
            reversed
                .zip(place)
                .map_or(1.0, |(signs, place)| signs[place])
        };
        conversion.signs = of_family.iter().map(sign).collect();
        if conversion.signs.iter().any(|sign| *sign < 0.0) {
            if !why.is_empty() {
                why.push_str(". ");
            }
            why.push_str("Reversed with the motor positions");
        }
        let part = (stem, family);
        let joint_lines = lines(
            self.survey,
            part,
            (self.robot, of_family),
            &conversion,
            &why,
        );
        chosen.lines.extend(joint_lines);
        if stem == "motor_torque" {
            return;
        }
        for joint in (chosen.joints.iter_mut()).filter(|joint| of_family.contains(&joint.joint)) {
            joint.lines.push(ChosenLine::open(
                "torque_constant_nm_per_a",
                "FILL IN the motor torque per current, N·m/A, with torque_constant_side = \"motor\" as in the \
                 data sheet of a motor, or \"output\" if it contains the gear ratio: the log has no torques",
            ));
            if stem == "drive_voltage" {
                joint.lines.push(ChosenLine::open(
                    "amplifier_gain_a_per_v",
                    "FILL IN the current per command voltage of the amplifier, A/V",
                ));
            }
        }
    }

    /// Returns the joint torque sensors if they are used: all joints of the log have one and a second encoder, or no motor
    /// torque.
    fn used_joint_torque(&self, joints: &[usize]) -> Option<&Family> {
        let link = self.positions.link.or_else(|| {
            let is_lone = self.torque.are_absent && self.positions.deflection.is_none();
            self.positions.motor.filter(|_| is_lone)
        });
        let (sensor, link) = (self.family(self.joint_torque)?, self.family(link)?);
        let have = |family: &Family| joints.iter().all(|&joint| family.of[joint].is_some());
        (have(sensor) && have(link)).then_some(sensor)
    }

    /// Returns whether the log shows the links alone: it has joint torques and no torques of motors.
    fn is_on_link_side(&self, joints: &[usize]) -> bool {
        self.torque.are_absent && self.used_joint_torque(joints).is_some()
    }

    fn joint_torque_lines(&self, joints: &[usize], chosen: &mut Chosen) {
        let Some(family) = self.used_joint_torque(joints) else {
            return;
        };
        let conversion = of_torques(family, self.robot, joints, None);
        let alone = if self.is_on_link_side(joints) {
            ". The log has no motor torques, so links, their friction and springs are identified, and no motors"
        } else {
            ""
        };
        let why = format!(
            "Joint torque sensors: {}{alone}",
            family.by_recorder.unwrap_or("by their names")
        );
        let all = lines(
            self.survey,
            ("joint_torque", family),
            (self.robot, joints),
            &conversion,
            &why,
        );
        chosen.lines.extend(all);
    }

    /// Returns the unit in the names of all measured columns of a sort, and the notation for a unit without a key, as a
    /// further sentence.
    fn unit_of(&self, sort: Sort, with_keys: &[&str]) -> (Option<&'static str>, String) {
        let meanings = self.all.iter().map(|family| &family.meaning);
        let mut units: Vec<Option<&'static str>> = meanings
            .filter(|meaning| meaning.sort == Some(sort) && !meaning.is_reference)
            .map(|meaning| meaning.unit)
            .collect();
        units.dedup();
        let [Some(unit)] = units[..] else {
            return (None, String::new());
        };
        let remark = if with_keys.contains(&unit) {
            String::new()
        } else {
            format!(
                ". Their unit is {unit} by their names, so write the key without its unit and with \
                 {{ column = [\"…\"], unit = \"{unit}\" }}"
            )
        };
        (Some(unit), remark)
    }

    /// Returns why columns of these sorts do not belong to joints, as a further sentence.
    fn problem_of(&self, sorts: &[Sort]) -> String {
        let is_of_sorts = |family: &&Family| {
            family
                .meaning
                .sort
                .is_some_and(|sort| sorts.contains(&sort))
        };
        let told = (self.all.iter().filter(is_of_sorts)).find_map(|family| {
            let problem = family.problem.as_ref()?;
            Some(format!(
                ". \"{}\" cannot be used: {}",
                family.name, problem.text
            ))
        });
        told.unwrap_or_default()
    }

    /// Returns sentences about columns of joints that are not used.
    fn unused(&self, joints: &[usize], problems: &[&Family]) -> Vec<String> {
        let used = [
            self.positions.motor,
            self.positions.link,
            self.positions.deflection,
            self.torque.family,
            self.torque.beside,
            self.used_joint_torque(joints).and(self.joint_torque),
        ];
        let names: Vec<String> = (self.all.iter().enumerate())
            .filter(|(k, family)| !used.contains(&Some(*k)) && family.problem.is_none())
            .filter(|(_, family)| family.meaning.sort != Some(Sort::Time))
            .map(|(_, family)| family.name.clone())
            .collect();
        let names: Vec<String> = names
            .into_iter()
            .chain(self.survey.counters.iter().cloned())
            .collect();
        let mut all = Vec::new();
        if !names.is_empty() {
            all.push(format!("Not used: {}", shortened(&names)));
        }
        for family in self.all {
            let is_used = used
                .iter()
                .flatten()
                .any(|&k| std::ptr::eq(&raw const self.all[k], family));
            if let (Some(by), false) = (family.by_recorder, is_used) {
                all.push(format!("\"{}\": {by}", family.name));
            }
            if let Some(by) = &family.joints_by {
                all.push(format!("Joints of \"{}\": by {by}", family.name));
            }
        }
        for family in problems {
            let problem = family.problem.as_ref().map_or("", |problem| &problem.text);
            all.push(format!("Not used: \"{}\": {problem}", family.name));
        }
        all
    }
}
