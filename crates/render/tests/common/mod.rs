//! What the tests of pictures share.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use trisect_method::Method;
use trisect_render::{Image, Renderer, Settings, Stage, Watch};
use trisect_scene::Scene;
use trisect_tracer::{Builder, Bvh, Tree};

/// A scene of `data/scenes`.
pub(crate) fn shipped(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes");
    Scene::load(folder.join(name)).unwrap_or_else(|error| panic!("{error}"))
}

/// A scene from a text, after a camera that looks down the negative z axis from (0, 0, 10), 2 high.
pub(crate) fn scene(text: &str) -> Scene {
    let camera =
        "[[camera]]\nkind = \"orthographic\"\neye = [0, 0, 10]\nlook_at = [0, 0, 0]\nheight = 2\n";
    Scene::from_toml("test", &format!("{camera}{text}"), None)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// A scene in trees of a method.
pub(crate) fn stage<M: Method>(scene: Scene) -> Stage {
    Stage::new(scene, |triangles| {
        Ok(Box::new(Bvh::<M>::build(triangles, Builder::Spatial)?) as Box<dyn Tree>)
    })
    .expect("the method takes every mesh")
}

/// The picture of a stage.
pub(crate) fn render(stage: &Stage, settings: &Settings) -> Image {
    let watch = Watch { stop: &AtomicBool::new(false), tile: &|| () };
    Renderer::new(stage).render(settings, &watch).expect("nobody stopped it")
}

/// The colour of the pixel at a point of the picture of [`scene`]'s camera: x and y from −1 to 1.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "pixels")]
pub(crate) fn at(image: &Image, x: f32, y: f32) -> trisect_scene::Color {
    let [width, height] = image.size.map(|side| side as f32);
    let column = ((x / (width / height) + 1.0) * 0.5 * width) as usize;
    let row = ((1.0 - y) * 0.5 * height) as usize;
    image.pixels[row * image.size[0] as usize + column]
}
