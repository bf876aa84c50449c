//! Texts of the View tab.

use super::Translation;

pub const TABLE: &[Translation] = &[
    [
        "Auto exposure",
        "Exposición automática",
        "Exposição automática",
    ],
    ["Exposure", "Exposición", "Exposição"],
    ["Colour map", "Mapa de colores", "Mapa de cores"],
    ["Auto range", "Rango automático", "Gama automática"],
    ["from", "de", "de"],
    ["to", "a", "a"],
    ["Logarithmic", "Logarítmico", "Logarítmico"],
    [
        "Bands between isolines",
        "Bandas entre isolíneas",
        "Bandas entre isolinhas",
    ],
    ["Background", "Fondo", "Fundo"],
    ["the scene's own", "el de la escena", "o da cena"],
    ["any colour", "cualquier color", "qualquer cor"],
    ["Image…", "Imagen…", "Imagem…"],
    ["scaled", "ajustada", "ajustada"],
    ["centred", "centrada", "centrada"],
    ["tiled", "en mosaico", "em mosaico"],
    [
        "saved with the scene",
        "guardado con la escena",
        "guardado com a cena",
    ],
    [
        "Fog in the scene",
        "Niebla en la escena",
        "Nevoeiro na cena",
    ],
    [
        "Nothing is visible beyond",
        "No se ve nada más allá de",
        "Não se vê nada para lá de",
    ],
    [
        "Exponential, as in real fog",
        "Exponencial, como la niebla real",
        "Exponencial, como o nevoeiro real",
    ],
    ["Show in viewport", "Mostrarla aquí", "Mostrá-lo aqui"],
    // The 16 colours.
    ["Black", "Negro", "Preto"],
    ["Maroon", "Granate", "Grená"],
    ["Green", "Verde", "Verde"],
    ["Olive", "Oliva", "Azeitona"],
    ["Navy", "Azul marino", "Azul-marinho"],
    ["Purple", "Púrpura", "Púrpura"],
    ["Teal", "Verde azulado", "Verde-azulado"],
    ["Silver", "Plata", "Prata"],
    ["Grey", "Gris", "Cinzento"],
    ["Red", "Rojo", "Vermelho"],
    ["Lime", "Lima", "Lima"],
    ["Yellow", "Amarillo", "Amarelo"],
    ["Blue", "Azul", "Azul"],
    ["Fuchsia", "Fucsia", "Fúcsia"],
    ["Aqua", "Aguamarina", "Água-marinha"],
    ["White", "Blanco", "Branco"],
];
