//! `trisect explain`: what a scene needs, and what is left out for it.

use std::io::Write;

use anyhow::{Context as _, Result, anyhow};
use serde::Serialize;
use trisect_harness::{Explanation, Omission};
use trisect_render::{Settings, Stage};
use trisect_scene::Scene;

use crate::arguments::Explain;
use crate::progress::Bar;
use crate::{output, tasks};

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
    method: &'static str,
    /// The form that leaves test triangles in.
    division: &'static str,
    instruction_set: &'static str,
    lanes: usize,
    builder: &'static str,
    #[serde(flatten)]
    found: Explanation,
}

pub(crate) fn run(arguments: &Explain) -> Result<()> {
    let entry = tasks::method(&arguments.method)?;
    let scene = Scene::load(&arguments.scene)?;
    let settings = Settings {
        depth: arguments.depth,
        lights: arguments.lights.map_or(usize::MAX, usize::from),
        ..Settings::new([arguments.width, arguments.height])
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(usize::from(arguments.threads))
        .build()
        .context("the system gives no threads; ask for fewer with --threads")?;
    let stage = pool
        .install(|| Stage::new(scene, |triangles| (entry.tree)(triangles, arguments.builder)))
        .map_err(|unsuitable| anyhow!("{}: {unsuitable}", arguments.scene.display()))?;
    let mut bar = Bar::new();
    let rounds = (arguments.rounds as usize, arguments.seed);
    let found = trisect_harness::explain(&stage, &settings, rounds, &pool, &mut bar)?;
    drop(bar);
    let (instruction_set, lanes) = trisect_catalog::fast_lanes();
    let report = Report {
        scene: arguments.scene.display().to_string(),
        width: arguments.width,
        height: arguments.height,
        depth: arguments.depth,
        threads: pool.current_num_threads(),
        triangles: stage.triangles(),
        trees: stage.trees().count(),
        method: entry.info.name,
        division: entry.f32.divisions().next().unwrap_or_default(),
        instruction_set: instruction_set.name(),
        lanes,
        builder: arguments.builder.name(),
        found,
    };
    output::print_as(arguments.json, &report, |out| report.print(out))
}

impl Report {
    /// What there is in the scene of a part of the renderer.
    fn there_is(&self, part: &str) -> String {
        let Explanation { shapes, varying, lights, onward, .. } = self.found;
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
            _ => "all of that together".to_owned(),
        }
    }

    fn print(&self, out: &mut dyn Write) -> std::io::Result<()> {
        writeln!(
            out,
            "{}\n\
             trees    {}, with {} triangles, by the {} builder\n\
             method   {}, unless another is asked for with --method\n\
             lanes    {} of f32 on {}, the best for eight triangles here\n\
             division {}, as a leaf has it; shadow rays get no t, no barycentrics\n\n\
             part        in the scene                             costs\n",
            self.scene,
            self.trees,
            self.triangles,
            self.builder,
            self.method,
            self.lanes,
            self.instruction_set,
            self.division,
        )?;
        for omission in &self.found.omissions {
            let Omission { part, left_out, gain, quartiles } = omission;
            let costs = match (left_out, gain, quartiles) {
                (true, Some(gain), Some([low, high])) => {
                    format!("{:+.1} % ({:+.1} to {:+.1})", gain * 100.0, low * 100.0, high * 100.0)
                }
                _ => "needed".to_owned(),
            };
            writeln!(out, "{part:<11} {:<40} {costs}", self.there_is(part))?;
        }
        writeln!(
            out,
            "\n{} by {} pixels on {} thread(s): {:.2} ms, {} rays, {:.2} million/s.\n\
             Costs: how much longer it takes with what is left out put back, median and\n\
             quartiles of {} pairs in turn.",
            self.width,
            self.height,
            self.threads,
            self.found.picture_ns as f64 / 1e6,
            self.found.rays,
            self.found.rays as f64 * 1e3 / self.found.picture_ns.max(1) as f64,
            self.found.rounds,
        )
    }
}
