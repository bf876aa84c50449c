//! The pages of a lightmap: the light of texels with borders of charts, seams, and what viewers miss between texels.

use super::charts::Charts;
use super::indirect::SampleLight;
use super::{BakeOptions, BakedLight};
use azulejo_bake::{
    BetweenTexels, DIRECTIONAL, DirectTexels, Lightmap, Samples, SeamErrors, ShownSamples,
    TexelField, TexelHarmonics,
};
use azulejo_radiosity::SolveError;
use azulejo_trace::{GatherPoint, Run};

/// Pages with what is known of them.
pub struct Pages {
    pub lightmap: Lightmap,
    /// Where it comes from, if that is asked for.
    pub harmonics: Option<Box<[Lightmap; DIRECTIONAL]>>,
    /// Differences along seams.
    pub seams: SeamErrors,
    /// Root mean square of what interpolation between texels misses, W/m².
    pub between_texels: f64,
}

impl Pages {
    /// The pages of the light of all samples.
    pub fn new(
        charts: &Charts<'_>,
        samples: &Samples,
        light: SampleLight,
        options: &BakeOptions,
        run: Run,
    ) -> Result<Pages, SolveError> {
        let atlas = &charts.atlas;
        let gatherer = charts.solved.gatherer();
        let surfaces = gatherer.surfaces();
        let SampleLight {
            direct:
                DirectTexels {
                    light: direct,
                    mut harmonics,
                },
            all: mut light,
            error,
            ..
        } = light;
        let field = (options.light != BakedLight::Direct)
            .then(|| TexelField::new(atlas, samples, &light, &charts.objects, surfaces));
        let indirect = charts.indirect(options, error, run);
        if options.is_directional && options.light == BakedLight::Indirect {
            harmonics = TexelHarmonics::none(light.len());
        }
        if let Some(field) = &field {
            indirect.add_directions(&mut harmonics, samples, field)?;
        }
        if options.light == BakedLight::Indirect {
            direct.take_from(&mut light);
        }
        // What viewers read, with borders of charts and seams.
        let shown = ShownSamples::new(samples, &light, surfaces);
        let mut lightmap = shown.lightmap(samples, &light);
        if options.denoises && options.fixed_rays(run.progress).is_some() {
            azulejo_bake::denoise(&mut lightmap, &shown, samples, run.progress)?;
        }
        for page in &mut lightmap.pages {
            azulejo_bake::pad_charts(page, options.charts.padding);
        }
        let seams = azulejo_bake::stitch(&mut lightmap, atlas);
        if options.light != BakedLight::Indirect {
            direct.take_from(&mut light);
        }
        // What interpolation between texels misses, as part of their errors.
        let between = BetweenTexels {
            atlas,
            samples,
            shown: &shown,
            direct: &direct,
            rest: &light,
            gatherer,
            error,
            seed: options.seed(),
        };
        let rest = between.rest_of(options.charts.padding);
        let mut between_texels = 0.0_f64;
        if options.light != BakedLight::Indirect {
            between_texels = between.add_direct(&mut lightmap, &rest, run)?;
        }
        if let Some(field) = &field {
            let mut gather = |points: &[GatherPoint]| indirect.at(points, field);
            let missed = between.add_indirect(&mut lightmap, &rest, &mut gather)?;
            between_texels = between_texels.hypot(missed);
        }
        for page in &mut lightmap.pages {
            azulejo_bake::fill(page);
        }
        let harmonics = options.is_directional.then(|| {
            Box::new(harmonics.coefficients.map(|values| {
                let mut pages = shown.lightmap(samples, &values);
                for page in &mut pages.pages {
                    azulejo_bake::pad_charts(page, options.charts.padding);
                    azulejo_bake::fill(page);
                }
                pages
            }))
        });
        Ok(Pages {
            lightmap,
            harmonics,
            seams,
            between_texels,
        })
    }
}
