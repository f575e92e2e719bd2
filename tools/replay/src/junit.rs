//! Comparisons as JUnit XML: a suite for each file, a case for each request.

use std::path::Path;

use comparison::check::Checked;
use comparison::compare::{Comparison, Outcome};
use comparison::diff::Compared;
use comparison::exchanges::Contents;
use quick_junit::{NonSuccessKind, Report, SerializeError, TestCase, TestCaseStatus, TestSuite};

use crate::report::missed;

/// All files as one JUnit report.
pub(crate) fn report(checked: &[Checked]) -> Result<String, SerializeError> {
    let mut report = Report::new("replay check");
    report.add_test_suites(checked.iter().map(|file| {
        let path = file.path.to_string_lossy();
        let cases = file.cases.iter().map(|case| {
            let mut in_report = case_of(case.to_string(), &case.comparison);
            in_report.set_time(case.planning);
            in_report
        });
        suite(&path, cases.collect(), &[&file.contents])
    }));
    report.to_string()
}

/// Two recordings as a JUnit report with one suite.
pub(crate) fn diff_report(
    compared: &Compared,
    [a, b]: [&Path; 2],
) -> Result<String, SerializeError> {
    let mut report = Report::new("replay diff");
    let pairs = compared.pairs.iter().map(|pair| {
        let ([request, other], [key, other_key]) = (pair.indices, pair.keys);
        let name = format!("request {request} ({key}) and {other} ({other_key})");
        case_of(name, &pair.comparison)
    });
    let names = [a, b].map(|path| path.display().to_string());
    let alone = compared.alone.iter().zip(&names).flat_map(|(keys, name)| {
        keys.iter().map(move |key| {
            let message = format!("request {key} is only in {name}");
            TestCase::new(format!("request {key}"), status(NonSuccessKind::Failure, message))
        })
    });
    let [contents_a, contents_b] = &compared.contents;
    let cases = pairs.chain(alone).collect();
    let name = names.join(" and ");
    report.add_test_suite(suite(&name, cases, &[contents_a, contents_b]));
    report.to_string()
}

fn suite(name: &str, cases: Vec<TestCase>, contents: &[&Contents]) -> TestSuite {
    let mut suite = TestSuite::new(name);
    suite.add_test_cases(cases);
    // What is wrong with the file itself stands beside the requests.
    let troubles = contents.iter().flat_map(|contents| {
        let error = contents.error.as_ref().map(ToString::to_string);
        contents.incomplete().chain(error).chain(missed(contents))
    });
    for (index, trouble) in troubles.enumerate() {
        let status = status(NonSuccessKind::Error, trouble);
        suite.add_test_case(TestCase::new(format!("recording {index}"), status));
    }
    for case in &mut suite.test_cases {
        case.set_classname(name);
    }
    suite
}

fn status(kind: NonSuccessKind, message: String) -> TestCaseStatus {
    let mut status = TestCaseStatus::non_success(kind);
    status.set_message(message);
    status
}

fn case_of(name: String, comparison: &Comparison) -> TestCase {
    let status = match &comparison.outcome {
        Outcome::Equal { .. } => TestCaseStatus::success(),
        Outcome::NotRepeatable => {
            let mut status = TestCaseStatus::skipped();
            status.set_message("depends on load");
            status
        }
        Outcome::Different(difference) => {
            let mut status = status(NonSuccessKind::Failure, difference.to_string());
            let moved = comparison.answers.iter().filter(|answer| answer.verdict.is_regression());
            status.set_description(moved.map(|answer| format!("{answer}\n")).collect::<String>());
            status
        }
    };
    TestCase::new(name, status)
}
