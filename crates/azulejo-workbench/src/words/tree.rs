//! Texts of the tree of the scene.

use super::Translation;

pub const TABLE: &[Translation] = &[
    [
        "Only if it is unused.",
        "Solo si no se usa.",
        "Só se não estiver a ser utilizado.",
    ],
    ["Created here", "Creado aquí", "Criado aqui"],
    ["Lights", "Luces", "Luzes"],
    ["Cameras", "Cámaras", "Câmaras"],
    ["Materials", "Materiales", "Materiais"],
    ["Search", "Buscar", "Procurar"],
    [
        "Nothing has this in its name.",
        "Nada lleva esto en su nombre.",
        "Nada tem isto no nome.",
    ],
    [
        "Drop files here, or open them (Ctrl+O).",
        "Arrastre archivos aquí o ábralos (Ctrl+O).",
        "Arraste ficheiros para aqui ou abra-os (Ctrl+O).",
    ],
    [
        "Hide in the viewport only: it still casts and receives light",
        "Ocultar solo en la vista 3D: sigue emitiendo y recibiendo luz",
        "Ocultar apenas na vista 3D: continua a emitir e a receber luz",
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
        "Haga clic para seleccionar los objetos que la comparten",
        "Clique para selecionar os objetos que a partilham",
    ],
    ["Unnamed", "Sin nombre", "Sem nome"],
];
