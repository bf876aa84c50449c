//! Texts of the viewport and the status bar.

use super::Translation;

pub const TABLE: &[Translation] = &[
    ["Viewport", "Ventana del modelo", "Janela do modelo"],
    [
        "Click a surface to display its form factors.",
        "Haga clic en una superficie: sus factores de forma se verán como colores.",
        "Clique numa superfície: os seus fatores de forma passam a cores.",
    ],
    ["Move", "Mover", "Mover"],
    ["Rotate", "Girar", "Rodar"],
    ["Resize", "Cambiar el tamaño", "Mudar o tamanho"],
    ["face", "cara", "face"],
    ["Clear", "Vaciar", "Limpar"],
    ["matt", "mate", "mate"],
];
