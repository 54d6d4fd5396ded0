//! `trisect recommend`: one kernel for a mesh and its rays, with the lines that use it.

use std::time::Duration;

use anyhow::Result;
use serde::Serialize;
use trisect_studies::comparison;
use trisect_studies::input;
use trisect_studies::recommend::{self, RecommendSettings, Recommendation};

use crate::arguments::Recommend;
use crate::output::COLUMNS;
use crate::progress::Bar;
use crate::studies::say;
use crate::{lines, output, reading};

/// What is printed as JSON.
#[derive(Serialize)]
struct Report {
    mesh: String,
    #[serde(flatten)]
    found: Recommendation,
    /// The lines that use the first of the ranking.
    rust: String,
}

pub(crate) fn run(arguments: &Recommend) -> Result<()> {
    let mesh = input::load_mesh(&arguments.mesh, &arguments.reading, &say)?;
    input::say_rounding(
        &arguments.mesh,
        mesh.rounding(),
        "kernels in f32 are judged by where they move to",
        &say,
    );
    let inputs = match &arguments.rays {
        Some(path) => {
            let rays = reading::load_rays(path, &arguments.reading)?;
            reading::some_rays(&rays, path)?;
            comparison::inputs(rays, &mesh)
        }
        None => comparison::inputs_of(comparison::usual_rays(arguments.seed, &mesh), &mesh),
    };
    let settings = RecommendSettings {
        seed: arguments.seed,
        needs: arguments.needs,
        max_error: arguments.max_error,
        watertight: arguments.watertight,
        in_tracer: false,
        beside: None,
        time: Duration::from_secs_f64(arguments.seconds),
        exhaustive: arguments.exhaustive,
    };
    let mut bar = Bar::new();
    let found = recommend::recommend(&settings, &inputs, &mut bar)?;
    drop(bar);
    let rust = found.ranking.first().map_or_else(String::new, |best| lines::of(&best.variant));
    let report = Report { mesh: mesh.name, found, rust };
    output::print_as(arguments.json, &report, |out| {
        let text = recommend::recommendation_text(&report.mesh, &report.found, COLUMNS);
        write!(out, "{text}\n{}", report.rust)
    })
}
