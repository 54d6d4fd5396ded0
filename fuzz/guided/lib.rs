//! The readers that can be linked without the kernels, for an engine that watches which code its inputs
//! reach: `fuzz/guided.sh` runs one. As ordinary tests they try some random bytes.

#![cfg(test)]
#![forbid(unsafe_code)]

use std::panic::RefUnwindSafe;
use std::path::Path;

use trisect_fuzz::{Format, corpus, files, quick_folder, seal};

/// Gives bytes to a reader, as a file beside those that a sound one refers to.
fn given_to(
    format: Format,
    read: impl Fn(&Path) + RefUnwindSafe,
) -> impl Fn(&[u8]) + RefUnwindSafe {
    let folder =
        tempfile::tempdir_in(quick_folder()).expect("the system has a folder for temporaries");
    for (path, bytes) in files(&corpus().join("company")).expect("the corpus is there") {
        let name = path.file_name().expect("it is a file");
        std::fs::write(folder.path().join(name), bytes).expect("a temporary folder can be written");
    }
    move |bytes| {
        let mut bytes = bytes.to_vec();
        seal(&mut bytes);
        std::fs::write(folder.path().join(format.file()), bytes)
            .expect("a temporary folder can be written");
        read(&folder.path().join(format.main_file()));
    }
}

/// Whatever comes of it.
fn scene(path: &Path) {
    drop(trisect_scene::Scene::load(path));
}

fn rays(path: &Path) {
    drop(trisect_workloads::read_rays(path));
}

macro_rules! targets {
    ($($name:ident: $format:ident by $read:ident;)*) => {$(
        #[test]
        fn $name() {
            // The name of the target is that of this function.
            bolero::check!().for_each(given_to(Format::$format, $read));
        }
    )*};
}

targets! {
    ply: Ply by scene;
    obj: Obj by scene;
    mtl: Mtl by scene;
    stl: Stl by scene;
    gltf: Gltf by scene;
    glb: Glb by scene;
    toml: Toml by scene;
    png: Png by scene;
    jpeg: Jpeg by scene;
    csv: Csv by rays;
    rays_binary: Rays by rays;
}
