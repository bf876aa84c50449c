//! The command line from outside, and the rules of the house.

mod arrows;
mod bad_input;
mod commands;
mod exact;
mod files;
mod reading;
mod rtrace;
mod support;

#[cfg(unix)]
mod interrupt;
