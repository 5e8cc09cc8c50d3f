//! Steps of the deflection of a joint: motor less link position.

/// A jump exceeds this multiple of every other step of the deflection.
const JUMP_RATIO: f64 = 20.0;

/// A jump exceeds its neighbours by this factor.
const LONE_RATIO: f64 = 4.0;

/// A step of the deflection that stays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DeflectionJump {
    /// Time of the last sample before it, s.
    pub(crate) time: f64,
    /// Change of the position that jumps, rad (m).
    pub(crate) size: f64,
    /// Its size over that of every other step.
    pub(crate) ratio: f64,
    /// Whether the motor position jumps, and not that of the link.
    pub(crate) is_motor: bool,
}

/// Motor and link position of a joint at one sample.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pair {
    pub(crate) time: f64,
    pub(crate) motor: f64,
    pub(crate) link: f64,
}

impl Pair {
    fn deflection(self) -> f64 {
        self.motor - self.link
    }
}

/// The largest steps of the deflection of a joint. Their memory does not grow with the log.
#[derive(Clone, Debug, Default)]
pub(crate) struct DeflectionSteps {
    last: [Pair; 3],
    remembered: usize,
    largest: Option<DeflectionJump>,
    /// Largest of all other steps.
    second: f64,
}

impl DeflectionSteps {
    /// Takes the next sample.
    pub(crate) fn take(&mut self, next: Pair) {
        if self.remembered == 3 {
            let [a, b, c] = self.last;
            self.judge([a, b, c, next]);
        }
        self.last = [self.last[1], self.last[2], next];
        self.remembered = (self.remembered + 1).min(3);
    }

    /// Records that samples are missing before the next one.
    pub(crate) fn gap(&mut self) {
        self.remembered = 0;
    }

    /// Judges the step between the two middle samples.
    fn judge(&mut self, x: [Pair; 4]) {
        let step = |k: usize, of: fn(Pair) -> f64| of(x[k + 1]) - of(x[k]);
        let size = step(1, Pair::deflection).abs();
        let beside = [0, 2].map(|k| step(k, Pair::deflection).abs());
        let largest = self.largest.map_or(0.0, |jump| jump.size.abs());
        if size <= largest || size <= LONE_RATIO * beside[0].max(beside[1]) {
            self.second = self.second.max(size);
            return;
        }
        self.second = self.second.max(largest);
        // What a position steps beyond its motion before and after.
        let beyond = |of: fn(Pair) -> f64| step(1, of) - 0.5 * (step(0, of) + step(2, of));
        let (motor, link) = (beyond(|pair| pair.motor), beyond(|pair| pair.link));
        let is_motor = motor.abs() > link.abs();
        self.largest = Some(DeflectionJump {
            time: x[1].time,
            size: if is_motor { motor } else { link },
            ratio: 0.0,
            is_motor,
        });
    }

    /// Returns the step that is far larger than every other one.
    pub(crate) fn jump(&self) -> Option<DeflectionJump> {
        let jump = self.largest?;
        let ratio = jump.size.abs() / self.second;
        (self.second > 0.0 && ratio > JUMP_RATIO).then_some(DeflectionJump { ratio, ..jump })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A joint that moves, with a deflection of 0.1 mrad and positions of 10 µrad.
    fn jump_of(change: impl Fn(usize, &mut Pair)) -> Option<DeflectionJump> {
        let mut steps = DeflectionSteps::default();
        for k in 0..5000 {
            let time = 2e-3 * k as f64;
            let (link, deflection) = (0.5 * (3.0 * time).sin(), 1e-4 * (7.0 * time).cos());
            let counts = |x: f64| (x / 1e-5).round() * 1e-5;
            let mut pair = Pair {
                time,
                motor: counts(link + deflection),
                link: counts(link),
            };
            change(k, &mut pair);
            steps.take(pair);
        }
        steps.jump()
    }

    #[test]
    fn lost_counts_jump_once_in_one_position() {
        let jump = jump_of(|k, pair| pair.motor += if k > 4000 { -1e-3 } else { 0.0 }).unwrap();
        assert!(jump.is_motor && (jump.size + 1e-3).abs() < 3e-5, "{jump:?}");
        assert!((jump.time - 8.0).abs() < 1e-9, "{jump:?}");
        let jump = jump_of(|k, pair| pair.link += if k > 100 { 2e-3 } else { 0.0 }).unwrap();
        assert!(
            !jump.is_motor && (jump.size - 2e-3).abs() < 3e-5,
            "{jump:?}"
        );
    }

    #[test]
    fn motion_spikes_and_several_jumps_are_no_jump() {
        assert_eq!(jump_of(|_, _| ()), None);
        assert_eq!(
            jump_of(|k, pair| pair.link += if k == 900 { 1e-2 } else { 0.0 }),
            None
        );
        let back = |k: usize, pair: &mut Pair| {
            if (900..1200).contains(&k) {
                pair.link += 1e-2;
            }
        };
        assert_eq!(jump_of(back), None);
        // A spring whose stop is hit moves within several samples.
        let ramp =
            |k: usize, pair: &mut Pair| pair.motor += 1e-2 * ((k as f64 - 2000.0) / 5.0).tanh();
        assert_eq!(jump_of(ramp), None);
    }
}
