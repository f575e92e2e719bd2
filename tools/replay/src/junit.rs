//! What `replay check` prints as JUnit XML: a suite for each file, a case for each request.

use comparison::check::{Case, Checked};
use comparison::compare::Outcome;
use quick_junit::{NonSuccessKind, Report, SerializeError, TestCase, TestCaseStatus, TestSuite};

use crate::report::missed;

/// All files as one JUnit report.
pub(crate) fn report(checked: &[Checked]) -> Result<String, SerializeError> {
    let mut report = Report::new("replay check");
    report.add_test_suites(checked.iter().map(suite));
    report.to_string()
}

fn suite(file: &Checked) -> TestSuite {
    let path = file.path.to_string_lossy();
    let contents = &file.contents;
    let mut suite = TestSuite::new(&*path);
    suite.add_test_cases(file.cases.iter().map(case));
    // What is wrong with the file itself stands beside the requests.
    let losses = contents.losses.iter().map(ToString::to_string);
    let error = contents.error.as_ref().map(ToString::to_string);
    for (index, trouble) in losses.chain(error).chain(missed(contents)).enumerate() {
        let mut status = TestCaseStatus::non_success(NonSuccessKind::Error);
        status.set_message(trouble);
        suite.add_test_case(TestCase::new(format!("recording {index}"), status));
    }
    for case in &mut suite.test_cases {
        case.set_classname(&*path);
    }
    suite
}

fn case(case: &Case) -> TestCase {
    let status = match &case.outcome {
        Outcome::Equal { .. } => TestCaseStatus::success(),
        Outcome::NotRepeatable => {
            let mut status = TestCaseStatus::skipped();
            status.set_message("depends on load");
            status
        }
        Outcome::Different(difference) => {
            let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
            status.set_message(difference.to_string());
            status
        }
    };
    TestCase::new(case.to_string(), status)
}
