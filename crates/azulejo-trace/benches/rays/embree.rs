//! Embree 3 or 4, loaded at run time if the machine has it: the yardstick.
#![allow(unsafe_code, reason = "the yardstick is a C library")]

use azulejo_trace::{KernelHit, KernelRay};
use libloading::Library;
use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::ptr::null_mut;
use std::sync::OnceLock;

type Pointer = *mut c_void;

const TRIANGLES: c_int = 0;
const INDEX_BUFFER: c_int = 0;
const VERTEX_BUFFER: c_int = 1;
const UINT3: c_int = 0x5003;
const FLOAT3: c_int = 0x9003;
const ROBUST: c_int = 1 << 2;
const NOTHING: c_uint = c_uint::MAX;

#[repr(C, align(16))]
#[derive(Clone, Copy)]
struct RayHit {
    origin: [f32; 3],
    t_near: f32,
    direction: [f32; 3],
    time: f32,
    t_far: f32,
    mask: c_uint,
    id: c_uint,
    flags: c_uint,
    normal: [f32; 3],
    uv: [f32; 2],
    primitive: c_uint,
    geometry: c_uint,
    instance: c_uint,
}

/// `RTCIntersectContext` of Embree 3, incoherent.
#[repr(C)]
struct Context {
    flags: c_int,
    filter: Pointer,
    instance: c_uint,
    width_factor: f32,
}

type Query = unsafe extern "C" fn(Pointer, Pointer, Pointer);

/// One scene in Embree.
pub struct Embree {
    scene: Pointer,
    device: Pointer,
    intersect: Query,
    occluded: Query,
    release_scene: unsafe extern "C" fn(Pointer),
    release_device: unsafe extern "C" fn(Pointer),
    major: u32,
}

/// The library and its major version. It is never unloaded: its threads outlive its scenes.
fn library() -> Option<&'static (Library, u32)> {
    static LIBRARY: OnceLock<Option<(Library, u32)>> = OnceLock::new();
    let names = [
        ("libembree4.so.4", 4),
        ("libembree4.so", 4),
        ("libembree3.so.3", 3),
    ];
    let open = |(name, major)| {
        // SAFETY: Embree has no initialisers that could harm.
        unsafe { Library::new(name) }.ok().map(|l| (l, major))
    };
    LIBRARY
        .get_or_init(|| names.into_iter().find_map(open))
        .as_ref()
}

impl Embree {
    /// Which major version this machine has.
    pub fn version() -> Option<u32> {
        library().map(|&(_, major)| major)
    }

    /// Builds a scene of medium quality on one thread; `built` is called around the build alone.
    pub fn new(
        vertices: &[[f32; 3]],
        triangles: &[[u32; 3]],
        robust: bool,
        time: impl FnOnce(&mut dyn FnMut()) -> f64,
    ) -> Option<(Embree, f64)> {
        let &(ref library, major) = library()?;
        // SAFETY: the names and signatures are those of rtcore.h, the same in Embree 3 and 4
        // but for the order of two arguments of the queries; buffers are as long as asked for.
        unsafe {
            macro_rules! function {
                ($name:literal, fn($($a:ty),*) $(-> $r:ty)?) => {
                    *library.get::<unsafe extern "C" fn($($a),*) $(-> $r)?>($name).ok()?
                };
            }
            let new_device = function!(b"rtcNewDevice", fn(*const c_char) -> Pointer);
            let new_scene = function!(b"rtcNewScene", fn(Pointer) -> Pointer);
            let set_flags = function!(b"rtcSetSceneFlags", fn(Pointer, c_int));
            let new_geometry = function!(b"rtcNewGeometry", fn(Pointer, c_int) -> Pointer);
            let new_buffer = function!(
                b"rtcSetNewGeometryBuffer",
                fn(Pointer, c_int, c_uint, c_int, usize, usize) -> Pointer
            );
            let commit_geometry = function!(b"rtcCommitGeometry", fn(Pointer));
            let attach = function!(b"rtcAttachGeometry", fn(Pointer, Pointer) -> c_uint);
            let release_geometry = function!(b"rtcReleaseGeometry", fn(Pointer));
            let commit_scene = function!(b"rtcCommitScene", fn(Pointer));
            let config = CString::new("threads=1").ok()?;
            let device = new_device(config.as_ptr());
            let scene = new_scene(device);
            if robust {
                set_flags(scene, ROBUST);
            }
            let geometry = new_geometry(device, TRIANGLES);
            let to = new_buffer(geometry, VERTEX_BUFFER, 0, FLOAT3, 12, vertices.len());
            to.cast::<[f32; 3]>()
                .copy_from_nonoverlapping(vertices.as_ptr(), vertices.len());
            let to = new_buffer(geometry, INDEX_BUFFER, 0, UINT3, 12, triangles.len());
            to.cast::<[u32; 3]>()
                .copy_from_nonoverlapping(triangles.as_ptr(), triangles.len());
            commit_geometry(geometry);
            attach(scene, geometry);
            release_geometry(geometry);
            let seconds = time(&mut || commit_scene(scene));
            let embree = Embree {
                scene,
                device,
                intersect: function!(b"rtcIntersect1", fn(Pointer, Pointer, Pointer)),
                occluded: function!(b"rtcOccluded1", fn(Pointer, Pointer, Pointer)),
                release_scene: function!(b"rtcReleaseScene", fn(Pointer)),
                release_device: function!(b"rtcReleaseDevice", fn(Pointer)),
                major,
            };
            Some((embree, seconds))
        }
    }

    /// First meeting of each ray, one call per ray.
    pub fn closest(&self, rays: &[KernelRay], hits: &mut Vec<KernelHit>) {
        hits.clear();
        hits.extend(rays.iter().map(|ray| {
            let found = self.ask(self.intersect, ray);
            KernelHit {
                t: found.t_far,
                item: if found.geometry == NOTHING {
                    KernelHit::MISS
                } else {
                    found.primitive
                },
                u: found.uv[0],
                v: found.uv[1],
            }
        }));
    }

    /// Whether each ray meets anything, one call per ray.
    pub fn any(&self, rays: &[KernelRay], blocked: &mut Vec<bool>) {
        blocked.clear();
        blocked.extend(
            rays.iter()
                .map(|ray| self.ask(self.occluded, ray).t_far < 0.0),
        );
    }

    #[inline]
    fn ask(&self, query: Query, ray: &KernelRay) -> RayHit {
        let mut at = RayHit {
            origin: ray.origin,
            t_near: ray.t_min,
            direction: ray.direction,
            time: 0.0,
            t_far: ray.t_max,
            mask: NOTHING,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            uv: [0.0; 2],
            primitive: NOTHING,
            geometry: NOTHING,
            instance: NOTHING,
        };
        let ray_hit = (&raw mut at).cast();
        let mut context = Context {
            flags: 0,
            filter: null_mut(),
            instance: NOTHING,
            width_factor: 0.0,
        };
        // SAFETY: `at` is laid out as RTCRayHit, which begins as RTCRay does; Embree 4 takes no
        // arguments for null.
        unsafe {
            if self.major == 3 {
                query(self.scene, (&raw mut context).cast(), ray_hit);
            } else {
                query(self.scene, ray_hit, null_mut());
            }
        }
        at
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: both were made by `new` and are released once.
        unsafe {
            (self.release_scene)(self.scene);
            (self.release_device)(self.device);
        }
    }
}
