//! A function that runs when the process ends.
//!
//! The test harness of stable Rust has no hook for its end, and it ends either by returning from
//! `main` or by `std::process::exit`. Both run what C's `atexit` registered; destructors of
//! statics do not exist in Rust, and those of thread-locals run with their threads.

use std::ffi::c_int;
use std::sync::OnceLock;

static HOOK: OnceLock<fn()> = OnceLock::new();

/// Calls `hook` when the process ends, other than by a signal or an abort.
///
/// Only the first hook of a process counts.
#[allow(unsafe_code, reason = "the standard library has no such hook")]
pub(crate) fn at_exit(hook: fn()) {
    extern "C" fn call() {
        if let Some(hook) = HOOK.get() {
            hook();
        }
    }
    // SAFETY: this is the declaration of the C standard, in the library that `std` itself links.
    // The function may be called from any thread and keeps only a pointer to code.
    unsafe extern "C" {
        safe fn atexit(hook: extern "C" fn()) -> c_int;
    }
    if HOOK.set(hook).is_ok() {
        // It fails only if memory is exhausted; then the report is missing.
        let _ = atexit(call);
    }
}
