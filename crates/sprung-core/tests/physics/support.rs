//! Random numbers, robots on the heap, and derivatives by finite differences.
use sprung_core::controller::{Compensation, Feedforward, FeedforwardScratch, TorqueSeries};
use sprung_core::drives::State;
use sprung_core::links::{JointScratch, PairScratch, Step, Workspace, numbers_len};
use sprung_core::robot::{Robot, Torques, Values};
use sprung_core::scalar::Scalar;

/// The generator `SplitMix64`: the same numbers on every machine.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let unit = ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// Two numbers between `-limit` and `limit`.
    pub(crate) fn pair(&mut self, limit: f64) -> [f64; 2] {
        [self.between(-limit, limit), self.between(-limit, limit)]
    }

    /// As many numbers between `-limit` and `limit`.
    pub(crate) fn list(&mut self, n: usize, limit: f64) -> Vec<f64> {
        (0..n).map(|_| self.between(-limit, limit)).collect()
    }
}

/// A workspace on the heap.
pub(crate) struct Memory {
    joints: Vec<JointScratch>,
    steps: Vec<Step>,
    pairs: Vec<PairScratch>,
    numbers: Vec<f64>,
}

impl Memory {
    pub(crate) fn new(n: usize) -> Self {
        Self {
            joints: vec![JointScratch::default(); n],
            steps: vec![Step::default(); n],
            pairs: vec![PairScratch::default(); n * n],
            numbers: vec![f64::NAN; numbers_len(n)],
        }
    }

    pub(crate) fn workspace(&mut self) -> Workspace<'_> {
        Workspace {
            joints: &mut self.joints,
            steps: &mut self.steps,
            pairs: &mut self.pairs,
            numbers: &mut self.numbers,
        }
    }
}

/// A state on the heap.
pub(crate) struct JointState {
    pub(crate) q: Vec<f64>,
    pub(crate) dq: Vec<f64>,
    pub(crate) phi: Vec<f64>,
    pub(crate) dphi: Vec<f64>,
    /// Elements of presliding friction and hysteresis; empty without.
    pub(crate) elements: Vec<f64>,
}

impl JointState {
    pub(crate) fn view(&self) -> State<'_> {
        State {
            q: &self.q,
            dq: &self.dq,
            phi: &self.phi,
            dphi: &self.dphi,
            excess: &[],
            elements: &self.elements,
        }
    }

    /// State after the time `t` at constant accelerations. Its first derivatives at zero are those of the true
    /// motion.
    pub(crate) fn moved(&self, [ddq, ddphi]: &[Vec<f64>; 2], t: f64) -> Self {
        Self {
            q: moved(&moved(&self.q, &self.dq, t), ddq, 0.5 * t * t),
            dq: moved(&self.dq, ddq, t),
            phi: moved(&moved(&self.phi, &self.dphi, t), ddphi, 0.5 * t * t),
            dphi: moved(&self.dphi, ddphi, t),
            elements: self.elements.clone(),
        }
    }
}

/// Accelerations of links and motors.
pub(crate) fn acceleration(
    robot: &Robot<'_>,
    values: &Values<'_>,
    state: &JointState,
    tau: &[f64],
) -> [Vec<f64>; 2] {
    let torques = Torques {
        motor: tau,
        link: None,
    };
    forced_acceleration(robot, values, state, &torques)
}

/// Accelerations of links and motors under torques on both.
pub(crate) fn forced_acceleration(
    robot: &Robot<'_>,
    values: &Values<'_>,
    state: &JointState,
    torques: &Torques<'_>,
) -> [Vec<f64>; 2] {
    let n = robot.joints();
    let [mut torque, mut out] = [(); 2].map(|()| vec![f64::NAN; robot.rows()]);
    robot.coordinate_torques(torques, &mut torque).unwrap();
    let mut memory = Memory::new(n);
    let workspace = &mut memory.workspace();
    robot
        .acceleration(values, &state.view(), &torque, workspace, &mut out)
        .unwrap();
    let motors = (0..n).map(|joint| out[robot.motor_coordinate(joint)]);
    [out[..n].to_vec(), motors.collect()]
}

/// Entries of `Y_a` and `Y_b`.
pub(crate) fn entries(robot: &Robot<'_>, state: &JointState) -> [Vec<f64>; 2] {
    let mut memory = Memory::new(robot.joints());
    let mut entries = [(); 2].map(|()| vec![f64::NAN; robot.entries]);
    let [momentum, rest] = &mut entries;
    robot
        .regressor(&state.view(), &mut memory.workspace(), momentum, rest)
        .unwrap();
    entries
}

/// `Y_a theta` and `Y_b theta`.
///
/// - `places`: row and column of every entry.
pub(crate) fn products(
    robot: &Robot<'_>,
    places: &[(usize, usize)],
    theta: &[f64],
    state: &JointState,
) -> [Vec<f64>; 2] {
    entries(robot, state).map(|entries| {
        assert_eq!(entries.len(), places.len());
        let mut sums = vec![0.0; robot.rows()];
        for (entry, &(row, column)) in entries.iter().zip(places) {
            sums[row] += entry * theta[column];
        }
        sums
    })
}

/// Nominal torque and state on a desired link trajectory.
///
/// - `speed`: speed below which the compensation of friction fades; without it there is none.
pub(crate) fn feedforward(
    robot: &Robot<'_>,
    values: &Values<'_>,
    q_d: &[[f64; 5]],
    speed: Option<f64>,
) -> (Vec<f64>, JointState) {
    let n = robot.joints();
    let mut series = [(); 4].map(|()| vec![TorqueSeries::ZERO; n]);
    let mut steps = vec![Step::default(); n];
    let [mut tau, mut phi, mut dphi] = [(); 3].map(|()| vec![f64::NAN; n]);
    let mut nominal = Feedforward {
        tau: &mut tau,
        phi: &mut phi,
        dphi: &mut dphi,
    };
    let mut scratch = FeedforwardScratch {
        series: series.each_mut().map(Vec::as_mut_slice),
        steps: &mut steps,
    };
    let compensation = speed.map(|speed| Compensation {
        speed,
        elements: &[],
    });
    (nominal.fill(robot, values, q_d, compensation, &mut scratch)).unwrap();
    let of_order = |order: usize| q_d.iter().map(|d| d[order]).collect();
    let state = JointState {
        q: of_order(0),
        dq: of_order(1),
        phi,
        dphi,
        elements: Vec::new(),
    };
    (tau, state)
}

/// A smooth motion of every joint: a sine.
pub(crate) struct Waves(Vec<[f64; 3]>);

impl Waves {
    /// - `speed`: highest frequency, rad/s.
    pub(crate) fn draw(random: &mut Random, n: usize, speed: f64) -> Self {
        let mut wave = || [1.0, speed, 3.0].map(|limit| random.between(-limit, limit));
        Self((0..n).map(|_| wave()).collect())
    }

    /// Derivatives 0 to 4 of every joint's position.
    pub(crate) fn at(&self, t: f64) -> Vec<[f64; 5]> {
        let wave = |[amplitude, w, phase]: &[f64; 3]| {
            let (sin, cos) = (w * t + phase).sin_cos();
            let turns = [sin, cos, -sin, -cos, sin];
            std::array::from_fn(|order| amplitude * w.powi(order as i32) * turns[order])
        };
        self.0.iter().map(wave).collect()
    }
}

/// The largest error so far, relative to a scale.
#[derive(Default)]
pub(crate) struct Worst(f64);

impl Worst {
    /// - `scale`: reference of the error; at least 1 is used.
    pub(crate) fn see(&mut self, error: f64, scale: f64) {
        let error = error.abs() / scale.abs().max(1.0);
        // A NaN counts as an infinite error.
        self.0 = self
            .0
            .max(if error.is_nan() { f64::INFINITY } else { error });
    }

    pub(crate) fn assert_below(&self, limit: f64, what: &str) {
        println!("{what}: {:.1e}", self.0);
        assert!(self.0 < limit, "{what}: {:e}", self.0);
    }
}

pub(crate) fn inner(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `x + t v`.
pub(crate) fn moved(x: &[f64], v: &[f64], t: f64) -> Vec<f64> {
    x.iter().zip(v).map(|(x, v)| x + t * v).collect()
}

/// Derivative at zero by finite differences of sixth order.
pub(crate) fn slope(h: f64, f: impl Fn(f64) -> f64) -> f64 {
    let d = |k: f64| f(k * h) - f(-k * h);
    (45.0 * d(1.0) - 9.0 * d(2.0) + d(3.0)) / (60.0 * h)
}

/// Error of [`slope`] if every value of a function of size 1 has an error of one rounding. The error by the step,
/// `h⁶/140` times the seventh derivative, is far below it for the steps of these tests.
pub(crate) fn slope_rounding(h: f64) -> f64 {
    2.0 * (45.0 + 9.0 + 1.0) / (60.0 * h) * f64::EPSILON
}

/// Roundings between a state and a torque or an energy: about 20 for each of up to twelve joints.
pub(crate) const ROUNDINGS: f64 = 240.0;
