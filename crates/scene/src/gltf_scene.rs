//! Scenes of glTF 2.0: meshes, nodes, cameras, textures, and the extensions `KHR_lights_punctual`,
//! `KHR_materials_transmission`, `KHR_materials_ior` and `KHR_materials_emissive_strength`.

use std::path::Path;

use glam::{Affine3A, DMat4, Vec2, Vec3};
use gltf::camera::Projection;
use gltf::image::Source;
use gltf::khr_lights_punctual::Kind;
use gltf::{Semantic, texture};
use trisect_core::Triangle;
use trisect_mesh::{GltfFile, MeshProblem, ReadProblem, Reading};

use crate::camera::{Camera, Lens};
use crate::error::{SceneError, SceneProblem};
use crate::mesh::Mesh;
use crate::model::{Color, Instance, Light, Material, Scene};
use crate::texture::Texture;

/// Lumen per watt at the wavelength that the eye sees best: glTF counts light as the eye does.
const LUMINOUS_EFFICACY: f32 = 683.0;

/// Reads a scene. Light of `KHR_lights_punctual`, in candela and lux, is divided by 683.
pub(crate) fn load(path: &Path, reading: &mut Reading) -> Result<Scene, SceneError> {
    let name = path.display().to_string();
    let fail = |problem: ReadProblem| SceneProblem::from(problem).of_file(name.as_str());
    let bytes = reading.file(path).map_err(fail)?;
    read(&bytes, path.parent(), reading).map_err(|problem| problem.of_file(name))
}

fn read(bytes: &[u8], folder: Option<&Path>, reading: &mut Reading) -> Result<Scene, SceneProblem> {
    let file = GltfFile::open(bytes, folder, reading).map_err(SceneProblem::Mesh)?;
    let mut scene = Scene::empty();
    for texture in file.document.textures() {
        scene.textures.push(read_texture(&file, &texture, folder, reading)?);
    }
    for material in file.document.materials() {
        scene.materials.push(read_material(&material)?);
    }
    // What has no material gets the format's: white, and here without gloss.
    scene.materials.push(Material { diffuse: Vec3::ONE, ..Material::default() });
    for mesh in file.document.meshes() {
        scene.meshes.push(read_mesh(&file, &mesh, scene.materials.len() - 1)?);
    }
    for (node, matrix) in file.nodes() {
        let to_world = Affine3A::from_mat4(DMat4::from_cols_array_2d(&matrix).as_mat4());
        if let Some(mesh) = node.mesh() {
            let place = format!("node {}", node.index());
            if !to_world.is_finite() || to_world.matrix3.determinant() == 0.0 {
                let what = "its transform has no inverse";
                let mend = "give it a size along every axis";
                return Err(SceneProblem::faulty(place, "matrix", what, mend));
            }
            scene.instances.push(Instance {
                mesh: mesh.index(),
                to_world,
                material: None,
                smooth: !scene.meshes[mesh.index()].normals.is_empty(),
            });
        }
        if let Some(camera) = node.camera() {
            let lens = match camera.projection() {
                Projection::Perspective(lens) => Lens::Pinhole { field_of_view: lens.yfov() },
                Projection::Orthographic(lens) => Lens::Orthographic { height: lens.ymag() * 2.0 },
            };
            let place = format!("camera {}", camera.index());
            let sound = match lens {
                Lens::Orthographic { height } => height > 0.0 && height.is_finite(),
                Lens::Pinhole { field_of_view } | Lens::Thin { field_of_view, .. } => {
                    field_of_view > 0.0 && field_of_view < std::f32::consts::PI
                }
            };
            let camera = sound.then(|| Camera::transformed(&to_world, lens)).flatten();
            let mut camera = camera.ok_or_else(|| {
                let what = "it sees nothing: its angle, height or transform is 0 or too large";
                SceneProblem::faulty(place, "yfov, ymag or matrix", what, "correct it")
            })?;
            node.name().unwrap_or_default().clone_into(&mut camera.name);
            scene.cameras.push(camera);
        }
        if let Some(light) = node.light() {
            let color = Color::from(light.color()) * (light.intensity() / LUMINOUS_EFFICACY);
            let position = Vec3::from(to_world.translation);
            let direction = to_world.transform_vector3(Vec3::NEG_Z).normalize_or(Vec3::NEG_Z);
            scene.lights.push(match light.kind() {
                Kind::Directional => Light::Directional { direction, irradiance: color },
                Kind::Point => Light::Point { position, intensity: color },
                Kind::Spot { inner_cone_angle, outer_cone_angle } => Light::Spot {
                    position,
                    direction,
                    intensity: color,
                    inner: inner_cone_angle.cos(),
                    outer: outer_cone_angle.cos(),
                },
            });
        }
    }
    Ok(scene)
}

fn read_texture(
    file: &GltfFile,
    texture: &texture::Texture<'_>,
    folder: Option<&Path>,
    reading: &mut Reading,
) -> Result<Texture, SceneProblem> {
    let place = format!("texture {}", texture.index());
    let faulty = |what: String| {
        SceneProblem::faulty(
            place.as_str(),
            "source",
            what,
            "give a PNG or a JPEG beside the file or in it",
        )
    };
    let pixels = match texture.source().source() {
        Source::View { view, .. } => {
            let bytes = file.view(&view).ok_or_else(|| faulty("beyond its buffer".to_owned()))?;
            Texture::decode(bytes)
        }
        Source::Uri { uri, .. } if uri.starts_with("data:") => {
            return Err(faulty("pictures as text are not supported".to_owned()));
        }
        Source::Uri { uri, .. } => {
            Texture::load(&folder.unwrap_or(Path::new(".")).join(uri), reading)
        }
    };
    let pixels = pixels.map_err(|problem| faulty(problem.to_string()))?;
    Ok(Texture { scale: Vec2::ONE, pixels })
}

/// The metallic-roughness model in this one's terms: a metal is a mirror as far as it is smooth, the rest
/// of it a Phong highlight; all else is Lambert's, with glass where it transmits.
fn read_material(material: &gltf::Material<'_>) -> Result<Material, SceneProblem> {
    let surface = material.pbr_metallic_roughness();
    let [red, green, blue, _] = surface.base_color_factor();
    let base = Vec3::new(red, green, blue);
    let (metallic, roughness) = (surface.metallic_factor(), surface.roughness_factor());
    let clear = material.transmission().map_or(0.0, |x| x.transmission_factor());
    let index_of_refraction = material.ior().unwrap_or(1.5);
    let place = format!("material {}", material.index().unwrap_or_default());
    if !(index_of_refraction > 0.0 && index_of_refraction.is_finite()) {
        let (field, mend) = ("KHR_materials_ior.ior", "write a number from 1");
        let what = format!("is {index_of_refraction}");
        return Err(SceneProblem::faulty(place, field, what, mend));
    }
    let smooth = (1.0 - roughness * 4.0).max(0.0);
    let metal = base * metallic;
    // Phong's exponent of the microfacets' width (Walter et al. 2007, section 5.2), roughness squared.
    let width = (roughness * roughness).max(1e-3);
    Ok(Material {
        name: material.name().unwrap_or_default().to_owned(),
        diffuse: base * (1.0 - metallic) * (1.0 - clear),
        specular: metal * (1.0 - smooth),
        shininess: (2.0 / (width * width) - 2.0).clamp(0.0, 1e6),
        reflection: metal * smooth,
        transmission: base * (1.0 - metallic) * clear,
        index_of_refraction,
        emission: Vec3::from(material.emissive_factor())
            * material.emissive_strength().unwrap_or(1.0),
        texture: surface.base_color_texture().map(|info| info.texture().index()),
    })
}

fn read_mesh(file: &GltfFile, mesh: &gltf::Mesh<'_>, plain: usize) -> Result<Mesh, SceneProblem> {
    let name = mesh.name().unwrap_or_default().to_owned();
    let mut whole = Mesh { name, ..Mesh::default() };
    let has = |semantic: &Semantic| mesh.primitives().any(|part| part.get(semantic).is_some());
    let uv = Semantic::TexCoords(0);
    let (has_normals, has_coordinates) = (has(&Semantic::Normals), has(&uv));
    for primitive in mesh.primitives() {
        let place = format!("mesh {} primitive {}", mesh.index(), primitive.index());
        let positions = primitive.get(&Semantic::Positions).ok_or_else(|| {
            SceneProblem::Mesh(MeshProblem::Missing { what: format!("POSITION in {place}") })
        })?;
        let positions = file.floats::<3>(&positions, &place).map_err(SceneProblem::Mesh)?;
        if positions.iter().flatten().any(|x| !x.is_finite()) {
            let mend = "export it anew";
            return Err(SceneProblem::faulty(place, "POSITION", "is not finite", mend));
        }
        let normals = match primitive.get(&Semantic::Normals) {
            None => Vec::new(),
            Some(accessor) => file.floats::<3>(&accessor, &place).map_err(SceneProblem::Mesh)?,
        };
        let coordinates = match primitive.get(&uv) {
            None => Vec::new(),
            Some(accessor) => file.floats::<2>(&accessor, &place).map_err(SceneProblem::Mesh)?,
        };
        let material = primitive.material().index().unwrap_or(plain);
        let corners = file.corners(&primitive, positions.len(), &place);
        for corners in corners.map_err(SceneProblem::Mesh)? {
            let [a, b, c] = corners.map(|corner| positions[corner]);
            let triangle = Triangle::new(a, b, c);
            let own = Vec3::from(triangle.normal()).normalize_or_zero();
            whole.triangles.push(triangle);
            whole.materials.push(material);
            if has_normals {
                let normal = |corner| normals.get(corner).map_or(own, |n| Vec3::from_array(*n));
                whole.normals.push(corners.map(|corner| normal(corner).normalize_or(own)));
            }
            if has_coordinates {
                let at = |corner| coordinates.get(corner).map_or(Vec2::ZERO, |x| Vec2::from(*x));
                whole.coordinates.push(corners.map(at));
            }
        }
    }
    Ok(whole)
}
