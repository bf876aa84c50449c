//! Texts of the start screen and of the cards over the model.

use super::Translation;

pub const TABLE: &[Translation] = &[
    [
        "Render this size",
        "Renderizar a este tamaño",
        "Renderizar a este tamanho",
    ],
    ["Width", "Anchura", "Largura"],
    // The start screen.
    ["Recent files", "Archivos recientes", "Ficheiros recentes"],
    [
        "or drop files here",
        "o suelte aquí los archivos",
        "ou largue aqui os ficheiros",
    ],
    [
        "From a model to an image",
        "Del modelo a la imagen",
        "Do modelo à imagem",
    ],
    [
        "a model of any common format",
        "un modelo en cualquier formato habitual",
        "um modelo em qualquer formato comum",
    ],
    [
        "adds lamps and a floor, or a lamp in a room",
        "añade lámparas y un suelo, o una lámpara en una habitación",
        "adiciona candeeiros e um chão, ou um candeeiro numa sala",
    ],
    [
        "computes the light for all viewpoints",
        "calcula la luz para todos los puntos de vista",
        "calcula a luz para todos os pontos de vista",
    ],
    [
        "traces a picture of the current view",
        "traza una imagen de la vista actual",
        "traça uma imagem da vista atual",
    ],
    ["Cornell box", "Caja de Cornell", "Caixa de Cornell"],
    [
        "Coloured walls that tint each other.",
        "Paredes de color que se tiñen unas a otras.",
        "Paredes de cor que se tingem umas às outras.",
    ],
    ["Mirror block", "Bloque de espejo", "Bloco de espelho"],
    [
        "A mirror that throws light into its surroundings.",
        "Un espejo que devuelve la luz a su entorno.",
        "Um espelho que devolve a luz ao que o rodeia.",
    ],
    ["3D text", "Texto en 3D", "Texto em 3D"],
    [
        "Solid letters with exact outlines, in a studio.",
        "Letras sólidas de contorno exacto, en un estudio.",
        "Letras sólidas de contorno exato, num estúdio.",
    ],
    // Progress.
    [
        "The solver is paused",
        "El cálculo está en pausa",
        "O cálculo está em pausa",
    ],
    ["Solving the light", "Calculando la luz", "A calcular a luz"],
    [
        "Baking the lightmap",
        "Calculando el mapa de luz",
        "A calcular o mapa de luz",
    ],
    ["Loading", "Abriendo", "A abrir"],
    ["error", "error", "erro"],
    ["about", "quedan unos", "faltam cerca de"],
    ["at most", "como mucho", "no máximo"],
    // The rendered image.
    ["Back to the model", "Volver al modelo", "Voltar ao modelo"],
    [
        "The image is not finished",
        "La imagen no está terminada",
        "A imagem não está terminada",
    ],
    [
        "Save as it is…",
        "Guardar tal como está…",
        "Guardar tal como está…",
    ],
    [
        "Keep rendering",
        "Seguir renderizando",
        "Continuar a renderizar",
    ],
    // What the model lacks.
    [
        "Nothing shines yet.",
        "Aún no hay ninguna fuente de luz.",
        "Ainda não há nenhuma fonte de luz.",
    ],
    [
        "The light is not solved yet.",
        "La luz aún no está calculada.",
        "A luz ainda não está calculada.",
    ],
    [
        "The light is less accurate than asked for: error",
        "La luz es menos exacta de lo pedido: error",
        "A luz é menos exata do que o pedido: erro",
    ],
    [
        "Solve without a time limit",
        "Resolver sin límite de tiempo",
        "Resolver sem limite de tempo",
    ],
    // Saved light.
    [
        "Saved with its light on a finer mesh:",
        "Guardado con su luz en una malla más fina:",
        "Guardado com a sua luz numa malha mais fina:",
    ],
    ["instead of", "en lugar de", "em vez de"],
    [
        "Keep the faces of the model",
        "Conservar las caras del modelo",
        "Manter as faces do modelo",
    ],
    [
        "Solves the light on the vertices of the model and saves again.",
        "Calcula la luz en los vértices del modelo y guarda de nuevo.",
        "Calcula a luz nos vértices do modelo e guarda de novo.",
    ],
    [
        "Stores the light on the vertices of the model. Without it, the light is stored on a finer mesh, which shows finer shadows.",
        "Guarda la luz en los vértices del modelo. Sin esta opción, se guarda en una malla más fina, que muestra sombras más finas.",
        "Guarda a luz nos vértices do modelo. Sem esta opção, é guardada numa malha mais fina, que mostra sombras mais finas.",
    ],
    // Failures.
    [
        "That did not work",
        "No se ha podido hacer",
        "Não foi possível",
    ],
    ["Copy", "Copiar", "Copiar"],
];
