//! Wavefront OBJ with its material libraries (MTL).

use std::collections::HashMap;
use std::path::Path;

use glam::{Vec2, Vec3};
use trisect_core::Triangle;
use trisect_mesh::{ObjFile, ObjLine, ReadProblem, Reading, quoted, unquoted};

use crate::error::{SceneError, SceneProblem};
use crate::files::{beside, is_missing, read_text};
use crate::mesh::Mesh;
use crate::model::{Material, Scene};
use crate::mtl;

/// Reads a mesh, and adds its materials and textures to the scene. Triangles without a material get one
/// that is grey.
pub(crate) fn load(
    path: &Path,
    scene: &mut Scene,
    reading: &mut Reading,
) -> Result<Mesh, SceneError> {
    let name = path.display().to_string();
    let text = read_text(path, reading)?;
    let at_fault = |problem| SceneProblem::Mesh(problem).of_file(name.as_str());
    let unread = |problem: ReadProblem| SceneProblem::Unread(problem).of_file(name.as_str());
    let file = ObjFile::parse(&text, &name, reading).map_err(at_fault)?;
    let triangles = file.triangles(&name, reading).map_err(at_fault)?;
    let mut known = HashMap::new();
    for line in file.libraries() {
        for library in libraries(path.parent(), &line.text) {
            let materials = match mtl::load(&beside(path.parent(), library), scene, reading) {
                Err(SceneError { problem: SceneProblem::Unread(problem), .. })
                    if is_missing(&problem) =>
                {
                    let what = "a material library that cannot be read is left out";
                    let place = format!("line {}: `{}`: {problem}", line.number, quoted(library));
                    reading.note(&name, &place, what).map_err(unread)?;
                    continue;
                }
                materials => materials?,
            };
            for material in materials {
                known.insert(material.name.clone(), scene.materials.len());
                scene.materials.push(material);
            }
        }
    }
    scene.materials.push(Material::default());
    let grey = scene.materials.len() - 1;
    let mut is_used = vec![false; file.materials().len()];
    for material in triangles.iter().filter_map(|triangle| triangle.material) {
        is_used[material] = true;
    }
    let mut materials = Vec::with_capacity(is_used.len());
    for (ObjLine { number, text }, is_used) in file.materials().iter().zip(is_used) {
        let material = known.get(text).copied();
        // Without any library the names say nothing, and nothing uses some.
        if material.is_none() && is_used && !known.is_empty() && !text.is_empty() {
            let what = "a material that no library has is taken as grey";
            reading
                .note(&name, &format!("line {number}: `{}`", quoted(text)), what)
                .map_err(unread)?;
        }
        materials.push(material.unwrap_or(grey));
    }

    let mut corners = triangles.iter().flat_map(|triangle| &triangle.corners);
    let has_normals = corners.clone().any(|corner| corner.normal.is_some());
    let has_coordinates = corners.any(|corner| corner.coordinates.is_some());
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let exact = triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.corners.map(|corner| corner.position);
        Triangle::new(a, b, c)
    });
    let mut mesh = Mesh::near(stem, &exact.collect::<Vec<_>>());
    for (triangle, own) in triangles.iter().zip(mesh.own_normals()) {
        mesh.materials.push(triangle.material.map_or(grey, |place| materials[place]));
        if has_normals {
            let normal = |normal: Option<[f32; 3]>| Vec3::from(normal.unwrap_or_default());
            let normals = triangle.corners.map(|corner| normal(corner.normal).normalize_or(own));
            mesh.normals.push(normals);
        }
        if has_coordinates {
            let at = |at: Option<[f32; 2]>| Vec2::from(at.unwrap_or_default());
            mesh.coordinates.push(triangle.corners.map(|corner| at(corner.coordinates)));
        }
    }
    Ok(mesh)
}

/// The files of an `mtllib`: all of it where that is a file; else those in quotation marks, those up to
/// `.mtl`, which may hold spaces, and single words.
fn libraries<'a>(folder: Option<&Path>, text: &'a str) -> Vec<&'a str> {
    let mut rest = unquoted(text);
    if beside(folder, rest).is_file() {
        return vec![rest];
    }
    let mut names = Vec::new();
    while !rest.is_empty() {
        if let Some((name, after)) = rest.strip_prefix('"').and_then(|rest| rest.split_once('"')) {
            names.push(name);
            rest = after.trim_start();
            continue;
        }
        let spaces = rest.match_indices(char::is_whitespace).map(|(at, _)| at);
        let is_library = |end: &usize| {
            let ending = rest[..*end].get(end.saturating_sub(4)..);
            ending.is_some_and(|ending| ending.eq_ignore_ascii_case(".mtl"))
        };
        let Some(end) = spaces.chain([rest.len()]).find(is_library) else {
            names.extend(rest.split_whitespace().map(unquoted));
            break;
        };
        let (name, after) = rest.split_at(end);
        names.push(name);
        rest = after.trim_start();
    }
    names
}
