//! What a picture needs of the renderer, found once; what it does not need is not in the code that draws it.
//!
//! Features that are asked about at the same place go together, so that there are few instances: one for
//! each set of four [`Part`]s, and one that traces paths, with everything. What is done once for thousands of
//! rays is asked about there, and multiplies nothing.

use std::ops::{BitOr, BitOrAssign};

use trisect_scene::Material;

use crate::settings::{Mode, Settings};
use crate::stage::Stage;

/// A part of the renderer that a picture can do without.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Spheres, planes, meshes that rays are carried to, and what is clear beside what is not: all but one
    /// tree in the world.
    Shapes,
    /// Textures and interpolated normals.
    Varying,
    /// Rays to lights, and for ambient occlusion.
    Shadows,
    /// Rays for mirrors and glass.
    Onward,
    /// Several samples of a pixel, or one that is not in its middle.
    Samples,
    /// Light that goes through what is clear on its way to a surface.
    Transparency,
}

impl Part {
    /// Those that the renderer is compiled with and without.
    pub const COMPILED: [Self; 4] = [Self::Shapes, Self::Varying, Self::Shadows, Self::Onward];
    /// All of them.
    pub const ALL: [Self; 6] = {
        let [a, b, c, d] = Self::COMPILED;
        [a, b, c, d, Self::Samples, Self::Transparency]
    };

    /// The name used in lists and records.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Shapes => "shapes",
            Self::Varying => "varying",
            Self::Shadows => "shadows",
            Self::Onward => "onward",
            Self::Samples => "samples",
            Self::Transparency => "transparency",
        }
    }
}

/// A set of [`Part`]s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Parts(u8);

impl Parts {
    /// None.
    pub const NONE: Self = Self(0);
    /// All of them.
    pub const ALL: Self = Self((1 << Part::ALL.len()) - 1);

    /// Whether a part is among them.
    pub const fn has(self, part: Part) -> bool {
        self.0 & (1 << part as u8) != 0
    }
}

impl From<Part> for Parts {
    fn from(part: Part) -> Self {
        Self(1 << part as u8)
    }
}

impl BitOr for Parts {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitOrAssign for Parts {
    fn bitor_assign(&mut self, other: Self) {
        *self = *self | other;
    }
}

impl FromIterator<Part> for Parts {
    fn from_iter<T: IntoIterator<Item = Part>>(parts: T) -> Self {
        parts.into_iter().fold(Self::NONE, |all, part| all | part.into())
    }
}

/// What there is in a scene, as far as its pictures can do without.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facts {
    /// Spheres.
    pub spheres: usize,
    /// Planes.
    pub planes: usize,
    /// Meshes that rays are carried to, by their places.
    pub carried: usize,
    /// Trees that rays go through, by their places.
    pub trees: usize,
    /// Triangles with normals at their corners, or beside such in a tree.
    pub interpolated: usize,
    /// Materials with a texture.
    pub textured: usize,
    /// Lights.
    pub lights: usize,
    /// Materials that are mirrors.
    pub mirrors: usize,
    /// Clear materials.
    pub clear: usize,
}

impl Facts {
    /// Those of a scene.
    pub(crate) fn of(stage: &Stage) -> Self {
        let scene = &stage.scene;
        let mut used = vec![false; scene.materials.len()];
        let triangles = stage.groups.iter().flat_map(|group| &group.materials);
        let simple = scene.spheres.iter().map(|sphere| sphere.material);
        let simple = simple.chain(scene.planes.iter().map(|plane| plane.material));
        for material in triangles.map(|&material| material as usize).chain(simple) {
            used[material] = true;
        }
        let count = |is: fn(&Material) -> bool| {
            scene
                .materials
                .iter()
                .zip(&used)
                .filter(|(material, used)| **used && is(material))
                .count()
        };
        let instances = stage.all.instances();
        Self {
            spheres: scene.spheres.len(),
            planes: scene.planes.len(),
            carried: instances.iter().filter(|of| !of.transform().is_identity()).count(),
            trees: instances.len(),
            interpolated: stage.groups.iter().map(|group| group.normals.len()).sum(),
            textured: count(|material| material.texture.is_some()),
            lights: scene.lights.len(),
            mirrors: count(|material| material.reflection != glam::Vec3::ZERO),
            clear: count(Material::is_clear),
        }
    }

    /// What a picture of the scene needs.
    pub fn needs(&self, settings: &Settings) -> Parts {
        let is_paths = settings.mode == Mode::Paths;
        let occludes = matches!(settings.mode, Mode::Whitted { occlusion: Some(_) });
        let has_shapes = self.spheres + self.planes + self.carried > 0 || self.trees > 1;
        let has_shadows = is_paths || occludes || self.lights.min(settings.lights) > 0;
        let goes_onward = settings.depth > 0 && self.mirrors + self.clear > 0;
        [
            (Part::Shapes, is_paths || has_shapes),
            (Part::Varying, is_paths || self.interpolated + self.textured > 0),
            (Part::Shadows, has_shadows),
            (Part::Onward, is_paths || goes_onward),
            (Part::Samples, is_paths || !settings.sampling.is_middle()),
            (Part::Transparency, has_shadows && self.clear > 0),
        ]
        .into_iter()
        .filter_map(|(part, is_needed)| is_needed.then_some(part))
        .collect()
    }
}

/// What an instance of the renderer has, as a type.
pub(crate) trait Needs: 'static {
    const SHAPES: bool;
    const VARYING: bool;
    const SHADOWS: bool;
    const ONWARD: bool;
    /// Whether it traces paths, instead of shading after Whitted.
    const PATHS: bool = false;
}

/// After Whitted, with some parts.
pub(crate) struct With<
    const SHAPES: bool,
    const VARYING: bool,
    const SHADOWS: bool,
    const ONWARD: bool,
>;

impl<const SHAPES: bool, const VARYING: bool, const SHADOWS: bool, const ONWARD: bool> Needs
    for With<SHAPES, VARYING, SHADOWS, ONWARD>
{
    const SHAPES: bool = SHAPES;
    const VARYING: bool = VARYING;
    const SHADOWS: bool = SHADOWS;
    const ONWARD: bool = ONWARD;
}

/// Paths, with everything.
pub(crate) struct Paths;

impl Needs for Paths {
    const SHAPES: bool = true;
    const VARYING: bool = true;
    const SHADOWS: bool = true;
    const ONWARD: bool = true;
    const PATHS: bool = true;
}

/// Something to do with an instance of choice.
pub(crate) trait Job {
    type Output;
    fn run<N: Needs>(self) -> Self::Output;
}

/// Runs a job on the instance that has these parts, and no others.
pub(crate) fn with<J: Job>(parts: Parts, job: J) -> J::Output {
    macro_rules! choose {
        ([$($known:literal)*]) => { job.run::<With<$($known),*>>() };
        ([$($known:literal)*] $part:ident $($rest:ident)*) => {
            if parts.has(Part::$part) {
                choose!([$($known)* true] $($rest)*)
            } else {
                choose!([$($known)* false] $($rest)*)
            }
        };
    }
    choose!([] Shapes Varying Shadows Onward)
}
