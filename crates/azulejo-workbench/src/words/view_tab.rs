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
    ["Auto range", "Rango automático", "Intervalo automático"],
    ["From", "Desde", "De"],
    ["To", "Hasta", "Até"],
    ["Logarithmic", "Logarítmica", "Logarítmica"],
    [
        "Bands between isolines",
        "Bandas entre isolíneas",
        "Bandas entre isolinhas",
    ],
    ["Background", "Fondo", "Fundo"],
    ["From the scene", "De la escena", "Da cena"],
    ["Any colour", "Cualquier color", "Qualquer cor"],
    ["Image…", "Imagen…", "Imagem…"],
    ["Scaled", "Ajustada", "Ajustada"],
    ["Centred", "Centrada", "Centrada"],
    ["Tiled", "En mosaico", "Em mosaico"],
    [
        "Radiance of white",
        "Radiancia del blanco",
        "Radiância do branco",
    ],
    [
        "Match exposure",
        "Igualar a la exposición",
        "Igualar à exposição",
    ],
    [
        "Pictures are exposed like the surfaces: this is what the image shows as white.",
        "La imagen se expone como las superficies: esto es lo que muestra como blanco.",
        "A imagem é exposta como as superfícies: isto é o que mostra como branco.",
    ],
    [
        "Shows the image as bright as it is at the exposure of the view.",
        "Muestra la imagen tan clara como es con la exposición de la vista.",
        "Mostra a imagem tão clara como é com a exposição da vista.",
    ],
    [
        "Background in the scene",
        "Fondo en la escena",
        "Fundo na cena",
    ],
    [
        "Fog in the scene",
        "Niebla en la escena",
        "Nevoeiro na cena",
    ],
    [
        "Visibility range",
        "Alcance de visibilidad",
        "Alcance de visibilidade",
    ],
    [
        "Exponential, as in real fog",
        "Exponencial, como la niebla real",
        "Exponencial, como o nevoeiro real",
    ],
    [
        "Show in viewport",
        "Mostrar en la vista 3D",
        "Mostrar na vista 3D",
    ],
    // The 16 colours.
    ["Black", "Negro", "Preto"],
    ["Maroon", "Granate", "Grená"],
    ["Green", "Verde", "Verde"],
    ["Olive", "Verde oliva", "Verde-azeitona"],
    ["Navy", "Azul marino", "Azul-marinho"],
    ["Purple", "Púrpura", "Púrpura"],
    ["Teal", "Verde azulado", "Verde-azulado"],
    ["Silver", "Plateado", "Prateado"],
    ["Grey", "Gris", "Cinzento"],
    ["Red", "Rojo", "Vermelho"],
    ["Lime", "Lima", "Lima"],
    ["Yellow", "Amarillo", "Amarelo"],
    ["Blue", "Azul", "Azul"],
    ["Fuchsia", "Fucsia", "Fúcsia"],
    ["Aqua", "Cian", "Ciano"],
    ["White", "Blanco", "Branco"],
];
