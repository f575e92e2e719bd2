//! Driving among walls at any angle: against constructions that share no code with it.

mod ladder;
mod scene;
mod taut;
