//! Texts of the material library, and of tables of light.

use super::Translation;

pub(super) const TABLE: &[Translation] = &[
    ["Library", "Biblioteca", "Biblioteca"],
    [
        "Gives the selected material this reflection; what it emits stays. Without a selected material, it is added to the scene.",
        "Da al material seleccionado esta reflexión; lo que emite se conserva. Sin material seleccionado, se añade a la escena.",
        "Dá ao material selecionado esta reflexão; o que emite mantém-se. Sem material selecionado, é adicionado à cena.",
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
];
