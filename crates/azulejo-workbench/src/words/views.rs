//! Texts of units of light, sections, comparisons and values in the viewport.

use super::Translation;

pub const TABLE: &[Translation] = &[
    ["as in the file", "como en el archivo", "como no ficheiro"],
    ["Show light in", "Mostrar la luz en", "Mostrar a luz em"],
    [
        "Converted by a luminous efficacy of",
        "Convertida con una eficacia luminosa de",
        "Convertida com uma eficácia luminosa de",
    ],
    [
        "Numbers of the file are in",
        "Los números del archivo están en",
        "Os números do ficheiro estão em",
    ],
    [
        "Hide back faces",
        "Ocultar las caras traseras",
        "Ocultar as faces traseiras",
    ],
    ["Section plane", "Plano de sección", "Plano de corte"],
    ["Other side", "El otro lado", "O outro lado"],
    [
        "Cut away the ceiling",
        "Quitar el techo de la vista",
        "Retirar o teto da vista",
    ],
    ["Compare", "Comparar", "Comparar"],
    [
        "Divider between both pictures",
        "Divisor entre ambas imágenes",
        "Divisor entre ambas as imagens",
    ],
    [
        "Keep proportions",
        "Mantener las proporciones",
        "Manter as proporções",
    ],
    ["Flux", "Flujo", "Fluxo"],
    [
        "Colour temperature",
        "Temperatura de color",
        "Temperatura de cor",
    ],
    [
        "Far from the colour of any glowing body.",
        "Lejos del color de cualquier cuerpo incandescente.",
        "Longe da cor de qualquer corpo incandescente.",
    ],
];
