//! JSON values a few changes away from a given one.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};
use serde_json::{Map, Value, json};

/// One change: where, what, and with which value.
#[derive(Debug, Clone)]
pub struct Change {
    place: Index,
    entry: Index,
    operation: Operation,
    value: Value,
    name: String,
}

#[derive(Debug, Clone, Copy)]
enum Operation {
    /// Puts the value in place of what is there.
    Replace,
    /// Puts null in place of what is there.
    Erase,
    /// Adds a field with the name that is null.
    AddNull,
    /// Puts a copy of another part of the document in place of what is there.
    Move,
    /// Removes a field or an entry.
    Remove,
    /// Adds a field with the name and the value.
    Add,
    /// Gives a field the name.
    Rename,
    /// Repeats an entry.
    Repeat,
}

/// One to three changes. Fields that are added or renamed have one of these names.
pub fn changes(names: &'static [String]) -> impl Strategy<Value = Vec<Change>> {
    use Operation::{Add, AddNull, Erase, Move, Remove, Rename, Repeat, Replace};
    let operation =
        select(&[Replace, Replace, Erase, AddNull, Move, Remove, Add, Rename, Repeat][..]);
    let change = (any::<Index>(), any::<Index>(), operation, select(values()), select(names));
    let change = change.prop_map(|(place, entry, operation, value, name)| Change {
        place,
        entry,
        operation,
        value,
        name,
    });
    vec(change, 1..4)
}

fn values() -> Vec<Value> {
    let numbers = [json!(0), json!(3), json!(-3), json!(2.5), json!(-0.0), json!(1e300)];
    let large = [json!(u64::MAX), json!(u64::MAX as f64), json!(i64::MIN)];
    let texts = ["", "x", "safest", "drive", "in_place", "+x", "y", "arc", "no_route"];
    let rules = [json!("table 1, rule 3"), json!("table 01, rule 3"), json!("table 1, rule 70000")];
    let lists = [json!([]), json!([1]), json!([1, 2]), json!([1, 2.5, 3]), json!([1, 2, 3, 4])];
    let nested =
        [json!([[1, 2]]), json!([[1, 2, 3], [4, 5, 6]]), json!(["+x", "-z"]), json!([null])];
    let objects = [
        json!({}),
        json!({ "gap": 0.5 }),
        json!({ "gap": null, "gaps": [0.5, [0.5]] }),
        json!({ "gap": 1, "gaps": [1] }),
        json!({ "curve": 3 }),
        json!({ "box": { "min": [0, 0], "max": [1, 1] }, "polygon": null }),
        json!({ "min": [0, 0], "max": [1, 1] }),
        json!({ "period": 1, "count": null, "spacing": null }),
        json!({ "error": { "code": "internal", "message": "", "axis": "z", "setting": null } }),
    ];
    let others = [Value::Null, Value::Null, Value::Null, json!(true), json!(false)];
    let all = [&numbers[..], &large, &rules, &lists, &nested, &objects, &others].concat();
    all.into_iter().chain(texts.map(Value::from)).collect()
}

/// The value after the changes.
pub fn mutant(mut document: Value, changes: &[Change]) -> Value {
    for change in changes {
        let places = count(&document, false);
        let other = at(&mut document, change.entry.index(places), false).clone();
        // Coordinates are the most of a document: fields are added where there can be some.
        let objects = match change.operation {
            Operation::Add | Operation::AddNull | Operation::Rename => count(&document, true),
            _ => 0,
        };
        let place = match objects {
            0 => at(&mut document, change.place.index(places), false),
            _ => at(&mut document, change.place.index(objects), true),
        };
        match (change.operation, place) {
            (Operation::Replace, place) => *place = change.value.clone(),
            (Operation::Erase, place) => *place = Value::Null,
            (Operation::Move, place) => *place = other,
            (Operation::Add, Value::Object(fields)) => {
                fields.insert(change.name.clone(), change.value.clone());
            }
            (Operation::AddNull, Value::Object(fields)) => {
                fields.entry(change.name.clone()).or_insert(Value::Null);
            }
            (Operation::Remove, Value::Object(fields)) => {
                remove(fields, change.entry);
            }
            (Operation::Remove, Value::Array(list)) if !list.is_empty() => {
                list.remove(change.entry.index(list.len()));
            }
            (Operation::Rename, Value::Object(fields)) => {
                if let Some(value) = remove(fields, change.entry) {
                    fields.insert(change.name.clone(), value);
                }
            }
            (Operation::Repeat, Value::Array(list)) if !list.is_empty() => {
                list.push(list[change.entry.index(list.len())].clone());
            }
            _ => {}
        }
    }
    document
}

fn remove(fields: &mut Map<String, Value>, which: Index) -> Option<Value> {
    let names: Vec<_> = fields.keys().cloned().collect();
    (!names.is_empty()).then(|| fields.remove(which.get(&names)).expect("it is there"))
}

/// How many values there are in a document, itself included; with `objects` only objects count.
fn count(value: &Value, objects: bool) -> usize {
    let inside: usize = match value {
        Value::Array(list) => list.iter().map(|value| count(value, objects)).sum(),
        Value::Object(fields) => fields.values().map(|value| count(value, objects)).sum(),
        _ => 0,
    };
    inside + usize::from(!objects || value.is_object())
}

/// The value with this number among those that count, from 0.
fn at(value: &mut Value, number: usize, objects: bool) -> &mut Value {
    let mut left = number;
    if !objects || value.is_object() {
        match left.checked_sub(1) {
            None => return value,
            Some(inside) => left = inside,
        }
    }
    let inside: Vec<&mut Value> = match value {
        Value::Array(list) => list.iter_mut().collect(),
        Value::Object(fields) => fields.values_mut().collect(),
        _ => Vec::new(),
    };
    for value in inside {
        let here = count(value, objects);
        if left < here {
            return at(value, left, objects);
        }
        left -= here;
    }
    unreachable!("a document has as many values as were counted")
}
