//! Scenes of glTF 2.0: meshes, nodes, cameras, textures, and the extensions `KHR_lights_punctual`,
//! `KHR_materials_transmission`, `KHR_materials_ior` and `KHR_materials_emissive_strength`.
//!
//! What the triangles are is read where meshes are; a document is refused here for no other reason. A
//! faulty camera, light, material or picture is left out, or its default taken, and that is said.

use std::collections::HashMap;
use std::path::Path;

use glam::{DAffine3, DMat3, DMat4, DVec3, Mat3, Vec2, Vec3};
use trisect_core::Triangle;
use trisect_mesh::{
    GltfCamera, GltfFile, GltfLight, GltfMaterial, Matrix, MeshProblem, Part, ReadProblem, Reading,
};

use crate::camera::{Camera, Lens};
use crate::draft::Draft;
use crate::error::{SceneError, SceneProblem};
use crate::mesh::Mesh;
use crate::model::{Color, Instance, Light, Material};
use crate::texture::Texture;

/// Lumen per watt at the wavelength that the eye sees best: glTF counts light as the eye does.
const LUMINOUS_EFFICACY: f32 = 683.0;

/// Bytes of a triangle with its normals, coordinates and material, in f64 and in f32.
const OF_TRIANGLE: usize =
    size_of::<Triangle<f64>>() + size_of::<(Triangle<f32>, [Vec3; 3], [Vec2; 3], usize)>();

/// Reads a scene. Light of `KHR_lights_punctual`, in candela and lux, is divided by 683.
pub(crate) fn load(path: &Path, reading: &mut Reading) -> Result<Draft, SceneError> {
    let name = path.display().to_string();
    let fail = |problem: ReadProblem| SceneProblem::from(problem).of_file(name.as_str());
    let bytes = reading.file(path).map_err(fail)?;
    let file = GltfFile::open(&name, &bytes, path.parent(), reading)
        .map_err(|problem| SceneProblem::Mesh(problem).of_file(name.as_str()))?;
    let document = Reader { name: &name, file: &file, reading };
    document.read().map_err(|problem| problem.of_file(name.as_str()))
}

struct Reader<'a> {
    name: &'a str,
    file: &'a GltfFile,
    reading: &'a mut Reading,
}

impl Reader<'_> {
    fn read(mut self) -> Result<Draft, SceneProblem> {
        let mut draft = Draft::new();
        let is_used = self.meshes(&mut draft)?;
        for (number, world) in self.file.nodes() {
            let node = &self.file.document.nodes[number];
            if node.camera.is_some() || node.light().is_some() {
                draft.put_viewpoint(DMat4::from_cols_array_2d(world).w_axis.truncate());
            }
        }
        draft.settle();
        let mut pictures = HashMap::new();
        for (number, is_used) in is_used.into_iter().enumerate() {
            let mut material = self.material(number)?;
            if is_used {
                material.texture = self.texture(number, &mut pictures, &mut draft)?;
            }
            draft.scene.materials.push(material);
        }
        // What has no material gets the format's: white, and here without gloss.
        draft.scene.materials.push(Material { diffuse: Vec3::ONE, ..Material::default() });
        self.nodes(&mut draft)?;
        Ok(draft)
    }

    fn note(&mut self, place: &str, what: &str) -> Result<(), SceneProblem> {
        Ok(self.reading.note(self.name, place, what)?)
    }

    fn remark(&mut self, place: &str, what: &str) {
        self.reading.remark(self.name, place, what);
    }

    /// Adds the meshes where nodes put them, and says which materials they have.
    fn meshes(&mut self, draft: &mut Draft) -> Result<Vec<bool>, SceneProblem> {
        let file = self.file;
        let plain = file.document.materials.len();
        let mut is_used = vec![false; plain];
        let mut shared: HashMap<usize, Known> = HashMap::new();
        for placed in file.placed_meshes().map_err(SceneProblem::Mesh)? {
            let mut own = None;
            if !placed.is_shared() || !shared.contains_key(&placed.mesh) {
                let parts = file.parts(&placed, self.reading).map_err(SceneProblem::Mesh)?;
                own = Some(Known { parts, mesh: None });
            }
            let known = match (own.as_mut(), placed.is_shared()) {
                (Some(own), false) => own,
                _ => shared.entry(placed.mesh).or_insert_with(|| own.take().unwrap_or_default()),
            };
            file.check_range(&placed, &known.parts).map_err(SceneProblem::Mesh)?;
            if known.parts.iter().all(|part| part.corners.is_empty()) {
                continue;
            }
            for material in known.parts.iter().filter_map(|part| part.material) {
                is_used[material] = true;
            }
            let corners: usize = known.parts.iter().map(|part| part.corners.len()).sum();
            self.reading.claim((corners * OF_TRIANGLE) as u64)?;
            let meshes = &mut draft.scene.meshes;
            let mut add = |parts: &[Part]| {
                meshes.push(mesh_of(file.mesh_name(placed.mesh), parts, plain));
                meshes.len() - 1
            };
            let (mesh, to_world) = if can_be_inverted(&placed.world) {
                let mesh = *known.mesh.get_or_insert_with(|| add(&known.parts));
                (mesh, DAffine3::from_mat4(DMat4::from_cols_array_2d(&placed.world)))
            } else {
                // It has no place in a space of its own, but one in the world.
                let parts: Vec<Part> =
                    known.parts.iter().map(|part| part.carried(&placed.world)).collect();
                (add(&parts), DAffine3::IDENTITY)
            };
            let smooth = !draft.scene.meshes[mesh].normals.is_empty();
            draft.put(Instance { mesh, smooth, ..Instance::default() }, to_world);
        }
        if draft.scene.instances.is_empty() {
            return Err(SceneProblem::Mesh(MeshProblem::Empty));
        }
        Ok(is_used)
    }

    /// Adds cameras and lights.
    fn nodes(&mut self, draft: &mut Draft) -> Result<(), SceneProblem> {
        let document = &self.file.document;
        for (number, world) in self.file.nodes() {
            let node = &document.nodes[number];
            let world = DMat4::from_cols_array_2d(world);
            let position = draft.local(world.w_axis.truncate());
            let along = |axis: DVec3| world.transform_vector3(axis).normalize_or_zero().as_vec3();
            if let Some(camera) = node.camera {
                let lens = document.cameras.get(camera).and_then(lens_of);
                let (forward, up) = (along(DVec3::NEG_Z), along(DVec3::Y));
                let is_sound = position.is_finite() && forward != Vec3::ZERO;
                let lens = lens.filter(|_| is_sound);
                let camera = lens.and_then(|lens| Camera::towards(position, forward, up, lens));
                if let Some(camera) = camera {
                    draft.scene.cameras.push(Camera { name: node.name.clone(), ..camera });
                } else {
                    let what = "a camera that sees nothing, left out: its kind is unknown, or its \
                                    angle, height or transform is 0 or too large";
                    self.note(&format!("node {number}"), what)?;
                }
            }
            if let Some(light) = node.light() {
                let direction = along(DVec3::NEG_Z);
                let light = document.lights().get(light);
                let light = light.filter(|_| position.is_finite());
                if let Some(light) = light.and_then(|light| light_of(light, position, direction)) {
                    draft.scene.lights.push(light);
                } else {
                    let what = "a light that lights nothing, left out: its kind is unknown, or its \
                                    colour, intensity, cone or place is below 0 or too large";
                    self.note(&format!("node {number}"), what)?;
                }
            }
        }
        Ok(())
    }

    /// The metallic-roughness model in this one's terms: a metal is a mirror as far as it is smooth, the
    /// rest of it a Phong highlight; all else is Lambert's, with glass where it transmits.
    fn material(&mut self, number: usize) -> Result<Material, SceneProblem> {
        let place = format!("material {number}");
        let material: &GltfMaterial = &self.file.document.materials[number];
        let surface = &material.surface;
        let [red, green, blue, _] = surface.base_color_factor;
        let factors = [red, green, blue, surface.metallic_factor, surface.roughness_factor];
        let factors = [factors.as_slice(), &[material.transmission()]].concat();
        let share = |factor: f32| factor.clamp(0.0, 1.0);
        if factors.iter().any(|&factor| share(factor) != factor) {
            self.note(&place, "factors that are not from 0 to 1, brought there")?;
        }
        let base = Vec3::new(share(red), share(green), share(blue));
        let (metallic, clear) = (share(surface.metallic_factor), share(material.transmission()));
        let roughness = share(surface.roughness_factor);
        let mut index_of_refraction = material.index_of_refraction();
        if !(index_of_refraction > 0.0 && index_of_refraction.is_finite()) {
            self.note(&place, "an index of refraction that is no number above 0, taken for 1.5")?;
            index_of_refraction = 1.5;
        }
        let mut emission = Vec3::from(material.emissive_factor) * material.emissive_strength();
        if !(emission.is_finite() && emission.min_element() >= 0.0) {
            self.note(&place, "emitted light that is below 0 or infinite, left out")?;
            emission = Vec3::ZERO;
        }
        if material.has_other_maps() {
            self.remark(&place, "textures of other than the base colour are not read");
        }
        if material.has_alpha() {
            self.remark(&place, "alpha is not read: the surface is opaque");
        }
        let smooth = (1.0 - roughness * 4.0).max(0.0);
        let metal = base * metallic;
        // Phong's exponent of the microfacets' width (Walter et al. 2007, section 5.2), roughness squared.
        let width = (roughness * roughness).max(1e-3);
        Ok(Material {
            name: material.name.clone(),
            diffuse: base * (1.0 - metallic) * (1.0 - clear),
            specular: metal * (1.0 - smooth),
            shininess: (2.0 / (width * width) - 2.0).clamp(0.0, 1e6),
            reflection: metal * smooth,
            transmission: base * (1.0 - metallic) * clear,
            index_of_refraction,
            emission,
            texture: None,
        })
    }

    /// The texture of a material's base colour. Without its picture the surface has the factor alone.
    fn texture(
        &mut self,
        material: usize,
        known: &mut HashMap<usize, Option<usize>>,
        draft: &mut Draft,
    ) -> Result<Option<usize>, SceneProblem> {
        let document = &self.file.document;
        let Some(info) = document.base_texture(Some(material)) else { return Ok(None) };
        if let Some(known) = known.get(&info.index) {
            return Ok(*known);
        }
        let place = format!("texture {}", info.index);
        let texture = document.textures.get(info.index);
        if texture.is_some_and(|texture| document.is_clamped(texture)) {
            self.remark(
                &place,
                "a texture that ends at its edges or is mirrored there: it repeats",
            );
        }
        let pixels = match texture.and_then(|texture| texture.source) {
            None => Err(SceneProblem::faulty("image", "source", "there is none", "name one")),
            Some(image) => match self.file.image(image, self.reading) {
                Ok(bytes) => {
                    let name = format!("{}: image {image}", self.name);
                    Texture::decode(&bytes, &name, self.reading)
                }
                Err(MeshProblem::Unread(problem)) => Err(problem.into()),
                Err(problem) => Err(SceneProblem::Mesh(problem)),
            },
        };
        let pixels = Texture::or_without(pixels, self.name, &place, self.reading)?;
        let number = pixels.map(|pixels| {
            draft.scene.textures.push(Texture { scale: Vec2::ONE, pixels });
            draft.scene.textures.len() - 1
        });
        known.insert(info.index, number);
        Ok(number)
    }
}

/// A mesh that several nodes may show.
#[derive(Default)]
struct Known {
    parts: Vec<Part>,
    /// Its number in the scene, where it has one in its own space.
    mesh: Option<usize>,
}

/// Whether rays can be carried to the space of what a matrix carries to the world, in f32.
fn can_be_inverted(world: &Matrix) -> bool {
    let world = DMat4::from_cols_array_2d(world);
    let linear = DMat3::from_mat4(world).as_mat3();
    let determinant = linear.determinant();
    let sound = |m: Mat3| m.is_finite() && m.determinant().is_normal();
    let is_near = world.w_axis.truncate().as_vec3().is_finite();
    is_near && determinant.is_normal() && sound(linear) && sound(linear.inverse())
}

/// What a camera makes its picture with, if it makes one.
fn lens_of(camera: &GltfCamera) -> Option<Lens> {
    match (&camera.perspective, &camera.orthographic) {
        (Some(lens), _) if lens.yfov > 0.0 && lens.yfov < std::f32::consts::PI => {
            Some(Lens::Pinhole { field_of_view: lens.yfov })
        }
        (None, Some(lens)) if lens.ymag > 0.0 && (lens.ymag * 2.0).is_finite() => {
            Some(Lens::Orthographic { height: lens.ymag * 2.0 })
        }
        _ => None,
    }
}

fn light_of(light: &GltfLight, position: Vec3, direction: Vec3) -> Option<Light> {
    let color = Color::from(light.color) * (light.intensity / LUMINOUS_EFFICACY);
    let direction = direction.normalize_or(Vec3::NEG_Z);
    let spot = &light.spot;
    let (inner, outer) = (spot.inner_cone_angle, spot.outer_cone_angle);
    let light = match light.kind.as_str() {
        "directional" => Light::Directional { direction, irradiance: color },
        "point" => Light::Point { position, intensity: color },
        "spot" if 0.0 <= inner && inner < outer && outer <= std::f32::consts::FRAC_PI_2 + 1e-6 => {
            let (inner, outer) = (inner.cos(), outer.cos());
            Light::Spot { position, direction, intensity: color, inner, outer }
        }
        _ => return None,
    };
    (color.is_finite() && color.min_element() >= 0.0).then_some(light)
}

fn mesh_of(name: &str, parts: &[Part], plain: usize) -> Mesh {
    let has_normals = parts.iter().any(|part| !part.normals.is_empty());
    let has_coordinates = parts.iter().any(|part| !part.coordinates.is_empty());
    let triangle = |part: &Part, corners: &[usize; 3]| {
        let [a, b, c] = corners.map(|corner| part.positions[corner]);
        Triangle::new(a, b, c)
    };
    let exact: Vec<Triangle<f64>> = parts
        .iter()
        .flat_map(|part| part.corners.iter().map(|corners| triangle(part, corners)))
        .collect();
    let mut mesh = Mesh::near(name, &exact);
    let of_parts = parts.iter().flat_map(|part| part.corners.iter().map(move |c| (part, c)));
    for (own, (part, corners)) in mesh.own_normals().zip(of_parts) {
        mesh.materials.push(part.material.unwrap_or(plain));
        if has_normals {
            let normal = |corner: usize| {
                let normal = part.normals.get(corner).map(|normal| DVec3::from(*normal));
                normal.map_or(own, |normal| normal.as_vec3().normalize_or(own))
            };
            mesh.normals.push(corners.map(normal));
        }
        if has_coordinates {
            let at = |corner: usize| part.coordinates.get(corner).copied().unwrap_or_default();
            mesh.coordinates.push(corners.map(|corner| {
                let at = Vec2::from(at(corner).map(|x| {
                    #[allow(clippy::cast_possible_truncation, reason = "the nearest is meant")]
                    let x = x as f32;
                    x
                }));
                if at.is_finite() { at } else { Vec2::ZERO }
            }));
        }
    }
    mesh
}
