//! Random robots made of bodies, and derivatives by differences.

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
}

/// Two links and the rotor that sits on the tip of the first.
pub(crate) struct Body {
    mass: [f64; 2],
    /// Distance of the centre of mass from the link's joint.
    centre: [f64; 2],
    /// About the centre of mass.
    inertia: [f64; 2],
    length: f64,
    rotor_mass: f64,
}

impl Body {
    pub(crate) fn draw(random: &mut Random) -> Self {
        Self {
            mass: [random.between(0.2, 3.0), random.between(0.2, 3.0)],
            centre: [random.between(0.05, 0.4), random.between(0.05, 0.4)],
            inertia: [random.between(0.001, 0.1), random.between(0.001, 0.1)],
            length: random.between(0.2, 0.6),
            rotor_mass: random.between(0.0, 1.0),
        }
    }

    /// The parameters of the links as defined, those of the joints at random.
    pub(crate) fn theta(&self, random: &mut Random) -> [f64; 15] {
        let ([m1, m2], [l1, l2]) = (self.mass, self.centre);
        let mut theta = [0.0; 15];
        theta[0] = self.inertia[0]
            + self.inertia[1]
            + m1 * l1 * l1
            + (m2 + self.rotor_mass) * self.length * self.length
            + m2 * l2 * l2;
        theta[1] = m2 * self.length * l2;
        theta[2] = self.inertia[1] + m2 * l2 * l2;
        for (from, low, high) in [
            (3, 0.005, 0.3),
            (5, 0.0, 0.1),
            (7, 0.0, 9.0),
            (9, 2.0, 50.0),
            (11, 0.0, 0.1),
            (13, 0.0, 2.0),
        ] {
            theta[from] = random.between(low, high);
            theta[from + 1] = random.between(low, high);
        }
        theta
    }

    /// Mass, position and velocity of each body's centre.
    fn centres(&self, q: &[f64; 2], dq: &[f64; 2]) -> [(f64, [f64; 2], [f64; 2]); 3] {
        let (angle, speed) = ([q[0], q[0] + q[1]], [dq[0], dq[0] + dq[1]]);
        let arm = |r: f64, i: usize| {
            let (sin, cos) = angle[i].sin_cos();
            (
                [r * cos, r * sin],
                [-r * speed[i] * sin, r * speed[i] * cos],
            )
        };
        let sum = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        let (first, first_rate) = arm(self.centre[0], 0);
        let (tip, tip_rate) = arm(self.length, 0);
        let (second, second_rate) = arm(self.centre[1], 1);
        [
            (self.mass[0], first, first_rate),
            (self.rotor_mass, tip, tip_rate),
            (self.mass[1], sum(tip, second), sum(tip_rate, second_rate)),
        ]
    }

    pub(crate) fn kinetic_energy(&self, q: &[f64; 2], dq: &[f64; 2]) -> f64 {
        let spin = [dq[0], dq[0] + dq[1]];
        let turning: f64 = (0..2).map(|i| self.inertia[i] * spin[i] * spin[i]).sum();
        let moving: f64 = (self.centres(q, dq).iter())
            .map(|(m, _, v)| m * (v[0] * v[0] + v[1] * v[1]))
            .sum();
        0.5 * (turning + moving)
    }

    /// About the axis of the first joint.
    pub(crate) fn angular_momentum(&self, q: &[f64; 2], dq: &[f64; 2]) -> f64 {
        let turning = self.inertia[0] * dq[0] + self.inertia[1] * (dq[0] + dq[1]);
        let moving: f64 = (self.centres(q, dq).iter())
            .map(|(m, x, v)| m * (x[0] * v[1] - x[1] * v[0]))
            .sum();
        turning + moving
    }
}

/// Derivative at zero by a central difference of order 6.
pub(crate) fn rate_of(f: impl Fn(f64) -> f64) -> f64 {
    let h = 1e-4;
    let pair = |n: f64| f(n * h) - f(-n * h);
    (45.0 * pair(1.0) - 9.0 * pair(2.0) + pair(3.0)) / (60.0 * h)
}

/// An error as part of `scale`, or of 1 where the scale is smaller.
pub(crate) fn scaled(error: f64, scale: f64) -> f64 {
    error.abs() / scale.abs().max(1.0)
}
