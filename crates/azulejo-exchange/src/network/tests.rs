//! Balances, closed forms and errors.

use super::*;
