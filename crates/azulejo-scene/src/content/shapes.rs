//! Contents of scenes, shapes and lights.

use super::{ContentBytes, ContentSink};
use crate::content_bytes::{content_of_fields, content_of_variants};
use crate::sky::{CieSky, PerezSky, Sky, SkyDistribution};
use crate::{
    Attribute, BackIrradiance, Backplate, BackplateFit, Bevel, BevelEnds, BevelProfile,
    BicubicPatch, Camera, Contour, Csg, Curve, Environment, EnvironmentSource, Exact, Faces,
    Figure, FillRule, Fog, Light, LightKind, Mesh, MeshInstance, Object, Operation, PhotometricWeb,
    Primitive, PrimitiveKind, Prism, Projection, Scene, SceneBackground, Shape, Solid, SurfaceGrid,
    SurfaceLight, Units, Up, VertexLight, WebType,
};

// Zones say which rows are written together, not what they see. RTRACE's own parameters are read by its own shading alone, which has no first pass; what a mesh was before it was
// mapped is not what it is.
content_of_fields! {
    Scene { objects, materials, textures, lights, cameras, background, fog, units; rtrace }
    Object { name, shape; zone }
    Fog { color, visibility, exponential }
    Units { metres_per_unit, up, photometric }
    Camera { name, eye, target, up, vertical_fov, size }
    Light { name, kind }
    Backplate { texture, fit, radiance }
    Environment { source, world_from_environment, scale }
    Sky { distribution, toward_sun, scale, ground }
    PerezSky { coefficients }
    MeshInstance { mesh, world_from_mesh, light }
    VertexLight { irradiance, error, back }
    Mesh {
        positions, normals, uvs, lightmap_uvs, colors, irradiance, irradiance_error, back, faces,
        face_materials, smoothing; history
    }
    Faces { starts, corners }
    BackIrradiance { irradiance, error }
    Primitive { kind, world_from_object, material, light }
    SurfaceLight { grids, irradiance, error }
    SurfaceGrid { nu, nv }
    Exact { solids, proxy }
    Csg { operation, left, right }
    Prism { figure, world_from_figure, material, bevel }
    Bevel { profile, inset, depth, ends }
    BicubicPatch { points, material }
    Figure { contours, rule }
    Contour { curves }
}

content_of_variants! {
    Up { 0 = Y, 1 = Z }
    LightKind {
        0 = Point { position, intensity },
        1 = Spot { position, direction, intensity, inner, outer },
        2 = Directional { direction, irradiance, half_angle },
        3 = Ambient { radiance },
        4 = Environment(environment),
        5 = Luminaire { position, world_from_web, scale, web },
    }
    WebType { 0 = A, 1 = B, 2 = C }
    SceneBackground { 0 = Color(color), 1 = Environment(environment), 2 = Backplate(plate) }
    EnvironmentSource { 0 = Picture { texture, projection }, 1 = Sky(sky) }
    SkyDistribution { 0 = Uniform, 1 = Cie(sky), 2 = Perez(sky) }
    BackplateFit { 0 = Scaled, 1 = Centered, 2 = Tiled }
    Projection { 0 = Equirectangular, 1 = AngularMap }
    Shape { 0 = Mesh(mesh), 1 = Primitive(primitive), 2 = Exact(exact), 3 = Instance(instance) }
    PrimitiveKind {
        0 = Sphere,
        1 = Cylinder,
        2 = Cone { top },
        3 = Tube { top },
        4 = Cuboid,
        5 = Square,
    }
    Solid {
        0 = Primitive(primitive),
        1 = Prism(prism),
        2 = Patch(patch),
        3 = Mesh(mesh),
        4 = Shell(pieces),
        5 = Csg(csg),
    }
    Operation { 0 = Union, 1 = Difference, 2 = Intersection }
    FillRule { 0 = EvenOdd, 1 = NonZero }
    BevelProfile { 0 = Chamfer, 1 = Round }
    BevelEnds { 0 = Front, 1 = Both }
    Curve { 0 = Line { start }, 1 = Cubic { start, control1, control2 } }
}

impl ContentBytes for PhotometricWeb {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        let [vertical, horizontal] = self.angles();
        self.kind().feed(sink);
        for numbers in [vertical, horizontal, self.values()] {
            numbers.feed(sink);
        }
    }
}

impl ContentBytes for CieSky {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.number().feed(sink);
    }
}

impl<T: ContentBytes> ContentBytes for Attribute<T> {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        let Attribute { values, corners } = self;
        values.feed(sink);
        corners.feed(sink);
    }
}
