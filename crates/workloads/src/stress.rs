//! Pairs of a ray and a triangle that are hard in one way, with a knob for how hard.
//!
//! The same random numbers are drawn at every level of a family, so that levels differ in their
//! difficulty alone. Pairs are made in f64 with operations that every machine rounds alike, and
//! rounded to the precision under test: corners first, then the origin, then the direction, which is
//! aimed from the rounded origin at a point of the rounded triangle.

use trisect_core::{Float, Ray, Scalar, Triangle, Vec3};

use crate::stream::Stream;

/// A ray and a triangle that are tested against each other.
pub type Pair<E> = (Ray<E>, Triangle<E>);

/// What makes the pairs hard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stress {
    /// Flat triangles: the third corner near the middle of the longest edge.
    Sliver,
    /// Two long edges and a short one.
    Needle,
    /// A right angle between a long and a short edge.
    MixedScale,
    /// Three corners on a line but for some units in the last place.
    NearCollinear,
    /// Rays at a small angle to the plane.
    Grazing,
    /// Origins far from the triangle.
    FarOrigin,
    /// Ray and triangle far from the origin of the world.
    FarMesh,
    /// Scenes tiny and huge, with directions of length 1.
    Scale,
    /// Directions short and long.
    DirectionLength,
    /// Scenes so small that few bits are left.
    Subnormal,
    /// Rays aimed beside an edge.
    NearEdge,
    /// Rays aimed beside a corner.
    NearVertex,
    /// Intervals that end near the hit.
    IntervalEnd,
    /// Origins near the plane, the interval beginning at 0.
    OriginNearPlane,
    /// Directions along axes, coordinates that are zero, of both signs, and corners on a lattice.
    AxisAligned,
    /// Any bits at all.
    RandomBits,
}

impl Stress {
    /// All families.
    pub const ALL: [Self; 16] = [
        Self::Sliver,
        Self::Needle,
        Self::MixedScale,
        Self::NearCollinear,
        Self::Grazing,
        Self::FarOrigin,
        Self::FarMesh,
        Self::Scale,
        Self::DirectionLength,
        Self::Subnormal,
        Self::NearEdge,
        Self::NearVertex,
        Self::IntervalEnd,
        Self::OriginNearPlane,
        Self::AxisAligned,
        Self::RandomBits,
    ];

    /// The name used in records and tables.
    pub const fn name(self) -> &'static str {
        self.facts().0
    }

    /// What the level is, with its unit.
    pub const fn knob(self) -> &'static str {
        self.facts().1
    }

    /// One sentence for a reader.
    pub const fn description(self) -> &'static str {
        self.facts().2
    }

    const fn facts(self) -> (&'static str, &'static str, &'static str) {
        match self {
            Self::Sliver => (
                "sliver",
                "longest edge over height",
                "flat triangles, the third corner above the longest edge",
            ),
            Self::Needle => {
                ("needle", "long edges over the short one", "triangles with one short edge")
            }
            Self::MixedScale => (
                "mixed-scale",
                "long leg over short leg",
                "right triangles with a long and a short leg",
            ),
            Self::NearCollinear => (
                "near-collinear",
                "units in the last place off the line",
                "corners on a line but for some units in the last place",
            ),
            Self::Grazing => (
                "grazing",
                "tangent of the angle to the plane",
                "rays nearly parallel to the plane",
            ),
            Self::FarOrigin => {
                ("far-origin", "distance over size", "rays that start far from the triangle")
            }
            Self::FarMesh => {
                ("far-mesh", "offset over size", "ray and triangle far from the world's origin")
            }
            Self::Scale => ("scale", "size", "everything tiny or huge, directions of length 1"),
            Self::DirectionLength => {
                ("direction-length", "length", "directions that are short or long")
            }
            Self::Subnormal => (
                "subnormal",
                "bits left of the largest coordinate",
                "everything so small that numbers lose bits",
            ),
            Self::NearEdge => (
                "near-edge",
                "distance from the edge over height",
                "rays aimed at both sides of an edge",
            ),
            Self::NearVertex => {
                ("near-vertex", "distance from the corner over size", "rays aimed around a corner")
            }
            Self::IntervalEnd => (
                "interval-end",
                "units in the last place of t",
                "intervals that end just before or behind the hit",
            ),
            Self::OriginNearPlane => (
                "origin-near-plane",
                "height over size",
                "rays that start just before or behind the plane, within the triangle",
            ),
            Self::AxisAligned => (
                "axis-aligned",
                "zeros among the coordinates of the direction",
                "directions with zeros of both signs, corners on a lattice",
            ),
            Self::RandomBits => ("random-bits", "none", "random bits for numbers"),
        }
    }

    /// The levels of difficulty, easiest first, for precision `E`: f64 goes on where f32 ends.
    pub fn levels<E: Float>(self) -> Vec<f64> {
        let wide = E::SIGNIFICANT_BITS > 24;
        let decades = |exponents: &[i32]| exponents.iter().map(|&e| power_of_ten(e)).collect();
        match self {
            Self::Sliver | Self::Needle | Self::MixedScale | Self::FarOrigin => {
                decades(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 12])
            }
            Self::FarMesh => decades(&[0, 1, 2, 3, 4, 5, 6, 7, 8]),
            Self::Grazing | Self::OriginNearPlane => {
                decades(&[0, -1, -2, -3, -4, -5, -6, -7, -8, -10, -12])
            }
            Self::Scale if wide => {
                decades(&[0, -60, -90, -100, -120, -150, -200, -300, 60, 100, 120, 150, 240])
            }
            Self::Scale => decades(&[
                0, -6, -8, -10, -12, -14, -16, -20, -24, -30, -36, -40, 6, 9, 12, 15, 18, 20, 25,
                30,
            ]),
            Self::DirectionLength => decades(&[0, -4, -8, -12, -16, -20, 4, 8, 12, 16, 20]),
            Self::Subnormal if wide => vec![53.0, 40.0, 28.0, 20.0, 12.0, 8.0, 4.0, 2.0],
            Self::Subnormal => vec![24.0, 20.0, 16.0, 12.0, 8.0, 4.0, 2.0],
            Self::NearEdge | Self::NearVertex => {
                let mut levels: Vec<f64> =
                    decades(&[-1, -2, -3, -4, -5, -6, -7, -8, -10, -12, -14, -16]);
                levels.push(0.0);
                levels
            }
            Self::NearCollinear | Self::IntervalEnd => {
                let mut levels: Vec<f64> =
                    [20, 16, 12, 10, 8, 6, 4, 3, 2, 1, 0].map(|k| f64::from(1_u32 << k)).to_vec();
                levels.push(0.0);
                levels
            }
            Self::AxisAligned => vec![0.0, 1.0, 2.0],
            Self::RandomBits => vec![0.0],
        }
    }

    /// `count` pairs at a level.
    pub fn pairs<E: Float>(self, seed: u64, level: f64, count: usize) -> Vec<Pair<E>> {
        let mut stream = Stream::new(&format!("stress/{}", self.name()), seed);
        (0..count).map(|_| self.pair(&mut stream, level)).collect()
    }

    fn pair<E: Float>(self, stream: &mut Stream, level: f64) -> Pair<E> {
        match self {
            Self::AxisAligned => return on_a_lattice(stream, level),
            Self::RandomBits => return random_bits(stream),
            _ => {}
        }
        let base = Base::draw(stream);
        let scale = match self {
            Self::Scale => level,
            // The largest coordinate is near 2; the smallest normal number has all its bits.
            Self::Subnormal => {
                E::smallest_det().to_f64()
                    * 0.5
                    * power_of_two(level - f64::from(E::SIGNIFICANT_BITS))
            }
            _ => 1.0,
        };
        let offset = match self {
            Self::FarMesh => base.away.scale(level),
            _ => base.away.scale(0.5),
        };
        let short = 1.0 / level;
        let flat = match self {
            Self::Sliver => [[0.0, 0.0], [1.0, 0.0], [base.middle, short]],
            Self::Needle => [[0.0, 0.0], [1.0, -0.5 * short], [1.0, 0.5 * short]],
            Self::MixedScale => [[0.0, 0.0], [1.0, 0.0], [0.0, short]],
            Self::NearCollinear => [[0.0, 0.0], [1.0, 0.0], [base.middle, 0.0]],
            _ => base.flat,
        };
        let [u, v, n] = base.frame;
        let mut corners =
            flat.map(|[x, y]| (u.mul_add(x, v.mul_add(y, offset))).scale(scale).map(E::from_f64));
        if self == Self::NearCollinear {
            bend(&mut corners[2], &base, level);
        }
        base.shuffle(&mut corners);
        let [a, b, c] = corners;
        let triangle = Triangle { a, b, c };

        let point = self.target(&base, level, corners.map(|corner| corner.map(Scalar::to_f64)));
        // From the point back to the origin, in units of the scene.
        let back = match self {
            Self::Grazing => base.along().mul_add(base.distance, n.scale(base.distance * level)),
            Self::FarOrigin => base.slanted().scale(base.distance * level),
            Self::OriginNearPlane => {
                let height = level * if base.flip { -1.0 } else { 1.0 };
                let slanted = base.slanted();
                slanted.scale(height / slanted.dot(n))
            }
            _ => base.slanted().scale(base.distance),
        };
        let o = back.mul_add(scale, point).map(E::from_f64);
        let towards = if self == Self::OriginNearPlane {
            // The origin may be the point itself.
            -base.slanted()
        } else {
            point - o.map(Scalar::to_f64)
        };
        let length = match self {
            Self::Scale | Self::Subnormal => 1.0,
            Self::DirectionLength => level,
            _ => base.length,
        };
        // By the largest coordinate first, so that no square under- or overflows.
        let largest = towards.map(f64::abs).to_array()[towards.largest_axis()];
        let towards = towards.map(|x| if largest > 0.0 { x / largest } else { x });
        let reach = towards.dot(towards).sqrt().max(1.0);
        let d = towards.map(|x| E::from_f64(x * (length / reach)));
        let ray = Ray::<E>::new(o, d);
        if self == Self::IntervalEnd {
            return (ends_near(&ray, &triangle, &base, level), triangle);
        }
        (ray, triangle)
    }

    /// The point of the plane that the ray is aimed at.
    fn target(self, base: &Base, level: f64, [a, b, c]: [Vec3<f64>; 3]) -> Vec3<f64> {
        let side = if base.flip { -level } else { level };
        let [beta, gamma] = match self {
            // Along the edge, beside it.
            Self::NearEdge => [base.middle, side],
            Self::NearVertex => [side, if base.flop { -level } else { level }],
            // Three of four inside.
            _ if base.aside => base.outside,
            _ => base.inside,
        };
        (b - a).mul_add(beta, (c - a).mul_add(gamma, a))
    }
}

/// The random numbers of a pair, whatever the family and the level.
struct Base {
    /// Unit vectors at right angles; the third is the normal.
    frame: [Vec3<f64>; 3],
    /// Corners in the plane, at least 30 degrees at each, and edges of 1/2 to 2.
    flat: [[f64; 2]; 3],
    away: Vec3<f64>,
    inside: [f64; 2],
    outside: [f64; 2],
    aside: bool,
    flip: bool,
    flop: bool,
    /// In [1/4, 3/4).
    middle: f64,
    /// In [1/2, 2).
    distance: f64,
    length: f64,
    slope: [f64; 2],
    order: usize,
}

impl Base {
    fn draw(stream: &mut Stream) -> Self {
        let n = stream.sphere_f64();
        let u = loop {
            let across = n.cross(stream.sphere_f64());
            let squared = across.dot(across);
            if squared > 0.25 {
                break across.scale(1.0 / squared.sqrt());
            }
        };
        let corner =
            |stream: &mut Stream| [stream.range_f64(-1.0, 1.0), stream.range_f64(-1.0, 1.0)];
        let flat = loop {
            let corners = [corner(stream), corner(stream), corner(stream)];
            if is_well_shaped(&corners) {
                break corners;
            }
        };
        let inside = {
            let (x, y) = (stream.unit_f64(), stream.unit_f64());
            if x + y < 1.0 { [x, y] } else { [1.0 - x, 1.0 - y] }
        };
        let outside = loop {
            let [x, y] = [stream.range_f64(-1.0, 2.0), stream.range_f64(-1.0, 2.0)];
            if x < 0.0 || y < 0.0 || x + y > 1.0 {
                break [x, y];
            }
        };
        let away = stream.sphere_f64();
        let mut bit = || stream.unit_f64() < 0.5;
        let (flip, flop, quarter) = (bit(), bit(), [bit(), bit()]);
        Self {
            frame: [u, n.cross(u), n],
            flat,
            away,
            inside,
            outside,
            aside: quarter == [true, true],
            flip,
            flop,
            middle: stream.range_f64(0.25, 0.75),
            distance: stream.range_f64(0.5, 2.0),
            length: stream.range_f64(0.5, 2.0),
            slope: [stream.range_f64(-1.0, 1.0), stream.range_f64(-1.0, 1.0)],
            order: stream.below(6),
        }
    }

    /// A unit vector in the plane.
    fn along(&self) -> Vec3<f64> {
        let [u, v, _] = self.frame;
        // The slopes are rarely both near zero, and then any direction in the plane serves.
        let d = u.mul_add(self.slope[0] + 1.5, v.scale(self.slope[1]));
        d.scale(1.0 / d.dot(d).sqrt())
    }

    /// A unit vector at 35 degrees or more to the plane, from the side of `flop`.
    fn slanted(&self) -> Vec3<f64> {
        let [u, v, n] = self.frame;
        let n = if self.flop { -n } else { n };
        let d = u.mul_add(self.slope[0], v.mul_add(self.slope[1], n));
        d.scale(1.0 / d.dot(d).sqrt())
    }

    /// The corners in one of their six orders: a corner is as likely `A` as `B` or `C`.
    fn shuffle<T: Copy>(&self, corners: &mut [T; 3]) {
        corners.rotate_left(self.order % 3);
        if self.order >= 3 {
            corners.swap(1, 2);
        }
    }
}

fn is_well_shaped([a, b, c]: &[[f64; 2]; 3]) -> bool {
    let edge = |p: &[f64; 2], q: &[f64; 2]| [q[0] - p[0], q[1] - p[1]];
    let squared = |e: [f64; 2]| e[0] * e[0] + e[1] * e[1];
    let edges = [edge(a, b), edge(b, c), edge(c, a)];
    let area = (edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0]).abs();
    let pairs = [(0, 1), (1, 2), (2, 0)];
    edges.iter().all(|&e| (0.25..=4.0).contains(&squared(e)))
        && pairs.iter().all(|&(i, j)| area * area > 0.25 * squared(edges[i]) * squared(edges[j]))
}

/// Moves one coordinate of a corner by that many units in the last place.
fn bend<E: Float>(corner: &mut Vec3<E>, base: &Base, units: f64) {
    let units = if base.flip { -units } else { units };
    let place = match base.order % 3 {
        0 => &mut corner.x,
        1 => &mut corner.y,
        _ => &mut corner.z,
    };
    *place = moved(*place, units);
}

/// The number that many representable numbers farther from zero.
#[allow(clippy::cast_possible_truncation, reason = "small whole numbers")]
fn moved<E: Float>(x: E, units: f64) -> E {
    E::from_bits64(x.bits64().wrapping_add_signed(units as i64))
}

/// The ray with an interval whose one end is that many units in the last place from `t`, on either
/// side of it.
fn ends_near<E: Float>(ray: &Ray<E>, triangle: &Triangle<E>, base: &Base, units: f64) -> Ray<E> {
    let wide = |v: Vec3<E>| v.map(Scalar::to_f64);
    let [a, b, c] = triangle.corners().map(wide);
    let n = (b - a).cross(c - a);
    let t = E::from_f64(n.dot(a - wide(ray.o)) / n.dot(wide(ray.d)));
    let end = moved(t, if base.flip { -units } else { units });
    if base.flop { Ray { tmin: end, ..*ray } } else { Ray { tmax: end, ..*ray } }
}

/// Corners on whole eighths in a plane along two axes; a direction with that many zeros, of both
/// signs, and rays aimed at whole eighths of the triangle, edges and corners included.
fn on_a_lattice<E: Float>(stream: &mut Stream, zeros: f64) -> Pair<E> {
    let eighth =
        |stream: &mut Stream| f64::from(u8::try_from(stream.below(33)).unwrap_or(0)) / 8.0 - 2.0;
    let axis = stream.below(3);
    let height = eighth(stream);
    let corner = |stream: &mut Stream| {
        Vec3::new(eighth(stream), eighth(stream), height).with_axis_last(axis)
    };
    let (a, b, c) = loop {
        let (a, b, c) = (corner(stream), corner(stream), corner(stream));
        if !(Triangle { a, b, c }).is_degenerate() {
            break (a, b, c);
        }
    };
    let weights = [0, 1].map(|_| f64::from(u8::try_from(stream.below(9)).unwrap_or(0)) / 8.0);
    let point = (b - a).mul_add(weights[0], (c - a).mul_add(weights[1], a));
    let mut zero = || if stream.unit_f64() < 0.5 { 0.0 } else { -0.0 };
    let (first, second) = (zero(), zero());
    let mut slope = || eighth(stream) + 1.0 / 16.0;
    let d = match zeros {
        z if z < 1.0 => [slope(), slope(), slope()],
        z if z < 2.0 => [first, slope(), slope()],
        _ => [first, second, slope()],
    };
    let d = Vec3::from(d).with_axis_last(axis);
    let o = point - d;
    let [a, b, c, o, d] = [a, b, c, o, d].map(|v| v.map(E::from_f64));
    let ray = Ray::<E>::new(o, d);
    (ray, Triangle { a, b, c })
}

/// Any bits; half of the rays aimed at a point of the triangle.
fn random_bits<E: Float>(stream: &mut Stream) -> Pair<E> {
    let mut number = || E::from_upper_bits(stream.bits());
    let mut vector = || Vec3::new(number(), number(), number());
    let (o, d, a, b, c) = (vector(), vector(), vector(), vector(), vector());
    let (tmin, tmax) = (number(), number());
    let open = stream.unit_f64() < 0.5;
    let aimed = stream.unit_f64() < 0.5;
    let third = E::from_f64(1.0 / 3.0);
    let d = if aimed { a.scale(third) + (b.scale(third) + c.scale(third)) - o } else { d };
    let ray = if open { Ray::<E>::new(o, d) } else { Ray { o, d, tmin, tmax } };
    (ray, Triangle { a, b, c })
}

/// A power of ten, rounded once: the same on every machine.
fn power_of_ten(exponent: i32) -> f64 {
    format!("1e{exponent}").parse().expect("digits with an exponent are a number")
}

/// A power of two with a whole exponent that is not large.
fn power_of_two(exponent: f64) -> f64 {
    let mut x = 1.0;
    let mut left = exponent;
    while left >= 1.0 {
        x *= 2.0;
        left -= 1.0;
    }
    while left <= -1.0 {
        x *= 0.5;
        left += 1.0;
    }
    x
}
