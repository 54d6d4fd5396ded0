//! Wavefront OBJ with its material libraries (MTL).

use std::collections::HashMap;
use std::path::Path;

use glam::{Vec2, Vec3};
use trisect_core::Triangle;
use trisect_mesh::{ObjFile, ObjLine, Reading};

use crate::error::{SceneError, SceneProblem};
use crate::load::read_text;
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
    let file = ObjFile::parse(&text).map_err(at_fault)?;
    let triangles = file.triangles().map_err(at_fault)?;
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut known = HashMap::new();
    for library in file.libraries() {
        for material in mtl::load(&folder.join(library), scene, reading)? {
            known.insert(material.name.clone(), scene.materials.len());
            scene.materials.push(material);
        }
    }
    scene.materials.push(Material::default());
    let grey = scene.materials.len() - 1;
    let material = |line: &ObjLine<'_>| match known.get(line.text) {
        Some(&number) => Ok(number),
        // Without any library the names say nothing.
        None if known.is_empty() => Ok(grey),
        None => Err(SceneProblem::faulty(
            format!("line {}", line.number),
            "usemtl",
            format!("no library has a material `{}`", line.text),
            "add it to a library, or name another",
        )
        .of_file(name.as_str())),
    };
    let materials = file.materials().iter().map(material).collect::<Result<Vec<_>, _>>()?;

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
