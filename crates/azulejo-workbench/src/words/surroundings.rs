//! Texts of suns, skies and pictures of the surroundings, and the CIE types of skies.

use super::Translation;

pub const TABLE: &[Translation] = &[
    // In the menu, and labels of undo.
    ["Ambient light", "Luz ambiental", "Luz ambiente"],
    [
        "Picture of the surroundings…",
        "Imagen del entorno…",
        "Imagem dos arredores…",
    ],
    ["Studio", "Estudio", "Estúdio"],
    ["extract the sun", "extraer el sol", "extrair o sol"],
    ["add a studio", "añadir un estudio", "adicionar um estúdio"],
    [
        "Choose a picture of the surroundings",
        "Elija una imagen del entorno",
        "Escolha uma imagem dos arredores",
    ],
    // Suns.
    ["Azimuth", "Acimut", "Azimute"],
    ["Elevation", "Elevación", "Elevação"],
    ["Angular size", "Tamaño angular", "Tamanho angular"],
    [
        "As under a clear sky",
        "Como con cielo despejado",
        "Como com céu limpo",
    ],
    // Skies.
    [
        "From the sky, and from the ground below it.",
        "Del cielo, y del suelo bajo él.",
        "Do céu, e do chão por baixo dele.",
    ],
    ["Azimuth of the sun", "Acimut del sol", "Azimute do sol"],
    [
        "Elevation of the sun",
        "Elevación del sol",
        "Elevação do sol",
    ],
    ["Type of sky", "Tipo de cielo", "Tipo de céu"],
    [
        "On level ground",
        "En suelo horizontal",
        "Em chão horizontal",
    ],
    [
        "Ground reflectance",
        "Reflectancia del suelo",
        "Refletância do chão",
    ],
    ["Typical brightness", "Brillo típico", "Brilho típico"],
    ["Around the sun", "Alrededor del sol", "À volta do sol"],
    [
        "the same everywhere",
        "igual en todas partes",
        "igual em todo o lado",
    ],
    [
        "by weather (Perez)",
        "según el tiempo (Perez)",
        "conforme o tempo (Perez)",
    ],
    ["Weather", "Tiempo meteorológico", "Tempo meteorológico"],
    ["Direct normal", "Directa normal", "Direta normal"],
    [
        "Diffuse horizontal",
        "Difusa horizontal",
        "Difusa horizontal",
    ],
    ["Dew point", "Punto de rocío", "Ponto de orvalho"],
    ["Day of the year", "Día del año", "Dia do ano"],
    [
        "Make the sky of this weather",
        "Hacer el cielo de este tiempo",
        "Fazer o céu deste tempo",
    ],
    // Pictures.
    ["Rotation", "Rotación", "Rotação"],
    ["Other picture…", "Otra imagen…", "Outra imagem…"],
    ["Extract the sun", "Extraer el sol", "Extrair o sol"],
    // The types of the CIE standard general sky.
    ["overcast", "cubierto", "encoberto"],
    [
        "overcast, brighter toward the sun",
        "cubierto, más claro hacia el sol",
        "encoberto, mais claro para o sol",
    ],
    [
        "overcast, moderate gradation",
        "cubierto, gradación moderada",
        "encoberto, gradação moderada",
    ],
    [
        "overcast, moderate gradation, brighter toward the sun",
        "cubierto, gradación moderada, más claro hacia el sol",
        "encoberto, gradação moderada, mais claro para o sol",
    ],
    ["uniform", "uniforme", "uniforme"],
    [
        "partly cloudy, no gradation, brighter toward the sun",
        "parcialmente nublado, sin gradación, más claro hacia el sol",
        "parcialmente nublado, sem gradação, mais claro para o sol",
    ],
    [
        "partly cloudy, no gradation, bright around the sun",
        "parcialmente nublado, sin gradación, claro alrededor del sol",
        "parcialmente nublado, sem gradação, claro à volta do sol",
    ],
    [
        "partly cloudy, no gradation, solar corona",
        "parcialmente nublado, sin gradación, corona solar",
        "parcialmente nublado, sem gradação, coroa solar",
    ],
    [
        "partly cloudy, sun obscured",
        "parcialmente nublado, sol oculto",
        "parcialmente nublado, sol oculto pelas nuvens",
    ],
    [
        "partly cloudy, bright around the sun",
        "parcialmente nublado, claro alrededor del sol",
        "parcialmente nublado, claro à volta do sol",
    ],
    [
        "white-blue, solar corona",
        "azul blanquecino, corona solar",
        "azul esbranquiçado, coroa solar",
    ],
    ["clear", "despejado", "limpo"],
    [
        "clear, polluted air",
        "despejado, aire contaminado",
        "limpo, ar poluído",
    ],
    [
        "cloudless, turbid, broad solar corona",
        "sin nubes, turbio, corona solar ancha",
        "sem nuvens, turvo, coroa solar larga",
    ],
    [
        "white-blue, turbid, broad solar corona",
        "azul blanquecino, turbio, corona solar ancha",
        "azul esbranquiçado, turvo, coroa solar larga",
    ],
    ["overcast of 1955", "cubierto de 1955", "encoberto de 1955"],
];
