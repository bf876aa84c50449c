// Lightmaps of glTF models, as `azulejo bake` writes them, in three.js and Babylon.js.
//
// A material with MOZ_lightmap has the irradiance E = intensity × texel, and a matt surface of base colour ρ shows
// ρE/π. Nothing is imported: what is needed of three.js or Babylon.js comes with the loader.

const NAME = "MOZ_lightmap";

// A material with less of its light from below the surface is seen by what it mirrors or lets through.
const LEAST_MATT = 0.5;

function lightmapOf(material) {
    return material?.extensions?.[NAME];
}

// A material without its lightmap.
function plain(material) {
    const { [NAME]: _, ...extensions } = material.extensions;
    return { ...material, extensions };
}

// The lightmap as information on a texture. Other textures have set 0 if none is said.
function textureInfo(map) {
    return { texCoord: 1, ...map };
}

function coordinateSet(map) {
    return map.extensions?.KHR_texture_transform?.texCoord ?? textureInfo(map).texCoord;
}

// Viewers take missing coordinates as (0, 0), whose texel is of another place. Primitives without coordinates get a
// copy of their material without the lightmap; others that share the material keep it.
function separate({ meshes = [], materials = [] }) {
    const copies = new Map();
    for (const primitive of meshes.flatMap((mesh) => mesh.primitives)) {
        const map = lightmapOf(materials[primitive.material]);
        if (map && primitive.attributes[`TEXCOORD_${coordinateSet(map)}`] === undefined) {
            if (!copies.has(primitive.material)) {
                copies.set(primitive.material, materials.push(plain(materials[primitive.material])) - 1);
            }
            primitive.material = copies.get(primitive.material);
        }
    }
}

// The textures of where the light of a lightmap comes from (`bake --directional`): one for the x, y and z axis each, or
// one for all channels of the light.
function directionsOf(map) {
    const known = map.extras?.azulejo?.directions ?? [];
    return known.length === 3 || known.length === 1 ? known.map(({ index }) => ({ ...textureInfo(map), index })) : [];
}

// GLSL: by how much more a normal t receives than the normal n of the surface, where g is the vector irradiance over
// the scalar irradiance. Light above the surface is taken as that of one direction, and an even sky beside it, which g
// tells apart.
const TILTED = `
float azTilted(vec3 g, vec3 n, vec3 t) {
  float c = dot(g, n) - .5;
  vec3 r = g - .5 * n;
  float s = clamp((c + sqrt(c * c + 3. * dot(r, r))) / 1.5, 0., 1.);
  vec3 d = r + .5 * s * n;
  float sun = s * max(dot(d, t), 0.) / max(length(d), 1e-4);
  return (sun + (1. - s) * .25 * (1. + dot(t, n))) / max(c + .5, .05);
}`;

// GLSL: the factor for the channels of a lightmap, of normals n and t in the axes of glTF, by what is read of the
// textures.
function tilted([x, y, z]) {
    const g = (k) => (y ? `vec3(${x}.${k}, ${y}.${k}, ${z}.${k})` : `${x}.rgb`);
    return `vec3(${["r", "g", "b"].map((k) => `azTilted(2. * ${g(k)} - 1., azN, azT)`)})`;
}

// A function that says what the option `exr` has for a lightmap: itself, or what it returns, asked once for each
// texture.
function choice(exr) {
    const answers = new Map();
    return (json, { index }) => {
        if (typeof exr === "function" && !answers.has(index)) {
            answers.set(index, exr(json.textures[index].name ?? "", index));
        }
        return typeof exr === "function" ? answers.get(index) : exr;
    };
}

/**
 * The plug-in of three.js' GLTFLoader: `loader.register((parser) => new LightmapPlugin(parser))`.
 *
 * Sets `lightMap` and `lightMapIntensity` of materials, so that matt surfaces show the radiance ρE/π, and unlit ones
 * colour × E, in the unit of E (W/m² or lx). Takes the KTX2 of a lightmap if the loader has a KTX2Loader, else the PNG.
 */
export class LightmapPlugin {
    /**
     * @param parser What GLTFLoader gives to the function that is registered.
     * @param options `exr`: the EXR beside the model, as EXRLoader loads it, in place of the pictures in the model; or
     *     a function that returns it, or a promise of it, for the name and the index of a lightmap's texture. For null
     *     the picture in the model is taken.
     */
    constructor(parser, { exr = null } = {}) {
        this.name = NAME;
        this.parser = parser;
        this.exrOf = choice(exr);
    }

    /** Called by the loader before anything is loaded. */
    beforeRoot() {
        separate(this.parser.json);
        return null;
    }

    /**
     * Called by the loader for each material. The hook `extendMaterialParams` would not see unlit ones, and once the
     * scene is there, its meshes have copies, and materials that are loaded later are missed.
     */
    loadMaterial(index) {
        const map = lightmapOf(this.parser.json.materials[index]);
        return map ? this.load(index, map) : null;
    }

    async load(index, map) {
        const { parser } = this;
        const material = await parser.loadMaterial(index);
        // Materials of other plug-ins may have no lightmap.
        if (!("lightMap" in material)) {
            return material;
        }
        await parser.assignTexture(material, "lightMap", textureInfo(map), "srgb");
        const light = await this.exrOf(parser.json, map);
        if (light && material.lightMap) {
            material.lightMap = placed(light, material.lightMap);
        }
        // three divides by π for unlit materials too, where the extension does not.
        const factor = material.isMeshBasicMaterial ? Math.PI : 1;
        material.lightMapIntensity = (light ? 1 : map.intensity ?? 1) * factor;
        // It would darken the baked light, which has been occluded already.
        material.aoMap = null;
        const directions = material.normalMap || material.bumpMap ? directionsOf(map) : [];
        if (directions.length) {
            const load = (info) => parser.assignTexture({}, "map", info, "");
            showRelief(material, await Promise.all(directions.map(load)));
        }
        return material;
    }
}

// Lets a material with normals of its own, and its copies, show where the light of its lightmap comes from.
function showRelief(material, textures) {
    const { clone } = material;
    material.clone = function () {
        const copy = clone.call(this);
        showRelief(copy, textures);
        return copy;
    };
    material.customProgramCacheKey = () => `${NAME}${textures.length}`;
    material.onBeforeCompile = (shader) => {
        shader.uniforms.azDirections = { value: textures };
        const texels = textures.map((_, k) => `texture2D(azDirections[${k}], vLightMapUv)`);
        const chunk = "#include <lights_fragment_maps>";
        shader.fragmentShader = shader.fragmentShader
            .replace("void main() {", `uniform sampler2D azDirections[${textures.length}];${TILTED}\nvoid main() {`)
            .replace(chunk, `${chunk}
vec3 azN = inverseTransformDirection(nonPerturbedNormal, viewMatrix), azT = inverseTransformDirection(normal, viewMatrix);
irradiance += lightMapIrradiance * (${tilted(texels)} - 1.);`);
    };
}

// A picture as EXRLoader has it, rows from the bottom, with the coordinates of another texture.
function placed(light, { channel, rotation, matrixAutoUpdate, center, offset, repeat, matrix, wrapS, wrapT }) {
    const texture = light.clone();
    Object.assign(texture, { channel, rotation, matrixAutoUpdate, wrapS, wrapT, flipY: true, needsUpdate: true });
    texture.center.copy(center);
    texture.offset.copy(offset);
    texture.repeat.copy(repeat);
    texture.matrix.copy(matrix);
    return texture;
}

/**
 * Makes Babylon.js' loader of glTF 2.0 show lightmaps, in every model that is loaded afterwards.
 *
 * Matt surfaces become unlit and show ρE/π, unlit ones colour × E, in the unit of E (W/m² or lx); lights and
 * surroundings act on them no more. Materials that are more metal or glass than matt stay as Babylon.js shows them,
 * without light from the lightmap. Called again, it replaces the options.
 *
 * @param GLTFLoader That of `@babylonjs/loaders/glTF/2.0`, or `BABYLON.GLTF2.GLTFLoader`.
 * @param options `exr`: the address of the EXR beside the model, in place of the pictures in the model; or a function
 *     that returns it, or a promise of it, for the name and the index of a lightmap's texture. For null the picture in
 *     the model is taken. `MaterialPluginBase`: the class of that name, with which normal maps show where the light
 *     comes from.
 */
export function registerLightmaps(GLTFLoader, { exr = null, MaterialPluginBase = null } = {}) {
    const showRelief = MaterialPluginBase && reliefOf(MaterialPluginBase);
    GLTFLoader.UnregisterExtension(NAME);
    GLTFLoader.RegisterExtension(NAME, (loader) => new BabylonExtension(loader, exr, showRelief));
}

// What lets a material with normals of its own show where the light of its lightmap comes from. The constructor of the
// base class asks for the textures already, so that each material has a class with its own.
function reliefOf(MaterialPluginBase) {
    return (material, textures) => {
        const define = `AZ_RELIEF${textures.length}`;
        const names = textures.map((_, k) => `azDirection${k}`);
        // The loader has turned the axes of glTF, unless the scene is right-handed.
        const axes = material.getScene().useRightHandedSystem ? "" : " * vec3(-1., 1., 1.)";
        const code = {
            CUSTOM_FRAGMENT_DEFINITIONS: names.map((name) => `uniform sampler2D ${name};`).join("") + TILTED,
            CUSTOM_FRAGMENT_BEFORE_FINALCOLORCOMPOSITION: `#ifdef LIGHTMAP
vec3 azN = geometricNormalW${axes}, azT = normalW${axes};
lightmapColor.rgb *= ${tilted(names.map((name) => `texture2D(${name}, vLightmapUV)`))};
#endif`,
        };
        class Relief extends MaterialPluginBase {
            getClassName() {
                return "AzulejoRelief";
            }

            prepareDefines(defines) {
                defines[define] = true;
            }

            getActiveTextures(all) {
                all.push(...textures);
            }

            isReadyForSubMesh() {
                return textures.every((texture) => texture.isReadyOrNotBlocking());
            }

            getSamplers(samplers) {
                samplers.push(...names);
            }

            bindForSubMesh(buffer) {
                names.forEach((name, k) => buffer.setTexture(name, textures[k]));
            }

            getCustomCode(type) {
                return type === "fragment" ? code : null;
            }
        }
        new Relief(material, "AzulejoRelief", 200, { [define]: false })._enable(true);
    };
}

class BabylonExtension {
    constructor(loader, exr, showRelief) {
        this.name = NAME;
        this.showRelief = showRelief;
        this.enabled = true;
        // Before KHR_materials_unlit, which asks no extension after it.
        this.order = 100;
        this.loader = loader;
        this.exrOf = choice(exr);
    }

    dispose() {
        this.loader = null;
    }

    onLoading() {
        const { gltf } = this.loader;
        separate(gltf);
        // The loader has numbered the materials before.
        gltf.materials?.forEach((material, index) => (material.index = index));
    }

    loadMaterialPropertiesAsync(context, definition, material) {
        const map = lightmapOf(definition);
        // OpenPBR materials have no lightmap.
        const isShown = map && "lightmapTexture" in material && mattShare(definition) >= LEAST_MATT;
        return isShown ? this.load(context, definition, material, map) : null;
    }

    async load(context, definition, material, map) {
        const { gltf, babylonScene } = this.loader;
        // The decoder of KTX2 knows Basis Universal alone, and fails at the floats of azulejo.
        const { source, extensions } = gltf.textures[map.index];
        if (source !== undefined) {
            delete extensions?.KHR_texture_basisu;
        }
        await this.loader.loadMaterialPropertiesAsync(context, plain(definition), material);
        let texture = await this.loader.loadTextureInfoAsync(`${context}/lightmap`, textureInfo(map));
        const address = await this.exrOf(gltf, map);
        if (address) {
            texture = await fromExr(address, texture, babylonScene);
        }
        // An unlit material with its lightmap as a shadow map shows colour × texel × level.
        const factor = definition.extensions.KHR_materials_unlit ? 1 : mattShare(definition) / Math.PI;
        texture.level = (address ? 1 : map.intensity ?? 1) * factor;
        material.lightmapTexture = texture;
        material.useLightmapAsShadowmap = true;
        material.unlit = true;
        const directions = this.showRelief && material.bumpTexture ? directionsOf(map) : [];
        if (directions.length) {
            const load = (info, k) =>
                this.loader.loadTextureInfoAsync(`${context}/direction${k}`, { ...info, nonColorData: true });
            this.showRelief(material, await Promise.all(directions.map(load)));
        }
    }
}

// The share of the base colour that is matt. That of a picture of metalness is unknown here, and most of these are of
// things that are hardly metal.
function mattShare({ pbrMetallicRoughness: pbr = {}, extensions }) {
    if (extensions.KHR_materials_unlit) {
        return 1;
    }
    const metal = pbr.metallicRoughnessTexture ? 0 : pbr.metallicFactor ?? 1;
    return (1 - metal) * (1 - (extensions.KHR_materials_transmission?.transmissionFactor ?? 0));
}

// An EXR with the texture coordinates of another texture.
function fromExr(address, other, scene) {
    return new Promise((resolve, reject) => {
        const fail = (message, problem) => reject(new Error(`${address}: ${message ?? ""} ${problem ?? ""}`));
        const loaded = () => {
            // Only now does the texture take it.
            light.gammaSpace = false;
            resolve(light);
        };
        // `other` is a Texture: no class of Babylon.js has to be given. Without mipmaps, bilinear.
        const light = new other.constructor(address, scene, true, false, 2, loaded, fail);
        const { coordinatesIndex, uOffset, uScale, uRotationCenter, vRotationCenter, wrapU, wrapV } = other;
        Object.assign(light, { coordinatesIndex, uOffset, uScale, uRotationCenter, vRotationCenter, wrapU, wrapV });
        // Its rows come from the bottom, whatever `invertY` says.
        [light.vScale, light.vOffset, light.wAng] = [-other.vScale, 1 - other.vOffset, -other.wAng];
    });
}
