//! Texts of messages from all parts of the window.

use super::Translation;

pub const TABLE: &[Translation] = &[
    ["saved", "guardado", "guardado"],
    [
        "saved with its light",
        "guardado con la iluminación calculada",
        "guardado com a iluminação calculada",
    ],
    [
        "saved without light: the solution is for an earlier state",
        "guardado sin iluminación: la solución corresponde a un estado anterior",
        "guardado sem iluminação: a solução corresponde a um estado anterior",
    ],
    [
        "saved without the light stored in the file",
        "guardado sin la iluminación que contenía el archivo",
        "guardado sem a iluminação que o ficheiro continha",
    ],
    [
        "this format does not store everything",
        "este formato no conserva todos los datos",
        "este formato não conserva todos os dados",
    ],
    [
        "recovery copy",
        "copia de recuperación",
        "cópia de recuperação",
    ],
    [
        "the file no longer exists; save to write it again",
        "el archivo ya no existe; guarde para volver a crearlo",
        "o ficheiro já não existe; guarde para o criar de novo",
    ],
    ["objects", "objetos", "objetos"],
    ["materials", "materiales", "materiais"],
    ["lights", "luces", "luzes"],
    [
        "there is no image yet: render one first",
        "aún no hay ninguna imagen: renderice una antes",
        "ainda não há nenhuma imagem: renderize uma primeiro",
    ],
    [
        "there is no light source: add a light or an emissive material",
        "no hay ninguna fuente de luz: añada una luz o un material emisor",
        "não há nenhuma fonte de luz: adicione uma luz ou um material emissor",
    ],
    [
        "cancelled: another file was opened",
        "cancelado: se abrió otro archivo",
        "cancelado: foi aberto outro ficheiro",
    ],
    ["files", "archivos", "ficheiros"],
    [
        "cannot render an image of this size in pixels",
        "no se puede renderizar una imagen de este tamaño en píxeles",
        "não é possível renderizar uma imagem deste tamanho em píxeis",
    ],
    [
        "the maximum number of probes is reached: remove some first",
        "se ha alcanzado el número máximo de sondas: quite antes alguna",
        "foi atingido o número máximo de sondas: remova primeiro alguma",
    ],
    [
        "the model changed while the probes were measured: measure again",
        "el modelo cambió durante la medición de las sondas: repita la medición",
        "o modelo mudou durante a medição das sondas: repita a medição",
    ],
    ["probes", "sondas", "sondas"],
    [
        "the name contains control characters, expected one line of text",
        "el nombre contiene caracteres de control; se esperaba una línea de texto",
        "o nome contém caracteres de controlo; esperava-se uma linha de texto",
    ],
    [
        "nothing is selected, select what to delete",
        "no hay nada seleccionado; seleccione lo que desea eliminar",
        "não há nada selecionado; selecione o que pretende eliminar",
    ],
    [
        "nothing is selected, select what to duplicate",
        "no hay nada seleccionado; seleccione lo que desea duplicar",
        "não há nada selecionado; selecione o que pretende duplicar",
    ],
    [
        "the transform is singular, expected factors other than 0",
        "la transformación es singular; se esperaban factores distintos de 0",
        "a transformação é singular; esperavam-se fatores diferentes de 0",
    ],
    [
        "the object's transform is singular, expected factors other than 0",
        "la transformación del objeto es singular; se esperaban factores distintos de 0",
        "a transformação do objeto é singular; esperavam-se fatores diferentes de 0",
    ],
    [
        "the object exceeds the range of coordinates",
        "el objeto excede el intervalo de coordenadas",
        "o objeto excede o intervalo de coordenadas",
    ],
    ["light", "iluminación", "iluminação"],
    ["rendering", "renderizado", "renderização"],
];
