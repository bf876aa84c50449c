//! Texts of messages from all parts of the window.

use super::Translation;

pub const TABLE: &[Translation] = &[
    ["saved", "guardado", "guardado"],
    [
        "saved with its light",
        "guardado con su luz",
        "guardado com a sua luz",
    ],
    [
        "saved without light: the solution is for an earlier state",
        "guardado sin luz: la resuelta es de un estado anterior",
        "guardado sem luz: a resolvida é de um estado anterior",
    ],
    [
        "saved without the light stored in the file",
        "guardado sin la luz del archivo",
        "guardado sem a luz do ficheiro",
    ],
    [
        "this format does not store everything",
        "este formato no lo conserva todo",
        "este formato não conserva tudo",
    ],
    [
        "recovery copy",
        "copia de recuperación",
        "cópia de recuperação",
    ],
    [
        "the file no longer exists; save to write it again",
        "el archivo ya no existe; guarde para volver a escribirlo",
        "o ficheiro já não existe; guarde para o escrever de novo",
    ],
    ["objects", "objetos", "objetos"],
    ["materials", "materiales", "materiais"],
    ["lights", "luces", "luzes"],
    [
        "there is no image yet: render one first",
        "aún no hay imagen: dibuje una antes",
        "ainda não há imagem: desenhe uma primeiro",
    ],
    [
        "there is no light source: add a light or an emissive material",
        "nada brilla: añada una luz o dé emisión a un material",
        "nada brilha: acrescente uma luz ou dê emissão a um material",
    ],
    [
        "cancelled: another file was opened",
        "abandonado por otro archivo",
        "abandonado por outro ficheiro",
    ],
    ["files", "archivos", "ficheiros"],
    [
        "cannot render an image of this size in pixels",
        "no se puede dibujar una imagen así, en píxeles",
        "não se pode desenhar uma imagem assim, em pixels",
    ],
    [
        "the maximum number of probes is reached: remove some first",
        "no caben más sondas: quite antes alguna",
        "não cabem mais sondas: retire antes alguma",
    ],
    [
        "the model changed while the probes were measured: measure again",
        "el modelo cambió mientras se medían las sondas: mida otra vez",
        "o modelo mudou enquanto se mediam as sondas: meça outra vez",
    ],
    ["probes", "sondas", "sondas"],
    [
        "the name contains control characters, expected one line of text",
        "el nombre contiene caracteres de control; se esperaba una línea de texto",
        "o nome contém caracteres de controlo; esperava-se uma linha de texto",
    ],
    [
        "nothing is selected, select what to delete",
        "no hay nada seleccionado; seleccione lo que quiere borrar",
        "não há nada selecionado; selecione o que quer apagar",
    ],
    [
        "nothing is selected, select what to duplicate",
        "no hay nada seleccionado; seleccione lo que quiere duplicar",
        "não há nada selecionado; selecione o que quer duplicar",
    ],
    [
        "the transform is singular, expected factors other than 0",
        "la transformación aplana lo que mueve; se esperaban factores distintos de 0",
        "a transformação achata o que move; esperavam-se fatores diferentes de 0",
    ],
    [
        "the object's transform is singular, expected factors other than 0",
        "la transformación aplana el objeto; se esperaban factores distintos de 0",
        "a transformação achata o objeto; esperavam-se fatores diferentes de 0",
    ],
    [
        "the object exceeds the range of coordinates",
        "el objeto se sale del alcance de los números",
        "o objeto sai do alcance dos números",
    ],
    ["light", "luz", "luz"],
    ["rendering", "imagen", "imagem"],
];
