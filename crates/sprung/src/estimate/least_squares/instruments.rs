//! Instrumental variables: the regression is multiplied by the regression of a simulated motion
//! without noise.

use faer::Mat;

use crate::estimate::result::{CrossCheckResult, EstimateResult};
use crate::estimate::start::feasible;
use crate::finding::{Finding, Severity};
use crate::fit::{Fitted, Free};
use crate::model::{Model, Theta};
use crate::named::Named;
use crate::prepare::Excerpt;
use crate::preprocess::{Butterworth, RawBlock, SignalBlock, Smoother};
use crate::regression::{CrossProducts, Reading, cross_products, signals};
use crate::simulate::{Measured, Positions, subsystems};

/// Name in files and tables.
const NAME: &str = "instrumental-variables";

/// Number of rounds. Each round simulates the instruments with the estimate of the previous round.
const SIMULATION_ROUNDS: usize = 4;

/// Cut-off of the filter whose positions drive the simulation: this multiple of the position
/// filter's cut-off, at most this fraction of the sampling rate.
const DRIVING_CUTOFF_RATIO: f64 = 3.0;
const MAX_SHARE_OF_RATE: f64 = 0.4;

/// Minimum cosine between a column and its instrument.
const MIN_COSINE: f64 = 0.5;

/// Condition number of the products with scaled columns above which they are singular. The
/// condition number of the regression is about its square root.
const SINGULAR_CONDITION: f64 = 1e10;

/// Maximum number of parameters that the text of a finding names.
const MAX_NAMED_PARAMETERS: usize = 5;

/// Reason why there is no estimate.
#[derive(Clone, Debug, PartialEq)]
enum Refusal {
    /// No joint has a spring.
    Rigid,
    /// The samples have no weights.
    Unweighted,
    /// The beginning of the log is too short for the filters.
    TooShort,
    /// The simulated motion diverges from the measured one.
    Diverged,
    /// These columns correlate too little with their instruments.
    Uncorrelated(Vec<usize>),
    /// The products do not determine the parameters.
    Singular,
}

/// Adds the estimate to every result that has cross-checks. If there is no estimate, adds a finding
/// with the reason.
pub(in crate::estimate) fn add_instruments(
    reading: &Reading,
    excerpt: &Excerpt,
    fitted: &Fitted,
    results: &mut [EstimateResult],
) {
    let model = reading.model();
    let mut beside: Vec<&mut EstimateResult> = (results.iter_mut())
        .filter(|result| !result.cross_checks.is_empty())
        .collect();
    if beside.is_empty() {
        return;
    }
    match instrumental(reading, excerpt, &fitted.theta) {
        Ok(theta) => {
            let values: Named = (model.parameters().iter().zip(theta))
                .map(|(parameter, value)| (parameter.name.clone(), value))
                .collect();
            for result in &mut beside {
                result.cross_checks.push(CrossCheckResult {
                    method: NAME.to_owned(),
                    values: values.clone(),
                });
            }
        }
        Err(why) => {
            let finding = why.finding(model);
            for result in &mut beside {
                result.warnings.push(finding.clone());
            }
        }
    }
}

/// Solves the weighted regression of the beginning of a log by instrumental variables. Returns the
/// parameter vector, \[p\], or the reason why there is none.
///
/// The instruments are the regression of a simulated motion, with the same filters, weights and
/// samples. [`subsystems`] simulates it with the previous estimate, driven by positions whose
/// filter has three times the cut-off. Noise of the measured positions is in the regression, but
/// hardly in the instruments. So it hardly biases the products, whereas it biases the normal
/// equations of least squares. The bias by the Coulomb transition remains, because the mean
/// friction at noisy velocities differs from the friction at the mean velocity. Weights reduce this
/// bias. Without weights the method has no advantage over least squares.
///
/// # Source
///
/// `θ = (Z^T Y)^-1 Z^T b`, columns scaled; instruments from a simulation as in Janot, Vandanjon and
/// Gautier, "A generic instrumental variable approach for industrial robot identification", 2014,
/// but without a controller.
fn instrumental(reading: &Reading, excerpt: &Excerpt, linear: &[f64]) -> Result<Theta, Refusal> {
    let model = reading.model();
    let springs = (0..model.joint_count()).any(|joint| model.is_flexible(joint));
    if !springs {
        return Err(Refusal::Rigid);
    }
    if reading.weights().is_none() {
        return Err(Refusal::Unweighted);
    }
    let (period, blocks) = (excerpt.period(), excerpt.blocks());
    let measured = signals(reading, period, blocks).map_err(|_| Refusal::TooShort)?;
    let cutoff =
        (DRIVING_CUTOFF_RATIO * reading.position_cutoff_hz()).min(MAX_SHARE_OF_RATE / period);
    let wider = reading.with_position_cutoff(cutoff);
    let driving = signals(&wider, period, blocks).map_err(|_| Refusal::TooShort)?;
    let search = Search {
        reading,
        period,
        measured: &measured,
        driving: &driving,
    };
    search.run(linear)
}

/// Data from which the instruments are formed.
struct Search<'a> {
    reading: &'a Reading,
    period: f64,
    measured: &'a [SignalBlock],
    driving: &'a [SignalBlock],
}

impl Search<'_> {
    fn run(&self, linear: &[f64]) -> Result<Theta, Refusal> {
        let model = self.reading.model();
        let mut theta = linear.to_vec();
        for _ in 0..SIMULATION_ROUNDS {
            let (start, _) = feasible(model, &theta).map_err(|_| Refusal::Diverged)?;
            let simulated: Vec<Option<SignalBlock>> = (self.driving.iter())
                .map(|stretch| self.simulate(&start, stretch))
                .collect::<Result<_, _>>()?;
            let pairs: Vec<(&SignalBlock, &SignalBlock)> = (self.measured.iter())
                .filter_map(|of| Some((of, belonging(of, &simulated)?)))
                .collect();
            let products =
                cross_products(self.reading, &pairs, self.period).map_err(|_| Refusal::Singular)?;
            theta = solve(model, &products)?;
        }
        Ok(theta)
    }

    /// Returns a simulated segment, filtered as the measured ones; `None` if it is too short for
    /// the filters.
    fn simulate(
        &self,
        theta: &[f64],
        stretch: &SignalBlock,
    ) -> Result<Option<SignalBlock>, Refusal> {
        let model = self.reading.model();
        let measured = Measured {
            q: &stretch.q,
            dq: &stretch.dq,
            phi: &stretch.phi,
            dphi: &stretch.dphi,
            tau: &stretch.tau,
        };
        let Positions { q, phi } =
            subsystems(model, theta, &measured, self.period).map_err(|_| Refusal::Diverged)?;
        let order = self.reading.settings().position_filter_order;
        let Ok(filter) = Butterworth::new(order, self.reading.position_cutoff_hz(), self.period)
        else {
            return Ok(None);
        };
        let flexible: Vec<bool> = (0..model.joint_count())
            .map(|joint| model.is_flexible(joint))
            .collect();
        let mut smoother = Smoother::new(&filter, &flexible, self.period);
        let mut out = SignalBlock::new(model.joint_count());
        let raw = RawBlock {
            time: stretch.time.clone(),
            later: 0.0,
            begin: 0.0,
            q,
            phi,
            tau: stretch.tau.clone(),
            // Instruments need no right-hand side.
            spring: Vec::new(),
            gyroscope: Vec::new(),
            rate: Vec::new(),
            excess: stretch.excess.clone(),
        };
        smoother.push(&raw, &mut out);
        Ok(smoother.finish(&mut out).then_some(out))
    }
}

/// Returns the simulated segment that covers the middle of a measured one.
fn belonging<'s>(of: &SignalBlock, all: &'s [Option<SignalBlock>]) -> Option<&'s SignalBlock> {
    let middle = of.time.get(of.len() / 2)?;
    (all.iter().flatten()).find(|stretch| {
        let ends = stretch.time.first().zip(stretch.time.last());
        ends.is_some_and(|(first, last)| first <= middle && middle <= last)
    })
}

/// Solves `Z^T Y θ = Z^T b` for all rows together.
fn solve(model: &Model, products: &[CrossProducts]) -> Result<Theta, Refusal> {
    let free = Free::new(model);
    let count = free.unknowns.len();
    let mut a = Mat::<f64>::zeros(count, count);
    let mut b = vec![0.0; count];
    let (mut of_y, mut of_z) = (vec![0.0_f64; count], vec![0.0_f64; count]);
    for (row, sums) in products.iter().enumerate() {
        let columns = model.row_columns(row);
        let places: Vec<Option<usize>> = (columns.iter())
            .map(|column| free.unknowns.binary_search(column).ok())
            .collect();
        for (i, at) in places.iter().enumerate() {
            let Some(at) = *at else { continue };
            of_y[at] += sums.measured[i];
            of_z[at] += sums.instrument[i];
            b[at] += sums.products[(i, columns.len())];
            for (j, &column) in columns.iter().enumerate() {
                if let Some(of) = places[j] {
                    a[(at, of)] += sums.products[(i, j)];
                } else {
                    let known = model.parameters()[column].fixed.unwrap_or_default();
                    b[at] -= known * sums.products[(i, j)];
                }
            }
        }
    }
    let unlike: Vec<usize> = (0..count)
        .filter(|&i| {
            let cosine = a[(i, i)] / (of_y[i] * of_z[i]).sqrt();
            cosine.is_nan() || cosine < MIN_COSINE
        })
        .map(|i| free.unknowns[i])
        .collect();
    if !unlike.is_empty() {
        return Err(Refusal::Uncorrelated(unlike));
    }
    let scaled = Mat::from_fn(count, count, |i, j| a[(i, j)] / (of_z[i] * of_y[j]).sqrt());
    let svd = scaled.thin_svd().map_err(|_| Refusal::Singular)?;
    let (u, v) = (svd.U(), svd.V());
    let sigma: Vec<f64> = svd.S().column_vector().iter().copied().collect();
    if sigma
        .last()
        .is_none_or(|last| SINGULAR_CONDITION * last <= sigma[0])
    {
        return Err(Refusal::Singular);
    }
    let mut x = vec![0.0; count];
    for (k, sigma) in sigma.iter().enumerate() {
        let along: f64 = (0..count).map(|i| u[(i, k)] * b[i] / of_z[i].sqrt()).sum();
        for (j, x) in x.iter_mut().enumerate() {
            *x += v[(j, k)] * along / (sigma * of_y[j].sqrt());
        }
    }
    if x.iter().all(|x| x.is_finite()) {
        Ok(free.whole(&x, |value| value))
    } else {
        Err(Refusal::Singular)
    }
}

impl Refusal {
    fn finding(&self, model: &Model) -> Finding {
        let (why, about) = match self {
            Self::Rigid => (
                "no joint has a spring between link and motor".to_owned(),
                Vec::new(),
            ),
            Self::Unweighted => (
                "without weights = \"transition\" they have no advantage".to_owned(),
                Vec::new(),
            ),
            Self::TooShort => (
                "the beginning of the log is too short for the filters".to_owned(),
                Vec::new(),
            ),
            Self::Diverged => (
                "the simulated motion of links and motors diverges from the measured one"
                    .to_owned(),
                Vec::new(),
            ),
            Self::Uncorrelated(columns) => {
                let names: Vec<String> = (columns.iter())
                    .map(|&column| model.parameters()[column].name.clone())
                    .collect();
                let mut all = names[..names.len().min(MAX_NAMED_PARAMETERS)].join(", ");
                if let Some(more) = names
                    .len()
                    .checked_sub(MAX_NAMED_PARAMETERS)
                    .filter(|more| *more > 0)
                {
                    all = format!("{all} and {more} more");
                }
                (
                    format!(
                        "the simulated motion correlates too little with the measured one for {all}"
                    ),
                    names,
                )
            }
            Self::Singular => (
                "the simulated motion does not determine all parameters".to_owned(),
                Vec::new(),
            ),
        };
        Finding::new(
            Severity::Info,
            "no-instruments",
            format!("instrumental variables are left out of the cross-checks: {why}"),
            "use the other cross-checks, or record a motion that excites all joints",
        )
        .about(about)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{no_files, read};

    /// A carriage with mass, viscous friction, Coulomb friction and an offset.
    fn model(more: &str) -> Model {
        let text = format!(
            "format = 1\n[robot]\ndh_modified = [{{ prismatic = true }}]\n\
             gravity_m_per_s2 = [9.81, 0.0, 0.0]\n{more}\n[[robot.joint]]\nname = \"carriage\"\ntransmission = \"rigid\"\n"
        );
        Model::new(&read("carriage", &text, &[], &mut no_files).unwrap()).unwrap()
    }

    /// Products of rows that the parameters explain exactly; the instruments have no noise.
    fn products(theta: &[f64], change: impl Fn(&mut [f64; 4], &mut [f64; 4])) -> CrossProducts {
        let mut sums = CrossProducts {
            products: Mat::zeros(4, 5),
            measured: vec![0.0; 4],
            instrument: vec![0.0; 4],
        };
        for k in 0..400 {
            let t = 0.1 * f64::from(k);
            let mut z = [t.sin(), t.cos(), (1.7 * t).sin(), 1.0];
            // The noise alternates, so it is orthogonal to z.
            let noise = if k % 2 == 0 { 0.3 } else { -0.3 };
            let mut y = [z[0] + noise, z[1], z[2], z[3]];
            change(&mut z, &mut y);
            let clean = [y[0] - noise, y[1], y[2], y[3]];
            let rhs: f64 = clean.iter().zip(theta).map(|(y, x)| y * x).sum();
            for i in 0..4 {
                for (j, y) in y.into_iter().chain([rhs]).enumerate() {
                    sums.products[(i, j)] += z[i] * y;
                }
                sums.measured[i] += y[i] * y[i];
                sums.instrument[i] += z[i] * z[i];
            }
        }
        sums
    }

    #[test]
    fn noise_of_a_column_does_not_shrink_its_parameter() {
        let theta = [2.0, 0.5, -1.5, 0.1];
        let found = solve(&model(""), &[products(&theta, |_, _| ())]).unwrap();
        // Least squares would be 15 % low: the noise adds 0.3² to the mean square of 0.5.
        // Measured 0.06 to 0.09 %; the limit allows a factor of six.
        assert!((found[0] / theta[0] - 1.0).abs() < 0.005, "{found:?}");
        assert!((found[2] / theta[2] - 1.0).abs() < 0.005, "{found:?}");
        let known = model("fixed = { \"carriage.motor_viscous\" = 0.5 }");
        let found = solve(&known, &[products(&theta, |_, _| ())]).unwrap();
        assert!((found[1] - 0.5).abs() < 1e-12 && (found[2] / theta[2] - 1.0).abs() < 0.005);
    }

    #[test]
    fn uncorrelated_instruments_are_refused() {
        let theta = [2.0, 0.5, -1.5, 0.1];
        let unlike = products(&theta, |z, _| z[2] = z[1]);
        assert_eq!(
            solve(&model(""), &[unlike]),
            Err(Refusal::Uncorrelated(vec![2]))
        );
        let still = products(&theta, |z, y| (z[2], y[2]) = (0.0, 0.0));
        let refusal = solve(&model(""), &[still]).unwrap_err();
        assert_eq!(refusal, Refusal::Uncorrelated(vec![2]));
        let finding = refusal.finding(&model(""));
        assert_eq!(finding.severity, Severity::Info);
        assert_eq!(finding.parameters, ["carriage.motor_coulomb"]);
        let alike = products(&theta, |z, y| (z[2], y[2]) = (z[1], y[1]));
        assert_eq!(solve(&model(""), &[alike]), Err(Refusal::Singular));
    }
}
