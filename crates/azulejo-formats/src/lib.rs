//! bytes to Scene and back: GRF, OBJ
