//! The project's own scene file. `README.md` of this crate documents the format.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use glam::{Affine3A, DAffine3, DVec3, EulerRot, Quat, Vec2, Vec3};
use serde::Deserialize;
use toml::Spanned;
use trisect_mesh::{MeshFormat, Reading, quoted};

use crate::camera::{Camera, Lens};
use crate::draft::Draft;
use crate::error::{SceneError, SceneProblem, line_of};
use crate::mesh::{Mesh, load_triangles};
use crate::model::{Instance, Light, Material, Plane, SIZE, Scene, Sphere};
use crate::obj;
use crate::texture::{Pixels, Texture};

type Number = Spanned<f32>;
type Triple = Spanned<[f32; 3]>;
/// A position. It is rounded once the scene is near 0.
type Position = Spanned<[f64; 3]>;
type Name = Spanned<String>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    picture: Option<Picture>,
    #[serde(default)]
    camera: Vec<Spanned<CameraTable>>,
    #[serde(default)]
    light: Vec<Spanned<LightTable>>,
    #[serde(default)]
    texture: BTreeMap<String, Spanned<TextureTable>>,
    #[serde(default)]
    material: BTreeMap<String, Spanned<MaterialTable>>,
    #[serde(default)]
    mesh: BTreeMap<String, Spanned<MeshTable>>,
    #[serde(default)]
    instance: Vec<Spanned<InstanceTable>>,
    #[serde(default)]
    sphere: Vec<SphereTable>,
    #[serde(default)]
    plane: Vec<PlaneTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Picture {
    width: Option<Spanned<u32>>,
    height: Option<Spanned<u32>>,
    background: Option<Triple>,
    zenith: Option<Triple>,
    ambient: Option<Triple>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraTable {
    #[serde(default)]
    name: String,
    kind: Name,
    eye: Position,
    look_at: Position,
    up: Option<Triple>,
    field_of_view: Option<Number>,
    height: Option<Number>,
    aperture: Option<Number>,
    focus: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LightTable {
    kind: Name,
    position: Option<Position>,
    direction: Option<Triple>,
    intensity: Option<Triple>,
    irradiance: Option<Triple>,
    inner: Option<Number>,
    outer: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TextureTable {
    file: Option<Name>,
    checker: Option<Spanned<[[f32; 3]; 2]>>,
    scale: Option<Spanned<[f32; 2]>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MaterialTable {
    diffuse: Option<Triple>,
    specular: Option<Triple>,
    shininess: Option<Number>,
    reflection: Option<Triple>,
    transmission: Option<Triple>,
    index_of_refraction: Option<Number>,
    emission: Option<Triple>,
    texture: Option<Name>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeshTable {
    file: Option<Name>,
    model: Option<Name>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct InstanceTable {
    mesh: Name,
    material: Option<Name>,
    translate: Option<Position>,
    rotate: Option<Triple>,
    scale: Option<Triple>,
    normals: Option<Name>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SphereTable {
    center: Position,
    radius: Number,
    material: Name,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlaneTable {
    point: Position,
    normal: Triple,
    material: Name,
}

/// The names of a scene's parts, as numbers.
type Names<'a> = BTreeMap<&'a str, usize>;

/// The text that is read, for the lines of messages.
struct Reader<'a> {
    file: &'a str,
    text: &'a str,
}

pub(crate) fn parse(
    file: &str,
    text: &str,
    folder: Option<&Path>,
    reading: &mut Reading,
) -> Result<Scene, SceneError> {
    let reader = Reader { file, text };
    let tables: File = toml::from_str(text).map_err(|error| reader.syntax(&error))?;
    let folder = folder.unwrap_or(Path::new("."));
    let mut draft = Draft::new();
    let scene = &mut draft.scene;
    if let Some(picture) = &tables.picture {
        reader.picture(picture, scene)?;
    }
    if tables.camera.is_empty() {
        let mend = "add a table [[camera]]";
        return Err(reader.fault(&(0..0), "camera", "there is none", mend));
    }
    let mut textures = Names::new();
    for (name, texture) in &tables.texture {
        textures.insert(name, scene.textures.len());
        scene.textures.push(reader.texture(texture, folder, reading)?);
    }
    let mut materials = Names::new();
    for (name, material) in &tables.material {
        materials.insert(name, scene.materials.len());
        scene.materials.push(reader.material(name, material, &textures)?);
    }
    let mut meshes = Names::new();
    for (name, mesh) in &tables.mesh {
        meshes.insert(name, scene.meshes.len());
        let mesh = reader.mesh(mesh, folder, scene, reading)?;
        scene.meshes.push(Mesh { name: name.clone(), ..mesh });
    }
    for instance in &tables.instance {
        let (instance, place) = reader.instance(instance, &draft.scene, &meshes, &materials)?;
        draft.put(instance, place);
    }
    for sphere in &tables.sphere {
        let center = reader.position(&sphere.center, "center")?;
        let radius = reader.positive(&sphere.radius, "radius")?;
        let material = reader.named(&sphere.material, "material", &materials)?;
        draft.put_sphere(Sphere { center: Vec3::ZERO, radius, material }, center);
    }
    let eyes = tables.camera.iter().map(|camera| &camera.get_ref().eye);
    let lamps = tables.light.iter().filter_map(|light| light.get_ref().position.as_ref());
    for position in eyes.chain(lamps) {
        draft.put_viewpoint(DVec3::from(*position.get_ref()));
    }
    draft.settle();
    for plane in &tables.plane {
        let point = reader.position(&plane.point, "point")?;
        let normal = reader.direction(&plane.normal, "normal")?;
        let material = reader.named(&plane.material, "material", &materials)?;
        draft.put_plane(Plane { point: Vec3::ZERO, normal, material }, point);
    }
    for camera in &tables.camera {
        let camera = reader.camera(camera, &draft)?;
        draft.scene.cameras.push(camera);
    }
    for light in &tables.light {
        let light = reader.light(light, &draft)?;
        draft.scene.lights.push(light);
    }
    Ok(draft.scene)
}

impl Reader<'_> {
    fn fault(&self, span: &Range<usize>, field: &str, what: &str, mend: &str) -> SceneError {
        SceneProblem::faulty(line_of(self.text, span), field, what, mend).of_file(self.file)
    }

    /// What the library refuses: the field is in its message, or stands in the line.
    fn syntax(&self, error: &toml::de::Error) -> SceneError {
        let span = error.span().unwrap_or(0..0);
        let message = error.message().replace('\n', ", ");
        let start = self.text[..span.start.min(self.text.len())].rfind('\n').map_or(0, |at| at + 1);
        let line = self.text[start..].lines().next().unwrap_or_default();
        let quoted = message.split('`').nth(1).filter(|_| message.contains(" field `"));
        let field = quoted.unwrap_or_else(|| line.split('=').next().unwrap_or_default().trim());
        let mend = if message.starts_with("missing field") {
            "add it to this table"
        } else {
            "see the format in crates/scene/README.md"
        };
        self.fault(&span, field, &message, mend)
    }

    fn finite(&self, value: &Triple, field: &str) -> Result<Vec3, SceneError> {
        let vector = Vec3::from(*value.get_ref());
        if vector.is_finite() {
            return Ok(vector);
        }
        Err(self.fault(&value.span(), field, "is not finite", "write three finite numbers"))
    }

    /// A position that is finite in f32.
    fn position(&self, value: &Position, field: &str) -> Result<DVec3, SceneError> {
        let position = DVec3::from(*value.get_ref());
        if position.as_vec3().is_finite() {
            return Ok(position);
        }
        Err(self.fault(&value.span(), field, "is not finite", "write three finite numbers"))
    }

    fn direction(&self, value: &Triple, field: &str) -> Result<Vec3, SceneError> {
        self.finite(value, field)?.try_normalize().ok_or_else(|| {
            self.fault(&value.span(), field, "has no direction", "write one that is not 0")
        })
    }

    /// A colour of light: no part below 0.
    fn radiance(&self, value: &Triple, field: &str) -> Result<Vec3, SceneError> {
        let color = self.finite(value, field)?;
        if color.min_element() >= 0.0 {
            return Ok(color);
        }
        Err(self.fault(&value.span(), field, "is below 0", "write red, green and blue from 0"))
    }

    /// A colour of a surface: every part from 0 to 1.
    fn share(&self, value: &Triple, field: &str) -> Result<Vec3, SceneError> {
        let color = self.radiance(value, field)?;
        if color.max_element() <= 1.0 {
            return Ok(color);
        }
        let mend = "write red, green and blue from 0 to 1";
        Err(self.fault(&value.span(), field, "is above 1", mend))
    }

    fn within(
        &self,
        value: &Number,
        field: &str,
        range: Range<f32>,
        mend: &str,
    ) -> Result<f32, SceneError> {
        let number = *value.get_ref();
        if range.contains(&number) {
            return Ok(number);
        }
        Err(self.fault(&value.span(), field, &format!("is {number}"), mend))
    }

    fn positive(&self, value: &Number, field: &str) -> Result<f32, SceneError> {
        let least = f32::MIN_POSITIVE;
        self.within(value, field, least..f32::INFINITY, "write a finite number above 0")
    }

    fn named(&self, name: &Name, field: &str, names: &Names<'_>) -> Result<usize, SceneError> {
        names.get(name.get_ref().as_str()).copied().ok_or_else(|| {
            let known: Vec<&str> = names.keys().copied().collect();
            let mend = match known.len() {
                0 => format!("add a table [{field}.{}]", name.get_ref()),
                _ => format!("there are {}", known.join(", ")),
            };
            let what = format!("`{}` is not in this file", name.get_ref());
            self.fault(&name.span(), field, &what, &mend)
        })
    }

    /// A field that the table's kind asks for.
    fn asked<'t, T>(
        &self,
        value: Option<&'t T>,
        kind: &Name,
        field: &str,
    ) -> Result<&'t T, SceneError> {
        value.ok_or_else(|| {
            let what = format!("is missing where kind is `{}`", kind.get_ref());
            self.fault(&kind.span(), field, &what, "add it to this table")
        })
    }

    fn unknown_kind(&self, kind: &Name, field: &str, known: &str) -> SceneError {
        let what = format!("`{}` is not known", kind.get_ref());
        self.fault(&kind.span(), field, &what, &format!("write {known}"))
    }

    fn picture(&self, picture: &Picture, scene: &mut Scene) -> Result<(), SceneError> {
        let side = |value: &Option<Spanned<u32>>, field, default| match value {
            None => Ok(default),
            Some(value) if (1..=65_536).contains(value.get_ref()) => Ok(*value.get_ref()),
            Some(value) => {
                let what = format!("is {}", value.get_ref());
                Err(self.fault(&value.span(), field, &what, "write 1 to 65536"))
            }
        };
        scene.size =
            [side(&picture.width, "width", SIZE[0])?, side(&picture.height, "height", SIZE[1])?];
        if let Some(background) = &picture.background {
            scene.background = self.radiance(background, "background")?;
            scene.zenith = scene.background;
        }
        if let Some(zenith) = &picture.zenith {
            scene.zenith = self.radiance(zenith, "zenith")?;
        }
        if let Some(ambient) = &picture.ambient {
            scene.ambient = self.radiance(ambient, "ambient")?;
        }
        Ok(())
    }

    fn camera(&self, table: &Spanned<CameraTable>, draft: &Draft) -> Result<Camera, SceneError> {
        let CameraTable { name, kind, eye, look_at, up, .. } = table.get_ref();
        let CameraTable { field_of_view, height, aperture, focus, .. } = table.get_ref();
        let angle = || -> Result<f32, SceneError> {
            let field = "field_of_view";
            let value = self.asked(field_of_view.as_ref(), kind, field)?;
            let degrees =
                self.within(value, field, 1e-3..179.0, "write degrees from 0.001 to 179")?;
            Ok(degrees.to_radians())
        };
        let length = |value: &Option<Number>, field| {
            self.positive(self.asked(value.as_ref(), kind, field)?, field)
        };
        let lens = match kind.get_ref().as_str() {
            "pinhole" => Lens::Pinhole { field_of_view: angle()? },
            "orthographic" => Lens::Orthographic { height: length(height, "height")? },
            "thin-lens" => Lens::Thin {
                field_of_view: angle()?,
                radius: length(aperture, "aperture")? * 0.5,
                focus: length(focus, "focus")?,
            },
            _ => {
                let known = "pinhole, orthographic or thin-lens";
                return Err(self.unknown_kind(kind, "kind", known));
            }
        };
        let eye = draft.local(self.position(eye, "eye")?);
        let at = draft.local(self.position(look_at, "look_at")?);
        let vertical = match up {
            Some(up) => self.direction(up, "up")?,
            None => Vec3::Y,
        };
        let mut camera = Camera::looking(eye, at, vertical, lens).ok_or_else(|| {
            let what = "gives no direction: it is at the eye, or straight up from it";
            self.fault(&look_at.span(), "look_at", what, "move it, or turn up")
        })?;
        camera.name.clone_from(name);
        Ok(camera)
    }

    fn light(&self, table: &Spanned<LightTable>, draft: &Draft) -> Result<Light, SceneError> {
        let LightTable { kind, position, direction, intensity, irradiance, inner, outer } =
            table.get_ref();
        let position = || {
            let position = self.asked(position.as_ref(), kind, "position")?;
            self.position(position, "position").map(|position| draft.local(position))
        };
        let direction =
            || self.direction(self.asked(direction.as_ref(), kind, "direction")?, "direction");
        let intensity =
            || self.radiance(self.asked(intensity.as_ref(), kind, "intensity")?, "intensity");
        match kind.get_ref().as_str() {
            "point" => Ok(Light::Point { position: position()?, intensity: intensity()? }),
            "directional" => {
                let irradiance = self.asked(irradiance.as_ref(), kind, "irradiance")?;
                let irradiance = self.radiance(irradiance, "irradiance")?;
                Ok(Light::Directional { direction: direction()?, irradiance })
            }
            "spot" => {
                let outer = self.asked(outer.as_ref(), kind, "outer")?;
                let mend = "write degrees above 0, to 90";
                let widest = self.within(outer, "outer", 1e-3..90.001, mend)?;
                let narrowest = match inner {
                    None => 0.0,
                    Some(inner) => {
                        let mend = "write degrees from 0 to below outer";
                        self.within(inner, "inner", 0.0..widest, mend)?
                    }
                };
                Ok(Light::Spot {
                    position: position()?,
                    direction: direction()?,
                    intensity: intensity()?,
                    inner: narrowest.to_radians().cos(),
                    outer: widest.to_radians().cos(),
                })
            }
            _ => Err(self.unknown_kind(kind, "kind", "point, spot or directional")),
        }
    }

    fn texture(
        &self,
        table: &Spanned<TextureTable>,
        folder: &Path,
        reading: &mut Reading,
    ) -> Result<Texture, SceneError> {
        let TextureTable { file, checker, scale } = table.get_ref();
        let pixels = match (file, checker) {
            (Some(file), None) => {
                let path = folder.join(file.get_ref());
                Texture::load(&path, reading).map_err(|problem| {
                    let what = format!("`{}`: {problem}", file.get_ref());
                    self.fault(&file.span(), "file", &what, "name a PNG or a JPEG beside the scene")
                })?
            }
            (None, Some(checker)) => {
                let colors = checker.get_ref().map(Vec3::from);
                if colors
                    .iter()
                    .any(|color| !(color.min_element() >= 0.0 && color.max_element() <= 1.0))
                {
                    let mend = "write red, green and blue from 0 to 1";
                    let span = checker.span();
                    return Err(self.fault(&span, "checker", "is not from 0 to 1", mend));
                }
                Pixels::Checker(colors)
            }
            _ => {
                let what = "has no file and no checker, or both";
                return Err(self.fault(&table.span(), "texture", what, "give one of them"));
            }
        };
        let scale = match scale {
            None => Vec2::ONE,
            Some(scale) => {
                let value = Vec2::from(*scale.get_ref());
                if !value.is_finite() {
                    let span = scale.span();
                    return Err(self.fault(&span, "scale", "is not finite", "write two numbers"));
                }
                value
            }
        };
        Ok(Texture { scale, pixels })
    }

    fn material(
        &self,
        name: &str,
        table: &Spanned<MaterialTable>,
        textures: &Names<'_>,
    ) -> Result<Material, SceneError> {
        let MaterialTable { diffuse, specular, reflection, transmission, .. } = table.get_ref();
        let MaterialTable { shininess, index_of_refraction, emission, texture, .. } =
            table.get_ref();
        let share = |value: &Option<Triple>, field| {
            value.as_ref().map_or(Ok(Vec3::ZERO), |value| self.share(value, field))
        };
        let mut material = Material {
            name: name.to_owned(),
            diffuse: share(diffuse, "diffuse")?,
            specular: share(specular, "specular")?,
            reflection: share(reflection, "reflection")?,
            transmission: share(transmission, "transmission")?,
            ..Material::default()
        };
        if let Some(exponent) = shininess {
            let range = 0.0..1e6;
            material.shininess = self.within(exponent, "shininess", range, "write 0 to 1e6")?;
        }
        if let Some(index) = index_of_refraction {
            material.index_of_refraction = self.positive(index, "index_of_refraction")?;
        }
        if let Some(color) = emission {
            material.emission = self.radiance(color, "emission")?;
        }
        if let Some(name) = texture {
            material.texture = Some(self.named(name, "texture", textures)?);
        }
        Ok(material)
    }

    fn mesh(
        &self,
        table: &Spanned<MeshTable>,
        folder: &Path,
        scene: &mut Scene,
        reading: &mut Reading,
    ) -> Result<Mesh, SceneError> {
        match table.get_ref() {
            MeshTable { file: Some(file), model: None } => {
                let path = folder.join(file.get_ref());
                match MeshFormat::of(&path) {
                    Some(MeshFormat::Obj) => obj::load(&path, scene, reading),
                    Some(_) => load_triangles(&path, reading),
                    None => {
                        let what = format!("`{}` is of an unknown type", quoted(file.get_ref()));
                        let mend = "name a .ply, .obj, .stl, .gltf or .glb";
                        Err(self.fault(&file.span(), "file", &what, mend))
                    }
                }
            }
            MeshTable { file: None, model: Some(model) } => match model.get_ref().as_str() {
                "chair" => Ok(Mesh::chair()),
                _ => Err(self.unknown_kind(model, "model", "chair")),
            },
            _ => {
                let what = "has no file and no model, or both";
                Err(self.fault(&table.span(), "mesh", what, "give one of them"))
            }
        }
    }

    fn instance(
        &self,
        table: &Spanned<InstanceTable>,
        scene: &Scene,
        meshes: &Names<'_>,
        materials: &Names<'_>,
    ) -> Result<(Instance, DAffine3), SceneError> {
        let InstanceTable { mesh, material, translate, rotate, scale, normals } = table.get_ref();
        let number = self.named(mesh, "mesh", meshes)?;
        let material = match material {
            Some(material) => Some(self.named(material, "material", materials)?),
            None if scene.meshes[number].materials.is_empty() => {
                let what = "is missing, and the mesh has none of its own";
                return Err(self.fault(&mesh.span(), "material", what, "add it to this table"));
            }
            None => None,
        };
        let part = |value: &Option<Triple>, field, default| {
            value.as_ref().map_or(Ok(default), |value| self.finite(value, field))
        };
        let size = part(scale, "scale", Vec3::ONE)?;
        if let Some(scale) = scale
            && size.to_array().contains(&0.0)
        {
            return Err(self.fault(&scale.span(), "scale", "is 0", "write numbers that are not 0"));
        }
        let turn = part(rotate, "rotate", Vec3::ZERO)?.map(f32::to_radians);
        let turn = Quat::from_euler(EulerRot::XYZEx, turn.x, turn.y, turn.z);
        let place = match translate {
            Some(translate) => self.position(translate, "translate")?,
            None => DVec3::ZERO,
        };
        let smooth = match normals {
            None => true,
            Some(normals) => match normals.get_ref().as_str() {
                "smooth" => true,
                "flat" => false,
                _ => return Err(self.unknown_kind(normals, "normals", "smooth or flat")),
            },
        };
        let linear = Affine3A::from_scale_rotation_translation(size, turn, Vec3::ZERO);
        let to_world = DAffine3 { translation: place, ..linear.as_daffine3() };
        let smooth = smooth && !scene.meshes[number].normals.is_empty();
        Ok((Instance { mesh: number, material, smooth, ..Instance::default() }, to_world))
    }
}
