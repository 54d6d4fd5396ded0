//! `trisect recommend`: which method to use for a mesh and its rays, with the lines that use it.

use anyhow::Result;
use trisect_studies::recommend;
use trisect_studies::{Taken, input};

use crate::arguments::Recommend;
use crate::output::COLUMNS;
use crate::progress::Bar;
use crate::studies::{command, say};
use crate::{output, reading};

pub(crate) fn run(arguments: &Recommend) -> Result<()> {
    let mesh = input::load_mesh(&arguments.mesh, &arguments.reading, &say)?;
    input::say_rounding(&arguments.mesh, mesh.rounding(), input::MOVE, &say);
    let rays = match &arguments.rays {
        Some(path) => {
            let rays = reading::load_rays(path, &arguments.reading)?;
            reading::some_rays(&rays, path)?;
            Some(rays.rays_f32)
        }
        None => None,
    };
    let Recommend { seed, rounds, .. } = *arguments;
    let taken = Taken { command: command(), seed, rounds: rounds as usize };
    let mut bar = Bar::new();
    let found = recommend::recommend(&mesh, rays.as_deref(), taken, &mut bar)?;
    drop(bar);
    output::print_as(arguments.json, &found, |out| {
        write!(out, "{}\n{}", found.to_text(COLUMNS), found.rust)
    })
}
