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
        return material;
    }
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
 *     the model is taken.
 */
export function registerLightmaps(GLTFLoader, { exr = null } = {}) {
    GLTFLoader.UnregisterExtension(NAME);
    GLTFLoader.RegisterExtension(NAME, (loader) => new BabylonExtension(loader, exr));
}

class BabylonExtension {
    constructor(loader, exr) {
        this.name = NAME;
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
