//! Texts of the viewport and the status bar.

use super::Translation;

pub const TABLE: &[Translation] = &[
    ["Viewport", "Vista 3D", "Vista 3D"],
    [
        "Click a surface to display its form factors.",
        "Haga clic en una superficie para ver sus factores de forma.",
        "Clique numa superfície para ver os seus fatores de forma.",
    ],
    [
        "Not solved yet: press F5.",
        "Aún sin resolver: pulse F5.",
        "Ainda por resolver: prima F5.",
    ],
    [
        "This light is outdated: press F5.",
        "La solución está desactualizada: pulse F5.",
        "A solução está desatualizada: prima F5.",
    ],
    ["Move", "Mover", "Mover"],
    ["Rotate", "Girar", "Rodar"],
    ["Resize", "Escalar", "Escalar"],
    ["face", "cara", "face"],
    ["Clear", "Borrar", "Limpar"],
    ["diffuse", "difusa", "difusa"],
];
