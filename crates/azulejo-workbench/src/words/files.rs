//! Texts of the file dialog.

use super::Translation;

pub const TABLE: &[Translation] = &[
    // Places.
    ["Places", "Lugares", "Lugares"],
    ["Home", "Carpeta personal", "Pasta pessoal"],
    ["Desktop", "Escritorio", "Ambiente de trabalho"],
    ["Documents", "Documentos", "Documentos"],
    ["Downloads", "Descargas", "Transferências"],
    ["Current folder", "Carpeta actual", "Pasta atual"],
    // The list.
    ["Files", "Archivos", "Ficheiros"],
    ["Modified", "Modificado", "Modificado"],
    [
        "This folder cannot be read:",
        "No se puede leer esta carpeta:",
        "Não é possível ler esta pasta:",
    ],
    [
        "Nothing to show here",
        "Aquí no hay nada que mostrar",
        "Aqui não há nada para mostrar",
    ],
    [
        "files selected",
        "archivos seleccionados",
        "ficheiros selecionados",
    ],
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
    [
        "The folder could not be created:",
        "No se ha podido crear la carpeta:",
        "Não foi possível criar a pasta:",
    ],
    ["Create", "Crear", "Criar"],
    // The dialog of the desktop.
    ["Models", "Modelos", "Modelos"],
    [
        "The file is being chosen in a window of the desktop.",
        "El archivo se está eligiendo en una ventana del escritorio.",
        "O ficheiro está a ser escolhido numa janela do ambiente de trabalho.",
    ],
    ["Choose it here", "Elegirlo aquí", "Escolhê-lo aqui"],
    [
        "File dialogs",
        "Diálogos de archivos",
        "Diálogos de ficheiros",
    ],
    ["the desktop's", "del escritorio", "do ambiente de trabalho"],
    ["azulejo's", "de azulejo", "do azulejo"],
    [
        "If the desktop has none, azulejo's are used.",
        "Si el escritorio no los tiene, se usan los de azulejo.",
        "Se o ambiente de trabalho não os tem, usam-se os do azulejo.",
    ],
];
