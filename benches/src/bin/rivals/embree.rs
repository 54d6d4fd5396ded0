//! Embree 4 through its C interface, in a library that is opened when it is asked for.

use std::ffi::{CString, c_char, c_void};
use std::ops::Range;
use std::path::Path;
use std::ptr::{null, null_mut};
use std::sync::Arc;
use std::sync::atomic::{AtomicIsize, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, ensure};
use libloading::Library;
use trisect_core::{Ray, Triangle, Vec3};

use crate::contender::{Answers, Built, Contender, Entrant, Found};

type Device = *mut c_void;
type Scene = *mut c_void;
type Geometry = *mut c_void;

/// `RTCRay` of `embree4/rtcore_ray.h`.
#[repr(C, align(16))]
#[derive(Clone, Copy)]
struct RtcRay {
    origin: [f32; 3],
    near: f32,
    direction: [f32; 3],
    time: f32,
    far: f32,
    mask: u32,
    id: u32,
    flags: u32,
}

/// `RTCRayHit`, with room for the numbers of instances, which libraries differ in.
#[repr(C, align(16))]
#[derive(Clone, Copy)]
struct RtcRayHit {
    ray: RtcRay,
    normal: [f32; 3],
    u: f32,
    v: f32,
    primitive: u32,
    geometry: u32,
    instances: [u32; 5],
}

/// Rays of a packet.
const PACKET: usize = 16;

/// `RTCRay16`.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
struct RtcRay16 {
    origin: [[f32; PACKET]; 3],
    near: [f32; PACKET],
    direction: [[f32; PACKET]; 3],
    time: [f32; PACKET],
    far: [f32; PACKET],
    mask: [u32; PACKET],
    id: [u32; PACKET],
    flags: [u32; PACKET],
}

/// `RTCRayHit16`.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
struct RtcRayHit16 {
    ray: RtcRay16,
    normal: [[f32; PACKET]; 3],
    u: [f32; PACKET],
    v: [f32; PACKET],
    primitive: [u32; PACKET],
    geometry: [u32; PACKET],
    instances: [[u32; PACKET]; 2],
}

/// Which rays of a packet take part: −1 for those. Embree reads it as a whole, so aligned.
#[repr(C, align(64))]
struct Valid([i32; PACKET]);

/// `RTCIntersectArguments` and `RTCOccludedArguments`, which are laid out alike.
#[repr(C)]
struct RtcArguments {
    flags: u32,
    features: u32,
    context: *mut c_void,
    filter: *mut c_void,
    callback: *mut c_void,
    width: f32,
}

const NO_GEOMETRY: u32 = u32::MAX;
const TRIANGLES: u32 = 0;
const BUFFER_INDEX: u32 = 0;
const BUFFER_VERTEX: u32 = 1;
const FORMAT_UINT3: u32 = 0x5003;
const FORMAT_FLOAT3: u32 = 0x9003;
const SCENE_ROBUST: u32 = 1 << 2;
const QUERY_COHERENT: u32 = 1 << 16;
const FEATURES_ALL: u32 = u32::MAX;

/// Where benches/install-embree.sh puts the library, from the root of the workspace.
const INSTALLED: &str = "target/embree/libembree4.so";

/// How thoroughly a tree is built: `RTCBuildQuality`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quality {
    Medium = 1,
    High = 2,
}

type MemoryMonitor = unsafe extern "C" fn(*mut c_void, isize, bool) -> bool;
type Query = unsafe extern "C" fn(Scene, *mut c_void, *const RtcArguments);
type Query16 = unsafe extern "C" fn(*const i32, Scene, *mut c_void, *const RtcArguments);

macro_rules! interface {
    ($($field:ident = $symbol:literal: $signature:ty;)*) => {
        /// The functions that are used.
        struct Interface {
            $($field: $signature,)*
        }

        impl Interface {
            fn open(path: &Path) -> Result<Self> {
                // SAFETY: what a library does when it is opened is its own; this one is Embree, or
                // the user named another.
                let library = unsafe { Library::new(path) }.with_context(|| {
                    format!(
                        "{}: Embree cannot be opened; run benches/install-embree.sh, or name the \
                         library with --embree",
                        path.display()
                    )
                })?;
                // Stays open, as its threads may outlive its devices.
                let library: &'static Library = Box::leak(Box::new(library));
                $(
                    // SAFETY: the signature is that of the header of Embree 4.
                    let $field = *unsafe { library.get::<$signature>($symbol) }
                        .context("the library is not Embree 4")?;
                )*
                Ok(Self { $($field,)* })
            }
        }
    };
}

interface! {
    new_device = b"rtcNewDevice\0": unsafe extern "C" fn(*const c_char) -> Device;
    release_device = b"rtcReleaseDevice\0": unsafe extern "C" fn(Device);
    device_error = b"rtcGetDeviceError\0": unsafe extern "C" fn(Device) -> u32;
    monitor_memory = b"rtcSetDeviceMemoryMonitorFunction\0":
        unsafe extern "C" fn(Device, MemoryMonitor, *mut c_void);
    new_scene = b"rtcNewScene\0": unsafe extern "C" fn(Device) -> Scene;
    release_scene = b"rtcReleaseScene\0": unsafe extern "C" fn(Scene);
    set_quality = b"rtcSetSceneBuildQuality\0": unsafe extern "C" fn(Scene, u32);
    set_flags = b"rtcSetSceneFlags\0": unsafe extern "C" fn(Scene, u32);
    commit_scene = b"rtcCommitScene\0": unsafe extern "C" fn(Scene);
    new_geometry = b"rtcNewGeometry\0": unsafe extern "C" fn(Device, u32) -> Geometry;
    new_buffer = b"rtcSetNewGeometryBuffer\0":
        unsafe extern "C" fn(Geometry, u32, u32, u32, usize, usize) -> *mut c_void;
    commit_geometry = b"rtcCommitGeometry\0": unsafe extern "C" fn(Geometry);
    attach_geometry = b"rtcAttachGeometry\0": unsafe extern "C" fn(Scene, Geometry) -> u32;
    release_geometry = b"rtcReleaseGeometry\0": unsafe extern "C" fn(Geometry);
    intersect1 = b"rtcIntersect1\0": Query;
    occluded1 = b"rtcOccluded1\0": Query;
    intersect16 = b"rtcIntersect16\0": Query16;
    occluded16 = b"rtcOccluded16\0": Query16;
}

/// Adds up what the device has.
unsafe extern "C" fn count_memory(bytes: *mut c_void, change: isize, _after: bool) -> bool {
    // SAFETY: the device was given the address of a counter that outlives it.
    let counter = unsafe { &*bytes.cast::<AtomicIsize>() };
    counter.fetch_add(change, Ordering::Relaxed);
    true
}

/// How rays are handed over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// One by one.
    Single,
    /// Sixteen at a time, said to be coherent.
    Coherent,
    /// Sixteen at a time, said to be incoherent.
    Incoherent,
}

/// A scene of one mesh.
struct Tree {
    interface: Interface,
    device: Device,
    scene: Scene,
    /// What the device has. Boxed, as the device knows where it is.
    bytes: Box<AtomicIsize>,
}

// SAFETY: Embree's objects may be used from any thread.
unsafe impl Send for Tree {}
// SAFETY: a committed scene is only read, by as many threads as like.
unsafe impl Sync for Tree {}

/// A scene and how it is asked.
struct Embree {
    tree: Arc<Tree>,
    way: Way,
    original: Vec<Ray<f32>>,
    rays: Vec<RtcRayHit>,
    packets: Vec<RtcRayHit16>,
}

/// All forms of Embree in the library at `path`, or where it is installed. It is opened when a tree is
/// built, so that a race without Embree needs none.
pub(crate) fn entrants(path: Option<&Path>) -> Vec<Entrant> {
    let installed = || Path::new(env!("CARGO_MANIFEST_DIR")).with_file_name(INSTALLED);
    let path: Arc<Path> = path.map_or_else(installed, Path::to_owned).into();
    let trees: [(&str, Quality, bool, &[Way]); 3] = [
        ("embree", Quality::High, false, &[Way::Single, Way::Coherent, Way::Incoherent]),
        ("embree robust", Quality::High, true, &[Way::Single]),
        ("embree medium", Quality::Medium, false, &[Way::Single]),
    ];
    let entrant = |(name, quality, robust, ways): (&str, Quality, bool, &'static [Way])| {
        let path = Arc::clone(&path);
        let name_of = |way: &Way| match way {
            Way::Single => name.to_owned(),
            Way::Coherent => format!("{name} packets"),
            Way::Incoherent => format!("{name} streams"),
        };
        Entrant {
            name: name.to_owned(),
            contenders: ways.iter().map(name_of).collect(),
            build: Box::new(move |triangles, threads| {
                let interface = Interface::open(&path)?;
                let (tree, time) = Tree::build(interface, triangles, threads, quality, robust)?;
                let bytes = tree.bytes();
                let tree = Arc::new(tree);
                let contender = |way: &Way| {
                    let tree = Arc::clone(&tree);
                    let (original, rays, packets) = (Vec::new(), Vec::new(), Vec::new());
                    let embree = Embree { tree, way: *way, original, rays, packets };
                    Box::new(embree) as Box<dyn Contender>
                };
                Ok(Built { contenders: ways.iter().map(contender).collect(), time, bytes })
            }),
        }
    };
    trees.into_iter().map(entrant).collect()
}

impl Tree {
    fn build(
        interface: Interface,
        triangles: &[Triangle<f32>],
        threads: usize,
        quality: Quality,
        robust: bool,
    ) -> Result<(Self, Duration)> {
        let configuration = CString::new(format!("threads={threads}"))?;
        let count = triangles.len();
        // SAFETY: calls as the interface's documentation says; buffers are filled within what was
        // asked for, and the device goes when this is dropped, before the counter.
        unsafe {
            let device = (interface.new_device)(configuration.as_ptr());
            ensure!(!device.is_null(), "Embree makes no device");
            let scene = (interface.new_scene)(device);
            let bytes = Box::new(AtomicIsize::new(0));
            let tree = Self { interface, device, scene, bytes };
            let interface = &tree.interface;
            (interface.set_quality)(scene, quality as u32);
            (interface.set_flags)(scene, if robust { SCENE_ROBUST } else { 0 });
            let geometry = (interface.new_geometry)(device, TRIANGLES);
            let vertices =
                (interface.new_buffer)(geometry, BUFFER_VERTEX, 0, FORMAT_FLOAT3, 12, 3 * count);
            let indices =
                (interface.new_buffer)(geometry, BUFFER_INDEX, 0, FORMAT_UINT3, 12, count);
            let has_room = !vertices.is_null() && !indices.is_null();
            if has_room {
                let vertices = vertices.cast::<f32>();
                let corners = triangles.iter().flat_map(|triangle| triangle.corners());
                for (at, x) in corners.flat_map(Vec3::to_array).enumerate() {
                    vertices.add(at).write(x);
                }
                for (at, number) in (0..3 * count).zip(0_u32..) {
                    indices.cast::<u32>().add(at).write(number);
                }
                (interface.commit_geometry)(geometry);
                (interface.attach_geometry)(scene, geometry);
            }
            (interface.release_geometry)(geometry);
            ensure!(has_room, "Embree has no room for the mesh");
            // Only from here on: corners and numbers are the caller's with other contenders.
            (interface.monitor_memory)(
                device,
                count_memory,
                std::ptr::from_ref(&*tree.bytes).cast_mut().cast(),
            );
            let start = Instant::now();
            (interface.commit_scene)(scene);
            let time = start.elapsed();
            let error = (interface.device_error)(device);
            ensure!(error == 0, "Embree fails with error {error}");
            Ok((tree, time))
        }
    }

    fn bytes(&self) -> Option<usize> {
        usize::try_from(self.bytes.load(Ordering::Relaxed)).ok()
    }
}

impl Embree {
    /// Whole packets that the rays are in. Rays that fill up the last one are never hit.
    fn packets(rays: Range<usize>) -> Range<usize> {
        rays.start / PACKET..rays.end.div_ceil(PACKET)
    }

    fn arguments(&self) -> RtcArguments {
        RtcArguments {
            flags: if self.way == Way::Coherent { QUERY_COHERENT } else { 0 },
            features: FEATURES_ALL,
            context: null_mut(),
            filter: null_mut(),
            callback: null_mut(),
            width: 0.0,
        }
    }

    fn run_packets(&mut self, rays: Range<usize>, query: Query16) {
        let arguments = self.arguments();
        let all = Valid([-1; PACKET]);
        let scene = self.tree.scene;
        for packet in &mut self.packets[Self::packets(rays)] {
            let packet = std::ptr::from_mut(packet).cast();
            // SAFETY: the scene is committed, and the packet and who takes part are laid out and aligned
            // as the header says.
            unsafe { query(all.0.as_ptr(), scene, packet, &raw const arguments) };
        }
    }
}

impl Drop for Tree {
    fn drop(&mut self) {
        // SAFETY: both were made by this library and are released once.
        unsafe {
            (self.interface.release_scene)(self.scene);
            (self.interface.release_device)(self.device);
        }
    }
}

fn single(ray: &Ray<f32>) -> RtcRayHit {
    RtcRayHit {
        ray: RtcRay {
            origin: ray.o.to_array(),
            near: ray.tmin,
            direction: ray.d.to_array(),
            time: 0.0,
            far: ray.tmax,
            mask: u32::MAX,
            id: 0,
            flags: 0,
        },
        normal: [0.0; 3],
        u: 0.0,
        v: 0.0,
        primitive: u32::MAX,
        geometry: NO_GEOMETRY,
        instances: [u32::MAX; 5],
    }
}

fn packet(rays: &[Ray<f32>]) -> RtcRayHit16 {
    // What fills up a packet has an empty interval.
    let ray =
        |lane: usize| rays.get(lane).copied().unwrap_or(Ray { tmin: 1.0, tmax: 0.0, ..rays[0] });
    let row = |value: fn(&Ray<f32>) -> f32| std::array::from_fn(|lane| value(&ray(lane)));
    RtcRayHit16 {
        ray: RtcRay16 {
            origin: [row(|r| r.o.x), row(|r| r.o.y), row(|r| r.o.z)],
            near: row(|r| r.tmin),
            direction: [row(|r| r.d.x), row(|r| r.d.y), row(|r| r.d.z)],
            time: [0.0; PACKET],
            far: row(|r| r.tmax),
            mask: [u32::MAX; PACKET],
            id: [0; PACKET],
            flags: [0; PACKET],
        },
        normal: [[0.0; PACKET]; 3],
        u: [0.0; PACKET],
        v: [0.0; PACKET],
        primitive: [u32::MAX; PACKET],
        geometry: [NO_GEOMETRY; PACKET],
        instances: [[u32::MAX; PACKET]; 2],
    }
}

impl Contender for Embree {
    fn load(&mut self, rays: &[Ray<f32>]) {
        self.original = rays.to_vec();
        (self.rays, self.packets) = (Vec::new(), Vec::new());
        if self.way == Way::Single {
            self.rays = rays.iter().map(single).collect();
        } else {
            self.packets = rays.chunks(PACKET).map(packet).collect();
        }
    }

    fn reset(&mut self, rays: Range<usize>) {
        if self.way == Way::Single {
            for (mine, ray) in self.rays[rays.clone()].iter_mut().zip(&self.original[rays]) {
                *mine = single(ray);
            }
        } else {
            let rays = self.original[rays.clone()].chunks(PACKET).zip(Self::packets(rays));
            for (rays, place) in rays {
                self.packets[place] = packet(rays);
            }
        }
    }

    fn closest(&mut self, rays: Range<usize>) {
        if self.way != Way::Single {
            return self.run_packets(rays, self.tree.interface.intersect16);
        }
        let (query, scene) = (self.tree.interface.intersect1, self.tree.scene);
        for ray in &mut self.rays[rays] {
            // SAFETY: the scene is committed, and the ray is laid out and aligned as the header
            // says.
            unsafe { query(scene, std::ptr::from_mut(ray).cast(), null()) };
        }
    }

    fn any(&mut self, rays: Range<usize>) {
        if self.way != Way::Single {
            return self.run_packets(rays, self.tree.interface.occluded16);
        }
        let (query, scene) = (self.tree.interface.occluded1, self.tree.scene);
        for ray in &mut self.rays[rays] {
            // SAFETY: as above; a ray without room for a hit is enough.
            unsafe { query(scene, std::ptr::from_mut(&mut ray.ray).cast(), null()) };
        }
    }

    fn answers(&self, any: bool) -> Answers {
        let places = 0..self.original.len();
        // A ray that is occluded ends at minus infinity.
        let far = |at: usize| match self.way {
            Way::Single => self.rays[at].ray.far,
            _ => self.packets[at / PACKET].ray.far[at % PACKET],
        };
        if any {
            return Answers::Any(places.map(|at| far(at) == f32::NEG_INFINITY).collect());
        }
        let triangle = |at: usize| match self.way {
            Way::Single => self.rays[at].primitive,
            _ => self.packets[at / PACKET].primitive[at % PACKET],
        };
        let found = |at: usize| {
            let triangle = triangle(at);
            (triangle != u32::MAX).then_some(Found { triangle, t: far(at) })
        };
        Answers::Closest(places.map(found).collect())
    }
}
