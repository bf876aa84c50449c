//! Tests of the workbench from outside: windows without a screen, operated by role and label.

mod dialogs;
mod files;
mod inspector;
mod library;
mod lightmap;
mod menus;
mod script;
mod snapshots;
mod surroundings;
mod task_plane;
mod tree;
mod viewport;
mod window;
