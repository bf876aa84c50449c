//! Words of the windows over the window.

use super::Entry;

pub const TABLE: &[Entry] = &[
    [
        "Changes are not saved",
        "Hay cambios sin guardar",
        "Há mudanças por guardar",
    ],
    [
        "What you do next would lose them.",
        "Lo que va a hacer los perdería.",
        "O que vai fazer iria perdê-las.",
    ],
    [
        "Lose the changes",
        "Perder los cambios",
        "Perder as mudanças",
    ],
    ["Cancel", "Cancelar", "Cancelar"],
    [
        "The file has changed on the disk",
        "El archivo ha cambiado en el disco",
        "O ficheiro mudou no disco",
    ],
    [
        "Somebody wrote it since it was opened here.",
        "Alguien lo ha escrito desde que se abrió aquí.",
        "Alguém o escreveu desde que foi aberto aqui.",
    ],
    [
        "Keep mine and write over it",
        "Conservar lo mío y sobrescribirlo",
        "Manter o meu e escrever por cima",
    ],
    ["Read it again", "Volver a leerlo", "Ler de novo"],
    [
        "azulejo did not end well last time",
        "azulejo no terminó bien la última vez",
        "O azulejo não terminou bem da última vez",
    ],
    [
        "What was being worked on was kept:",
        "Se ha conservado lo que se estaba haciendo:",
        "Conservou-se o que se estava a fazer:",
    ],
    ["Recover", "Recuperar", "Recuperar"],
    ["Delete it", "Eliminarlo", "Eliminá-lo"],
    [
        "Ask me later",
        "Preguntar más tarde",
        "Perguntar mais tarde",
    ],
    ["days", "días", "dias"],
    // Letters.
    ["Solid letters", "Letras sólidas", "Letras sólidas"],
    ["Text", "Texto", "Texto"],
    [
        "Size of an em",
        "Tamaño de un cuadratín",
        "Tamanho de um quadratim",
    ],
    [
        "Depth, ems",
        "Profundidad, cuadratines",
        "Profundidade, quadratins",
    ],
    ["Typeface", "Tipo de letra", "Tipo de letra"],
    [
        "Add the letters",
        "Añadir las letras",
        "Adicionar as letras",
    ],
    // Files.
    ["Open", "Abrir", "Abrir"],
    ["New folder", "Carpeta nueva", "Nova pasta"],
    ["Look again", "Volver a mirar", "Ver de novo"],
    ["Folder above", "Carpeta superior", "Pasta acima"],
    ["File:", "Archivo:", "Ficheiro:"],
    [
        "Hidden ones too",
        "También los ocultos",
        "Também os ocultos",
    ],
    ["All files", "Todos los archivos", "Todos os ficheiros"],
    ["Open models", "Abrir modelos", "Abrir modelos"],
    ["Add models", "Añadir modelos", "Adicionar modelos"],
    ["Save as GRF", "Guardar como GRF", "Guardar como GRF"],
    ["Export a copy", "Exportar una copia", "Exportar uma cópia"],
    ["Save the picture", "Guardar la imagen", "Guardar a imagem"],
    [
        "A picture for the background",
        "Una imagen para el fondo",
        "Uma imagem para o fundo",
    ],
    ["A typeface", "Un tipo de letra", "Um tipo de letra"],
    [
        "Load a reflection model",
        "Cargar un modelo de reflexión",
        "Carregar um modelo de reflexão",
    ],
    [
        "Save the reflection model",
        "Guardar el modelo de reflexión",
        "Guardar o modelo de reflexão",
    ],
    [
        "There is a file of this name",
        "Ya hay un archivo con este nombre",
        "Já há um ficheiro com este nome",
    ],
    ["Replace it", "Sustituirlo", "Substituí-lo"],
    // Preferences.
    ["Preferences", "Preferencias", "Preferências"],
    ["Close", "Cerrar", "Fechar"],
    ["Language", "Idioma", "Língua"],
    ["Theme", "Tema", "Tema"],
    ["as the desktop", "como el escritorio", "como o ambiente"],
    ["bright", "claro", "claro"],
    ["dark", "oscuro", "escuro"],
    [
        "Size of texts",
        "Tamaño de los textos",
        "Tamanho dos textos",
    ],
    [
        "Copy for recovery after",
        "Copia de recuperación tras",
        "Cópia de recuperação após",
    ],
    ["0 s: never", "0 s: nunca", "0 s: nunca"],
    ["Threads", "Hilos", "Threads"],
    [
        "0: all but one, which the window keeps",
        "0: todos menos uno, que se queda la ventana",
        "0: todas menos uma, que fica para a janela",
    ],
    [
        "Paths per pixel of a picture",
        "Caminos por píxel de una imagen",
        "Caminhos por píxel de uma imagem",
    ],
    [
        "Rays of its final gather",
        "Rayos de su recogida final",
        "Raios da sua recolha final",
    ],
    [
        "Sharpens shadows and hides patches, slowly; 0 for none.",
        "Afina las sombras y oculta los parches, despacio; 0 para ninguno.",
        "Afina as sombras e esconde as parcelas, devagar; 0 para nenhum.",
    ],
    ["grey", "gris", "cinzento"],
    // Keys and mouse.
    ["Keys and mouse", "Teclas y ratón", "Teclas e rato"],
    ["Drag", "Arrastrar", "Arrastar"],
    [
        "turn around the middle of the view",
        "girar alrededor del centro de la vista",
        "rodar em torno do centro da vista",
    ],
    [
        "Right or middle drag, or Shift and drag",
        "Arrastrar con el botón derecho o central, o con Mayús",
        "Arrastar com o botão direito ou do meio, ou com Shift",
    ],
    ["shift the view", "desplazar la vista", "deslocar a vista"],
    [
        "Wheel, or Ctrl and drag",
        "Rueda, o arrastrar con Ctrl",
        "Roda, ou arrastar com Ctrl",
    ],
    [
        "nearer and further",
        "más cerca y más lejos",
        "mais perto e mais longe",
    ],
    ["Click", "Clic", "Clique"],
    [
        "select an object; with Ctrl, one more; with Alt, a face",
        "seleccionar un objeto; con Ctrl, uno más; con Alt, una cara",
        "selecionar um objeto; com Ctrl, mais um; com Alt, uma face",
    ],
    ["Double click", "Doble clic", "Duplo clique"],
    [
        "look at the object",
        "mirar el objeto",
        "olhar para o objeto",
    ],
    [
        "Drag while flying",
        "Arrastrar al volar",
        "Arrastar ao voar",
    ],
    ["look around", "mirar alrededor", "olhar em volta"],
    ["Shift + arrows", "Mayús + flechas", "Shift + setas"],
    [
        "turn around the model",
        "girar alrededor del modelo",
        "girar em volta do modelo",
    ],
    ["Ctrl + arrows", "Ctrl + flechas", "Ctrl + setas"],
    ["shift the view", "desplazar la vista", "deslocar a vista"],
    [
        "Enter, with the viewport in focus",
        "Intro, con el foco en la vista",
        "Enter, com o foco na vista",
    ],
    [
        "a click in the middle of it; with Alt, on a face",
        "un clic en el centro; con Alt, en una cara",
        "um clique no centro; com Alt, numa face",
    ],
    ["W A S D, R F", "W A S D, R F", "W A S D, R F"],
    [
        "fly forward, left, back, right, up, down",
        "volar adelante, izquierda, atrás, derecha, arriba, abajo",
        "voar em frente, esquerda, trás, direita, cima, baixo",
    ],
    ["Arrows", "Flechas", "Setas"],
    ["turn the head", "girar la cabeza", "virar a cabeça"],
    [
        "Drag an arrow of the selection",
        "Arrastrar una flecha de la selección",
        "Arrastar uma seta da seleção",
    ],
    [
        "move it along the axis",
        "moverla a lo largo del eje",
        "movê-la ao longo do eixo",
    ],
    [
        "Global illumination for the models people already have.",
        "Iluminación global para los modelos que la gente ya tiene.",
        "Iluminação global para os modelos que as pessoas já têm.",
    ],
];
