//! Draws of the posterior of an identification.

use sprung::session::{ErrorKind, Parameters, SampleRequest, SessionError};
use sprung_base::progress::Unheard;
use sprung_method::estimate::Verdict;

use crate::support::session;

fn request(count: usize) -> SampleRequest {
    SampleRequest {
        count,
        ..SampleRequest::default()
    }
}

#[test]
fn robots_of_an_identification_have_its_errors() {
    let session = session(&[]);
    let identification = session.identify(&mut Unheard).unwrap().identification;
    let result = identification.results[0].clone();
    let parameters = Parameters::from(identification);
    let samples = session.sample(&parameters, &request(2000)).unwrap();
    assert_eq!(samples.theta.len(), 2000);
    assert_eq!(
        samples,
        session.sample(&parameters, &request(2000)).unwrap()
    );
    for (at, name) in samples.parameters.iter().enumerate() {
        let parameter = result.parameter(name).unwrap();
        let (Some(value), Some(error)) = (parameter.value, parameter.standard_error) else {
            continue;
        };
        if parameter.one_sided {
            continue;
        }
        let count = samples.theta.len() as f64;
        let mean = samples.theta.iter().map(|theta| theta[at]).sum::<f64>() / count;
        let squares = samples.theta.iter().map(|theta| (theta[at] - mean).powi(2));
        let spread = (squares.sum::<f64>() / count).sqrt();
        assert!(
            (mean - value).abs() < 0.2 * error,
            "{name}: {mean} {value} {error}"
        );
        assert!(
            (spread / error - 1.0).abs() < 0.1,
            "{name}: {spread} {error}"
        );
    }
    // Each robot can be given to a simulation.
    let values = samples.values(7).unwrap();
    assert!(session.model().theta(&values).is_ok());
    assert!(samples.values(2000).is_none());
}

#[test]
fn results_without_a_distribution_are_refused_with_a_remedy() {
    let session = session(&[]);
    let mut identification = session.identify(&mut Unheard).unwrap().identification;
    let text = |parameters: &Parameters, request: &SampleRequest| {
        let error = session.sample(parameters, request).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Usage);
        error.to_string()
    };
    let bare = Parameters {
        identification: None,
        ..Parameters::from(identification.clone())
    };
    assert!(text(&bare, &request(10)).contains("give the identification.json"));
    let good = Parameters::from(identification.clone());
    assert!(text(&good, &request(0)).contains("draw 1 to 100000"));
    let last = SampleRequest {
        set: 5,
        ..request(10)
    };
    assert!(text(&good, &last).contains("there is no result 5"));
    identification.results[0].verdict = Verdict::Unusable;
    let unusable = Parameters::from(identification);
    assert!(matches!(
        session.sample(&unusable, &request(10)),
        Err(SessionError::UnusableResult { .. })
    ));
    assert!(text(&unusable, &request(10)).contains("accept unusable results"));
    let accepted = SampleRequest {
        accept_unusable: true,
        ..request(10)
    };
    assert_eq!(
        session.sample(&unusable, &accepted).unwrap().theta.len(),
        10
    );
}
