//! Previews of light while it is being solved.

use crate::first_pass::FirstPass;
use crate::gathering::Gathering;
use crate::system::RadiositySolution;
use crate::vertices::{Targets, targets};
use azulejo_factors::{Patches, ProxyScene};
use azulejo_scene::Irradiance;
use azulejo_trace::time::{Duration, Instant};

/// Least time between two previews of a stage.
const PAUSE: Duration = Duration::from_secs(1);

/// Provisional light of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Preview {
    /// What [`Scene::set_irradiance`](azulejo_scene::Scene::set_irradiance) takes.
    pub irradiance: Irradiance,
    /// The stage of the solution.
    pub stage: PreviewStage,
    /// Estimated relative RMS error, of the patches' radiosity or of the irradiance.
    pub error: f64,
}

/// What the light of a [`Preview`] is computed from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PreviewStage {
    /// Radiosity of patches, interpolated to the vertices: shadows are as coarse as the patches,
    /// and there are no standard errors.
    Patches,
    /// Irradiance gathered at the vertices, not yet with all rays.
    Vertices,
}

/// Passes previews to a callback, if there is one.
pub(crate) struct PreviewReporter<'w, 'a> {
    watch: Option<&'w mut dyn FnMut(Preview)>,
    proxy: &'a ProxyScene<'a>,
    pass: &'a FirstPass,
    last: Option<(PreviewStage, Instant)>,
}

impl<'w, 'a> PreviewReporter<'w, 'a> {
    /// Without a callback no previews are computed.
    pub fn new(
        watch: Option<&'w mut dyn FnMut(Preview)>,
        proxy: &'a ProxyScene<'a>,
        pass: &'a FirstPass,
    ) -> PreviewReporter<'w, 'a> {
        PreviewReporter {
            watch,
            proxy,
            pass,
            last: None,
        }
    }

    /// Reports the light of patches.
    pub fn show_patches(&mut self, patches: &Patches, found: &RadiositySolution) {
        let (given, scene, pass) = (self.proxy.given, &self.proxy.scene, self.pass);
        self.show(PreviewStage::Patches, |stage| Preview {
            irradiance: targets(given, patches, found, pass).interpolated(
                scene,
                patches,
                &found.incident,
            ),
            stage,
            error: found.error(patches),
        });
    }

    /// Reports what has been gathered at the vertices so far.
    pub fn show_vertices(&mut self, targets: &Targets, patches: &Patches, found: &Gathering) {
        let scene = &self.proxy.scene;
        self.show(PreviewStage::Vertices, |stage| Preview {
            irradiance: targets.irradiance(scene, patches, found),
            stage,
            error: found.relative_error(),
        });
    }

    fn show(&mut self, stage: PreviewStage, preview: impl FnOnce(PreviewStage) -> Preview) {
        let is_due = |(shown, at): (_, Instant)| shown != stage || at.elapsed() >= PAUSE;
        if let Some(watch) = self.watch.as_mut().filter(|_| self.last.is_none_or(is_due)) {
            watch(preview(stage));
            self.last = Some((stage, Instant::now()));
        }
    }
}
