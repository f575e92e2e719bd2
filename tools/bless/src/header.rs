//! The C header of `libclearway`.

use integration_tests::root;

/// `services/clients/c/include/clearway.h`, from the crate's sources.
pub(crate) fn c() -> String {
    let package = root().join("services/clients/c");
    let config = cbindgen::Config::from_file(package.join("cbindgen.toml"));
    let config = config.unwrap_or_else(|error| panic!("cbindgen.toml: {error}"));
    let sources = ["values", "error", "reply", "client"];
    let builder = cbindgen::Builder::new().with_config(config);
    let builder = sources
        .iter()
        .fold(builder, |builder, name| builder.with_src(package.join(format!("src/{name}.rs"))));
    let bindings = builder.generate().unwrap_or_else(|error| panic!("the C header: {error}"));
    let mut header = Vec::new();
    bindings.write(&mut header);
    String::from_utf8(header).expect("the sources are UTF-8")
}
