//! What is read of a glTF document, named as the specification names it.
//!
//! Numbers are f64, as JSON has them. What is not here is passed over, whatever it is.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::IgnoredAny;

/// The document. Lists are empty where the file has none.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Document {
    pub(super) asset: Asset,
    pub(super) extensions_used: Vec<String>,
    pub(super) extensions_required: Vec<String>,
    pub(super) scene: Option<usize>,
    pub(super) scenes: Vec<Scene>,
    /// The nodes.
    pub nodes: Vec<Node>,
    pub(super) meshes: Vec<Mesh>,
    pub(super) skins: Vec<Skin>,
    pub(super) animations: Vec<IgnoredAny>,
    pub(super) accessors: Vec<Accessor>,
    pub(super) buffer_views: Vec<View>,
    pub(super) buffers: Vec<Buffer>,
    /// The cameras.
    pub cameras: Vec<Camera>,
    /// The materials.
    pub materials: Vec<Material>,
    /// The textures.
    pub textures: Vec<Texture>,
    /// The images.
    pub images: Vec<Image>,
    pub(super) samplers: Vec<Sampler>,
    extensions: DocumentExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Asset {
    pub(super) version: Option<Version>,
    pub(super) min_version: Option<Version>,
}

/// A version: text, but the format's first one had numbers.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum Version {
    Text(String),
    Number(f64),
}

impl std::fmt::Display for Version {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Number(number) => write!(f, "{number:?}"),
        }
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct DocumentExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    lights: Option<Extension<Lights>>,
}

#[derive(Debug, Deserialize)]
struct Lights {
    lights: Vec<Light>,
}

impl Document {
    /// The lights of `KHR_lights_punctual`.
    pub fn lights(&self) -> &[Light] {
        let lights = self.extensions.lights.as_ref().and_then(Extension::sound);
        lights.map_or(&[], |lights| &lights.lights)
    }

    /// The texture that a material's base colour is multiplied by, where it has one.
    pub fn base_texture(&self, material: Option<usize>) -> Option<&TextureInfo> {
        self.materials.get(material?)?.surface.base_color_texture.as_ref()
    }
}

/// An extension: what breaks its rules does not break the document.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum Extension<T> {
    Sound(T),
    Faulty(IgnoredAny),
}

impl<T> Extension<T> {
    fn sound(&self) -> Option<&T> {
        match self {
            Self::Sound(extension) => Some(extension),
            Self::Faulty(_) => None,
        }
    }
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub(super) nodes: Vec<usize>,
}

/// A node.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Node {
    /// Its name; may be empty.
    pub name: String,
    pub(super) children: Vec<usize>,
    pub(super) matrix: Option<Box<[f64; 16]>>,
    pub(super) translation: Option<[f64; 3]>,
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<[f64; 3]>,
    pub(super) mesh: Option<usize>,
    pub(super) skin: Option<usize>,
    pub(super) weights: Option<Vec<f64>>,
    /// The number of its camera.
    pub camera: Option<usize>,
    extensions: NodeExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    light: Option<Extension<NodeLight>>,
}

#[derive(Debug, Deserialize)]
struct NodeLight {
    light: usize,
}

impl Node {
    /// The number of its light.
    pub fn light(&self) -> Option<usize> {
        self.extensions.light.as_ref()?.sound().map(|node| node.light)
    }
}

#[derive(Debug, Deserialize)]
pub(super) struct Mesh {
    #[serde(default)]
    pub(super) name: String,
    pub(super) primitives: Vec<Primitive>,
    #[serde(default)]
    pub(super) weights: Vec<f64>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    pub(super) attributes: BTreeMap<String, usize>,
    pub(super) indices: Option<usize>,
    pub(super) material: Option<usize>,
    #[serde(default = "triangles")]
    pub(super) mode: u32,
    #[serde(default)]
    pub(super) targets: Vec<BTreeMap<String, usize>>,
    /// By their names alone.
    #[serde(default)]
    pub(super) extensions: BTreeMap<String, Option<IgnoredAny>>,
}

const fn triangles() -> u32 {
    4
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Skin {
    pub(super) inverse_bind_matrices: Option<usize>,
    pub(super) joints: Vec<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<usize>,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) component_type: u32,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) count: usize,
    #[serde(rename = "type")]
    pub(super) kind: String,
    pub(super) min: Option<IgnoredAny>,
    pub(super) max: Option<IgnoredAny>,
    pub(super) sparse: Option<Sparse>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Sparse {
    pub(super) count: usize,
    pub(super) indices: SparsePart,
    pub(super) values: SparsePart,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparsePart {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    /// Of indices alone.
    #[serde(default)]
    pub(super) component_type: u32,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct View {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) byte_length: usize,
    pub(super) byte_stride: Option<usize>,
    /// By their names alone.
    #[serde(default)]
    pub(super) extensions: BTreeMap<String, Option<IgnoredAny>>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub(super) uri: Option<String>,
    pub(super) byte_length: usize,
}

/// A camera.
#[derive(Debug, Deserialize)]
pub struct Camera {
    /// How it sees, if it is of this kind.
    pub perspective: Option<Perspective>,
    /// The same.
    pub orthographic: Option<Orthographic>,
}

/// A camera whose rays go through one point.
#[derive(Debug, Deserialize)]
pub struct Perspective {
    /// Angle between the picture's lower and upper edge, in radians.
    pub yfov: f32,
}

/// A camera whose rays are parallel.
#[derive(Debug, Deserialize)]
pub struct Orthographic {
    /// Half the height of what is seen.
    pub ymag: f32,
}

/// A light of `KHR_lights_punctual`.
#[derive(Debug, Deserialize)]
pub struct Light {
    /// `point`, `spot` or `directional`.
    #[serde(rename = "type")]
    pub kind: String,
    /// Linear red, green and blue.
    #[serde(default = "white")]
    pub color: [f32; 3],
    /// In candela, or in lux if it is directional.
    #[serde(default = "one")]
    pub intensity: f32,
    /// The cone of a spot.
    #[serde(default)]
    pub spot: Spot,
}

/// Angles between a spot's axis and where its light begins and ends to fade, in radians.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Spot {
    /// Where it begins to fade.
    pub inner_cone_angle: f32,
    /// Where it has faded.
    pub outer_cone_angle: f32,
}

impl Default for Spot {
    fn default() -> Self {
        Self { inner_cone_angle: 0.0, outer_cone_angle: std::f32::consts::FRAC_PI_4 }
    }
}

/// A material.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Material {
    /// Its name; may be empty.
    pub name: String,
    /// The metallic-roughness model.
    #[serde(rename = "pbrMetallicRoughness")]
    pub surface: Surface,
    normal_texture: Option<IgnoredAny>,
    emissive_texture: Option<IgnoredAny>,
    /// Linear red, green and blue of the light that it gives off.
    pub emissive_factor: [f32; 3],
    alpha_mode: Option<String>,
    extensions: MaterialExtensions,
}

/// The metallic-roughness model.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Surface {
    /// Linear red, green, blue and opacity.
    pub base_color_factor: [f32; 4],
    base_color_texture: Option<TextureInfo>,
    /// How far it is a metal, 0 to 1.
    pub metallic_factor: f32,
    /// How rough it is, 0 to 1.
    pub roughness_factor: f32,
    metallic_roughness_texture: Option<IgnoredAny>,
}

impl Default for Surface {
    fn default() -> Self {
        Self {
            base_color_factor: [1.0; 4],
            base_color_texture: None,
            metallic_factor: 1.0,
            roughness_factor: 1.0,
            metallic_roughness_texture: None,
        }
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct MaterialExtensions {
    #[serde(rename = "KHR_materials_transmission")]
    transmission: Option<Extension<Transmission>>,
    #[serde(rename = "KHR_materials_ior")]
    ior: Option<Extension<Ior>>,
    #[serde(rename = "KHR_materials_emissive_strength")]
    emissive_strength: Option<Extension<EmissiveStrength>>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Transmission {
    #[serde(default)]
    transmission_factor: f32,
}

#[derive(Debug, Deserialize)]
struct Ior {
    ior: Option<f32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct EmissiveStrength {
    emissive_strength: Option<f32>,
}

impl Material {
    /// Share of light that enters, of `KHR_materials_transmission`.
    pub fn transmission(&self) -> f32 {
        let extension = self.extensions.transmission.as_ref().and_then(Extension::sound);
        extension.map_or(0.0, |extension| extension.transmission_factor)
    }

    /// Index of refraction, of `KHR_materials_ior`.
    pub fn index_of_refraction(&self) -> f32 {
        let extension = self.extensions.ior.as_ref().and_then(Extension::sound);
        extension.and_then(|extension| extension.ior).unwrap_or(1.5)
    }

    /// Factor of the emitted light, of `KHR_materials_emissive_strength`.
    pub fn emissive_strength(&self) -> f32 {
        let extension = self.extensions.emissive_strength.as_ref().and_then(Extension::sound);
        extension.and_then(|extension| extension.emissive_strength).unwrap_or(1.0)
    }

    /// Whether it has maps other than that of the base colour, which are not read.
    pub fn has_other_maps(&self) -> bool {
        let others = [
            &self.normal_texture,
            &self.emissive_texture,
            &self.surface.metallic_roughness_texture,
        ];
        others.into_iter().any(Option::is_some)
    }

    /// Whether some of it is to be seen through for its alpha, which is not read.
    pub fn has_alpha(&self) -> bool {
        self.alpha_mode.as_deref().is_some_and(|mode| mode != "OPAQUE")
    }
}

/// A material's use of a texture.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TextureInfo {
    /// The number of the texture.
    pub index: usize,
    #[serde(default)]
    tex_coord: usize,
    #[serde(default)]
    extensions: TextureInfoExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    transform: Option<Extension<TextureTransform>>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct TextureTransform {
    offset: [f64; 2],
    rotation: f64,
    scale: [f64; 2],
    tex_coord: Option<usize>,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

impl TextureInfo {
    fn transform(&self) -> Option<&TextureTransform> {
        self.extensions.transform.as_ref()?.sound()
    }

    /// The set of coordinates that it uses.
    pub(super) fn set(&self) -> usize {
        self.transform().and_then(|transform| transform.tex_coord).unwrap_or(self.tex_coord)
    }

    /// Coordinates as `KHR_texture_transform` carries them: scaled, turned from v towards u, and moved.
    ///
    /// The specification's text and the sample model that belongs to it turn so; the shader that it
    /// prints turns the other way.
    pub(super) fn carry(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let Some(TextureTransform { offset, rotation, scale, .. }) = self.transform() else {
            return [u, v];
        };
        let (sin, cos) = rotation.sin_cos();
        let [u, v] = [u * scale[0], v * scale[1]];
        [cos * u + sin * v + offset[0], cos * v - sin * u + offset[1]]
    }
}

/// A texture.
#[derive(Debug, Deserialize)]
pub struct Texture {
    /// The number of its image.
    pub source: Option<usize>,
    pub(super) sampler: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Sampler {
    wrap_s: Option<u32>,
    wrap_t: Option<u32>,
}

impl Document {
    /// Whether a texture ends at its edges, or is mirrored there.
    pub fn is_clamped(&self, texture: &Texture) -> bool {
        let sampler = texture.sampler.and_then(|number| self.samplers.get(number));
        let repeats = |wrap: Option<u32>| wrap.is_none_or(|wrap| wrap == 10_497);
        !sampler.is_none_or(|sampler| repeats(sampler.wrap_s) && repeats(sampler.wrap_t))
    }
}

/// An image: in a buffer, in the document or in a file.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Image {
    pub(super) uri: Option<String>,
    pub(super) buffer_view: Option<usize>,
}

const fn white() -> [f32; 3] {
    [1.0; 3]
}

const fn one() -> f32 {
    1.0
}
