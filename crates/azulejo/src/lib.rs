//! azulejo
