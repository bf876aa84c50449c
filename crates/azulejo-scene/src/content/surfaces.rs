//! Contents of materials, pictures and reflection models.

use super::{ContentBytes, ContentSink};
use crate::brdf::{Brdf, Content, Description, Measured, Model, Parameter, Value};
use crate::content_bytes::{content_of_fields, content_of_variants};
use crate::opacity::{Opacity, OpacityChannel, OpacityMode, OpacityPicture};
use crate::surface_maps::{FinishMaps, NumberPicture, PictureChannel, Relief, ReliefKind};
use crate::{Dielectric, Image, IrradiancePicture, Material, Rgb, Sidedness, Texture, WrapMode};

content_of_fields! {
    Rgb { r, g, b }
    Material {
        name, diffuse, mirror, dielectric, emission, emission_picture, emits_back, sidedness,
        textures, brdf, opacity, finish, relief, lightmap
    }
    Dielectric { ior, transmittance, thin }
    FinishMaps { base, metallic, roughness, metallic_picture, roughness_picture }
    NumberPicture { texture, channel }
    IrradiancePicture { texture, scale }
    Relief { texture, kind }
    Opacity { constant, picture, mode }
    OpacityPicture { texture, channel }
    Texture { path, image, wrap }
    Image { width, height, pixels, alpha }
    Model { name, parameters }
    Parameter { name, value }
}

content_of_variants! {
    PictureChannel { 0 = Red, 1 = Green, 2 = Blue }
    ReliefKind { 0 = Normals { scale }, 1 = Heights { slope } }
    OpacityChannel { 0 = Alpha, 1 = Luminance }
    OpacityMode { 0 = Mask { cutoff }, 1 = Blend }
    Sidedness { 0 = Unsaid, 1 = One, 2 = Two }
    WrapMode { 0 = Repeat, 1 = Clamp, 2 = Mirror }
    Description { 0 = Model(model), 1 = Combination(parts), 2 = File { path, content } }
    Content { 0 = Text(description), 1 = Measured(measured) }
    Value { 0 = Number(number), 1 = Color(color), 2 = Word(word) }
    Measured { 0 = Merl(merl), 1 = Rgl(rgl) }
}

/// The description, and the diffuse part, which tells a limited model from one that is not.
impl ContentBytes for Brdf {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.description().feed(sink);
        self.diffuse().feed(sink);
    }
}
