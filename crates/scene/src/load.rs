//! Scenes from files, by the ending of the file's name.

use std::path::Path;

use trisect_mesh::{FileInMemory, MeshFormat, ReadOptions, Reading};

use crate::draft::Draft;
use crate::error::{SceneError, SceneProblem};
use crate::files::read_text;
use crate::mesh::{Mesh, load_triangles};
use crate::model::{Material, Scene};
use crate::{gltf_scene, obj, toml_file};

/// The scenes of `data/scenes` with all files that they name, by their paths in `data`.
pub const SHIPPED: &[FileInMemory] = &[
    ("meshes/teapot.ply", include_bytes!("../../../data/meshes/teapot.ply")),
    ("scenes/block.mtl", include_bytes!("../../../data/scenes/block.mtl")),
    ("scenes/block.obj", include_bytes!("../../../data/scenes/block.obj")),
    ("scenes/bricks.png", include_bytes!("../../../data/scenes/bricks.png")),
    ("scenes/glass.toml", include_bytes!("../../../data/scenes/glass.toml")),
    ("scenes/lens.toml", include_bytes!("../../../data/scenes/lens.toml")),
    ("scenes/mirror.toml", include_bytes!("../../../data/scenes/mirror.toml")),
    ("scenes/morozov.toml", include_bytes!("../../../data/scenes/morozov.toml")),
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
}
