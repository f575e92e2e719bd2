//! The soak, as long as a change can wait for it; `cargo run --release --bin soak -- --for 1h` goes on.

use std::process::Command;

#[test]
fn every_request_is_accounted_for_and_nothing_grows() {
    let soaked = Command::new(env!("CARGO_BIN_EXE_soak")).args(["--for", "30s"]).output().unwrap();
    let said = String::from_utf8_lossy(&soaked.stdout);
    println!("{said}");
    assert!(soaked.status.success(), "{}", String::from_utf8_lossy(&soaked.stderr));
    assert!(said.contains("requests are accounted for"));
}
