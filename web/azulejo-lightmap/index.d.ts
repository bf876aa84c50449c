// The types of three.js and Babylon.js are not named here, so that users of one need not install the other.

/** The EXR of a lightmap, or what returns it for the name and the index of the lightmap's texture in the model. */
export type ExrOption<T> = T | null | ((name: string, index: number) => T | null | Promise<T | null>);

/** A texture of three.js, as far as it is used. */
export interface ThreeTexture {
    readonly isTexture: true;
    clone(): any;
}

/** Options of {@link LightmapPlugin}. */
export interface LightmapPluginOptions {
    /** The EXR beside the model, as EXRLoader loads it, in place of the pictures in the model. */
    exr?: ExrOption<ThreeTexture>;
}

/**
 * The plug-in of three.js' GLTFLoader: `loader.register((parser) => new LightmapPlugin(parser))`.
 *
 * Matt surfaces show the radiance ρE/π, and unlit ones colour × E, in the unit of E (W/m² or lx).
 */
export class LightmapPlugin {
    constructor(parser: any, options?: LightmapPluginOptions);
    readonly name: "MOZ_lightmap";
    beforeRoot(): null;
    loadMaterial(index: number): Promise<any> | null;
}

/** Options of {@link registerLightmaps}. */
export interface RegisterLightmapsOptions {
    /** The address of the EXR beside the model, in place of the pictures in the model. */
    exr?: ExrOption<string>;
    /** The class MaterialPluginBase of Babylon.js: normal maps then show where the light comes from. */
    MaterialPluginBase?: any;
}

/** The class GLTFLoader of Babylon.js, as far as it is used. */
export interface BabylonGltfLoader {
    RegisterExtension(name: string, factory: (loader: any) => any): void;
    UnregisterExtension(name: string): boolean;
}

/**
 * Makes Babylon.js' loader of glTF 2.0 show lightmaps, in every model that is loaded afterwards.
 *
 * Matt surfaces become unlit and show ρE/π, unlit ones colour × E, in the unit of E (W/m² or lx). Called again, it
 * replaces the options.
 */
export function registerLightmaps(GLTFLoader: BabylonGltfLoader, options?: RegisterLightmapsOptions): void;
