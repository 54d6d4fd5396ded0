//! What is looked at, from where, by which method, and how far the picture has come.

use std::cell::RefCell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use anyhow::{Result, anyhow};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use trisect_catalog::{Builder, Entry, entries};
use trisect_core::Ray;
use trisect_oracle::Oracle;
use trisect_render::{Image, Mode, Renderer, Sampling, Settings, Stage, StageError, Watch};
use trisect_scene::{Camera, Scene};

use crate::controls::Orbit;
use crate::frame::{Frame, MARGIN, Rgb};
use crate::heat::{self, Legend};
use crate::judge::{Cost, Triangles, Verdict, cost, judge};
use crate::view::View;

/// How often a path is reflected, refracted or scattered.
const PATH_DEPTH: u32 = 8;

/// Pixels across and down that are one while the camera moves, at most.
const COARSEST: u32 = 8;

/// Seconds that a picture may take while the camera moves.
const QUICK: f64 = 0.05;

/// What a hand does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Turns the camera about what is in the middle, by shares of the height, to the right and down.
    Turn(Vec2),
    /// Moves it across, by shares of the height.
    Pan(Vec2),
    /// Goes nearer, by notches of a wheel.
    Dolly(f32),
    /// Walks to the right, up and forward, by shares of the distance to what was in the middle.
    Walk(Vec3),
    /// So many methods on in the catalogue, or back.
    Method(isize),
    /// Shows something else.
    View(View),
    /// Looks through the scene's next camera.
    NextCamera,
    /// Puts the camera back.
    Reset,
    /// Shows what the keys do, or hides it.
    Help,
    /// The window has another size.
    Resize([u32; 2]),
}

/// What has been computed.
enum Content {
    /// The sum of so many samples.
    Light(Image, u32),
    Costs([u32; 2], Vec<Cost>),
    Verdicts([u32; 2], Vec<Verdict>),
}

/// How far the picture has come since the last change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Progress {
    /// Pixels that are one go across and down so many.
    Coarse(u32),
    /// So many passes are done at full size.
    Full(u32),
}

/// A scene on show. A window gives it [`Action`]s, has it [`advance`](Viewer::advance), and shows its
/// [`frame`](Viewer::frame).
pub struct Viewer {
    name: String,
    stage: Stage,
    /// Of each of the stage's trees.
    triangles: Triangles,
    /// Its place in the catalogue.
    method: usize,
    builder: Builder,
    view: View,
    size: [u32; 2],
    camera: usize,
    /// The cameras as the scene has them.
    cameras: Vec<Camera>,
    orbit: Orbit,
    progress: Progress,
    is_changed: bool,
    /// `None` before the first pass.
    content: Option<Content>,
    /// Seconds that a pixel took last in each view.
    pace: [Option<f64>; View::ALL.len()],
    note: Option<String>,
    shows_help: bool,
}

impl Viewer {
    /// Puts a scene into trees of a method; `name` is what it is called.
    ///
    /// # Errors
    /// When there is no such method, or it cannot take the scene's triangles.
    ///
    /// # Panics
    /// When the scene has no such camera, or the size is 0.
    pub fn new(
        name: impl Into<String>,
        scene: Scene,
        camera: usize,
        method: &str,
        builder: Builder,
        size: [u32; 2],
    ) -> Result<Self> {
        assert!(size[0] > 0 && size[1] > 0, "a window has pixels");
        let method =
            entries().iter().position(|entry| entry.info.name == method).ok_or_else(|| {
                anyhow!("unknown method `{method}`; `trisect list` shows what there is")
            })?;
        let name = name.into();
        let cameras = scene.cameras.clone();
        let (stage, triangles) = in_trees(scene, &entries()[method], builder)
            .map_err(|unsuitable| anyhow!("{name}: {unsuitable}"))?;
        let mut viewer = Self {
            name,
            stage,
            triangles,
            method,
            builder,
            view: View::Picture,
            size,
            camera,
            cameras,
            orbit: Orbit { distance: 1.0 },
            progress: Progress::Full(0),
            is_changed: true,
            content: None,
            pace: [None; View::ALL.len()],
            note: None,
            shows_help: false,
        };
        viewer.find_pivot();
        Ok(viewer)
    }

    /// Does what a hand does.
    pub fn act(&mut self, action: Action) {
        let (camera, orbit) = (self.stage.camera_mut(self.camera), &mut self.orbit);
        match action {
            Action::Turn(by) => orbit.turn(camera, by),
            Action::Pan(by) => orbit.pan(camera, by),
            Action::Dolly(by) => orbit.dolly(camera, by),
            Action::Walk(by) => orbit.walk(camera, by),
            Action::Method(step) => {
                self.change_method(step);
                return;
            }
            Action::View(view) => {
                // The one has what the other shows.
                let is_same = |view| matches!(view, View::Nodes | View::Triangles);
                let keeps = view == self.view || is_same(view) && is_same(self.view);
                self.view = view;
                if keeps {
                    return;
                }
            }
            Action::NextCamera | Action::Reset => {
                if action == Action::NextCamera {
                    self.camera = (self.camera + 1) % self.cameras.len();
                }
                *self.stage.camera_mut(self.camera) = self.cameras[self.camera].clone();
                self.find_pivot();
            }
            Action::Help => {
                self.shows_help = !self.shows_help;
                return;
            }
            Action::Resize(size) => {
                if size == self.size || size.contains(&0) {
                    return;
                }
                self.size = size;
            }
        }
        self.note = None;
        self.begin();
    }

    /// Goes on, or back, to the next method that can take the scene; a note says which cannot.
    fn change_method(&mut self, step: isize) {
        self.note = None;
        let count = entries().len().cast_signed();
        for hops in 1..count {
            let place = (self.method.cast_signed() + step * hops).rem_euclid(count).cast_unsigned();
            let entry = &entries()[place];
            match in_trees(self.stage.scene().clone(), entry, self.builder) {
                Ok((stage, triangles)) => {
                    (self.stage, self.triangles, self.method) = (stage, triangles, place);
                    self.begin();
                    return;
                }
                Err(unsuitable) => self.note = Some(format!("{}: {unsuitable}", entry.info.name)),
            }
        }
    }

    /// Begins anew, as coarsely as it takes to be quick.
    fn begin(&mut self) {
        let pixels = f64::from(self.size[0]) * f64::from(self.size[1]);
        let coarse = self.pace[self.view as usize].map_or(COARSEST / 2, |pace| {
            let is_quick = |coarse: &u32| pixels / f64::from(coarse * coarse) * pace <= QUICK;
            (0..=COARSEST.ilog2()).map(|power| 1 << power).find(is_quick).unwrap_or(COARSEST)
        });
        self.is_changed = true;
        self.progress = if coarse == 1 { Progress::Full(0) } else { Progress::Coarse(coarse) };
    }

    /// The camera moves around what is in the middle of its picture.
    fn find_pivot(&mut self) {
        let settings = Settings { camera: self.camera, ..Settings::new([1, 1]) };
        let ray = self.stage.primary(&settings, [0, 0]);
        let found = self.stage.sights(ray).filter_map(|sight| sight.tree.inspect(&sight.ray).found);
        let nearest = found.map(|found| found.hit.t).fold(ray.tmax, f32::min) * self.stage.unit();
        // Where there is nothing, as far as the scene is.
        let scene = self.stage.scene();
        let eye = scene.cameras[self.camera].eye;
        let far = || scene.bounds().map(|[low, high]| ((low + high) * 0.5).distance(eye));
        let is_distance = |t: &f32| t.is_finite() && *t > 0.0;
        let distance = Some(nearest).filter(is_distance).or_else(far).filter(is_distance);
        self.orbit.distance = distance.unwrap_or(1.0);
    }

    /// Whether the picture is as good as it gets.
    pub fn is_done(&self) -> bool {
        matches!(self.progress, Progress::Full(passes) if passes >= self.view.passes())
    }

    /// Whether nothing has been computed since the last change: that pass should not be stopped, or whoever
    /// moves all the time sees nothing.
    pub fn is_changed(&self) -> bool {
        self.is_changed
    }

    /// Passes done at full size.
    pub fn passes(&self) -> u32 {
        match self.progress {
            Progress::Coarse(_) => 0,
            Progress::Full(passes) => passes,
        }
    }

    /// The name of the method.
    pub fn method(&self) -> &'static str {
        entries()[self.method].info.name
    }

    /// Does one pass more; whether that changed the picture. It does not where it is stopped, or
    /// where the picture [is done](Viewer::is_done).
    pub fn advance(&mut self, stop: &AtomicBool) -> bool {
        if self.is_done() {
            return false;
        }
        let coarse = match self.progress {
            Progress::Coarse(coarse) => coarse,
            Progress::Full(_) => 1,
        };
        let start = Instant::now();
        let settings = self.settings(coarse);
        let Some(content) = self.pass(&settings, stop) else { return false };
        let pixels = f64::from(settings.size[0]) * f64::from(settings.size[1]);
        self.pace[self.view as usize] = Some(start.elapsed().as_secs_f64() / pixels);
        self.content = Some(content);
        self.is_changed = false;
        self.progress = match self.progress {
            Progress::Coarse(2) => Progress::Full(0),
            Progress::Coarse(coarse) => Progress::Coarse(coarse / 2),
            Progress::Full(passes) => Progress::Full(passes + 1),
        };
        true
    }

    fn settings(&self, coarse: u32) -> Settings {
        let size = self.size.map(|side| side.div_ceil(coarse));
        let sample = self.passes();
        let settings = Settings { camera: self.camera, seed: sample + 1, ..Settings::new(size) };
        match self.view {
            View::Picture => Settings { sampling: Sampling::Jittered(1), ..settings },
            View::Paths => Settings { mode: Mode::Paths, depth: PATH_DEPTH, seed: 1, ..settings },
            View::Triangles | View::Nodes | View::Error => settings,
        }
    }

    /// The next pass, unless it is stopped.
    fn pass(&mut self, settings: &Settings, stop: &AtomicBool) -> Option<Content> {
        let stage = &self.stage;
        match self.view {
            View::Picture | View::Paths => {
                let passes = self.passes();
                let before = match &self.content {
                    Some(Content::Light(sum, count)) if passes > 0 && *count == passes => Some(sum),
                    _ => None,
                };
                let watch = Watch { stop, tile: &|| () };
                let mut renderer = Renderer::new(stage);
                // A copy, as a pass that is stopped leaves what was there.
                let mut image = before.cloned().unwrap_or_else(|| Image::black(settings.size));
                if self.view == View::Paths {
                    renderer.accumulate(settings, passes, &mut image, &watch).ok()?;
                } else {
                    let one = renderer.render(settings, &watch).ok()?;
                    image.pixels.iter_mut().zip(one.pixels).for_each(|(sum, one)| *sum += one);
                }
                Some(Content::Light(image, passes + 1))
            }
            View::Triangles | View::Nodes => {
                let costs = by_pixel(stage, settings, stop, || (), |(), ray| cost(stage, ray))?;
                Some(Content::Costs(settings.size, costs))
            }
            View::Error => {
                let triangles = &self.triangles;
                let verdicts = by_pixel(stage, settings, stop, Oracle::default, |oracle, ray| {
                    judge(stage, triangles, oracle, ray)
                })?;
                Some(Content::Verdicts(settings.size, verdicts))
            }
        }
    }

    /// What there is to see.
    pub fn frame(&self) -> Frame {
        let (coarse, colors, legend): ([u32; 2], Vec<Rgb>, Option<Legend>) = match &self.content {
            None => ([1, 1], vec![[0; 3]], None),
            Some(Content::Light(sum, count)) => {
                let share = 1.0 / *count as f32;
                let pixels = sum.pixels.iter().map(|sum| *sum * share).collect();
                let bytes = Image { size: sum.size, pixels }.to_srgb();
                (sum.size, bytes.as_chunks().0.to_vec(), None)
            }
            Some(Content::Costs(size, costs)) => {
                let (what, of): (_, fn(&Cost) -> usize) = match self.view {
                    View::Nodes => ("nodes visited", |cost| cost.nodes),
                    _ => ("triangles tested", |cost| cost.triangles),
                };
                let counts: Vec<usize> = costs.iter().map(of).collect();
                let (colors, legend) = heat::of_counts(what, &counts);
                (*size, colors, Some(legend))
            }
            Some(Content::Verdicts(size, verdicts)) => {
                let (colors, legend) = heat::of_verdicts(verdicts);
                (*size, colors, Some(legend))
            }
        };
        let mut frame = Frame::of(self.size, coarse, &colors);
        if let Some(legend) = legend {
            legend.draw(&mut frame);
        }
        let mut lines = vec![self.status()];
        lines.extend(self.note.clone());
        let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
        let height = frame.write_box(&lines, [0, 0]);
        if self.shows_help {
            frame.write_box(&HELP, [0, height + MARGIN]);
        } else {
            let right = frame.size[0].cast_signed() - crate::frame::width_of(HINT) - 2 * MARGIN;
            frame.write_box(&[HINT], [right, 0]);
        }
        frame
    }

    /// One line: what is shown, by which method, and how far it has come.
    pub fn status(&self) -> String {
        let Self { name, view, method, .. } = self;
        let so_far = match (self.view, self.progress) {
            (View::Picture | View::Paths, Progress::Full(passes)) if passes > 0 => {
                format!(", {passes} {}", if *view == View::Paths { "paths" } else { "samples" })
            }
            _ => String::new(),
        };
        let (method, count) = (method + 1, entries().len());
        format!("{name}: {view} by {} ({method} of {count}){so_far}", self.method())
    }
}

const HINT: &str = "H: help";

/// What keys and the mouse do.
const HELP: [&str; 10] = [
    "1 2         picture after Whitted, by paths",
    "3 4         triangles tested, nodes visited",
    "5           error of t against the oracle",
    "[ ]         method before, method after",
    "drag        turn about the middle",
    "shift drag  move across, or with the right button",
    "wheel       nearer, farther",
    "W A S D Q E walk, down and up",
    "C R         next camera, camera as it was",
    "H Esc       hide this, close",
];

/// The scene in trees of a method, and the triangles of each.
fn in_trees(
    scene: Scene,
    entry: &Entry,
    builder: Builder,
) -> Result<(Stage, Triangles), StageError> {
    let triangles = RefCell::new(Vec::new());
    let stage = Stage::new(scene, |of_tree| {
        triangles.borrow_mut().push(of_tree.to_vec());
        entry.tree(of_tree, builder)
    })?;
    Ok((stage, triangles.into_inner()))
}

/// Something of the ray through the middle of each pixel, row by row, unless it is stopped. Each row has
/// its own tool.
fn by_pixel<T: Send, U>(
    stage: &Stage,
    settings: &Settings,
    stop: &AtomicBool,
    tool: impl Fn() -> U + Sync,
    of: impl Fn(&mut U, Ray<f32>) -> T + Sync,
) -> Option<Vec<T>> {
    let [width, height] = settings.size;
    let rows = (0..height).into_par_iter().map(|y| {
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        let mut tool = tool();
        let row = (0..width).map(|x| of(&mut tool, stage.primary(settings, [x, y])));
        Some(row.collect::<Vec<T>>())
    });
    let rows: Option<Vec<Vec<T>>> = rows.collect();
    Some(rows?.into_iter().flatten().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::LINE;
    use crate::view::SAMPLES;

    const SCENE: &str = "[picture]\nbackground = [0.2, 0.4, 0.8]\n\
                         [[camera]]\nkind = \"pinhole\"\neye = [1.2, 0.9, 1.6]\nlook_at = [0, 0.4, 0]\n\
                         field_of_view = 40\n\
                         [[camera]]\nkind = \"orthographic\"\neye = [0, 5, 0]\nlook_at = [0, 0, 0]\n\
                         up = [0, 0, -1]\nheight = 3\n\
                         [[light]]\nkind = \"directional\"\ndirection = [-1, -2, -3]\nirradiance = [3, 3, 3]\n\
                         [material.red]\ndiffuse = [0.8, 0.2, 0.1]\n\
                         [mesh.chair]\nmodel = \"chair\"\n\
                         [[instance]]\nmesh = \"chair\"\nmaterial = \"red\"\n";
    const SIZE: [u32; 2] = [320, 200];

    fn viewer() -> Viewer {
        let scene = Scene::from_toml("test", SCENE, None).expect("it is sound");
        Viewer::new("test", scene, 0, "watertight", Builder::Spatial, SIZE).expect("it takes all")
    }

    /// Goes on until so many passes are done at full size.
    fn after(viewer: &mut Viewer, passes: u32) -> Frame {
        while viewer.passes() < passes {
            assert!(viewer.advance(&AtomicBool::new(false)));
        }
        viewer.frame()
    }

    fn colors(frame: &Frame) -> usize {
        let mut colors = frame.pixels.clone();
        colors.sort_unstable();
        colors.dedup();
        colors.len()
    }

    /// How many pixels differ below the line of text.
    fn differing(a: &Frame, b: &Frame) -> usize {
        let text = SIZE[0] as usize * 2 * LINE.unsigned_abs() as usize;
        a.pixels.iter().zip(&b.pixels).skip(text).filter(|(a, b)| a != b).count()
    }

    #[test]
    fn every_view_shows_something_of_its_own_and_ends() {
        let mut viewer = viewer();
        let mut frames = Vec::new();
        for view in View::ALL {
            assert_eq!(view.name().parse(), Ok(view));
            viewer.act(Action::View(view));
            let frame = after(&mut viewer, 1);
            assert_eq!((frame.size, frame.pixels.len()), (SIZE, 320 * 200));
            assert!(colors(&frame) > 50, "{view}: {}", colors(&frame));
            assert!(viewer.status().starts_with(&format!("test: {view} by watertight (")));
            assert_eq!(viewer.is_done(), !matches!(view, View::Picture | View::Paths));
            for other in &frames {
                assert!(differing(&frame, other) > 1000, "{view}");
            }
            frames.push(frame);
        }
        assert!(!viewer.advance(&AtomicBool::new(false)));
        assert!("picture ".parse::<View>().is_err());
    }

    #[test]
    fn a_picture_gets_finer_and_is_the_same_again() {
        let (mut one, mut two) = (viewer(), viewer());
        let (first, fine) = (after(&mut one, 1), after(&mut one, 16));
        assert!(differing(&first, &fine) > 1000);
        assert!(one.status().ends_with(", 16 samples"), "{}", one.status());
        // Whatever was on the way, and however coarse it began.
        two.act(Action::View(View::Error));
        after(&mut two, 1);
        two.act(Action::View(View::Picture));
        assert_eq!(after(&mut two, 16), fine);
        after(&mut two, SAMPLES);
        assert!(two.is_done());
    }

    #[test]
    fn moving_begins_anew_and_putting_back_shows_the_same() {
        let mut viewer = viewer();
        let before = after(&mut viewer, 2);
        for action in [
            Action::Turn(Vec2::new(0.1, 0.05)),
            Action::Pan(Vec2::new(0.1, 0.0)),
            Action::Dolly(2.0),
            Action::Walk(Vec3::new(0.1, 0.0, 0.1)),
        ] {
            viewer.act(action);
            assert!(viewer.is_changed() && viewer.passes() == 0, "{action:?}");
            assert!(differing(&after(&mut viewer, 2), &before) > 1000, "{action:?}");
            assert!(!viewer.is_changed());
            viewer.act(Action::Reset);
            assert_eq!(after(&mut viewer, 2), before, "{action:?}");
        }
        viewer.act(Action::NextCamera);
        assert!(differing(&after(&mut viewer, 2), &before) > 1000);
        viewer.act(Action::NextCamera);
        assert_eq!(after(&mut viewer, 2), before);
        viewer.act(Action::Help);
        assert!(!viewer.is_changed() && viewer.frame() != before);
    }

    #[test]
    fn what_is_stopped_leaves_what_was_there() {
        let mut viewer = viewer();
        for view in View::ALL {
            viewer.act(Action::View(view));
            let before = viewer.frame();
            assert!(!viewer.advance(&AtomicBool::new(true)));
            assert_eq!(viewer.frame(), before, "{view}");
            after(&mut viewer, 1);
        }
    }

    #[test]
    fn methods_are_stepped_through_and_leave_the_camera() {
        let mut viewer = viewer();
        viewer.act(Action::Dolly(3.0));
        let before = after(&mut viewer, 1);
        let mut seen = vec![viewer.method()];
        viewer.act(Action::Method(1));
        while viewer.method() != "watertight" {
            assert!(!seen.contains(&viewer.method()), "{}", viewer.method());
            seen.push(viewer.method());
            viewer.act(Action::Method(1));
        }
        assert!(seen.len() > 30, "{}", seen.len());
        assert_eq!(after(&mut viewer, 1), before);
        viewer.act(Action::Method(-1));
        assert_eq!(viewer.method(), seen[seen.len() - 1]);
        assert!(differing(&after(&mut viewer, 1), &before) < 500);
    }

    #[test]
    fn a_window_may_have_any_size() {
        let mut viewer = viewer();
        for size in [[1, 1], [7, 300], [900, 3]] {
            for view in View::ALL {
                viewer.act(Action::Resize(size));
                viewer.act(Action::View(view));
                viewer.act(Action::Help);
                let frame = after(&mut viewer, 1);
                let pixels = size[0] as usize * size[1] as usize;
                assert_eq!((frame.size, frame.pixels.len()), (size, pixels));
            }
        }
        viewer.act(Action::Resize([0, 5]));
        assert_eq!(viewer.frame().size, [900, 3]);
    }

    #[test]
    fn what_there_is_not_is_refused() {
        let scene = || Scene::from_toml("test", SCENE, None).expect("it is sound");
        let error = Viewer::new("test", scene(), 0, "embree", Builder::Spatial, SIZE).err();
        let says = error.map(|error| error.to_string()).unwrap_or_default();
        assert_eq!(says, "unknown method `embree`; `trisect list` shows what there is");
    }
}
