//! Tests of the workbench from outside: windows without a screen, operated by role and label.

mod dialogs;
#[cfg(target_os = "linux")]
mod ending;
mod files;
mod inspector;
mod lightmap;
mod menus;
mod script;
mod snapshots;
mod surroundings;
mod tree;
mod viewport;
mod window;
