//! The planner process: a service loop on the bus around [`answer::Workspace`].

pub mod service;
