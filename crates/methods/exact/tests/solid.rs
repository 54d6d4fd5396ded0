//! The first triangle along a ray, and points in solids.

use std::cmp::Ordering;

use trisect_core::{Hit, Lanes, LanesVisitor, Precision, Ray, Token, Triangle, Vec3};
use trisect_exact::{Place, Stage, closest, order, point_in_solid};
use trisect_kernels::PreparedTriangles;
use trisect_oracle::{Oracle, compare_t};
use trisect_workloads::Stream;

fn lattice(stream: &mut Stream, most: f64) -> Vec3<f32> {
    [0, 1, 2].map(|_| f32::from(number(stream, most))).into()
}

#[allow(clippy::cast_possible_truncation, reason = "small whole numbers")]
fn number(stream: &mut Stream, most: f64) -> i16 {
    stream.range_f64(-most, most).round() as i16
}

struct Closest<'a> {
    ray: Ray<f32>,
    triangles: &'a [Triangle<f32>],
    expected: Option<(u32, Hit<f32>)>,
}

impl LanesVisitor for Closest<'_> {
    fn visit<L: Lanes<Elem: Precision>>(&mut self) {
        let Some(token) = L::Token::detect() else { return };
        let same = |&x: &f32| <L::Elem as trisect_core::Scalar>::from_f64(f64::from(x));
        let triangles: Vec<_> = self.triangles.iter().map(|t| t.map(same)).collect();
        let prepared = PreparedTriangles::new(&triangles).expect("it takes all meshes");
        let found = closest::<L>(token, &self.ray.map(same), &triangles, &prepared);
        let found = found.map(|(number, hit)| (number, hit.t));
        let expected = self.expected.map(|(number, hit)| (number, same(&hit.t)));
        assert_eq!(found, expected, "{:?}", self.ray);
    }
}

/// Many triangles through few points of a lattice: most first hits are shared.
#[test]
fn the_first_triangle_is_the_oracles() {
    let mut stream = Stream::new("exact/closest", 1);
    let (mut hits, mut shared) = (0, 0);
    for _ in 0..400 {
        let corner = |stream: &mut Stream| lattice(stream, 2.0);
        let mut triangles: Vec<Triangle<f32>> = (0..40)
            .map(|_| Triangle {
                a: corner(&mut stream),
                b: corner(&mut stream),
                c: corner(&mut stream),
            })
            .collect();
        // Planes that differ by less than any t can show, in front and behind in the list.
        for place in 0..40 {
            let mut bent = triangles[place];
            bent.b.x += 2.0_f32.powi(-22);
            triangles.push(bent);
        }
        triangles.rotate_left(40 * (stream.bits() & 1) as usize);
        let o = lattice(&mut stream, 8.0);
        let d = lattice(&mut stream, 2.0) - o;
        let ray = Ray::<f32>::new(o, d.map(|x| x / 3.0));
        let truth = Oracle::default().closest(&ray, &triangles);
        let expected = truth.and_then(|(place, answer)| {
            Some((u32::try_from(place).expect("few triangles"), answer.hit?))
        });
        if let Some((number, hit)) = expected {
            hits += 1;
            let alike = triangles.iter().filter(|triangle| {
                let other = Oracle::default().intersect(&ray, triangle).hit;
                other.is_some_and(|other| other.t == hit.t)
            });
            shared += usize::from(alike.count() > 1);
            assert!(number < 80);
        }
        let mut visitor = Closest { ray, triangles: &triangles, expected };
        f32::visit_native(&mut visitor);
    }
    assert!(hits > 200 && shared > 50, "{hits} hits, {shared} shared");
}

/// The order of any two planes along a ray, over the whole range of numbers.
#[test]
fn the_order_is_the_oracles() {
    let mut stream = Stream::new("exact/order", 1);
    let mut compared = [0; 3];
    for round in 0..4000 {
        let mut vector = || -> Vec3<f32> {
            [0, 1, 2]
                .map(|_| {
                    let bits = stream.bits();
                    match round % 3 {
                        0 => f32::from(number(&mut stream, 3.0)),
                        1 => f32::from_bits((bits >> 32) as u32),
                        _ => f32::from(number(&mut stream, 3.0)) * 1e-40,
                    }
                })
                .into()
        };
        let ray = Ray::<f32>::new(vector(), vector());
        let first = Triangle { a: vector(), b: vector(), c: vector() };
        let mut second = Triangle { a: vector(), b: vector(), c: vector() };
        if round % 2 == 0 {
            // Another triangle of the same plane.
            second = Triangle { a: first.b, b: first.c, c: first.a };
        }
        if let Some(expected) = compare_t(&ray, &first, &second) {
            assert_eq!(order(&ray, &first, &second), expected, "{ray:?} {first:?} {second:?}");
            let orders = [Ordering::Less, Ordering::Equal, Ordering::Greater];
            let place = orders.iter().position(|&order| order == expected);
            compared[place.expect("one of three")] += 1;
        }
    }
    assert!(compared.iter().all(|&count| count > 100), "{compared:?}");
}

/// The surface of the cube from −n to n, its faces divided into whole squares of two triangles each.
fn cube(n: i16) -> Vec<Triangle<f64>> {
    let mut surface = Vec::new();
    for axis in 0..3 {
        for side in [-n, n] {
            for x in -n..n {
                for y in -n..n {
                    let corner = |dx: i16, dy: i16| {
                        let [x, y, z] = [x + dx, y + dy, side].map(f64::from);
                        Vec3::new(x, y, z).with_axis_last(axis)
                    };
                    let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    surface.push(Triangle { a, b, c });
                    surface.push(Triangle { a, b: c, c: d });
                }
            }
        }
    }
    surface
}

/// The points whose coordinates have magnitudes with a sum of at most 6, as eight triangles.
fn octahedron() -> Vec<Triangle<f64>> {
    let tip = |axis: usize, sign: f64| {
        let mut tip = [0.0; 3];
        tip[axis] = 6.0 * sign;
        Vec3::from(tip)
    };
    let mut surface = Vec::new();
    for x in [-1.0, 1.0] {
        for y in [-1.0, 1.0] {
            for z in [-1.0, 1.0] {
                surface.push(Triangle { a: tip(0, x), b: tip(1, y), c: tip(2, z) });
            }
        }
    }
    surface
}

fn place(size: f64, limit: f64) -> Place {
    if size < limit {
        Place::Inside
    } else if size == limit {
        Place::On
    } else {
        Place::Outside
    }
}

/// Points below edges and corners, on faces, edges and corners, and anywhere.
#[test]
fn points_in_a_cube_and_in_an_octahedron() {
    let (cube, octahedron) = (cube(3), octahedron());
    for x in -9..=9 {
        for y in -9..=9 {
            for z in -9..=9 {
                let point = Vec3::from([x, y, z].map(|x: i8| f64::from(x) / 2.0));
                let [x, y, z] = point.map(f64::abs).to_array();
                let in_cube = place(x.max(y).max(z), 3.0);
                assert_eq!(point_in_solid(point, &cube), in_cube, "{point:?}");
                let point = point.scale(2.0);
                let in_octahedron = place(2.0 * (x + y + z), 6.0);
                assert_eq!(point_in_solid(point, &octahedron), in_octahedron, "{point:?}");
            }
        }
    }
}

/// The same solids where rounding is coarse: the next number decides.
#[test]
fn the_next_number_is_on_the_other_side() {
    let far = Vec3::new(1e7, -1e7, 1e7);
    let surface: Vec<Triangle<f64>> = cube(2)
        .iter()
        .map(|t| {
            let [a, b, c] = t.corners().map(|v| v + far);
            Triangle { a, b, c }
        })
        .collect();
    for (x, expected) in [
        ((1e7 + 2.0_f64).next_down(), Place::Inside),
        (1e7 + 2.0, Place::On),
        ((1e7 + 2.0_f64).next_up(), Place::Outside),
    ] {
        assert_eq!(point_in_solid(Vec3::new(x, -1e7, 1e7), &surface), expected, "{x}");
        assert_eq!(point_in_solid(Vec3::new(1e7, -1e7, x), &surface), expected, "{x}");
    }
    let inside = Vec3::new(f64::NAN, 0.0, 0.0);
    assert_eq!(point_in_solid(inside, &surface), Place::Outside);
    assert_eq!(point_in_solid(far, &[]), Place::Outside);
}

/// Each stage has its pairs: beside the triangle, inside it, nearer to an edge than f32 can tell, and on
/// an edge.
#[test]
fn each_stage_has_its_pairs() {
    let zero = Vec3::new(0.0, 0.0, 0.0);
    let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    let triangle = Triangle { a: zero, b: corner(3.0, 1.0), c: corner(1.0, 3.0) };
    let at = |x: f32, y: f32| Ray::<f32>::new(Vec3::new(x, y, -7.0), Vec3::new(0.0, 0.0, 1.0));
    assert_eq!(Stage::of(&at(-1.0, 3.0), &triangle), Stage::Miss);
    assert_eq!(Stage::of(&at(1.0, 1.0), &triangle), Stage::Filter);
    assert_eq!(Stage::of(&at(1.5, 0.5_f32.next_up()), &triangle), Stage::Double);
    assert_eq!(Stage::of(&at(1.5, 0.5), &triangle), Stage::Whole);
}
