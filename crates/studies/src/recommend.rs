//! Which method to use for a user's own mesh and rays: in a tree, and where every triangle is tested.
//!
//! It is a comparison of one workload, answered as the comparison is, by the same lines of a record.

use rand::SeedableRng as _;
use rand::seq::SliceRandom as _;
use rand_pcg::Pcg64;
use serde::Serialize;
use trisect_catalog::{Builder, entries, find};
use trisect_core::{FloatFormat, Ray, Triangle};
use trisect_mesh::Mesh;
use trisect_method::Culling;
use trisect_report::document::{Content, Document, Section, Shown};

use crate::comparison::document::answers::Answers;
use crate::comparison::document::view::View;
use crate::comparison::measure::compare;
use crate::comparison::record::{Family, Refusal};
use crate::comparison::tasks::{Task, Timed};
use crate::kernels::reference;
use crate::lines::source;
use crate::noise::Noise;
use crate::record::Records;
use crate::study::{Progress, StudyError, Taken};
use crate::subject::Inputs;
use crate::tracer::together::{both_classes, together};

/// Rays that kernels are held to the truth on, at most: more where triangles are few.
const RAYS: [usize; 2] = [256, 4096];

/// Triangles that kernels are tried on, at most: such as the second cache holds of every method, so that
/// kernels are told apart and not memories.
const TRIANGLES: usize = 2048;

/// Tests of a sample: longer than the clock's steps.
const TESTS: usize = 1 << 17;

/// What is recommended, and why.
#[derive(Serialize)]
pub struct Recommendation {
    /// The mesh.
    pub mesh: String,
    /// Its triangles, and how many of them every triangle's loop was tried on.
    pub triangles: [usize; 2],
    /// How steady the machine was.
    pub noise: Option<Noise>,
    /// Which method to use.
    pub answers: Answers,
    /// Methods that do not take the mesh.
    pub refused: Vec<Refusal>,
    /// The lines of Rust that trace rays through a tree of the recommended method.
    pub rust: String,
    #[serde(skip)]
    document: Document,
}

/// Recommends methods for a mesh, and the rays of its user, or else those that a renderer sends. Everything is
/// timed in turn, so many rounds.
///
/// # Errors
/// When a timed sample is not what its variant's answers add up to, or the system gives no threads.
pub fn recommend(
    mesh: &Mesh,
    own: Option<&[Ray<f32>]>,
    taken: Taken,
    progress: &mut dyn Progress,
) -> Result<Recommendation, StudyError> {
    let (seed, rounds) = (taken.seed, taken.rounds);
    let mut random = Pcg64::seed_from_u64(seed);
    let classes = both_classes(mesh, own, seed);
    let mut rays = classes.each_ref().map(|class| &class.rays[..]).concat();
    rays.shuffle(&mut random);
    let few = mesh.triangles.len().clamp(1, TRIANGLES);
    rays.truncate((TESTS / few).clamp(RAYS[0], RAYS[1]));
    let sample = sample(&mesh.triangles, &rays);
    let tried = sample.len();
    let records = taken.record(progress, |run| {
        // The whole mesh: what a method asks of all its triangles a part of them may have.
        let mut methods = Vec::new();
        for entry in entries() {
            match (entry.f32.prepare)(&mesh.triangles, &[]) {
                Ok(_) => methods.push(entry),
                Err(unsuitable) => run.add(Refusal {
                    method: entry.info.name.to_owned(),
                    precision: FloatFormat::F32,
                    workload: mesh.name.clone(),
                    reason: unsuitable.to_string(),
                }),
            }
        }
        together(&methods, mesh, &classes, (rounds, &mut random), run)?;
        let task = Task {
            name: mesh.name.clone(),
            description: "a part of a mesh, and of its rays".to_owned(),
            family: Family::Mesh,
            inputs: Inputs::new(rays, sample),
            timed_rays: TESTS.div_ceil(tried),
            timed: Timed::Single,
        };
        compare(&methods, (seed, rounds), [task], run)?;
        Ok::<_, StudyError>(())
    })?;
    Ok(of_record(mesh, tried, &records))
}

fn of_record(mesh: &Mesh, tried: usize, records: &Records) -> Recommendation {
    let view = View::new(records);
    let answers = Answers::of(&view);
    let mut sections = answers.sections(&view);
    let refused: Vec<Refusal> = records.all().cloned().collect();
    let notes = refused.iter().map(|refused| {
        ("  ".to_owned(), format!("without {}: {}", refused.method, refused.reason))
    });
    sections.push(Section::new("", "", Content::List(notes.collect())).shown(Shown::Terminal));
    if tried < mesh.triangles.len() {
        let all = mesh.triangles.len();
        let says = format!("Every triangle was tested of {tried} of the {all}.");
        sections.push(Section::prose(says).shown(Shown::Terminal));
    }
    let document = Document { title: "", heading: "", source: source(&records.header), sections };
    Recommendation {
        mesh: mesh.name.clone(),
        triangles: [mesh.triangles.len(), tried],
        noise: records.header.noise,
        rust: rust(&answers),
        answers,
        refused,
        document,
    }
}

impl Recommendation {
    /// As text of at most `width` columns, for 40 columns or more, without the lines of Rust.
    pub fn to_text(&self, width: usize) -> String {
        self.document.to_text(width)
    }
}

/// The lines that use the first of the answers in a tree that decided nothing wrongly, or else the exact method.
fn rust(answers: &Answers) -> String {
    let right = answers.trees.iter().find(|answer| answer.wrong_per_million == Some(0.0));
    let method = right.map_or("exact", |answer| &answer.method);
    let own = ["exact()", "fast()", "watertight()"];
    let own = trisect::trees::NAMES.into_iter().zip(own).find(|(name, _)| *name == method);
    // Names of types are long, and lines are not.
    let (named, option, more) = if let Some((_, option)) = own {
        (String::new(), option, "// Scene::first_of and any_of take many rays.\n")
    } else {
        let name = find(method).map_or("", |entry| &entry.type_name);
        (format!("type Method = {name};\n"), "with_method::<Method>()", "")
    };
    format!(
        "use trisect::{{Ray, Scene}};
{named}let scene = Scene::options().{option}.open(path)?;
let ray = Ray::new([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
let hit = scene.first(&ray); // none, or its triangle, t and weights
let is_hit = scene.any(&ray);
{more}"
    )
}

/// Those triangles that rays hit, and of the others some from all over the mesh, in its order.
fn sample(triangles: &[Triangle<f32>], rays: &[Ray<f32>]) -> Vec<Triangle<f32>> {
    let mut chosen = vec![false; triangles.len()];
    let tree = reference().tree(triangles, Builder::Binned);
    let tree = tree.expect("the reference takes every mesh");
    let mut hits = vec![None; rays.len()];
    tree.closest(trisect_catalog::Tracing::Plain, Culling::None, rays, &mut hits);
    // Half of them are left for what is missed, as most of a mesh is.
    for hit in hits.into_iter().flatten().take(TRIANGLES / 2) {
        chosen[hit.triangle as usize] = true;
    }
    let count = chosen.iter().filter(|chosen| **chosen).count();
    let missing = TRIANGLES.min(triangles.len()) - count;
    let rest: Vec<usize> = (0..triangles.len()).filter(|&number| !chosen[number]).collect();
    for place in 0..missing {
        chosen[rest[place * rest.len() / missing]] = true;
    }
    let chosen = triangles.iter().zip(chosen).filter(|(_, chosen)| *chosen);
    chosen.map(|(triangle, _)| *triangle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_holds_what_the_rays_hit() {
        let mesh = trisect_workloads::bunny();
        let rays = trisect_workloads::primary(&mesh, 8, 8).rays;
        let chosen = sample(&mesh.triangles, &rays);
        assert_eq!(chosen.len(), TRIANGLES);
        let hits = |triangles: &[Triangle<f32>]| {
            let tree = reference().tree(triangles, Builder::Binned).expect("it takes every mesh");
            let mut hits = vec![None; rays.len()];
            tree.closest(trisect_catalog::Tracing::Plain, Culling::None, &rays, &mut hits);
            hits.into_iter().flatten().map(|hit| hit.hit.t).collect::<Vec<_>>()
        };
        assert!(hits(&mesh.triangles).len() >= 8, "some rays meet the bunny");
        assert_eq!(hits(&chosen), hits(&mesh.triangles));
        assert_eq!(sample(&mesh.triangles[..3], &rays), &mesh.triangles[..3]);
    }
}
