//! Floor plans as free space, for `plan --map`.

pub mod map;
