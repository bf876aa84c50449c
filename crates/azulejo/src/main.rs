//! azulejo
fn main() {}
