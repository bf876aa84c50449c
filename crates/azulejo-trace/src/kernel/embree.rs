//! Embree 3 or 4 as the kernel for triangles, loaded at run time if it is installed.
//!
//! Wald et al., *Embree: A Kernel Framework for Efficient CPU Ray Tracing*, SIGGRAPH 2014. Hits
//! agree with those of our own kernel up to rounding, so each validates the other. Building this
//! needs nothing of Embree: its functions are found by name.
#![allow(unsafe_code, reason = "Embree is a C library")]

use super::bvh::KernelTriangle;
use super::prepared_ray::can_hit;
use super::ray::{KernelHit, KernelRay};
#[cfg(any(unix, windows))]
use libloading::Library;
use std::ffi::{OsString, c_char, c_int, c_uint, c_void};
#[cfg(not(any(unix, windows)))]
use std::io;
use std::mem::ManuallyDrop;
use std::path::{Path, PathBuf};
use std::ptr::null_mut;
use std::sync::Arc;
use std::{error, fmt};

type Pointer = *mut c_void;

/// A system that loads no libraries.
#[cfg(not(any(unix, windows)))]
#[derive(Debug)]
struct Library;

#[cfg(not(any(unix, windows)))]
impl Library {
    unsafe fn new(_: &std::ffi::OsStr) -> io::Result<Library> {
        Err(io::ErrorKind::Unsupported.into())
    }

    unsafe fn get<T>(&self, _: &str) -> io::Result<&T> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

// Constants of rtcore_common.h, rtcore_buffer.h, rtcore_geometry.h and rtcore_device.h, common to
// Embree 3 and 4.
const TRIANGLES: c_int = 0;
const INDEX_BUFFER: c_int = 0;
const VERTEX_BUFFER: c_int = 1;
const UINT3: c_int = 0x5003;
const FLOAT3: c_int = 0x9003;
const ROBUST: c_int = 1 << 2;
const VERSION: c_int = 0;
const OUT_OF_MEMORY: c_int = 4;
const NOTHING: c_uint = c_uint::MAX;

/// Names of the library, the newest first.
const NAMES: [&str; 4] = if cfg!(windows) {
    ["embree4.dll", "embree3.dll", "embree.dll", "libembree4.dll"]
} else if cfg!(target_os = "macos") {
    [
        "libembree4.4.dylib",
        "libembree4.dylib",
        "libembree3.3.dylib",
        "libembree3.dylib",
    ]
} else {
    [
        "libembree4.so.4",
        "libembree4.so",
        "libembree3.so.3",
        "libembree3.so",
    ]
};

/// Reasons why Embree is not available.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum EmbreeError {
    /// No library of these names could be loaded; what the system reported for the last one.
    Missing {
        /// The names, in the order tried.
        tried: Vec<PathBuf>,
        /// The message of the system.
        said: String,
    },
    /// A library that lacks one of Embree's functions.
    NotEmbree {
        /// The library.
        path: PathBuf,
        /// The function.
        function: &'static str,
    },
    /// Neither version 3 nor 4.
    Version {
        /// The library.
        path: PathBuf,
        /// The version that it reports, as 31305 for 3.13.5.
        version: isize,
    },
    /// Embree failed with this code of its enum `RTCError`.
    Refused {
        /// The code.
        code: i32,
    },
}

impl fmt::Display for EmbreeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EmbreeError::Missing { tried, said } => {
                let names: Vec<String> = tried.iter().map(|p| p.display().to_string()).collect();
                write!(
                    f,
                    "Embree was not found (tried {}; {said}): install it, on Debian and Ubuntu by \
                     \"apt install libembree-dev\", or give the path of its library",
                    names.join(", ")
                )
            }
            EmbreeError::NotEmbree { path, function } => write!(
                f,
                "{} is not Embree 3 or 4: it has no function {function}",
                path.display()
            ),
            EmbreeError::Version { path, version } => write!(
                f,
                "{} is Embree {}, expected version 3 or 4",
                path.display(),
                dotted(*version)
            ),
            EmbreeError::Refused {
                code: OUT_OF_MEMORY,
            } => f.write_str("Embree is out of memory"),
            EmbreeError::Refused { code } => {
                write!(f, "Embree does not run on this machine: error {code}")
            }
        }
    }
}

impl error::Error for EmbreeError {}

/// An error and what caused it.
fn reason(error: &dyn error::Error) -> String {
    match error.source() {
        Some(source) => format!("{error}: {}", reason(source)),
        None => error.to_string(),
    }
}

/// Formats 31305 as 3.13.5.
fn dotted(version: isize) -> String {
    format!(
        "{}.{}.{}",
        version / 10_000,
        version / 100 % 100,
        version % 100
    )
}

/// A loaded Embree library. Copies share it.
#[derive(Clone, Debug)]
pub struct Embree(Arc<Device>);

impl PartialEq for Embree {
    /// Copies of the same instance are equal.
    fn eq(&self, other: &Embree) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// The library, its functions, and a device.
#[derive(Debug)]
struct Device {
    functions: Functions,
    device: Pointer,
    version: isize,
    /// Never unloaded: threads that Embree started may outlive all known handles.
    _library: ManuallyDrop<Library>,
}

// SAFETY: Embree's devices may be used from any thread, by several at once (its API reference,
// "rtcNewDevice" and "Thread safety"), and the other fields are constant.
unsafe impl Send for Device {}
// SAFETY: as above.
unsafe impl Sync for Device {}

type Query = unsafe extern "C" fn(Pointer, Pointer, Pointer);

macro_rules! functions {
    ($($field:ident = $name:literal: fn($($a:ty),*) $(-> $r:ty)?;)*) => {
        /// The functions of the library that are used.
        #[derive(Debug)]
        struct Functions {
            $($field: unsafe extern "C" fn($($a),*) $(-> $r)?,)*
        }

        impl Functions {
            /// Looks up the functions of a library; the error is the name of a missing one.
            ///
            /// # Safety
            /// If the library has functions with all of these names, they must be Embree's.
            unsafe fn of(library: &Library) -> Result<Functions, &'static str> {
                Ok(Functions {
                    // SAFETY: the caller's promise.
                    $($field: unsafe { *library.get($name).map_err(|_| $name)? },)*
                })
            }
        }
    };
}

// As declared in rtcore.h. The queries take (scene, context, ray) in Embree 3 and (scene, ray,
// arguments) in 4.
functions! {
    new_device = "rtcNewDevice": fn(*const c_char) -> Pointer;
    release_device = "rtcReleaseDevice": fn(Pointer);
    property = "rtcGetDeviceProperty": fn(Pointer, c_int) -> isize;
    error = "rtcGetDeviceError": fn(Pointer) -> c_int;
    new_scene = "rtcNewScene": fn(Pointer) -> Pointer;
    release_scene = "rtcReleaseScene": fn(Pointer);
    set_flags = "rtcSetSceneFlags": fn(Pointer, c_int);
    commit_scene = "rtcCommitScene": fn(Pointer);
    new_geometry = "rtcNewGeometry": fn(Pointer, c_int) -> Pointer;
    release_geometry = "rtcReleaseGeometry": fn(Pointer);
    new_buffer = "rtcSetNewGeometryBuffer":
        fn(Pointer, c_int, c_uint, c_int, usize, usize) -> Pointer;
    commit_geometry = "rtcCommitGeometry": fn(Pointer);
    attach = "rtcAttachGeometry": fn(Pointer, Pointer) -> c_uint;
    intersect = "rtcIntersect1": fn(Pointer, Pointer, Pointer);
    occluded = "rtcOccluded1": fn(Pointer, Pointer, Pointer);
}

impl Embree {
    /// Loads the library at `path`, or else the one that the system finds under Embree's usual
    /// names. Loading runs its code: the path must be trusted.
    ///
    /// # Errors
    /// [`EmbreeError`], with what to do.
    pub fn load(path: Option<&Path>) -> Result<Embree, EmbreeError> {
        let names: Vec<OsString> = match path {
            Some(path) => vec![path.into()],
            None => NAMES.map(OsString::from).to_vec(),
        };
        let mut message = String::new();
        for name in &names {
            // SAFETY: the caller trusts the library's initializers.
            match unsafe { Library::new(name.as_os_str()) } {
                Ok(library) => return Embree::of(library, Path::new(name)),
                Err(error) => message = reason(&error),
            }
        }
        Err(EmbreeError::Missing {
            tried: names.into_iter().map(PathBuf::from).collect(),
            said: message,
        })
    }

    fn of(library: Library, path: &Path) -> Result<Embree, EmbreeError> {
        let library = ManuallyDrop::new(library);
        // SAFETY: only Embree has functions of these names.
        let functions = unsafe { Functions::of(&library) };
        let functions = functions.map_err(|function| EmbreeError::NotEmbree {
            path: path.to_owned(),
            function,
        })?;
        // With several threads Embree's trees vary from run to run, and so do its hits where a ray
        // hits two triangles at once. SAFETY: the configuration is a C string; the device is
        // checked before it is used.
        let device = unsafe { (functions.new_device)(c"threads=1".as_ptr()) };
        if device.is_null() {
            // SAFETY: a null device stands for errors of `rtcNewDevice` itself.
            let code = unsafe { (functions.error)(null_mut()) };
            return Err(EmbreeError::Refused { code });
        }
        // SAFETY: the device was just made.
        let version = unsafe { (functions.property)(device, VERSION) };
        let embree_device = Device {
            functions,
            device,
            version,
            _library: library,
        };
        match version / 10_000 {
            3 | 4 => Ok(Embree(Arc::new(embree_device))),
            _ => Err(EmbreeError::Version {
                path: path.to_owned(),
                version,
            }),
        }
    }

    /// Its version, as `3.13.5`.
    pub fn version(&self) -> String {
        dotted(self.0.version)
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: made by `of`, released once; scenes hold on to their device.
        unsafe { (self.functions.release_device)(self.device) }
    }
}

/// Triangles in Embree, ready for rays. Immutable; its queries may run on any thread.
#[derive(Debug)]
pub struct EmbreeScene {
    scene: Pointer,
    embree: Embree,
    /// Number of each triangle in hits.
    items: Vec<u32>,
}

// SAFETY: a committed scene is only read, and Embree's queries of it may run in parallel.
unsafe impl Send for EmbreeScene {}
// SAFETY: as above.
unsafe impl Sync for EmbreeScene {}

impl EmbreeScene {
    /// Builds a tree of medium quality over `count` triangles; `triangle` returns the corners of
    /// each and the item number of its hits. `is_robust` requests watertight edges.
    ///
    /// # Errors
    /// [`EmbreeError::Refused`] if there is not enough memory.
    pub fn new(
        embree: &Embree,
        count: usize,
        triangle: impl Fn(usize) -> ([[f32; 3]; 3], u32),
        is_robust: bool,
    ) -> Result<EmbreeScene, EmbreeError> {
        let Device {
            functions, device, ..
        } = &*embree.0;
        let device = *device;
        let corners = u32::try_from(3 * count).map_err(|_| EmbreeError::Refused {
            code: OUT_OF_MEMORY,
        })?;
        // SAFETY: all pointers come from Embree, which refuses null; buffers have the requested
        // size and are written completely before they are committed.
        let scene = unsafe {
            let scene = (functions.new_scene)(device);
            (functions.set_flags)(scene, if is_robust { ROBUST } else { 0 });
            if count > 0 {
                let geometry = (functions.new_geometry)(device, TRIANGLES);
                let new_buffer = functions.new_buffer;
                let vertices = new_buffer(geometry, VERTEX_BUFFER, 0, FLOAT3, 12, 3 * count);
                let indices = new_buffer(geometry, INDEX_BUFFER, 0, UINT3, 12, count);
                if !vertices.is_null() && !indices.is_null() {
                    let vertices = vertices.cast::<[[f32; 3]; 3]>();
                    (0..count).for_each(|k| vertices.add(k).write(triangle(k).0));
                    let indices = indices.cast::<u32>();
                    (0..corners).for_each(|k| indices.add(k as usize).write(k));
                    (functions.commit_geometry)(geometry);
                    (functions.attach)(scene, geometry);
                }
                (functions.release_geometry)(geometry);
            }
            (functions.commit_scene)(scene);
            scene
        };
        let built = EmbreeScene {
            scene,
            embree: embree.clone(),
            items: (0..count).map(|k| triangle(k).1).collect(),
        };
        // SAFETY: the device lives as long as `embree`. It reports the first failure.
        match unsafe { (functions.error)(device) } {
            0 => Ok(built),
            code => Err(EmbreeError::Refused { code }),
        }
    }

    /// The triangles of a tracer.
    pub(crate) fn of(
        embree: &Embree,
        triangles: &[KernelTriangle],
    ) -> Result<EmbreeScene, EmbreeError> {
        let triangle = |k: usize| (triangles[k].corners, triangles[k].item);
        EmbreeScene::new(embree, triangles.len(), triangle, true)
    }

    /// The library that holds it.
    pub fn embree(&self) -> &Embree {
        &self.embree
    }

    /// The first hit of each ray; `hits` is as long as `rays`.
    pub fn closest(&self, rays: &[KernelRay], hits: &mut [KernelHit]) {
        let query = EmbreeQuery::new(self, self.embree.0.functions.intersect);
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = query.trace(ray).map_or(KernelHit::NOTHING, |record| {
                match self.items.get(record.primitive as usize) {
                    Some(&item) if record.geometry != NOTHING => {
                        KernelHit::on_surface(record.t_far, item, record.uv)
                    }
                    _ => KernelHit::NOTHING,
                }
            });
        }
    }

    /// Whether each ray hits anything; `blocked` is as long as `rays`.
    pub fn any(&self, rays: &[KernelRay], blocked: &mut [bool]) {
        let query = EmbreeQuery::new(self, self.embree.0.functions.occluded);
        for (ray, blocked) in rays.iter().zip(blocked) {
            // For a blocked ray Embree sets `tfar` to −∞.
            *blocked = query.trace(ray).is_some_and(|record| record.t_far < 0.0);
        }
    }
}

impl Drop for EmbreeScene {
    fn drop(&mut self) {
        if !self.scene.is_null() {
            // SAFETY: made by `new`, released once.
            unsafe { (self.embree.0.functions.release_scene)(self.scene) }
        }
    }
}

/// `RTCRayHit`, with room for the additional instance IDs of builds with more levels of instances.
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
    instances: [c_uint; 17],
}

/// `RTCIntersectContext` of Embree 3, incoherent. Builds with more levels of instances store their
/// number, 0, before the instance IDs, which are not read here.
#[repr(C)]
struct Context {
    flags: c_int,
    filter: Pointer,
    level: c_uint,
    rest: [c_uint; 17],
}

/// Traces rays by one of Embree's two functions.
struct EmbreeQuery {
    scene: Pointer,
    query: Query,
    takes_context: bool,
}

impl EmbreeQuery {
    fn new(scene: &EmbreeScene, query: Query) -> EmbreeQuery {
        EmbreeQuery {
            scene: scene.scene,
            query,
            takes_context: scene.embree.0.version / 10_000 == 3,
        }
    }

    /// `None` for a ray that cannot hit anything, which must not be passed to Embree.
    #[inline]
    fn trace(&self, ray: &KernelRay) -> Option<RayHit> {
        if !can_hit(ray) {
            return None;
        }
        let mut at = RayHit {
            origin: ray.origin,
            t_near: ray.t_min.max(0.0),
            direction: ray.direction,
            time: 0.0,
            t_far: ray.t_max.next_down(),
            mask: NOTHING,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            uv: [0.0; 2],
            primitive: NOTHING,
            geometry: NOTHING,
            instances: [NOTHING; 17],
        };
        let ray_hit = (&raw mut at).cast();
        // SAFETY: the scene is committed; `at` begins as RTCRayHit does, which begins as RTCRay
        // does, and is aligned as they must be; Embree 4 takes no arguments for null.
        unsafe {
            if self.takes_context {
                let mut context = Context {
                    flags: 0,
                    filter: null_mut(),
                    level: 0,
                    rest: [NOTHING; 17],
                };
                (self.query)(self.scene, (&raw mut context).cast(), ray_hit);
            } else {
                (self.query)(self.scene, ray_hit, null_mut());
            }
        }
        Some(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_embree_is_refused() {
        let missing = Path::new("/nowhere/libembree4.so");
        let error = Embree::load(Some(missing)).expect_err("nothing is there");
        let words = error.to_string();
        assert!(matches!(&error, EmbreeError::Missing { tried, .. } if tried == &[missing]));
        assert!(
            words.contains("/nowhere/libembree4.so") && words.contains("apt install"),
            "{words}"
        );
        if cfg!(target_os = "linux") {
            let error = Embree::load(Some(Path::new("libc.so.6"))).expect_err("a C library");
            assert!(matches!(error, EmbreeError::NotEmbree { .. }), "{error}");
        }
    }
}
