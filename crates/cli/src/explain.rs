//! `trisect explain`: what a scene needs, and what is left out for it.

use std::io::Write;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use anyhow::{Context as _, Result, anyhow};
use serde::Serialize;
use trisect_core::Triangle;
use trisect_method::{Form, Output};
use trisect_render::{Settings, Stage};
use trisect_studies::omissions::{ExplainedPart, Explanation};
use trisect_studies::recommend::{self, Candidate, RecommendSettings};
use trisect_studies::{Inputs, input, omissions};

use crate::arguments::Explain;
use crate::progress::Bar;
use crate::{output, reading};

/// What is printed as JSON.
#[derive(Serialize)]
struct Report {
    scene: String,
    width: u32,
    height: u32,
    depth: u32,
    threads: usize,
    triangles: usize,
    trees: usize,
    /// Edges that do not join two triangles of a tree.
    open_edges: usize,
    method: &'static str,
    /// The form that leaves test triangles in.
    division: Form,
    instruction_set: &'static str,
    lanes: usize,
    builder: &'static str,
    /// The methods whose kernels are the fastest at leaves like the scene's, none where there was no race.
    fastest: Vec<Candidate>,
    #[serde(flatten)]
    found: Explanation,
}

pub(crate) fn run(arguments: &Explain) -> Result<()> {
    let entry = input::method(&arguments.method)?;
    let scene = reading::load_scene(&arguments.scene, &arguments.reading)?;
    let settings = Settings {
        depth: arguments.depth,
        lights: arguments.lights.map_or(usize::MAX, usize::from),
        ..Settings::new([arguments.width, arguments.height])
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(usize::from(arguments.threads))
        .build()
        .context("the system gives no threads; ask for fewer with --threads")?;
    // Of each tree.
    let triangles = Mutex::new(Vec::new());
    let stage = pool
        .install(|| {
            Stage::new(scene, |of_tree| {
                let mut triangles = triangles.lock().unwrap_or_else(PoisonError::into_inner);
                triangles.push(of_tree.to_vec());
                entry.tree(of_tree, arguments.builder)
            })
        })
        .map_err(|unsuitable| anyhow!("{}: {unsuitable}", arguments.scene.display()))?;
    let mut bar = Bar::new();
    let rounds = (arguments.rounds as usize, arguments.seed);
    let found = omissions::explain(&stage, &settings, rounds, &pool, &mut bar)?;
    let triangles = triangles.into_inner().unwrap_or_else(PoisonError::into_inner);
    let fastest = fastest(arguments, entry.info.name, &settings, &stage, &triangles, &mut bar)?;
    drop(bar);
    let (instruction_set, lanes) = trisect_catalog::fast_lanes();
    let report = Report {
        scene: arguments.scene.display().to_string(),
        width: arguments.width,
        height: arguments.height,
        depth: arguments.depth,
        threads: pool.current_num_threads(),
        triangles: stage.triangles(),
        open_edges: triangles.iter().map(|of_tree| trisect_studies::open_edges(of_tree)).sum(),
        trees: stage.trees().count(),
        method: entry.info.name,
        division: entry.info.forms.preferred(),
        instruction_set: instruction_set.name(),
        lanes,
        builder: arguments.builder.name(),
        fastest,
        found,
    };
    output::print_as(arguments.json, &report, |out| report.print(out))
}

/// Pixels across and down whose rays kernels race on.
const LOOKS: u32 = 48;

/// Races the kernels that a tracer may call on the largest tree's triangles and the rays of the camera that
/// come to it; the best of each method that stayed to the end, as the one in use does, the fastest first.
fn fastest(
    arguments: &Explain,
    method: &'static str,
    settings: &Settings,
    stage: &Stage,
    triangles: &[Vec<Triangle<f32>>],
    bar: &mut Bar,
) -> Result<Vec<Candidate>> {
    let largest = (0..triangles.len()).max_by_key(|&tree| triangles[tree].len());
    let Some(largest) = largest.filter(|_| arguments.seconds > 0.0) else { return Ok(Vec::new()) };
    let [width, height] = settings.size;
    let mut rays = Vec::new();
    for (x, y) in (0..LOOKS).flat_map(|y| (0..LOOKS).map(move |x| (x, y))) {
        let ray = stage.primary(settings, [x * width / LOOKS, y * height / LOOKS]);
        let sights = stage.sights(ray).filter(|sight| sight.number == largest);
        rays.extend(sights.map(|sight| sight.ray));
    }
    if rays.is_empty() {
        return Ok(Vec::new());
    }
    let inputs = Inputs::new(rays, triangles[largest].clone());
    let settings = RecommendSettings {
        seed: arguments.seed,
        needs: Output::T,
        max_error: None,
        watertight: false,
        in_tracer: true,
        beside: Some(method),
        time: Duration::from_secs_f64(arguments.seconds),
        exhaustive: false,
    };
    let found = recommend::recommend(&settings, &inputs, bar)?;
    let mut fastest: Vec<Candidate> = Vec::new();
    for candidate in found.ranking {
        if fastest.iter().all(|other| other.variant.method != candidate.variant.method) {
            fastest.push(candidate);
        }
    }
    Ok(fastest)
}

/// A share in percent, with a digit behind the point where that says anything.
fn percent(share: f64) -> String {
    if share.abs() < 1.0 {
        format!("{:+.1}", share * 100.0)
    } else {
        format!("{:+.0}", share * 100.0)
    }
}

impl Report {
    /// Which kernel is the fastest on the scene's own triangles and rays, and how far the one in use is
    /// behind it, on a line each.
    fn kernel(&self) -> [String; 2] {
        let Some(best) = self.fastest.first() else {
            return ["not raced".to_owned(), "see --seconds".to_owned()];
        };
        let Candidate { variant, ns_per_test, .. } = best;
        let first = format!("{}, {}: the fastest, without trees", variant.method, variant.division);
        let own = self.fastest.iter().find(|other| other.variant.method == self.method);
        let second = own.map_or_else(
            || format!("{} has no such kernel", self.method),
            |own| {
                let behind = (own.ns_per_test / ns_per_test - 1.0) * 100.0;
                let wrong = match own.wrong.total() {
                    0 => String::new(),
                    wrong => format!(", with {wrong} wrong decisions"),
                };
                format!("{} is {behind:.0} % behind{wrong}", self.method)
            },
        );
        [first, second]
    }

    /// What there is in the scene of a part of the renderer.
    fn there_is(&self, part: &str) -> String {
        let Explanation { shapes, varying, lights, onward, samples, .. } = self.found;
        match part {
            "shapes" => {
                let [spheres, planes, carried, trees] = shapes;
                format!("spheres {spheres}, planes {planes}, instances {carried}, trees {trees}")
            }
            "varying" => {
                let [textured, interpolated] = varying;
                format!("textures {textured}, smooth triangles {interpolated}")
            }
            "shadows" => format!("lights {lights}"),
            "onward" => format!("mirrors {}, clear materials {}", onward[0], onward[1]),
            "samples" => format!("samples of a pixel {samples}"),
            "transparency" => format!("clear materials {}, lights {lights}", onward[1]),
            _ => "all of that together".to_owned(),
        }
    }

    fn print(&self, out: &mut dyn Write) -> std::io::Result<()> {
        let why = match self.builder {
            "linear" => "the quickest to build",
            "spatial" => "the fastest to trace",
            _ => "between the quickest to build and the fastest to trace",
        };
        let [kernel, behind] = self.kernel();
        let surface = match self.open_edges {
            _ if self.triangles == 0 => "no triangles".to_owned(),
            0 => "closed: a method that is watertight lets no ray through".to_owned(),
            edges => format!("open along {edges} edges: no method is needed that is watertight"),
        };
        writeln!(
            out,
            "{}\n\
             trees    {}, with {} triangles, by the {} builder, {}\n\
             surface  {}\n\
             method   {}, unless another is asked for with --method\n\
             lanes    {} of f32 on {}, the best for eight triangles here\n\
             division {}, as a leaf has it; shadow rays get no t, no barycentrics\n\
             kernel   {}\n         {}\n\n\
             part         in the scene                             costs\n",
            self.scene,
            self.trees,
            self.triangles,
            self.builder,
            why,
            surface,
            self.method,
            self.lanes,
            self.instruction_set,
            self.division,
            kernel,
            behind,
        )?;
        for omission in &self.found.omissions {
            let ExplainedPart { part, left_out, gain, quartiles } = omission;
            let costs = match (left_out, gain, quartiles) {
                (true, Some(gain), Some([low, high])) => {
                    format!("{} % ({} to {})", percent(*gain), percent(*low), percent(*high))
                }
                _ => "needed".to_owned(),
            };
            writeln!(out, "{part:<12} {:<40} {costs}", self.there_is(part))?;
        }
        writeln!(
            out,
            "\n{} by {} pixels on {} thread(s): {:.2} ms, {} rays, {:.2} million/s.\n\
             Costs: how much longer it takes with what is left out put back, median and\n\
             quartiles of {} pairs in turn.",
            self.width,
            self.height,
            self.threads,
            self.found.picture_ns / 1e6,
            self.found.rays,
            self.found.rays as f64 * 1e3 / self.found.picture_ns,
            self.found.rounds,
        )
    }
}
