//! Floor plans in the form of the ROS map server.

use std::fs;

use tempfile::TempDir;

/// The first line of every YAML file here: nothing else is to be opened.
const IMAGE: &[u8] = b"image: map.pgm\n";

/// A map's YAML without its image's name, a zero byte, and its image.
pub fn floor_plan(bytes: &[u8]) {
    let zero = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    let (yaml, picture) = bytes.split_at(zero);
    if yaml.windows(5).any(|word| word == b"image") {
        return;
    }
    thread_local! {
        static FOLDER: TempDir = TempDir::new().expect("the system has room for files");
    }
    FOLDER.with(|folder| {
        let path = folder.path().join("map.yaml");
        fs::write(&path, [IMAGE, yaml].concat()).expect("the folder takes files");
        let picture = picture.get(1..).unwrap_or_default();
        fs::write(folder.path().join("map.pgm"), picture).expect("the folder takes files");
        match plan::map::read(&path) {
            Err(error) => assert!(!error.to_string().is_empty()),
            Ok(free_space) => {
                let bounds = free_space.bounds.expect("a map has bounds");
                let sides = bounds.min.as_slice().iter().zip(bounds.max.as_slice());
                for (min, max) in sides {
                    assert!(min.is_finite() && max.is_finite() && min < max, "{bounds:?}");
                }
            }
        }
    });
}
