//! Texts of files that could not be read.

use super::Translation;

pub const TABLE: &[Translation] = &[
    [
        "the file does not exist",
        "el archivo no existe",
        "o ficheiro não existe",
    ],
    ["access is denied", "acceso denegado", "acesso negado"],
    [
        "this is a folder, expected a model",
        "es una carpeta; se esperaba un modelo",
        "é uma pasta; esperava-se um modelo",
    ],
    [
        "there is nothing in this file that can be shown",
        "en este archivo no hay nada que mostrar",
        "não há nada neste ficheiro para mostrar",
    ],
    ["line", "línea", "linha"],
    ["column", "columna", "coluna"],
    ["byte", "byte", "byte"],
    ["Found:", "Encontrado:", "Encontrado:"],
    ["Expected:", "Se esperaba:", "Esperava-se:"],
    ["a model in", "un modelo en", "um modelo em"],
    ["an empty file", "un archivo vacío", "um ficheiro vazio"],
    [
        "text in no known format",
        "texto en un formato desconocido",
        "texto num formato desconhecido",
    ],
    [
        "only white space",
        "solo espacios en blanco",
        "apenas espaços em branco",
    ],
    [
        "the end of the file",
        "el fin del archivo",
        "o fim do ficheiro",
    ],
    ["a PNG picture", "una imagen PNG", "uma imagem PNG"],
    ["a PDF document", "un documento PDF", "um documento PDF"],
];
