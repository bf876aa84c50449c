//! Contents of materials, pictures and reflection models.

use super::{ContentBytes, ContentSink, content_of_fields, content_of_kinds};
use crate::brdf::{self, Brdf, Description, Measured, Model, Parameter, Value};
use crate::opacity::{Opacity, OpacityChannel, OpacityMode, OpacityPicture};
use crate::surface_maps::{FinishMaps, NumberPicture, PictureChannel, Relief, ReliefKind};
use crate::{Dielectric, Image, IrradiancePicture, Material, Rgb, Sidedness, Texture, WrapMode};

content_of_fields!(Rgb { r, g, b });
content_of_fields!(Material {
    name,
    diffuse,
    mirror,
    dielectric,
    emission,
    emission_picture,
    emits_back,
    sidedness,
    textures,
    brdf,
    opacity,
    finish,
    relief,
    lightmap,
});
content_of_fields!(FinishMaps {
    base,
    metallic,
    roughness,
    metallic_picture,
    roughness_picture,
});
content_of_fields!(NumberPicture { texture, channel });
content_of_kinds!(PictureChannel {
    Red = 0,
    Green = 1,
    Blue = 2
});
content_of_fields!(IrradiancePicture { texture, scale });
content_of_fields!(Relief { texture, kind });

impl ContentBytes for ReliefKind {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        match self {
            ReliefKind::Normals { scale } => {
                0u8.feed(sink);
                scale.feed(sink);
            }
            ReliefKind::Heights { slope } => {
                1u8.feed(sink);
                slope.feed(sink);
            }
        }
    }
}

content_of_fields!(Opacity {
    constant,
    picture,
    mode
});
content_of_fields!(OpacityPicture { texture, channel });
content_of_kinds!(OpacityChannel {
    Alpha = 0,
    Luminance = 1
});

impl ContentBytes for OpacityMode {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        match self {
            OpacityMode::Mask { cutoff } => {
                0u8.feed(sink);
                cutoff.feed(sink);
            }
            OpacityMode::Blend => 1u8.feed(sink),
        }
    }
}
content_of_fields!(Dielectric {
    ior,
    transmittance,
    thin
});
content_of_kinds!(Sidedness { Unsaid = 0, One = 1, Two = 2 });
content_of_fields!(Texture { path, image, wrap });
content_of_kinds!(WrapMode {
    Repeat = 0,
    Clamp = 1,
    Mirror = 2
});
content_of_fields!(Image {
    width,
    height,
    pixels,
    alpha
});

/// The description, and the diffuse part, which tells a limited model from one that is not.
impl ContentBytes for Brdf {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.description().feed(sink);
        self.diffuse().feed(sink);
    }
}

impl ContentBytes for Description {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        match self {
            Description::Model(model) => {
                0u8.feed(sink);
                model.feed(sink);
            }
            Description::Combination(parts) => {
                1u8.feed(sink);
                parts.feed(sink);
            }
            Description::File { path, content } => {
                2u8.feed(sink);
                path.feed(sink);
                content.feed(sink);
            }
        }
    }
}

impl ContentBytes for brdf::Content {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        match self {
            brdf::Content::Text(description) => {
                0u8.feed(sink);
                description.feed(sink);
            }
            brdf::Content::Measured(measured) => {
                1u8.feed(sink);
                measured.feed(sink);
            }
        }
    }
}

content_of_fields!(Model { name, parameters });
content_of_fields!(Parameter { name, value });

impl ContentBytes for Value {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        match self {
            Value::Number(number) => {
                0u8.feed(sink);
                number.feed(sink);
            }
            Value::Color(color) => {
                1u8.feed(sink);
                color.feed(sink);
            }
            Value::Word(word) => {
                2u8.feed(sink);
                word.feed(sink);
            }
        }
    }
}

impl ContentBytes for Measured {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        match self {
            Measured::Merl(merl) => {
                0u8.feed(sink);
                merl.feed(sink);
            }
            Measured::Rgl(rgl) => {
                1u8.feed(sink);
                rgl.feed(sink);
            }
        }
    }
}
