//! Texts of the file dialog.

use super::Translation;

pub const TABLE: &[Translation] = &[
    // What is wrong.
    [
        "There is no such file:",
        "No existe este archivo:",
        "Este ficheiro não existe:",
    ],
    [
        "There is no such folder:",
        "No existe esta carpeta:",
        "Esta pasta não existe:",
    ],
    // The dialog of the desktop.
    ["Models", "Modelos", "Modelos"],
    [
        "The file is being chosen in a window of the desktop.",
        "El archivo se está eligiendo en una ventana del escritorio.",
        "O ficheiro está a ser escolhido numa janela do ambiente de trabalho.",
    ],
    [
        "This is a folder:",
        "Esto es una carpeta:",
        "Isto é uma pasta:",
    ],
    ["Type a path…", "Escribir una ruta…", "Escrever um caminho…"],
];
