//! What is read: scenes and rays.

use std::path::Path;

use anyhow::{Result, bail};
use trisect_scene::Scene;
use trisect_studies::input::{MOVE, Reading, say_rounding};
use trisect_workloads::RaysFile;

use crate::studies::say;

/// Loads a scene, and says what its readers passed over.
pub(crate) fn load_scene(path: &Path, reading: &Reading) -> Result<Scene> {
    let scene = Scene::load_with(path, &reading.into())?;
    scene.notes.iter().for_each(|note| say(note));
    // Less than this is no part of a pixel.
    if scene.rounding > f64::from(f32::EPSILON) {
        say_rounding(path, scene.rounding, MOVE, &say);
    }
    Ok(scene)
}

/// Reads rays from a file, or from standard input for `-`.
pub(crate) fn load_rays(path: &Path, reading: &Reading) -> Result<RaysFile> {
    let options = reading.into();
    if path.as_os_str() == "-" {
        let input = std::io::stdin().lock();
        return Ok(trisect_workloads::read_rays_csv_with("standard input", input, &options)?);
    }
    Ok(trisect_workloads::read_rays_with(path, &options)?)
}

/// Refuses an empty list of rays where there is nothing to do without.
pub(crate) fn some_rays(rays: &RaysFile, path: &Path) -> Result<()> {
    if rays.rays.is_empty() {
        bail!("{}: no rays; give at least one", path.display());
    }
    Ok(())
}
