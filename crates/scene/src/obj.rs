//! Wavefront OBJ with its material libraries (MTL).
//!
//! The library that parses them keeps no line numbers. Where it fails, the line is found by parsing less
//! and less of the file.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3};
use tobj::LoadError;
use trisect_core::Triangle;

use crate::error::{SceneError, SceneProblem};
use crate::load::read_text;
use crate::mesh::Mesh;
use crate::model::{Material, Scene};
use crate::mtl;

/// Faces are split into fans of triangles, and corners numbered once.
const OPTIONS: tobj::LoadOptions = tobj::LoadOptions {
    triangulate: true,
    single_index: true,
    ignore_points: true,
    ignore_lines: true,
};

/// Reads a mesh, and adds its materials and textures to the scene. Triangles without a material get one
/// that is grey.
pub(crate) fn load(path: &Path, scene: &mut Scene) -> Result<Mesh, SceneError> {
    let name = path.display().to_string();
    let text = read_text(path)?;
    let models = match parse(&text) {
        Ok(models) => models,
        Err(what) => return Err(at_line(&text, &what, |part| parse(part).is_err()).of_file(name)),
    };
    let folder = path.parent().unwrap_or(Path::new("."));
    let first = scene.materials.len();
    let mut known = HashMap::new();
    for library in libraries(&text) {
        for material in mtl::load(&folder.join(&library), scene)? {
            known.insert(material.name.clone(), scene.materials.len());
            scene.materials.push(material);
        }
    }
    scene.materials.push(Material::default());
    let grey = scene.materials.len() - 1;
    let materials = used(&text, first, grey, &known, &name)?;
    let mesh = mesh_of(path, &models, |material| materials.get(material).copied().unwrap_or(grey));
    if mesh.triangles.is_empty() {
        return Err(SceneProblem::Mesh(trisect_workloads::MeshProblem::Empty).of_file(name));
    }
    Ok(mesh)
}

/// The models of a text, each with the number of the `usemtl` name that it uses.
fn parse(text: &str) -> Result<Vec<tobj::Model>, String> {
    // The library takes them.
    let mut numbers = ["v", "vt", "vn"].into_iter().flat_map(|keyword| after(text, keyword));
    let is_finite = |word: &str| word.parse().is_ok_and(f32::is_finite);
    if numbers.any(|(_, words)| words.split_whitespace().any(|word| !is_finite(word))) {
        return Err("not a finite number".to_owned());
    }
    // Every name is known here: what a library lacks is found later, with its line.
    let names = names(text).map(|(_, name)| name);
    let all: Vec<tobj::Material> = unique(names)
        .into_iter()
        .map(|name| tobj::Material { name, ..tobj::Material::default() })
        .collect();
    let known: HashMap<String, usize> =
        all.iter().enumerate().map(|(number, material)| (material.name.clone(), number)).collect();
    // The list goes in front, as a library that any text has.
    let text = format!("mtllib all\n{text}");
    let read = |path: &Path| {
        if path == Path::new("all") {
            Ok((all.clone(), known.clone().into_iter().collect()))
        } else {
            Ok((Vec::new(), HashMap::default()))
        }
    };
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &OPTIONS, read).map_err(said)?;
    Ok(models)
}

fn said(error: LoadError) -> String {
    error.to_string().to_lowercase()
}

/// The problem at the first line that fails, given the whole text does.
fn at_line(text: &str, what: &str, fails: impl Fn(&str) -> bool) -> SceneProblem {
    let ends: Vec<usize> =
        text.match_indices('\n').map(|(at, _)| at + 1).chain([text.len()]).collect();
    let line = ends.partition_point(|&end| !fails(&text[..end]));
    let start = if line == 0 { 0 } else { ends[line - 1] };
    let content = text[start..].lines().next().unwrap_or_default().trim();
    let field = content.split_whitespace().next().unwrap_or("line").to_owned();
    SceneProblem::faulty(
        format!("line {}", line + 1),
        field,
        format!("{what} in `{content}`"),
        "correct the line, or export the file again",
    )
}

/// What follows a keyword, with the number of its line from 1.
fn after<'a>(text: &'a str, keyword: &'a str) -> impl Iterator<Item = (usize, String)> + 'a {
    text.lines().enumerate().filter_map(move |(number, line)| {
        let line = line.split('#').next().unwrap_or_default();
        let rest = line.trim().strip_prefix(keyword)?;
        rest.starts_with(char::is_whitespace).then(|| (number + 1, rest.trim().to_owned()))
    })
}

fn names(text: &str) -> impl Iterator<Item = (usize, String)> + '_ {
    after(text, "usemtl")
}

fn unique(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for name in names {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    all
}

fn libraries(text: &str) -> Vec<PathBuf> {
    unique(after(text, "mtllib").map(|(_, name)| name)).into_iter().map(PathBuf::from).collect()
}

/// The scene's number of each `usemtl` name in the order of [`unique`].
fn used(
    text: &str,
    first: usize,
    grey: usize,
    known: &HashMap<String, usize>,
    file: &str,
) -> Result<Vec<usize>, SceneError> {
    // Without any library the names say nothing.
    if first == grey {
        return Ok(Vec::new());
    }
    for (line, name) in names(text) {
        if !known.contains_key(&name) {
            return Err(SceneProblem::faulty(
                format!("line {line}"),
                "usemtl",
                format!("no library has a material `{name}`"),
                "add it to a library, or name another",
            )
            .of_file(file));
        }
    }
    Ok(unique(names(text).map(|(_, name)| name)).iter().map(|name| known[name]).collect())
}

fn mesh_of(path: &Path, models: &[tobj::Model], material: impl Fn(usize) -> usize) -> Mesh {
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let has =
        |of: fn(&tobj::Mesh) -> &Vec<f32>| models.iter().any(|model| !of(&model.mesh).is_empty());
    let (has_normals, has_coordinates) = (has(|mesh| &mesh.normals), has(|mesh| &mesh.texcoords));
    let mut mesh = Mesh { name, ..Mesh::default() };
    for tobj::Model { mesh: part, .. } in models {
        let number = part.material_id.map_or_else(|| material(usize::MAX), &material);
        let three = |of: &[f32], at: u32| {
            of.get(at as usize * 3..at as usize * 3 + 3).map_or(Vec3::ZERO, Vec3::from_slice)
        };
        for corners in part.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| three(&part.positions, corners[i]));
            let triangle = Triangle::new(a, b, c);
            let own = Vec3::from(triangle.normal()).normalize_or_zero();
            mesh.triangles.push(triangle);
            mesh.materials.push(number);
            if has_normals {
                let normal = |i: usize| three(&part.normals, corners[i]).normalize_or(own);
                mesh.normals.push([0, 1, 2].map(normal));
            }
            if has_coordinates {
                let two = |i: usize| {
                    let at = corners[i] as usize * 2;
                    part.texcoords.get(at..at + 2).map_or(Vec2::ZERO, Vec2::from_slice)
                };
                mesh.coordinates.push([0, 1, 2].map(two));
            }
        }
    }
    mesh
}
