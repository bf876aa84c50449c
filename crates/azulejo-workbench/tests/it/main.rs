//! Tests of the workbench from outside: windows without a screen, operated by role and label.

mod cards;
mod dialogs;
#[cfg(target_os = "linux")]
mod ending;
mod file_dialog;
mod files;
mod inspector;
mod lab;
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
