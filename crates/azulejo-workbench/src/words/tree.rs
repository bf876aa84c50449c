//! Texts of the tree of the scene.

use super::Translation;

pub const TABLE: &[Translation] = &[
    [
        "Only if it is unused.",
        "Solo si no hay nada hecho de él.",
        "Só se não houver nada feito dele.",
    ],
    ["created here", "hecho aquí", "feito aqui"],
    ["Lights", "Luces", "Luzes"],
    ["Cameras", "Cámaras", "Câmaras"],
    ["Materials", "Materiales", "Materiais"],
    ["Search", "Buscar", "Procurar"],
    [
        "Drop files here, or open them (Ctrl+O).",
        "Suelte aquí los archivos, o ábralos (Ctrl+O).",
        "Largue aqui os ficheiros, ou abra-os (Ctrl+O).",
    ],
    [
        "Hide in the viewport only: it still casts and receives light",
        "Ocultar: no se ve, pero da y recibe luz como antes",
        "Ocultar: não se vê, mas dá e recebe luz como antes",
    ],
    ["Show", "Mostrar", "Mostrar"],
    ["Definitions", "Definiciones", "Definições"],
    ["Shapes", "Formas", "Formas"],
    ["Outlines", "Contornos", "Contornos"],
    ["Textures", "Texturas", "Texturas"],
    ["curves", "curvas", "curvas"],
    ["not found", "no encontrada", "não encontrada"],
    [
        "Click to select the objects that share it",
        "Pulse para seleccionar los objetos que lo comparten",
        "Clique para selecionar os objetos que o partilham",
    ],
    ["without name", "sin nombre", "sem nome"],
];
