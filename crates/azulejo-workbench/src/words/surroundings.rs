//! Texts of suns, skies and environment maps, and the CIE types of skies.

use super::Translation;

pub const TABLE: &[Translation] = &[
    // In the menu, and labels of undo.
    ["Ambient light", "Luz ambiental", "Luz ambiente"],
    ["Environment map…", "Mapa de entorno…", "Mapa de ambiente…"],
    ["Studio", "Estudio", "Estúdio"],
    ["extract the sun", "extraer el sol", "extrair o sol"],
    ["add a studio", "añadir un estudio", "adicionar um estúdio"],
    [
        "Choose an environment map",
        "Elija un mapa de entorno",
        "Escolha um mapa de ambiente",
    ],
    // Suns.
    ["Azimuth", "Acimut", "Azimute"],
    ["Elevation", "Elevación", "Elevação"],
    ["Angular size", "Tamaño angular", "Tamanho angular"],
    [
        "Use clear-sky irradiance",
        "Usar la irradiancia de cielo despejado",
        "Usar a irradiância de céu limpo",
    ],
    // Skies.
    [
        "From the sky, and from the ground below it.",
        "Del cielo y del suelo bajo él.",
        "Do céu e do solo por baixo dele.",
    ],
    ["Azimuth of the sun", "Acimut del sol", "Azimute do sol"],
    [
        "Elevation of the sun",
        "Elevación del sol",
        "Elevação do sol",
    ],
    ["Type of sky", "Tipo de cielo", "Tipo de céu"],
    [
        "Horizontal irradiance",
        "Irradiancia horizontal",
        "Irradiância horizontal",
    ],
    [
        "Ground reflectance",
        "Reflectancia del suelo",
        "Refletância do solo",
    ],
    [
        "Use typical irradiance",
        "Usar la irradiancia típica",
        "Usar a irradiância típica",
    ],
    ["Align with sun", "Alinear con el sol", "Alinhar com o sol"],
    ["Uniform", "Uniforme", "Uniforme"],
    [
        "From weather (Perez)",
        "Según datos meteorológicos (Perez)",
        "Segundo dados meteorológicos (Perez)",
    ],
    [
        "Weather data",
        "Datos meteorológicos",
        "Dados meteorológicos",
    ],
    [
        "Direct normal irradiance",
        "Irradiancia directa normal",
        "Irradiância direta normal",
    ],
    [
        "Diffuse horizontal irradiance",
        "Irradiancia difusa horizontal",
        "Irradiância difusa horizontal",
    ],
    ["Dew point", "Punto de rocío", "Ponto de orvalho"],
    ["Day of the year", "Día del año", "Dia do ano"],
    [
        "Create sky from weather",
        "Crear el cielo con estos datos",
        "Criar o céu com estes dados",
    ],
    // Environment maps.
    ["Rotation", "Rotación", "Rotação"],
    ["Change image…", "Cambiar imagen…", "Mudar a imagem…"],
    ["Extract the sun", "Extraer el sol", "Extrair o sol"],
    // The types of the CIE standard general sky.
    ["overcast", "cubierto", "encoberto"],
    [
        "overcast, brighter toward the sun",
        "cubierto, más luminoso hacia el sol",
        "encoberto, mais luminoso na direção do sol",
    ],
    [
        "overcast, moderate gradation",
        "cubierto, gradación moderada",
        "encoberto, gradação moderada",
    ],
    [
        "overcast, moderate gradation, brighter toward the sun",
        "cubierto, gradación moderada, más luminoso hacia el sol",
        "encoberto, gradação moderada, mais luminoso na direção do sol",
    ],
    ["uniform", "uniforme", "uniforme"],
    [
        "partly cloudy, no gradation, brighter toward the sun",
        "parcialmente nublado, sin gradación, más luminoso hacia el sol",
        "parcialmente nublado, sem gradação, mais luminoso na direção do sol",
    ],
    [
        "partly cloudy, no gradation, bright around the sun",
        "parcialmente nublado, sin gradación, luminoso alrededor del sol",
        "parcialmente nublado, sem gradação, luminoso em torno do sol",
    ],
    [
        "partly cloudy, no gradation, solar corona",
        "parcialmente nublado, sin gradación, corona solar",
        "parcialmente nublado, sem gradação, coroa solar",
    ],
    [
        "partly cloudy, sun obscured",
        "parcialmente nublado, sol oculto",
        "parcialmente nublado, sol encoberto",
    ],
    [
        "partly cloudy, bright around the sun",
        "parcialmente nublado, luminoso alrededor del sol",
        "parcialmente nublado, luminoso em torno do sol",
    ],
    [
        "white-blue, solar corona",
        "azul blanquecino, corona solar",
        "azul-esbranquiçado, coroa solar",
    ],
    ["clear", "despejado", "limpo"],
    [
        "clear, polluted air",
        "despejado, atmósfera contaminada",
        "limpo, atmosfera poluída",
    ],
    [
        "cloudless, turbid, broad solar corona",
        "sin nubes, turbio, corona solar amplia",
        "sem nuvens, turvo, coroa solar ampla",
    ],
    [
        "white-blue, turbid, broad solar corona",
        "azul blanquecino, turbio, corona solar amplia",
        "azul-esbranquiçado, turvo, coroa solar ampla",
    ],
    [
        "overcast of 1955",
        "cubierto (CIE 1955)",
        "encoberto (CIE 1955)",
    ],
];
