//! A new ray type in one file: rays of heat, beside rays that see, each with what it carries and its own programs.
#![allow(missing_docs, reason = "tests")]

mod common;

use common::{add, square};
use glam::Vec3;
use trisect_core::Ray;
use trisect_method::Culling;
use trisect_pipeline::{
    Buffer, Entry, Graph, Launch, On, Place, RayType, Scene, Sphere, Traces, Verdict,
};

/// What was there: rays that see.
struct Sight;

impl RayType for Sight {
    type Payload = ();
}

/// What is new: heat that is carried to what is met, and passes through what is thin. It does not meet backs.
struct Heat;

impl RayType for Heat {
    /// How warm it is.
    type Payload = f32;
    const FACES: Culling = Culling::Back;
}

/// How much of heat a material lets through.
struct Thin(f32);

/// What an index sees, how warm that is, and how many rays of heat got away.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Felt {
    distance: f32,
    warmth: f32,
    lost: u32,
}

struct Thermometer;

impl Entry for Thermometer {
    type Material = Thin;
    type Rays = (Sight, Heat);
    type Out = Felt;
    type Append = ();

    fn generate(&self, [x, ..]: [u32; 3], on: &mut On<'_, Self>) {
        let from = Vec3::new(x as f32 * 4.0, 10.0, 0.1);
        on.send(Sight, Ray::new(from, [0.0, -1.0, 0.0]), ());
        on.send(Heat, Ray::new(from, [0.0, -1.0, 0.0]), 100.0);
    }
}

impl Traces<Sight> for Thermometer {
    fn closest_hit(&self, at: &Place<'_, Thin>, (): (), on: &mut On<'_, Self>) {
        on.out().distance = at.t();
        // Seen from below as well: whose back is there.
        on.send(Heat, Ray::new(at.point() - Vec3::Y * 20.0, [0.0, 1.0, 0.0]), 1.0);
    }
}

impl Traces<Heat> for Thermometer {
    const ANY_HIT: bool = true;
    const ONCE: bool = true;

    fn any_hit(&self, at: &Place<'_, Thin>, warmth: &mut f32) -> Verdict {
        if at.material().0 == 0.0 {
            return Verdict::Accept;
        }
        *warmth *= at.material().0;
        Verdict::Ignore
    }

    fn closest_hit(&self, _: &Place<'_, Thin>, warmth: f32, on: &mut On<'_, Self>) {
        on.out().warmth += warmth;
    }

    fn miss(&self, _: &Ray<f32>, _: f32, on: &mut On<'_, Self>) {
        on.out().lost += 1;
    }
}

fn scene() -> Scene<Thin> {
    let mut graph = Graph::new();
    let ground = graph.geometry(common::mesh(square(0.0, 6.0), trisect_pipeline::Builder::Binned));
    let thick = graph.material(Thin(0.0));
    let ground = graph.instance(ground, thick);
    let ball =
        add::<Sphere, _>(&mut graph, Sphere { center: Vec3::Y * 3.0, radius: 1.0 }, Thin(0.5));
    let root = graph.group([ground, ball]);
    graph.commit(root).expect("it is placed")
}

#[test]
fn heat_passes_what_is_thin_and_warms_what_is_not() {
    let mut felt = Buffer::line(3, Felt::default());
    let rays = scene().launch(&Thermometer, &Launch::default(), &mut felt).rays;
    // Above the ball, beside it, and beside the ground. The ball's back is not met on the way out. From below the ground
    // has its back there, the ball its front.
    let above = Felt { distance: 10.0 - 3.995, warmth: 50.0, lost: 1 };
    let seen = felt.cells()[0];
    assert!((seen.distance - above.distance).abs() < 1e-3, "{seen:?}");
    assert_eq!((seen.warmth, seen.lost), (above.warmth, above.lost));
    assert_eq!(felt.cells()[1], Felt { distance: 10.0, warmth: 100.0, lost: 1 });
    assert_eq!(felt.cells()[2], Felt { distance: 0.0, warmth: 0.0, lost: 1 });
    assert_eq!(rays, [3, 5]);
}
