//! second pass: scene to image
