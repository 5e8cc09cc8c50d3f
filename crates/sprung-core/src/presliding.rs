//! Elements of presliding friction and of hysteresis: each grows with the travel after a reversal, then slides.
//!
//! An element is a spring in series with Coulomb friction. Its value is the force over that of
//! sliding, from −1 to 1. The sum of elements of several widths is a hysteresis loop without a law of
//! velocity: friction at rest keeps its value. In presliding friction the motor travels, in the hysteresis
//! of a spring its deflection.
//!
//! # Source
//!
//! Prandtl-Ishlinskii operators, as friction: Al-Bender, Lampaert and Swevers, IEEE Transactions on
//! Automatic Control 2005, the generalised Maxwell slip.

/// Number of elements of presliding friction, and of those of hysteresis, of one joint.
pub const ELEMENTS: usize = 6;

/// Number of all elements of one joint: those of presliding friction, then those of hysteresis.
pub const ALL_ELEMENTS: usize = 2 * ELEMENTS;

/// Width of each element of presliding friction over that of the widest: the travel from the middle until the element slides.
pub const WIDTHS: [f64; ELEMENTS] = [0.0025, 0.01, 0.03, 0.1, 0.3, 1.0];

/// The same of the elements of hysteresis.
pub const SPRING_WIDTHS: [f64; ELEMENTS] = [0.015, 0.04, 0.1, 0.25, 0.5, 1.0];

/// Returns the elements after a motion in one direction.
///
/// - `elements`: before the motion, from −1 to 1.
/// - `travel`: of the motor before the coupled transmission, or of the deflection, rad (m).
/// - `width`: of the widest element, rad (m), positive; `shares`: of each element over it.
#[must_use]
#[inline]
pub fn moved(
    elements: &[f64; ELEMENTS],
    travel: f64,
    width: f64,
    shares: &[f64; ELEMENTS],
) -> [f64; ELEMENTS] {
    let mut moved = *elements;
    for (element, share) in moved.iter_mut().zip(shares) {
        *element = (*element + travel / (share * width)).clamp(-1.0, 1.0);
    }
    moved
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_slide_after_their_width_and_turn_with_twice_the_width() {
        let rest = [0.0; ELEMENTS];
        for (at, share) in WIDTHS.into_iter().enumerate() {
            let half = moved(&rest, 0.5 * share, 1.0, &WIDTHS);
            assert!((half[at] - 0.5).abs() < 1e-12);
            let slides = moved(&half, 3.0 * share, 1.0, &WIDTHS);
            assert!((slides[at] - 1.0).abs() < 1e-12);
            let back = moved(&slides, -share, 1.0, &WIDTHS);
            assert!(back[at].abs() < 1e-12);
        }
    }

    #[test]
    fn a_closed_loop_takes_energy_and_returns_to_its_beginning() {
        // Over a cycle of ±a an element of width w takes 4 w (a/w − 1) of its largest force if a > w.
        let (width, amplitude) = (1.0, 0.25);
        let steps = 20_000;
        let mut elements = [0.0; ELEMENTS];
        let mut work = [0.0; ELEMENTS];
        let position = |k: i32| {
            let turns = f64::from(k) / f64::from(steps);
            let share = turns - libm::floor(turns);
            amplitude * (1.0 - 4.0 * (share - 0.5).abs())
        };
        let mut begin = elements;
        for k in 0..2 * steps {
            if k == steps {
                begin = elements;
            }
            let travel = position(k + 1) - position(k);
            let next = moved(&elements, travel, width, &WIDTHS);
            if k >= steps {
                for ((work, before), after) in work.iter_mut().zip(elements).zip(next) {
                    *work += 0.5 * (before + after) * travel;
                }
            }
            elements = next;
        }
        for at in 0..ELEMENTS {
            let w = WIDTHS[at] * width;
            let expected = (4.0 * (amplitude - w)).max(0.0);
            assert!((work[at] - expected).abs() < 1e-3, "{at}: {}", work[at]);
            assert!((elements[at] - begin[at]).abs() < 1e-9);
        }
    }
}
