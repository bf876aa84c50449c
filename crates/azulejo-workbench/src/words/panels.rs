//! Texts of the panels and of what lies over the view.

use super::Translation;

pub const TABLE: &[Translation] = &[
    ["Scene tree", "Árbol de la escena", "Árvore da cena"],
    ["Properties", "Propiedades", "Propriedades"],
    [
        "Orientation cube",
        "Cubo de orientación",
        "Cubo de orientação",
    ],
    // The faces of the cube, on which there is little room.
    ["Back", "Atrás", "Trás"],
    ["Left", "Izda", "Esq"],
    ["Right", "Dcha", "Dir"],
    ["Top", "Arriba", "Cima"],
    ["Bottom", "Abajo", "Baixo"],
];
