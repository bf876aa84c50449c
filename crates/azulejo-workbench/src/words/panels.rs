//! Texts of the panels and of what lies over the view.

use super::Translation;

pub const TABLE: &[Translation] = &[
    ["Scene tree", "Árbol de la escena", "Árvore da cena"],
    ["Properties", "Propiedades", "Propriedades"],
];
