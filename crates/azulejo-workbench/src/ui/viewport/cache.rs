//! The displayed polygons of each object, cached between frames.

use crate::app::App;
use crate::bake::LightmappedMesh;
use crate::document::{ItemId, SceneObject};
use crate::gpu::{DrawnMesh, FaceValues, Projection, chord_error, display_mesh, pick};
use crate::view::Shading;
use azulejo::scene::math::{Aabb, Ray};
use azulejo::scene::{Mesh, Rgb, Shape, Texture};
use glam::{DAffine3, DVec3};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Polygons of objects, kept until the shape or the required accuracy changes.
#[derive(Default)]
pub struct ViewportCache {
    entries: Vec<CachedMesh>,
    textures: HashMap<*const Texture, (u64, Arc<Texture>)>,
    form_factors: Option<(u64, Arc<Mesh>, Vec<f32>)>,
    next: u64,
}

/// The polygons of one object.
pub struct CachedMesh {
    pub id: ItemId,
    shape: Arc<Shape>,
    /// The tessellation of an exact shape.
    made: Option<Mesh>,
    /// What is shown of an object with a lightmap.
    lightmapped: Option<Arc<LightmappedMesh>>,
    chord_error: f64,
    is_lit: bool,
    /// Whether the polygons have relative errors in place of irradiance.
    shows_error: bool,
    key: u64,
    /// Bounding box of the polygons in object space.
    bounds: Aabb,
    /// World from object for the polygons.
    pub placement: DAffine3,
}

impl CachedMesh {
    /// The polygons.
    pub fn mesh(&self) -> &Mesh {
        if let Some(lightmapped) = &self.lightmapped {
            return &lightmapped.mesh;
        }
        match (&self.made, &*self.shape) {
            (Some(mesh), _) => mesh,
            (None, Shape::Mesh(mesh)) => mesh,
            (None, Shape::Exact(exact)) => exact.proxy.as_deref().unwrap_or(&EMPTY),
            (None, Shape::Instance(instance)) => &instance.mesh,
            (None, Shape::Primitive(_)) => &EMPTY,
        }
    }

    /// The polygons with their placement, for picking.
    pub fn drawn(&self) -> DrawnMesh<'_> {
        DrawnMesh {
            world_from_object: self.placement,
            bounds: Some(self.bounds),
            lightmap: self.lightmapped.as_ref().map(|l| &l.spots[..]),
            ..DrawnMesh::new(self.key, self.mesh())
        }
    }

    /// Unit normal of the side of a triangle that a ray hits.
    pub fn normal(&self, corners: [u32; 3], ray: &Ray) -> DVec3 {
        let mesh = self.mesh();
        let [a, b, c] = corners.map(|v| {
            let p = mesh.positions.get(v as usize).copied();
            self.placement.transform_point3(p.unwrap_or_default())
        });
        let n = (b - a).cross(c - a).normalize_or_zero();
        if n.dot(ray.direction) > 0.0 { -n } else { n }
    }

    /// Irradiance at a point of a triangle, with its standard error where known; `None` where it is
    /// not solved.
    pub fn light(&self, corners: [u32; 3], weights: DVec3) -> Option<(Rgb, Option<Rgb>)> {
        light_of(self.mesh(), corners, weights).filter(|_| self.is_lit && !self.shows_error)
    }

    /// Irradiance at a point of a triangle by the lightmap, if the object is shown with it.
    pub fn light_of_lightmap(&self, app: &App, corners: [u32; 3], weights: DVec3) -> Option<Rgb> {
        let spot = self.lightmapped.as_ref()?.spot(corners, weights);
        app.lightmap.shown.as_ref()?.lightmap.irradiance(spot)
    }

    /// The face of the model that a ray hits, where the solver's patches are displayed.
    pub fn model_face(&self, app: &App, ray: &Ray) -> Option<usize> {
        let item = app.document.object(self.id).filter(|_| self.is_lit)?;
        let Shape::Mesh(mesh) = &*item.shape else {
            return None;
        };
        let drawn = DrawnMesh {
            world_from_object: item.placement,
            ..DrawnMesh::new(0, mesh)
        };
        pick(&[drawn], ray, false).map(|hit| hit.face)
    }

    /// Irradiance where a ray hits the solved shape of the object, while another shape of it is
    /// displayed.
    pub fn light_beneath(&self, app: &App, ray: &Ray) -> Option<(Rgb, Option<Rgb>)> {
        let item = app.document.object(self.id)?;
        let lit = app.lighting.solution.as_ref()?.shown(item)?;
        let mesh = display_mesh(lit, self.chord_error, true);
        let hit = pick(&[DrawnMesh::new(0, &mesh)], ray, false)?;
        light_of(&mesh, hit.vertices, hit.barycentric).filter(|_| hit.is_front)
    }
}

/// A mesh with the standard error of its irradiance, relative to it, in place of the irradiance;
/// without light where the errors are not known.
fn with_errors(mut mesh: Mesh) -> Mesh {
    if mesh.irradiance_error.len() != mesh.irradiance.len() {
        mesh.irradiance = Vec::new();
        return mesh;
    }
    let errors = mesh.irradiance.iter().zip(&mesh.irradiance_error);
    mesh.irradiance = errors
        .map(|(light, error)| {
            let light = light.luminance();
            Rgb::grey(if light > 0.0 {
                error.luminance() / light
            } else {
                0.0
            })
        })
        .collect();
    mesh
}

/// Irradiance at a point of a triangle, with its standard error where known.
fn light_of(mesh: &Mesh, corners: [u32; 3], weights: DVec3) -> Option<(Rgb, Option<Rgb>)> {
    let mean = |values: &[Rgb]| {
        let mut sum = Rgb::BLACK;
        for (corner, weight) in corners.iter().zip(weights.to_array()) {
            sum += values.get(*corner as usize).copied().unwrap_or_default() * weight;
        }
        sum
    };
    let is_full = |values: &[Rgb]| values.len() == mesh.positions.len();
    let error = is_full(&mesh.irradiance_error).then(|| mean(&mesh.irradiance_error));
    is_full(&mesh.irradiance).then(|| (mean(&mesh.irradiance), error))
}

static EMPTY: Mesh = Mesh {
    positions: Vec::new(),
    normals: None,
    uvs: None,
    lightmap_uvs: None,
    colors: Vec::new(),
    irradiance: Vec::new(),
    irradiance_error: Vec::new(),
    back: None,
    faces: azulejo::scene::Faces {
        starts: Vec::new(),
        corners: Vec::new(),
    },
    face_materials: Vec::new(),
    smoothing: Vec::new(),
    history: azulejo::scene::PositionHistory::NONE,
};

impl ViewportCache {
    /// Updates the polygons to the document and the view.
    pub fn update(&mut self, app: &App, shading: Shading, view: &Projection) {
        let mut old: HashMap<ItemId, CachedMesh> =
            self.entries.drain(..).map(|e| (e.id, e)).collect();
        for item in app.document.objects.iter().filter(|i| !i.hidden) {
            let entry = self.entry(app, item, (shading, view), old.remove(&item.id));
            self.entries.push(entry);
        }
        self.keep_textures(app);
        self.update_form_factors(app);
    }

    fn entry(
        &mut self,
        app: &App,
        item: &SceneObject,
        (shading, view): (Shading, &Projection),
        old: Option<CachedMesh>,
    ) -> CachedMesh {
        let lightmap = app.lightmap.shown_in(shading);
        let lightmapped = lightmap.and_then(|shown| shown.lightmap.shown(item));
        let lit = if lightmapped.is_some() {
            // The triangles of the lightmap are shown in place of the shape.
            Some(&item.shape)
        } else if shading.shows_light() {
            app.lighting.solution.as_ref().and_then(|s| s.shown(item))
        } else {
            None
        };
        let is_lit = lit.is_some();
        let shows_error = is_lit && shading == Shading::Error;
        let shape = lit.unwrap_or(&item.shape);
        // Shapes returned by the solver are already in world space.
        let placement = if is_lit {
            DAffine3::IDENTITY
        } else {
            item.placement
        };
        let error = match &**shape {
            Shape::Mesh(_) => 1.0,
            _ => chord_error(item.bounds(), view) / mean_scale(&placement),
        };
        if let Some(mut old) = old
            && Arc::ptr_eq(&old.shape, shape)
            && old.is_lit == is_lit
            && old.shows_error == shows_error
            && is_same(&old.lightmapped, lightmapped)
            && old.chord_error == error
        {
            old.placement = placement;
            return old;
        }
        self.next += 1;
        let made = match lightmapped {
            Some(_) => None,
            None => match display_mesh(shape, error, is_lit) {
                mesh if shows_error => Some(with_errors(mesh.into_owned())),
                Cow::Borrowed(_) => None,
                Cow::Owned(mesh) => Some(mesh),
            },
        };
        let mut entry = CachedMesh {
            id: item.id,
            shape: Arc::clone(shape),
            made,
            lightmapped: lightmapped.cloned(),
            chord_error: error,
            is_lit,
            shows_error,
            key: self.next,
            bounds: Aabb::EMPTY,
            placement,
        };
        entry.bounds = entry.mesh().bounds();
        entry
    }

    fn keep_textures(&mut self, app: &App) {
        let textures = &app.document.textures;
        (self.textures).retain(|_, (_, kept)| textures.iter().any(|t| Arc::ptr_eq(t, kept)));
        for texture in textures {
            let next = &mut self.next;
            self.textures
                .entry(Arc::as_ptr(texture))
                .or_insert_with(|| {
                    *next += 1;
                    (*next, Arc::clone(texture))
                });
        }
    }

    fn update_form_factors(&mut self, app: &App) {
        let Some(seen) = &app.lighting.form_factors else {
            self.form_factors = None;
            return;
        };
        let is_same = self.form_factors.as_ref().is_some_and(|(_, mesh, values)| {
            Arc::ptr_eq(mesh, &seen.patches) && values.len() == seen.factors.len()
        });
        if !is_same
            || self
                .form_factors
                .as_ref()
                .is_some_and(|s| s.0 != seen.number)
        {
            let values = seen.factors.iter().map(|&f| f as f32).collect();
            self.form_factors = Some((seen.number, Arc::clone(&seen.patches), values));
        }
    }

    /// The key of a texture's image.
    pub fn texture_key(&self, texture: &Arc<Texture>) -> u64 {
        let texture = self.textures.get(&Arc::as_ptr(texture));
        texture.map_or(0, |(key, _)| *key)
    }

    /// The cached objects.
    pub fn entries(&self) -> &[CachedMesh] {
        &self.entries
    }

    /// The meshes to draw, in the order of [`entries`](ViewportCache::entries); if form factors are
    /// shown, their patches replace everything else.
    pub fn drawn<'a>(&'a self, app: &'a App, shows_factors: bool) -> Vec<DrawnMesh<'a>> {
        if shows_factors && let Some((number, mesh, values)) = &self.form_factors {
            // Keys of objects count up from 1, those of patches down from the maximum.
            let mut drawn = DrawnMesh::new(u64::MAX - number, mesh);
            drawn.face_values = Some(FaceValues {
                key: *number,
                values,
            });
            return vec![drawn];
        }
        let selected: HashSet<ItemId> = app.selection.ids.iter().copied().collect();
        let one = |e| self.one(app, e, &selected);
        self.entries.iter().map(one).collect()
    }

    fn one<'a>(
        &'a self,
        app: &'a App,
        entry: &'a CachedMesh,
        selected: &HashSet<ItemId>,
    ) -> DrawnMesh<'a> {
        let faces = match &app.selection.faces {
            Some((id, faces)) if *id == entry.id => faces.as_slice(),
            _ => &[],
        };
        DrawnMesh {
            is_selected: selected.contains(&entry.id) && faces.is_empty(),
            // Selected faces are indices into the model, which mean nothing on the solver's
            // patches: there the overlay marks them.
            selected_faces: if entry.is_lit { &[] } else { faces },
            ..entry.drawn()
        }
    }
}

fn is_same(a: &Option<Arc<LightmappedMesh>>, b: Option<&Arc<LightmappedMesh>>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        (a, b) => a.is_none() && b.is_none(),
    }
}

/// The mean scale of a map.
fn mean_scale(map: &DAffine3) -> f64 {
    let scale = map.matrix3.determinant().abs().cbrt();
    if scale > 0.0 && scale.is_finite() {
        // Powers of two, so that a drag does not tessellate again in every frame.
        2f64.powi(scale.log2().round() as i32)
    } else {
        1.0
    }
}
