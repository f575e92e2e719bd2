//! The whole path once, and the pictures that came of it.

use integration_tests::TestDomain;

#[test]
fn two_demos_run_at_once() {
    let test = TestDomain::new();
    let demos = ["one", "two"].map(|folder| test.start("demo", &["-o", folder], None));
    for (demo, folder) in demos.into_iter().zip(["one", "two"]) {
        let ended = demo.wait();
        assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
        // Section 4 both ways at three gaps, two corridors at four.
        for (task, gaps) in [("disassemble", 3), ("assemble", 3), ("drive A", 4), ("drive B", 4)] {
            let rows = ended
                .stdout
                .lines()
                .filter(|line| line.trim_start().starts_with(&format!("{task}  ")));
            assert_eq!(rows.count(), gaps, "{}", ended.stdout);
        }
        assert!(ended.stdout.contains("154 requests, 154 equal"), "{}", ended.stdout);
        for file in ["demo.mcap", "disassemble.svg", "assemble.svg", "drive-a.svg", "drive-b.svg"] {
            assert!(test.path(folder).join(file).exists(), "{folder} has no {file}");
        }
    }
    // What is there is not written over.
    let again = test.run("demo", &["-o", "one"]);
    assert_eq!(again.code, Some(1));
    assert!(again.stderr.contains("already contains a demo"), "{}", again.stderr);
}
