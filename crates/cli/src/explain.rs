//! `trisect explain`: what a scene needs, and what is left out for it.

use std::io::Write;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context as _, Result, anyhow};
use serde::Serialize;
use trisect_method::Form;
use trisect_render::{Settings, Stage};
use trisect_studies::omissions::{ExplainedPart, Explanation};
use trisect_studies::{input, omissions};

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
    // Of all trees.
    let open_edges = AtomicUsize::new(0);
    let stage = pool
        .install(|| {
            Stage::new(scene, |of_tree| {
                open_edges.fetch_add(trisect_studies::open_edges(of_tree), Ordering::Relaxed);
                entry.tree(of_tree, arguments.builder)
            })
        })
        .map_err(|unsuitable| anyhow!("{}: {unsuitable}", arguments.scene.display()))?;
    let mut bar = Bar::new();
    let rounds = (arguments.rounds as usize, arguments.seed);
    let found = omissions::explain(&stage, &settings, rounds, &pool, &mut bar)?;
    drop(bar);
    let (instruction_set, lanes) = trisect_catalog::fast_lanes();
    let report = Report {
        scene: arguments.scene.display().to_string(),
        width: arguments.width,
        height: arguments.height,
        depth: arguments.depth,
        threads: pool.current_num_threads(),
        triangles: stage.triangles(),
        open_edges: open_edges.into_inner(),
        trees: stage.trees().count(),
        method: entry.info.name,
        division: entry.info.forms.preferred(),
        instruction_set: instruction_set.name(),
        lanes,
        builder: arguments.builder.name(),
        found,
    };
    output::print_as(arguments.json, &report, |out| report.print(out))
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
             method   {}; `trisect recommend` says which to use\n\
             lanes    {} of f32 on {}, the best for eight triangles here\n\
             division {}, as a leaf has it; shadow rays get no t, no barycentrics\n\
\n\
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
