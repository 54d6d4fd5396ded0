//! The scenes that are compiled into the program, as files.

use trisect_scene::{SHIPPED, Scene};

/// A folder with them, for as long as it lives.
pub(crate) struct Shipped(tempfile::TempDir);

impl Shipped {
    /// Writes the files.
    ///
    /// # Panics
    /// When the system has no place for temporary files.
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().expect("the system has a place for temporary files");
        for (name, content) in SHIPPED {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap_or(folder.path()))
                .and_then(|()| std::fs::write(path, content))
                .expect("the system has a place for temporary files");
        }
        Self(folder)
    }

    /// One of them, by its path in [`SHIPPED`].
    ///
    /// # Panics
    /// When there is no such scene.
    pub(crate) fn load(&self, name: &str) -> Scene {
        let scene = Scene::load(self.0.path().join(name));
        scene.unwrap_or_else(|error| panic!("a shipped scene is faulty: {error}"))
    }
}
