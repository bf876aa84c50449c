//! Texts of the viewport and the status bar.

use super::Translation;

pub const TABLE: &[Translation] = &[
    ["Viewport", "Vista 3D", "Vista 3D"],
    [
        "Click a surface to display its form factors.",
        "Haga clic en una superficie para ver sus factores de forma.",
        "Clique numa superfície para ver os seus fatores de forma.",
    ],
    ["Move", "Mover", "Mover"],
    ["Rotate", "Girar", "Rodar"],
    ["Resize", "Escalar", "Escalar"],
    ["face", "cara", "face"],
    ["Clear", "Borrar", "Limpar"],
    ["diffuse", "difusa", "difusa"],
];
