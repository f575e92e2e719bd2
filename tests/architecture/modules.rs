//! Within a crate, too, modules and files depend on each other in one direction.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::code::{Arrow, Code};

/// The modules of `planning`, each knowing only those of the lines before its own.
const PLANNING: [&[&str]; 9] = [
    &["altered", "budget"],
    &["geometry"],
    &["motion"],
    &["free_space"],
    &["clearance"],
    &["disassembly", "driving"],
    &["route"],
    &["any_angle", "translation"],
    &["trajectory"],
];

#[test]
fn planning_depends_one_way() {
    let code = Code::of_services_and_tools();
    let planning = code.iter().find(|code| code.package == "planning").expect("it is ours");
    let rank = |module: &str| {
        let rank = PLANNING.iter().position(|modules| modules.contains(&module));
        rank.unwrap_or_else(|| panic!("planning::{module} has no place in the order"))
    };
    let mut wrong = Vec::new();
    let mut seen = BTreeSet::new();
    for arrow in planning.arrows() {
        let [from, to] = [&arrow.from, &arrow.to].map(|path| path.first());
        let (Some(from), Some(to)) = (from, to) else { continue };
        seen.extend([from.clone(), to.clone()]);
        if from != to && rank(to) >= rank(from) {
            let Arrow { file, line, name, .. } = &arrow;
            wrong.push(format!("{}:{line}: {from} -> {to} ({name})", file.display()));
        }
    }
    assert!(wrong.is_empty(), "arrows against the order of modules:\n{}", wrong.join("\n"));
    assert!(seen.len() >= 8, "only {seen:?} were seen to depend on each other");
}

#[test]
fn files_depend_one_way() {
    let (mut circles, mut count) = (Vec::new(), 0);
    for code in Code::of_services_and_tools() {
        let arrows = between_files(code.arrows());
        count += arrows.values().map(BTreeMap::len).sum::<usize>();
        if let Some(circle) = circle(&arrows) {
            circles.push(format!("{}:\n{}", code.package, circle.join("\n")));
        }
    }
    assert!(count > 150, "there are more arrows than these {count}");
    assert!(circles.is_empty(), "files in circles:\n{}", circles.join("\n"));
}

type Arrows = BTreeMap<PathBuf, BTreeMap<PathBuf, String>>;

/// For each file those it names, with the first place where it does. The file of a module
/// and those of the modules within it count as one thing: they may name each other.
fn between_files(arrows: Vec<Arrow>) -> Arrows {
    let mut files = Arrows::new();
    for Arrow { from, to, file, target, line, name } in arrows {
        if !from.starts_with(&to) && !to.starts_with(&from) && file != target {
            let place = format!("{}:{line} -> {} ({name})", file.display(), target.display());
            files.entry(file).or_default().entry(target).or_insert(place);
        }
    }
    files
}

/// The arrows of a circle, if there is one.
fn circle(arrows: &Arrows) -> Option<Vec<String>> {
    fn follow<'a>(
        arrows: &'a Arrows,
        file: &'a Path,
        way: &mut Vec<(&'a Path, &'a str)>,
        done: &mut BTreeSet<&'a Path>,
    ) -> Option<Vec<String>> {
        if let Some(begin) = way.iter().position(|(before, _)| *before == file) {
            return Some(way[begin..].iter().map(|(_, arrow)| arrow.to_string()).collect());
        }
        if done.contains(file) {
            return None;
        }
        for (next, arrow) in arrows.get(file).into_iter().flatten() {
            way.push((file, arrow));
            if let Some(circle) = follow(arrows, next, way, done) {
                return Some(circle);
            }
            way.pop();
        }
        done.insert(file);
        None
    }
    let mut done = BTreeSet::new();
    arrows.keys().find_map(|file| follow(arrows, file, &mut Vec::new(), &mut done))
}

#[test]
fn a_circle_is_found() {
    let arrows = |pairs: &[(&str, &str)]| {
        let mut arrows = Arrows::new();
        for (from, to) in pairs {
            let arrow = format!("{from} -> {to}");
            arrows.entry(PathBuf::from(from)).or_default().insert(PathBuf::from(to), arrow);
        }
        arrows
    };
    assert_eq!(circle(&arrows(&[("a", "b"), ("a", "c"), ("b", "c"), ("c", "d")])), None);
    let found = circle(&arrows(&[("a", "b"), ("b", "c"), ("c", "d"), ("d", "b")]));
    assert_eq!(found.unwrap(), ["b -> c", "c -> d", "d -> b"]);
}
