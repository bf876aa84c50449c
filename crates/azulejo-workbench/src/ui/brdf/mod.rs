//! The editor of reflection models.
