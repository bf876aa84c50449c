//! Pictures of a scene by the graphics card, or by a driver that does without one.
