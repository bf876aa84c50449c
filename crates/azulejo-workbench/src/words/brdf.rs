//! Words of the editor of reflection models.

use super::Entry;

pub const TABLE: &[Entry] = &[
    [
        "reciprocal",
        "recíproco",
        "recíproco",
    ],
    [
        "not reciprocal",
        "no recíproco",
        "não recíproco",
    ],
    [
        "Light and eye exchanged, for many pairs of directions: f differs by at most",
        "Intercambiando luz y ojo, en muchos pares de direcciones: f cambia como mucho un",
        "Trocando luz e olho, em muitos pares de direções: f muda no máximo",
    ],
    [
        "energy at most",
        "energía máxima",
        "energia máxima",
    ],
    [
        "creates energy:",
        "crea energía:",
        "cria energia:",
    ],
    [
        "at",
        "a",
        "a",
    ],
    [
        "Share of the light that is reflected, by its angle:",
        "Fracción de la luz que se refleja, según su ángulo:",
        "Fração da luz que é refletida, segundo o seu ângulo:",
    ],
    [
        "Lobe as a body; drag or use the arrow keys to turn it",
        "Lóbulo como cuerpo; arrastre o use las flechas para girarlo",
        "Lóbulo como corpo; arraste ou use as setas para o rodar",
    ],
    [
        "Matt",
        "Mates",
        "Mates",
    ],
    [
        "Smooth",
        "Lisos",
        "Lisos",
    ],
    [
        "Cosine lobes",
        "Lóbulos de coseno",
        "Lóbulos de cosseno",
    ],
    [
        "Microfacets",
        "Microfacetas",
        "Microfacetas",
    ],
    [
        "Waves and cylinders",
        "Ondas y cilindros",
        "Ondas e cilindros",
    ],
    [
        "By impression",
        "Por impresión",
        "Por impressão",
    ],
    [
        "nothing",
        "nada",
        "nada",
    ],
    [
        "Both are shown in the same plots; the second is dashed.",
        "Ambos se muestran en los mismos gráficos; el segundo, a trazos.",
        "Ambos aparecem nos mesmos gráficos; o segundo, a tracejado.",
    ],
    [
        "Compare with",
        "Comparar con",
        "Comparar com",
    ],
    [
        "Materials of the scene",
        "Materiales de la escena",
        "Materiais da cena",
    ],
    [
        "without name",
        "sin nombre",
        "sem nome",
    ],
    [
        "Share of light that is reflected, against its angle",
        "Fracción de luz que se refleja, según su ángulo",
        "Fração de luz que é refletida, segundo o seu ângulo",
    ],
    [
        "The last possible model is kept.",
        "Se mantiene el último modelo posible.",
        "Mantém-se o último modelo possível.",
    ],
    [
        "This model reflects more than arrives: of even light",
        "Este modelo refleja más de lo que llega: de una luz uniforme, el",
        "Este modelo reflete mais do que chega: de uma luz uniforme,",
    ],
    [
        "scaled down to",
        "reducido al",
        "reduzido a",
    ],
    [
        "is",
        "es",
        "é",
    ],
    [
        "it must be between",
        "debe estar entre",
        "deve estar entre",
    ],
    [
        "and",
        "y",
        "e",
    ],
    [
        "Missing:",
        "Falta:",
        "Falta:",
    ],
    [
        "more than 1 would reflect more than arrives.",
        "más de 1 reflejaría más de lo que llega.",
        "mais de 1 refletiria mais do que chega.",
    ],
    [
        "Model file",
        "Archivo",
        "Ficheiro",
    ],
    [
        "Load…",
        "Cargar…",
        "Carregar…",
    ],
    [
        "Save…",
        "Guardar…",
        "Guardar…",
    ],
    [
        "Name",
        "Nombre",
        "Nome",
    ],
    [
        "Add a model",
        "Añadir un modelo",
        "Juntar um modelo",
    ],
    [
        "A weighted sum of models: the weights add up to at most 1.",
        "Una suma ponderada de modelos: los pesos suman como mucho 1.",
        "Uma soma ponderada de modelos: os pesos somam no máximo 1.",
    ],
    [
        "Share of this model in the sum.",
        "Parte de este modelo en la suma.",
        "Parte deste modelo na soma.",
    ],
    [
        "Weight",
        "Peso",
        "Peso",
    ],
    [
        "Remove model",
        "Quitar el modelo",
        "Retirar o modelo",
    ],
    [
        "Model",
        "Modelo",
        "Modelo",
    ],
    [
        "Examples",
        "Ejemplos",
        "Exemplos",
    ],
    [
        "File",
        "Archivo",
        "Ficheiro",
    ],
    [
        "The file could not be found: the surface reflects nothing.",
        "No se encontró el archivo: la superficie no refleja nada.",
        "O ficheiro não foi encontrado: a superfície não reflete nada.",
    ],
    [
        "Change a copy",
        "Modificar una copia",
        "Alterar uma cópia",
    ],
    [
        "Measured",
        "Medido",
        "Medido",
    ],
    [
        "angles",
        "ángulos",
        "ângulos",
    ],
    [
        "the same around the normal",
        "igual alrededor de la normal",
        "igual em torno da normal",
    ],
    [
        "different around the normal",
        "distinto alrededor de la normal",
        "diferente em torno da normal",
    ],
    [
        "Given; otherwise the model has its own value.",
        "Dado; si no, el modelo usa su propio valor.",
        "Dado; senão, o modelo usa o seu próprio valor.",
    ],
    [
        "as the model has it",
        "el del modelo",
        "o do modelo",
    ],
    [
        "One number for each of red, green and blue.",
        "Un número para cada uno de rojo, verde y azul.",
        "Um número para cada um de vermelho, verde e azul.",
    ],
    [
        "How much the smooth boundary of a facet mirrors, by the angle.",
        "Cuánto refleja el borde liso de una faceta, según el ángulo.",
        "Quanto espelha a fronteira lisa de uma faceta, segundo o ângulo.",
    ],
    [
        "Fresnel",
        "Fresnel",
        "Fresnel",
    ],
    [
        "Numbers of a metal",
        "Números de un metal",
        "Números de um metal",
    ],
    [
        "all light is reflected",
        "se refleja toda la luz",
        "toda a luz é refletida",
    ],
    [
        "a metal by name",
        "un metal por su nombre",
        "um metal pelo nome",
    ],
    [
        "indices of refraction",
        "índices de refracción",
        "índices de refração",
    ],
    [
        "Schlick, from normal incidence",
        "Schlick, desde la normal",
        "Schlick, a partir da normal",
    ],
    [
        "the same at all angles",
        "igual en todos los ángulos",
        "igual em todos os ângulos",
    ],
    [
        "Lobes in the plane of incidence",
        "Lóbulos en el plano de incidencia",
        "Lóbulos no plano de incidência",
    ],
    [
        "Reflected share against the angle",
        "Fracción reflejada según el ángulo",
        "Fração refletida segundo o ângulo",
    ],
    [
        "Being computed; until then the last result is shown.",
        "Calculando; mientras, se muestra el último resultado.",
        "A calcular; entretanto, mostra-se o último resultado.",
    ],
    [
        "Largest difference:",
        "Mayor diferencia:",
        "Maior diferença:",
    ],
    [
        "reflected share",
        "fracción reflejada",
        "fração refletida",
    ],
    [
        "1/sr",
        "1/sr",
        "1/sr",
    ],
    [
        "linear",
        "lineal",
        "linear",
    ],
    [
        "logarithmic",
        "logarítmica",
        "logarítmica",
    ],
    [
        "Sphere of the material under the light of the scene",
        "Esfera del material bajo la luz de la escena",
        "Esfera do material sob a luz da cena",
    ],
    [
        "paths per pixel",
        "caminos por píxel",
        "caminhos por píxel",
    ],
    [
        "Matt surface",
        "Superficie mate",
        "Superfície mate",
    ],
    [
        "Mirror",
        "Espejo",
        "Espelho",
    ],
    [
        "Matt and mirror",
        "Mate y espejo",
        "Mate e espelho",
    ],
    [
        "Glass",
        "Vidrio",
        "Vidro",
    ],
    [
        "Reflection model",
        "Modelo de reflexión",
        "Modelo de reflexão",
    ],
    [
        "Surface",
        "Superficie",
        "Superfície",
    ],
    [
        "What happens to light that arrives.",
        "Qué ocurre con la luz que llega.",
        "O que acontece à luz que chega.",
    ],
    [
        "Share of light that is reflected in all directions alike; with what is mirrored at most 1.",
        "Fracción de luz que se refleja por igual en todas direcciones; con la especular, como mucho 1.",
        "Fração de luz que é refletida por igual em todas as direções; com a espelhada, no máximo 1.",
    ],
    [
        "Diffuse",
        "Difusa",
        "Difusa",
    ],
    [
        "Share of light that is mirrored exactly; with what is diffuse at most 1.",
        "Fracción de luz que se refleja como en un espejo; con la difusa, como mucho 1.",
        "Fração de luz que é espelhada exatamente; com a difusa, no máximo 1.",
    ],
    [
        "Mirrored",
        "Especular",
        "Espelhada",
    ],
    [
        "Index of refraction of the body relative to what is outside: water 1.33, glass 1.5, diamond 2.4.",
        "Índice de refracción del cuerpo respecto al exterior: agua 1,33, vidrio 1,5, diamante 2,4.",
        "Índice de refração do corpo em relação ao exterior: água 1,33, vidro 1,5, diamante 2,4.",
    ],
    [
        "Refraction",
        "Refracción",
        "Refração",
    ],
    [
        "Scales the light that passes; white for clear glass.",
        "Escala la luz que pasa; blanco para vidrio claro.",
        "Escala a luz que passa; branco para vidro claro.",
    ],
    [
        "Passes",
        "Transmitida",
        "Transmitida",
    ],
    [
        "Scales the light that is mirrored; white by Fresnel's equations.",
        "Escala la luz que se refleja; blanco según las ecuaciones de Fresnel.",
        "Escala a luz que é espelhada; branco segundo as equações de Fresnel.",
    ],
    [
        "A whole pane, both surfaces of it in one face.",
        "Una lámina entera, con sus dos superficies en una cara.",
        "Uma lâmina inteira, com as duas superfícies numa só face.",
    ],
    [
        "thin pane",
        "lámina fina",
        "lâmina fina",
    ],
    [
        "Radiance of the front, of the channel that is brightest; 0 for no light.",
        "Radiancia del anverso, del canal más brillante; 0 si no emite luz.",
        "Radiância da frente, do canal mais brilhante; 0 se não emite luz.",
    ],
    [
        "Emission",
        "Emisión",
        "Emissão",
    ],
    [
        "from both sides",
        "por ambos lados",
        "pelos dois lados",
    ],
    [
        "Colour of the light that is emitted.",
        "Color de la luz que se emite.",
        "Cor da luz que é emitida.",
    ],
    [
        "Its colour",
        "Su color",
        "A sua cor",
    ],
    [
        "Incidence",
        "Incidencia",
        "Incidência",
    ],
    [
        "Angle between the light and the normal.",
        "Ángulo entre la luz y la normal.",
        "Ângulo entre a luz e a normal.",
    ],
    [
        "Azimuth",
        "Acimut",
        "Azimute",
    ],
    [
        "Angle between the plane of incidence and the tangent.",
        "Ángulo entre el plano de incidencia y la tangente.",
        "Ângulo entre o plano de incidência e a tangente.",
    ],
    [
        "Radius",
        "Radio",
        "Raio",
    ],
    [
        "What the distance from the origin means.",
        "Qué significa la distancia al origen.",
        "O que significa a distância à origem.",
    ],
    [
        "Scale",
        "Escala",
        "Escala",
    ],
    [
        "more angles",
        "más ángulos",
        "mais ângulos",
    ],
    [
        "diffuse reflectance",
        "reflectancia difusa",
        "refletância difusa",
    ],
    [
        "reflectance where k = 1",
        "reflectancia donde k = 1",
        "refletância onde k = 1",
    ],
    [
        "reflectance along the normal",
        "reflectancia en la normal",
        "refletância na normal",
    ],
    [
        "reflectance of the lobe",
        "reflectancia del lóbulo",
        "refletância do lóbulo",
    ],
    [
        "reflectance of the layer below at grazing angles; 0.31 of it along the normal",
        "reflectancia de la capa inferior en ángulos rasantes; 0,31 de ella en la normal",
        "refletância da camada inferior em ângulos rasantes; 0,31 dela na normal",
    ],
    [
        "reflectance of the material",
        "reflectancia del material",
        "refletância do material",
    ],
    [
        "reflectance at all angles",
        "reflectancia en todos los ángulos",
        "refletância em todos os ângulos",
    ],
    [
        "reflectance at normal incidence",
        "reflectancia en incidencia normal",
        "refletância em incidência normal",
    ],
    [
        "roughness",
        "rugosidad",
        "rugosidade",
    ],
    [
        "roughness along the tangent",
        "rugosidad a lo largo de la tangente",
        "rugosidade ao longo da tangente",
    ],
    [
        "roughness along the bitangent; `ax` where it is not given",
        "rugosidad a lo largo de la bitangente; `ax` si no se da",
        "rugosidade ao longo da bitangente; `ax` se não for dada",
    ],
    [
        "the same again, if it is given",
        "lo mismo otra vez, si se da",
        "o mesmo outra vez, se for dado",
    ],
    [
        "roughness: 0 is a mirror, 1 is matt",
        "rugosidad: 0 es un espejo, 1 es mate",
        "rugosidade: 0 é um espelho, 1 é mate",
    ],
    [
        "roughness; 0 is Lambert's",
        "rugosidad; 0 es la de Lambert",
        "rugosidade; 0 é a de Lambert",
    ],
    [
        "colour of the base or of the metal",
        "color de la base o del metal",
        "cor da base ou do metal",
    ],
    [
        "colour of the surface",
        "color de la superficie",
        "cor da superfície",
    ],
    [
        "scale of the first surface",
        "escala de la primera superficie",
        "escala da primeira superfície",
    ],
    [
        "1/c is the angle where e times fewer facets lie",
        "1/c es el ángulo en que hay e veces menos facetas",
        "1/c é o ângulo em que há e vezes menos facetas",
    ],
    [
        "distance between the cylinders' axes",
        "distancia entre los ejes de los cilindros",
        "distância entre os eixos dos cilindros",
    ],
    [
        "depth of the axes below the floor",
        "profundidad de los ejes bajo el suelo",
        "profundidade dos eixos sob o chão",
    ],
    [
        "index of refraction, real part",
        "índice de refracción, parte real",
        "índice de refração, parte real",
    ],
    [
        "index of refraction, imaginary part",
        "índice de refracción, parte imaginaria",
        "índice de refração, parte imaginária",
    ],
    [
        "darkening of the rim; 1 is Lambert's",
        "oscurecimiento del borde; 1 es el de Lambert",
        "escurecimento da borda; 1 é o de Lambert",
    ],
    [
        "wavelength of each channel; (0.61, 0.55, 0.465) where it is not given",
        "longitud de onda de cada canal; (0,61, 0,55, 0,465) si no se da",
        "comprimento de onda de cada canal; (0,61, 0,55, 0,465) se não for dado",
    ],
    [
        "root mean square slope of the facets, times √2",
        "pendiente cuadrática media de las facetas, por √2",
        "declive quadrático médio das facetas, vezes √2",
    ],
    [
        "a metal of the table, by name",
        "un metal de la tabla, por su nombre",
        "um metal da tabela, pelo nome",
    ],
    [
        "0 is a dielectric, 1 a metal",
        "0 es un dieléctrico, 1 un metal",
        "0 é um dielétrico, 1 um metal",
    ],
    [
        "1 colours the highlight, and darkens what is smooth",
        "1 colorea el brillo y oscurece lo liso",
        "1 dá cor ao brilho e escurece o que é liso",
    ],
    [
        "exponent: the higher, the narrower",
        "exponente: cuanto mayor, más estrecho",
        "expoente: quanto maior, mais estreito",
    ],
    [
        "exponent along the tangent",
        "exponente a lo largo de la tangente",
        "expoente ao longo da tangente",
    ],
    [
        "exponent along the bitangent",
        "exponente a lo largo de la bitangente",
        "expoente ao longo da bitangente",
    ],
    [
        "how fast shadows grow with θh",
        "con qué rapidez crecen las sombras con θh",
        "com que rapidez crescem as sombras com θh",
    ],
    [
        "how fast shadows fade with β",
        "con qué rapidez se desvanecen las sombras con β",
        "com que rapidez se desvanecem as sombras com β",
    ],
    [
        "isotropy: 1 is the same around the normal, less is brushed along the tangent",
        "isotropía: 1 es igual alrededor de la normal, menos es cepillado a lo largo de la tangente",
        "isotropia: 1 é igual em torno da normal, menos é escovado ao longo da tangente",
    ],
    [
        "its square is the facets' mean slope",
        "su cuadrado es la pendiente media de las facetas",
        "o seu quadrado é o declive médio das facetas",
    ],
    [
        "standard deviation of the facets' slope angles",
        "desviación típica de los ángulos de pendiente de las facetas",
        "desvio padrão dos ângulos de declive das facetas",
    ],
    [
        "standard deviation of the facets' slopes",
        "desviación típica de las pendientes de las facetas",
        "desvio padrão dos declives das facetas",
    ],
    [
        "root mean square height",
        "altura cuadrática media",
        "altura quadrática média",
    ],
    [
        "0 is matt, 1 a mirror",
        "0 es mate, 1 un espejo",
        "0 é mate, 1 um espelho",
    ],
    [
        "correlation length of the heights",
        "longitud de correlación de las alturas",
        "comprimento de correlação das alturas",
    ],
    [
        "what OpenPBR leaves of it at cos θ = 1/7",
        "lo que OpenPBR deja de ella en cos θ = 1/7",
        "o que o OpenPBR deixa dela em cos θ = 1/7",
    ],
    [
        "share of the light that the surface lets through, which is lost here",
        "fracción de la luz que la superficie deja pasar, que aquí se pierde",
        "fração da luz que a superfície deixa passar, que aqui se perde",
    ],
    [
        "degrees",
        "grados",
        "graus",
    ],
    [
        "radii",
        "radios",
        "raios",
    ],
    [
        "Smooth metal",
        "Metal liso",
        "Metal liso",
    ],
    [
        "Smooth varnish: what a dielectric's surface mirrors",
        "Barniz liso: lo que refleja un dieléctrico",
        "Verniz liso: o que espelha um dielétrico",
    ],
    [
        "Burley (Disney) diffuse",
        "Burley (Disney), difuso",
        "Burley (Disney), difuso",
    ],
    [
        "Energy-preserving Oren–Nayar",
        "Oren–Nayar que conserva la energía",
        "Oren–Nayar que conserva a energia",
    ],
    [
        "GGX with multiple reflections",
        "GGX con reflexiones múltiples",
        "GGX com reflexões múltiplas",
    ],
    [
        "He–Torrance–Sillion–Greenberg, the coherent part alone",
        "He–Torrance–Sillion–Greenberg, solo la parte coherente",
        "He–Torrance–Sillion–Greenberg, só a parte coerente",
    ],
    [
        "Lewis (modified Phong)",
        "Lewis (Phong modificado)",
        "Lewis (Phong modificado)",
    ],
    [
        "Phong (original)",
        "Phong (original)",
        "Phong (original)",
    ],
    [
        "glTF metallic-roughness",
        "glTF metálico-rugosidad",
        "glTF metálico-rugosidade",
    ],
];
