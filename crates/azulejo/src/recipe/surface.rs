//! Rules by name: what surfaces become.

use super::RecipeError;
use super::tables::{RecipePatterns, RecipeSource, RuleTable};
use crate::luminaire::flux;
use azulejo_scene::brdf::Description;
use azulejo_scene::{Brdf, Dielectric, Material, Rgb};
use globset::{Glob, GlobSet, GlobSetBuilder};
use std::f64::consts::PI;
use std::sync::Arc;

/// What the names of a rule are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RuleTarget {
    /// Materials.
    Material,
    /// Objects.
    Object,
}

impl RuleTarget {
    /// In messages.
    pub fn word(self) -> &'static str {
        match self {
            RuleTarget::Material => "material",
            RuleTarget::Object => "object",
        }
    }
}

/// A checked rule.
pub(super) struct SurfaceRule<'r> {
    /// Its patterns, in messages.
    pub words: String,
    source: &'r RecipeSource,
    at: usize,
    names: GlobSet,
    diffuse: Option<Rgb>,
    mirror: Option<Rgb>,
    emission: Option<Rgb>,
    brdf: Option<Arc<Brdf>>,
    glass: Option<(f64, bool)>,
    lumens: Option<(f64, Option<f64>)>,
}

impl<'r> SurfaceRule<'r> {
    /// Checks a rule.
    pub fn new(
        table: &RuleTable,
        target: RuleTarget,
        source: &'r RecipeSource,
    ) -> Result<SurfaceRule<'r>, RecipeError> {
        let at = table.name.span().start;
        let list = match table.name.get_ref() {
            RecipePatterns::One(one) => std::slice::from_ref(one),
            RecipePatterns::Many(many) => many,
        };
        let mut names = GlobSetBuilder::new();
        for pattern in list {
            names.add(Glob::new(pattern).map_err(|e| source.wrong(at, e))?);
        }
        let share = |color| source.share(color);
        let rule = SurfaceRule {
            words: format!("\"{}\"", list.join("\", \"")),
            source,
            at,
            names: names.build().map_err(|e| source.wrong(at, e))?,
            diffuse: table.diffuse.as_ref().map(share).transpose()?,
            mirror: table.mirror.as_ref().map(share).transpose()?,
            emission: (table.emission.as_ref().map(|c| source.light(c))).transpose()?,
            brdf: match &table.brdf {
                None => None,
                Some(text) => {
                    let made = text.get_ref().parse::<Description>().and_then(Brdf::new);
                    let made = made.map_err(|e| source.wrong(text.span().start, e))?;
                    Some(Arc::new(made))
                }
            },
            glass: match &table.glass {
                Some(ior) if !(*ior.get_ref() > 0.0 && ior.get_ref().is_finite()) => {
                    return Err(source.wrong(ior.span().start, "an index of refraction above 0"));
                }
                ior => ior.as_ref().map(|ior| (*ior.get_ref(), table.thin)),
            },
            lumens: table
                .lumens
                .as_ref()
                .map(|l| (*l.get_ref(), table.temperature)),
        };
        rule.check(table, target)?;
        Ok(rule)
    }

    /// Refuses what contradicts itself.
    fn check(&self, table: &RuleTable, target: RuleTarget) -> Result<(), RecipeError> {
        let wrong = |message: &str| Err(self.source.wrong(self.at, message));
        if self.lumens.is_some() && target == RuleTarget::Material {
            return wrong("`lumens` is the light of an object: put it under [[object]]");
        }
        if table.temperature.is_some() && self.lumens.is_none() {
            return wrong("`temperature` is the colour of `lumens`, which is missing");
        }
        if self.lumens.is_some() && self.emission.is_some() {
            return wrong("either `lumens` or `emission`");
        }
        if table.thin && self.glass.is_none() {
            return wrong("`thin` belongs to `glass`, which is missing");
        }
        let is_plain = self.diffuse.is_some() || self.mirror.is_some();
        if self.brdf.is_some() && (is_plain || self.glass.is_some()) {
            return wrong(
                "a `brdf` says all of the reflection: leave out diffuse, mirror and glass",
            );
        }
        let changes = is_plain
            || self.brdf.is_some()
            || self.glass.is_some()
            || self.emission.is_some()
            || self.lumens.is_some();
        if changes {
            Ok(())
        } else {
            wrong("a rule that changes nothing")
        }
    }

    /// Whether the rule is about this name.
    pub fn matches(&self, name: &str) -> bool {
        self.names.is_match(name)
    }

    /// A message with the rule's place before it.
    pub fn place(&self, message: &str) -> String {
        self.source.place(self.at, message)
    }

    /// Changes a material, `lumens` apart.
    pub fn change(&self, material: &mut Material) {
        let is_plain = self.diffuse.is_some() || self.mirror.is_some();
        if self.brdf.is_some() || self.glass.is_some() || is_plain {
            // Pictures of metalness and roughness belong to the model that goes.
            material.finish = None;
        }
        if self.emission.is_some() || self.lumens.is_some() {
            material.emission_picture = None;
        }
        if let Some(brdf) = &self.brdf {
            let made = Material::with_brdf(material.name.clone(), brdf.clone());
            material.diffuse = made.diffuse;
            material.mirror = made.mirror;
            material.brdf = made.brdf;
            material.dielectric = None;
        }
        if is_plain {
            material.brdf = None;
            material.dielectric = None;
        }
        if let Some((ior, thin)) = self.glass {
            material.brdf = None;
            material.diffuse = Rgb::BLACK;
            material.mirror = Rgb::WHITE;
            material.dielectric = Some(Dielectric {
                ior,
                transmittance: Rgb::WHITE,
                thin,
            });
        }
        material.diffuse = self.diffuse.unwrap_or(material.diffuse);
        material.mirror = self.mirror.unwrap_or(material.mirror);
        material.emission = self.emission.unwrap_or(material.emission);
    }

    /// The radiance by which a matt lamp of this area emits the rule's `lumens`.
    pub fn radiance(&self, area: f64, photometric: bool) -> Result<Option<Rgb>, RecipeError> {
        let Some((lumens, temperature)) = self.lumens else {
            return Ok(None);
        };
        let failed = |message: &str| RecipeError::Content(self.place(message));
        let flux = flux(lumens, temperature, photometric);
        let flux = flux.ok_or_else(|| failed("lumens and temperature must be above 0"))?;
        if area > 0.0 {
            Ok(Some(flux / (PI * area)))
        } else {
            Err(failed("a lamp without area"))
        }
    }
}
