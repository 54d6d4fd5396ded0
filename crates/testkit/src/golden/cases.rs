//! The cases as they stand in `data/golden`, and as they run.

use std::sync::LazyLock;

use serde::Deserialize;
use trisect_core::{FloatFormat, Hit, Ray, Triangle, Vec3};
use trisect_method::Culling;
use trisect_workloads::{Aim, Placement, Surface};

use super::scenes::{Golden, Scene, Wanted, made, sized};

const FILES: [&str; 5] = [
    include_str!("../../../../data/golden/surfaces.toml"),
    include_str!("../../../../data/golden/hits.toml"),
    include_str!("../../../../data/golden/not-finite.toml"),
    include_str!("../../../../data/golden/degenerate.toml"),
    include_str!("../../../../data/golden/scale.toml"),
];

/// Who must pass a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Holds {
    /// Every method in every form: never to be recorded as failed.
    Contract,
    /// It is expected of every method; a failure may be recorded, with its reason on the page.
    All,
    /// Methods that claim to be watertight, in what the claim covers; the failures of others are
    /// recorded.
    Watertight,
}

/// A case: scenes in both precisions, and what must come of them.
pub(super) struct Case {
    pub(super) id: String,
    pub(super) what: String,
    pub(super) holds: Holds,
    /// Whether the order of the triangles is turned round as well.
    pub(super) reversed: bool,
    /// By precision.
    scenes: [Vec<Scene>; 2],
}

impl Case {
    pub(super) fn scenes(&self, precision: FloatFormat) -> &[Scene] {
        &self.scenes[precision as usize]
    }
}

/// All of them, in order.
pub(super) static CASES: LazyLock<Vec<Case>> = LazyLock::new(|| {
    FILES
        .iter()
        .flat_map(|file| {
            let file: File = toml::from_str(file).unwrap_or_else(|error| panic!("{error}"));
            assert!(!file.source.is_empty(), "cases have a source");
            file.cases.into_iter().flat_map(Entry::cases)
        })
        .collect()
});

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    source: String,
    #[serde(rename = "case")]
    cases: Vec<Entry>,
}

/// A case as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    id: String,
    what: String,
    holds: Holds,
    #[serde(default)]
    reversed: bool,
    /// The mesh of the tests; the unit triangle where there is none.
    #[serde(default)]
    triangles: Vec<[[f64; 3]; 3]>,
    surface: Option<Shape>,
    #[serde(default)]
    tests: Vec<Test>,
    make: Option<Make>,
    /// One case per power of ten, with the unit triangle as large.
    powers: Option<[i32; 2]>,
}

impl Entry {
    fn cases(self) -> Vec<Case> {
        let Some([first, last]) = self.powers else {
            let scenes = [self.scenes::<f32>(), self.scenes::<f64>()];
            return vec![self.case(&scenes, "", "")];
        };
        (first..=last)
            .map(|power| {
                let size = format!("1e{power}");
                let edge: f64 = size.parse().expect("a power of ten");
                let scenes = [vec![sized::<f32>(edge)], vec![sized::<f64>(edge)]];
                self.case(&scenes, &format!("/{size}"), &format!(" of {size}"))
            })
            .collect()
    }

    fn case(&self, scenes: &[Vec<Scene>; 2], id: &str, what: &str) -> Case {
        assert!(scenes.iter().any(|scenes| !scenes.is_empty()), "{} is empty", self.id);
        Case {
            id: format!("{}{id}", self.id),
            what: format!("{}{what}", self.what),
            holds: self.holds,
            reversed: self.reversed,
            scenes: scenes.clone(),
        }
    }

    fn scenes<E: Golden>(&self) -> Vec<Scene> {
        let mut scenes: Vec<Scene> =
            self.tests.iter().filter_map(|test| self.scene::<E>(test)).collect();
        if let Some(make) = &self.make {
            scenes.extend(made::<E>(make));
        }
        scenes
    }

    /// One ray against a mesh, `None` in the precision that it is not for.
    fn scene<E: Golden>(&self, test: &Test) -> Option<Scene> {
        if test.precision.is_some_and(|precision| precision != E::FORMAT) {
            return None;
        }
        let offset = Vec3::from(test.offset);
        let given = if test.triangles.is_empty() { &self.triangles } else { &test.triangles };
        let triangles = match &self.surface {
            Some(shape) => {
                let placement = Placement { scale: test.scale, offset };
                shape.surface().triangles::<f64>(&placement)
            }
            None if given.is_empty() => {
                vec![Triangle::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])]
            }
            None => given.iter().map(|&[a, b, c]| Triangle::new(a, b, c)).collect(),
        };
        let wanted = match (test.miss, test.hits, test.hit) {
            (true, None, None) => Wanted::Miss,
            (false, Some(least), None) => Wanted::AtLeast(least),
            (false, None, Some([t, beta, gamma])) => Wanted::Ulps(Hit { t, beta, gamma }, 0),
            _ => panic!("a test of {} wants one thing", self.id),
        };
        let ray = Ray {
            o: Vec3::from(test.o),
            d: Vec3::from(test.d),
            tmin: test.tmin.map_or(0.0, Number::value::<E>),
            tmax: test.tmax.map_or(f64::INFINITY, Number::value::<E>),
        };
        let culling = match test.culling.as_deref() {
            None => Culling::None,
            Some("back") => Culling::Back,
            Some("front") => Culling::Front,
            Some(other) => panic!("{other} is no face"),
        };
        Some(Scene { rays: vec![ray], triangles, culling, wanted: vec![wanted] })
    }
}

/// One ray, and what must come of it: it misses, hits at least so many triangles, or hits with the
/// very numbers `t`, `beta`, `gamma`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Test {
    o: [f64; 3],
    d: [f64; 3],
    tmin: Option<Number>,
    tmax: Option<Number>,
    culling: Option<String>,
    /// Where it says something in one precision alone.
    precision: Option<FloatFormat>,
    /// The mesh, where it is not the case's.
    #[serde(default)]
    triangles: Vec<[[f64; 3]; 3]>,
    #[serde(default = "one")]
    scale: f64,
    #[serde(default)]
    offset: [f64; 3],
    #[serde(default)]
    miss: bool,
    hits: Option<usize>,
    hit: Option<[f64; 3]>,
}

fn one() -> f64 {
    1.0
}

/// A number, or its neighbour in the precision under test.
#[derive(Clone, Copy, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
enum Number {
    Same(f64),
    Above { above: f64 },
    Below { below: f64 },
}

impl Number {
    fn value<E: Golden>(self) -> f64 {
        match self {
            Self::Same(x) => x,
            Self::Above { above } => E::from_f64(above).up().to_f64(),
            Self::Below { below } => E::from_f64(below).down().to_f64(),
        }
    }
}

/// A surface of the workloads.
#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum Shape {
    Sphere { subdivisions: u32 },
    RaggedSphere { seed: u64 },
    Cube { divisions: usize },
    SplitSquare { seed: u64, triangles: usize },
    Fan { triangles: usize },
}

impl Shape {
    pub(super) fn surface(&self) -> Surface {
        match *self {
            Self::Sphere { subdivisions } => Surface::sphere(subdivisions),
            Self::RaggedSphere { seed } => Surface::ragged_sphere(seed),
            Self::Cube { divisions } => Surface::cube(divisions),
            Self::SplitSquare { seed, triangles } => Surface::split_square(seed, triangles),
            Self::Fan { triangles } => Surface::fan(triangles),
        }
    }
}

/// What rays are aimed at.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Target {
    Edges,
    Vertices,
    /// Nothing: directions are random.
    Anywhere,
}

impl Target {
    pub(super) fn aim(self) -> Option<Aim> {
        match self {
            Self::Edges => Some(Aim::Edges),
            Self::Vertices => Some(Aim::Vertices),
            Self::Anywhere => None,
        }
    }
}

/// What must come of each ray at a surface.
#[derive(Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Each {
    #[default]
    Hits,
    /// Of the hits that are closest the one of the lowest number is that of the first triangle that
    /// meets what the ray is aimed at.
    HitsTheFirst,
    Anything,
}

/// A scene that is generated.
#[derive(Deserialize)]
#[serde(tag = "scene", rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum Make {
    /// Rays at surfaces, each of which must hit.
    Surfaces {
        surfaces: Vec<Shape>,
        at: Vec<Target>,
        /// Rays per surface and target.
        rays: usize,
        /// Fewer rays where there would be more pairs than this.
        pairs: Option<usize>,
        #[serde(default)]
        seed: u64,
        #[serde(default)]
        offset: [f64; 3],
        #[serde(default)]
        from_the_middle: bool,
        #[serde(default)]
        each: Each,
    },
    /// A lattice at `z = 0` crossed in points of the line `y = 0`, everything exact.
    Crossing { divisions: usize, rays: usize },
    /// Two triangles of a turned square, and `side`² rays from a hemisphere to its middle.
    Quad { side: usize, offset: [f64; 3] },
    /// `side`² points inside the unit triangle, hit from 1 away.
    Grid { side: u16, ulps: u64 },
    /// Triangles whose corners lie on a line, and whose edges round.
    Collinear { triangles: usize, seed: u64 },
    /// Rays that start at points of triangles, `offset` times the unit roundoff times the largest
    /// coordinate away from them along the normal, and lead away: none hits its triangle again.
    Spawned { triangles: usize, rays: usize, offset: f64, power: f64, seed: u64 },
    /// Random bits for every number.
    Bits { rays: usize, triangles: usize, scenes: u64, seed: u64 },
    /// Rays and triangles of a size between the smallest and the largest numbers.
    Sizes { rays: usize, triangles: usize, scenes: u64, seed: u64 },
    /// Random rays and triangles in the unit ball.
    Random { rays: usize, triangles: Vec<usize>, seed: u64 },
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Rows of the table in the notes that the cases restate.
    const ROWS: [&str; 35] = [
        "W1", "W2", "W4", "W5", "W6", "W7", "W8", "W9", "W10", "W11", "W12", "H1", "B1", "B2",
        "T1", "T2", "T3", "T4", "N1", "N2", "N3", "N4", "N5", "D1", "D2", "D3", "C1", "S1", "S2",
        "S4", "S5", "R1", "K1", "K2", "K3",
    ];

    #[test]
    fn every_row_has_a_case_and_every_case_a_row() {
        let rows: BTreeSet<&str> = ROWS.into();
        let of = |case: &'static Case| case.id.split('/').next().expect("an id");
        let found: BTreeSet<&str> = CASES.iter().map(of).collect();
        assert_eq!(found, rows);
        let ids: BTreeSet<&str> = CASES.iter().map(|case| case.id.as_str()).collect();
        assert_eq!(ids.len(), CASES.len(), "an id is used twice");
    }
}
