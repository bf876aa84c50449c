//! Readers and writers on whole files.

mod obj;
