//! Words of messages, whatever part of the window they come from.

use super::Entry;

pub const TABLE: &[Entry] = &[
    ["saved", "guardado", "guardado"],
    [
        "saved with its light",
        "guardado con su luz",
        "guardado com a sua luz",
    ],
    [
        "saved without light: what is solved is of an earlier state",
        "guardado sin luz: la resuelta es de un estado anterior",
        "guardado sem luz: a resolvida é de um estado anterior",
    ],
    [
        "this format does not keep all",
        "este formato no lo conserva todo",
        "este formato não conserva tudo",
    ],
    [
        "copy for recovery",
        "copia de recuperación",
        "cópia de recuperação",
    ],
    [
        "the file is gone; save to write it again",
        "el archivo ya no existe; guarde para volver a escribirlo",
        "o ficheiro já não existe; guarde para o escrever de novo",
    ],
    ["objects", "objetos", "objetos"],
    ["materials", "materiales", "materiais"],
    ["lights", "luces", "luzes"],
    [
        "there is no picture yet: draw one first",
        "aún no hay imagen: dibuje una antes",
        "ainda não há imagem: desenhe uma primeiro",
    ],
    [
        "nothing shines: add a light, or give a material emission",
        "nada brilla: añada una luz o dé emisión a un material",
        "nada brilha: acrescente uma luz ou dê emissão a um material",
    ],
    [
        "given up for another file",
        "abandonado por otro archivo",
        "abandonado por outro ficheiro",
    ],
    ["files", "archivos", "ficheiros"],
    ["light", "luz", "luz"],
    ["picture", "imagen", "imagem"],
];
