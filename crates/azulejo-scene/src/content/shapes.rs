//! Contents of scenes, shapes and lights.

use super::{ContentBytes, ContentSink, content_of_fields, content_of_kinds};
use crate::sky::{PerezSky, Sky, SkyDistribution};
use crate::{
    Attribute, BackIrradiance, Backplate, BackplateFit, BicubicPatch, Camera, Contour, Csg, Curve,
    Environment, EnvironmentSource, Exact, Faces, Figure, FillRule, Fog, Light, LightKind, Mesh,
    MeshInstance, Object, Operation, Primitive, PrimitiveKind, Prism, Projection, Scene,
    SceneBackground, Shape, Solid, SurfaceGrid, SurfaceLight, Units, Up, VertexLight,
};

impl ContentBytes for Scene {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        let Scene {
            objects,
            materials,
            textures,
            lights,
            cameras,
            background,
            fog,
            units,
            // Only RTRACE's own shading reads it, which has no first pass.
            rtrace: _,
        } = self;
        objects.feed(sink);
        materials.feed(sink);
        textures.feed(sink);
        lights.feed(sink);
        cameras.feed(sink);
        background.feed(sink);
        fog.feed(sink);
        units.feed(sink);
    }
}

content_of_fields!(Object { name, shape });
content_of_fields!(Fog {
    color,
    visibility,
    exponential
});
content_of_fields!(Units {
    metres_per_unit,
    up,
    photometric
});
content_of_kinds!(Up { Y = 0, Z = 1 });
content_of_fields!(Camera {
    name,
    eye,
    target,
    up,
    vertical_fov,
    size
});
content_of_fields!(Light { name, kind });

impl ContentBytes for LightKind {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        match self {
            LightKind::Point {
                position,
                intensity,
            } => {
                0u8.feed(sink);
                position.feed(sink);
                intensity.feed(sink);
            }
            LightKind::Spot {
                position,
                direction,
                intensity,
                inner,
                outer,
            } => {
                1u8.feed(sink);
                position.feed(sink);
                direction.feed(sink);
                intensity.feed(sink);
                [*inner, *outer].feed(sink);
            }
            LightKind::Directional {
                direction,
                irradiance,
                half_angle,
            } => {
                2u8.feed(sink);
                direction.feed(sink);
                irradiance.feed(sink);
                half_angle.feed(sink);
            }
            LightKind::Ambient { radiance } => {
                3u8.feed(sink);
                radiance.feed(sink);
            }
            LightKind::Environment(environment) => kind(4, environment, sink),
        }
    }
}

impl ContentBytes for SceneBackground {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        match self {
            SceneBackground::Color(color) => kind(0, color, sink),
            SceneBackground::Environment(environment) => kind(1, environment, sink),
            SceneBackground::Backplate(plate) => kind(2, plate, sink),
        }
    }
}

content_of_fields!(Backplate {
    texture,
    fit,
    radiance
});

content_of_fields!(Environment {
    source,
    world_from_environment,
    scale
});

impl ContentBytes for EnvironmentSource {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        match self {
            EnvironmentSource::Picture {
                texture,
                projection,
            } => {
                kind(0, texture, sink);
                projection.feed(sink);
            }
            EnvironmentSource::Sky(sky) => kind(1, sky, sink),
        }
    }
}

content_of_fields!(Sky {
    distribution,
    toward_sun,
    scale,
    ground
});

impl ContentBytes for SkyDistribution {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        match self {
            SkyDistribution::Uniform => 0u8.feed(sink),
            SkyDistribution::Cie(sky) => kind(1, &sky.number(), sink),
            SkyDistribution::Perez(PerezSky { coefficients }) => kind(2, coefficients, sink),
        }
    }
}

content_of_kinds!(BackplateFit {
    Scaled = 0,
    Centered = 1,
    Tiled = 2
});

content_of_kinds!(Projection {
    Equirectangular = 0,
    AngularMap = 1
});

/// A kind's number, and then its content.
fn kind(number: u8, content: &impl ContentBytes, sink: &mut ContentSink<'_>) {
    number.feed(sink);
    content.feed(sink);
}

impl ContentBytes for Shape {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        match self {
            Shape::Mesh(mesh) => kind(0, mesh, sink),
            Shape::Primitive(primitive) => kind(1, primitive, sink),
            Shape::Exact(exact) => kind(2, exact, sink),
            Shape::Instance(instance) => kind(3, instance, sink),
        }
    }
}

content_of_fields!(MeshInstance {
    mesh,
    world_from_mesh,
    light
});
content_of_fields!(VertexLight {
    irradiance,
    error,
    back
});
impl ContentBytes for Mesh {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        let Mesh {
            positions,
            normals,
            uvs,
            lightmap_uvs,
            colors,
            irradiance,
            irradiance_error,
            back,
            faces,
            face_materials,
            smoothing,
            // What came before is not what is there.
            history: _,
        } = self;
        positions.feed(sink);
        normals.feed(sink);
        uvs.feed(sink);
        lightmap_uvs.feed(sink);
        colors.feed(sink);
        irradiance.feed(sink);
        irradiance_error.feed(sink);
        back.feed(sink);
        faces.feed(sink);
        face_materials.feed(sink);
        smoothing.feed(sink);
    }
}

content_of_fields!(Faces { starts, corners });
content_of_fields!(BackIrradiance { irradiance, error });

impl<T: ContentBytes> ContentBytes for Attribute<T> {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        let Attribute { values, corners } = self;
        values.feed(sink);
        corners.feed(sink);
    }
}

content_of_fields!(Primitive {
    kind,
    world_from_object,
    material,
    light
});
content_of_fields!(SurfaceLight {
    grids,
    irradiance,
    error
});
content_of_fields!(SurfaceGrid { nu, nv });

impl ContentBytes for PrimitiveKind {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        match self {
            PrimitiveKind::Sphere => 0u8.feed(sink),
            PrimitiveKind::Cylinder => 1u8.feed(sink),
            PrimitiveKind::Cone { top } => kind(2, top, sink),
            PrimitiveKind::Tube { top } => kind(3, top, sink),
            PrimitiveKind::Cuboid => 4u8.feed(sink),
            PrimitiveKind::Square => 5u8.feed(sink),
        }
    }
}

content_of_fields!(Exact { solids, proxy });

impl ContentBytes for Solid {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        match self {
            Solid::Primitive(primitive) => kind(0, primitive, sink),
            Solid::Prism(prism) => kind(1, prism, sink),
            Solid::Patch(patch) => kind(2, patch, sink),
            Solid::Mesh(mesh) => kind(3, mesh, sink),
            Solid::Shell(pieces) => kind(4, pieces, sink),
            Solid::Csg(csg) => kind(5, csg, sink),
        }
    }
}

content_of_fields!(Csg {
    operation,
    left,
    right
});
content_of_kinds!(Operation { Union = 0, Difference = 1, Intersection = 2 });
content_of_fields!(Prism {
    figure,
    world_from_figure,
    material
});
content_of_fields!(BicubicPatch { points, material });
content_of_fields!(Figure { contours, rule });
content_of_fields!(Contour { curves });
content_of_kinds!(FillRule { EvenOdd = 0, NonZero = 1 });

impl ContentBytes for Curve {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        match self {
            Curve::Line { start } => kind(0, start, sink),
            Curve::Cubic {
                start,
                control1,
                control2,
            } => kind(1, &[*start, *control1, *control2], sink),
        }
    }
}
