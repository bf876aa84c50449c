//! Texts of the material library, and of tables of light.

use super::Translation;

pub(super) const TABLE: &[Translation] = &[
    ["Library", "Biblioteca", "Biblioteca"],
    [
        "Gives the selection this material; other objects keep theirs, and what is emitted stays. Without a selection, it is added to the scene.",
        "Da este material a la selección; los demás objetos conservan el suyo, y lo que se emite se conserva. Sin selección, se añade a la escena.",
        "Dá este material à seleção; os outros objetos mantêm o seu, e o que é emitido mantém-se. Sem seleção, é adicionado à cena.",
    ],
    ["Add to the scene", "Añadir a la escena", "Adicionar à cena"],
    [
        "Adds it as a new material, which the selected objects get.",
        "Lo añade como material nuevo, que reciben los objetos seleccionados.",
        "Adiciona-o como material novo, que os objetos selecionados recebem.",
    ],
    ["White plaster", "Yeso blanco", "Estuque branco"],
    [
        "White wall paint",
        "Pintura blanca de pared",
        "Tinta branca de parede",
    ],
    ["Brick", "Ladrillo", "Tijolo"],
    ["Concrete", "Hormigón", "Betão"],
    ["Oak", "Roble", "Carvalho"],
    ["Glazed tile", "Azulejo", "Azulejo"],
    ["Porcelain", "Porcelana", "Porcelana"],
    ["Frosted plastic", "Plástico mate", "Plástico fosco"],
    ["Black rubber", "Goma negra", "Borracha preta"],
    ["Velvet", "Terciopelo", "Veludo"],
    [
        "Red car paint",
        "Pintura roja de coche",
        "Tinta vermelha de automóvel",
    ],
    ["Brushed steel", "Acero cepillado", "Aço escovado"],
    ["Polished chrome", "Cromo pulido", "Crómio polido"],
    ["Gold", "Oro", "Ouro"],
    ["Copper", "Cobre", "Cobre"],
    ["Aluminium", "Aluminio", "Alumínio"],
    ["Window glass", "Vidrio de ventana", "Vidro de janela"],
    ["Save as CSV…", "Guardar como CSV…", "Guardar como CSV…"],
    ["Save the probes", "Guardar las sondas", "Guardar as sondas"],
    [
        "All probes with their places, in the unit that is shown.",
        "Todas las sondas con sus posiciones, en la unidad mostrada.",
        "Todas as sondas com as suas posições, na unidade mostrada.",
    ],
    [
        "there are no probes yet: pin one first",
        "aún no hay sondas: coloque una primero",
        "ainda não há sondas: coloque uma primeiro",
    ],
    // The task plane.
    ["Task plane", "Plano de trabajo", "Plano de trabalho"],
    ["task plane", "plano de trabajo", "plano de trabalho"],
    [
        "Save the task plane",
        "Guardar el plano de trabajo",
        "Guardar o plano de trabalho",
    ],
    [
        "Solves the light again with the settings above, and gathers it at the points of the plane.",
        "Resuelve de nuevo la iluminación con los ajustes anteriores y la recoge en los puntos del plano.",
        "Resolve de novo a iluminação com as definições acima e recolhe-a nos pontos do plano.",
    ],
    ["Measure the plane", "Medir el plano", "Medir o plano"],
    ["Remove the plane", "Quitar el plano", "Remover o plano"],
    [
        "Above the lowest point of the model.",
        "Sobre el punto más bajo del modelo.",
        "Acima do ponto mais baixo do modelo.",
    ],
    ["Margin", "Margen", "Margem"],
    [
        "Distance of the plane from the edges of the model's footprint.",
        "Distancia del plano a los bordes de la planta del modelo.",
        "Distância do plano às margens da planta do modelo.",
    ],
    [
        "Numbers of points along x, and along the other horizontal axis.",
        "Números de puntos a lo largo de x y del otro eje horizontal.",
        "Números de pontos ao longo de x e do outro eixo horizontal.",
    ],
    ["Minimum", "Mínimo", "Mínimo"],
    ["Mean", "Media", "Média"],
    ["Maximum", "Máximo", "Máximo"],
    ["Uniformity U0", "Uniformidad U0", "Uniformidade U0"],
    [
        "Smallest irradiance relative to the mean.",
        "Irradiancia mínima respecto a la media.",
        "Irradiância mínima em relação à média.",
    ],
    [
        "Minimum to maximum",
        "Mínimo entre máximo",
        "Mínimo sobre máximo",
    ],
    [
        "Smallest irradiance relative to the largest.",
        "Irradiancia mínima respecto a la máxima.",
        "Irradiância mínima em relação à máxima.",
    ],
    [
        "These figures are of another height, margin or number of points.",
        "Estos valores son de otra altura, otro margen u otro número de puntos.",
        "Estes valores são de outra altura, outra margem ou outro número de pontos.",
    ],
    [
        "All points lie inside of solids.",
        "Todos los puntos están dentro de sólidos.",
        "Todos os pontos estão dentro de sólidos.",
    ],
    [
        "points inside of solids are left out",
        "puntos dentro de sólidos se omiten",
        "pontos dentro de sólidos são omitidos",
    ],
    [
        "the margin leaves nothing of the model's footprint",
        "el margen no deja nada de la planta del modelo",
        "a margem não deixa nada da planta do modelo",
    ],
    [
        "the model changed while the task plane was measured: measure again",
        "el modelo cambió mientras se medía el plano de trabajo: mida de nuevo",
        "o modelo mudou enquanto se media o plano de trabalho: meça de novo",
    ],
    [
        "the task plane has not been measured yet",
        "el plano de trabajo aún no se ha medido",
        "o plano de trabalho ainda não foi medido",
    ],
];
