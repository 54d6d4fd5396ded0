//! Scenes from files, by the ending of the file's name.

use std::path::Path;

use glam::{DVec3, Vec3};
use trisect_mesh::{FileInMemory, MeshFormat, ReadOptions, ReadProblem, Reading};

use crate::draft::Draft;
use crate::error::{SceneError, SceneProblem};
use crate::mesh::Mesh;
use crate::model::{Material, Scene};
use crate::{gltf_scene, obj, toml_file};

/// Pixels of a picture where a file says nothing of it.
pub(crate) const SIZE: [u32; 2] = [640, 480];

/// The scenes of `data/scenes` with all files that they name, by their paths in `data`.
pub const SHIPPED: &[FileInMemory] = &[
    ("meshes/teapot.ply", include_bytes!("../../../data/meshes/teapot.ply")),
    ("scenes/block.mtl", include_bytes!("../../../data/scenes/block.mtl")),
    ("scenes/block.obj", include_bytes!("../../../data/scenes/block.obj")),
    ("scenes/bricks.png", include_bytes!("../../../data/scenes/bricks.png")),
    ("scenes/glass.toml", include_bytes!("../../../data/scenes/glass.toml")),
    ("scenes/lens.toml", include_bytes!("../../../data/scenes/lens.toml")),
    ("scenes/mirror.toml", include_bytes!("../../../data/scenes/mirror.toml")),
    ("scenes/room.toml", include_bytes!("../../../data/scenes/room.toml")),
    ("scenes/teapots.toml", include_bytes!("../../../data/scenes/teapots.toml")),
    ("scenes/textures.toml", include_bytes!("../../../data/scenes/textures.toml")),
];

impl Scene {
    /// Reads a scene: `.toml` as this crate's documentation describes it, `.gltf` and `.glb`, `.obj` with
    /// its materials, or a mesh alone (`.ply`, `.stl`). Where a file has no camera, one looks at all of
    /// it; where it has no light, one shines from over the camera's shoulder, and there is some ambient
    /// light.
    ///
    /// # Errors
    /// When a file cannot be read or is faulty; the message names the file, the line or element, the
    /// field and what mends it.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        Self::load_with(path, &ReadOptions::default())
    }

    /// The same, read as the options say.
    ///
    /// # Errors
    /// As [`Scene::load`], and for what the options refuse.
    pub fn load_with(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Self, SceneError> {
        let mut reading = Reading::new(options);
        let mut scene = Self::read(path.as_ref(), &mut reading)?;
        scene.notes = reading.into_notes();
        Ok(scene)
    }

    /// Reads one of the scenes that are compiled into the program, by its path among [`SHIPPED`].
    ///
    /// # Errors
    /// When there is no such scene.
    pub fn shipped(path: &str) -> Result<Self, SceneError> {
        Self::read(Path::new(path), &mut Reading::in_memory(SHIPPED))
    }

    fn read(path: &Path, reading: &mut Reading) -> Result<Self, SceneError> {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        if ending.eq_ignore_ascii_case("toml") {
            let mut text = read_text(path, reading)?;
            if text.contains('\r') && !text.contains('\n') {
                let fail =
                    |problem| SceneProblem::Unread(problem).of_file(path.display().to_string());
                reading.tolerate("file", "line ends of CR alone").map_err(fail)?;
                text = text.replace('\r', "\n");
            }
            return toml_file::parse(&path.display().to_string(), &text, path.parent(), reading);
        }
        let mut draft = Draft::new();
        match MeshFormat::of(path) {
            Some(MeshFormat::Gltf) => draft = gltf_scene::load(path, reading)?,
            Some(MeshFormat::Obj) => {
                let mesh = obj::load(path, &mut draft.scene, reading)?;
                draft.put_mesh(mesh);
                draft.settle();
            }
            Some(MeshFormat::Ply | MeshFormat::Stl) => {
                let mesh = load_triangles(path, reading)?;
                draft.scene.materials.push(Material::default());
                draft.put_mesh(Mesh { materials: vec![0; mesh.triangles.len()], ..mesh });
                draft.settle();
            }
            None => return Err(SceneProblem::UnknownType.of_file(path.display().to_string())),
        }
        draft.complete().map_err(|problem| problem.of_file(path.display().to_string()))
    }

    /// Reads a scene in this crate's format from memory; `name` stands for the file in messages, and
    /// files that it names are looked for in `folder`.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn from_toml(name: &str, text: &str, folder: Option<&Path>) -> Result<Self, SceneError> {
        let mut reading = Reading::new(&ReadOptions::default());
        let mut scene = toml_file::parse(name, text, folder, &mut reading)?;
        scene.notes = reading.into_notes();
        Ok(scene)
    }

    /// A scene with nothing in it, not even a camera.
    pub(crate) fn empty() -> Self {
        Self {
            size: SIZE,
            background: Vec3::ZERO,
            zenith: Vec3::ZERO,
            ambient: Vec3::ZERO,
            cameras: Vec::new(),
            lights: Vec::new(),
            materials: Vec::new(),
            textures: Vec::new(),
            meshes: Vec::new(),
            instances: Vec::new(),
            spheres: Vec::new(),
            planes: Vec::new(),
            origin: DVec3::ZERO,
            rounding: 0.0,
            notes: Vec::new(),
        }
    }

    /// The lowest and highest corner of the box around all instances and spheres; `None` where there is
    /// neither.
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        let corners = self.instances.iter().flat_map(|instance| {
            let triangles = self.meshes.get(instance.mesh).map(|mesh| &mesh.triangles);
            triangles.into_iter().flatten().flat_map(|triangle| {
                triangle.corners().map(|corner| instance.to_world.transform_point3(corner.into()))
            })
        });
        let spheres = self
            .spheres
            .iter()
            .flat_map(|s| [s.center - Vec3::splat(s.radius), s.center + Vec3::splat(s.radius)]);
        corners.chain(spheres).fold(None, |bounds, p| {
            let [low, high] = bounds.unwrap_or([p, p]);
            Some([low.min(p), high.max(p)])
        })
    }
}

pub(crate) fn read_text(path: &Path, reading: &mut Reading) -> Result<String, SceneError> {
    let fail =
        |problem: ReadProblem| SceneProblem::from(problem).of_file(path.display().to_string());
    reading.text(path).map_err(fail)
}

/// Triangles of a file of any format, with smooth normals and without materials.
pub(crate) fn load_triangles(path: &Path, reading: &mut Reading) -> Result<Mesh, SceneError> {
    let mesh = trisect_mesh::Mesh::read(path, reading)?;
    Ok(Mesh::near(&*mesh.name, &mesh.triangles_f64()).with_smooth_normals())
}
