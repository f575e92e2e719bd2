//! Pictures of scenes with their answers.

use integration_tests::scene;

use crate::planned::planned;

/// A scene with its answers.
pub(crate) fn picture(name: &str) -> String {
    let scene = scene(name);
    render::picture::draw(&scene, &planned(&scene))
}
