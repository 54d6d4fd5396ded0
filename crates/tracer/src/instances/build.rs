//! Building a tree over instances, and moving them.

use std::sync::Arc;

use glam::{Affine3A, DVec3};
use trisect_core::Vec3;

use super::transform::{BadTransform, Off, Transform};
use super::{Extent, HasTree, Instance, InstanceError, Instances, LEVELS};
use crate::bvh::builders::corners::Corners;
use crate::bvh::builders::{boxes, is_worn};

/// Directions have a coordinate as large as this, or nothing is known of what is carried.
const LEAST_DIRECTION: f64 = 1.0 / (1_u64 << 60) as f64;

/// What became of a tree whose triangles or instances have moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Update {
    /// It was fitted to them: its boxes were computed anew.
    Refitted {
        /// What a ray is expected to cost now, over what it cost when the tree was built.
        cost: f64,
    },
    /// It was built anew, as it had become worn: see [`is_worn`].
    Rebuilt,
}

impl Update {
    /// What is to be done with a tree that was fitted, given its cost when it was built and now.
    pub fn of_cost(built: f64, now: f64) -> Self {
        if is_worn(built, now) { Self::Rebuilt } else { Self::Refitted { cost: now / built } }
    }
}

/// What is known of an instance before its box is.
struct Placing {
    off: Off,
    /// Around it, in the world; `None` where nothing can be hit.
    around: Option<[DVec3; 2]>,
}

impl Placing {
    fn new(transform: &Transform, extent: &Extent) -> Self {
        let around = (!extent.boxes.is_empty()).then(|| transform.around(&extent.boxes));
        Self { off: transform.off().over(extent.per_origin), around }
    }
}

fn transform(instance: usize, to_world: Affine3A) -> Result<Transform, InstanceError> {
    Transform::new(to_world).map_err(|bad| {
        let columns = to_world.to_cols_array_2d();
        let rows = [0, 1, 2].map(|row| columns.map(|column| column[row]));
        match bad {
            BadTransform::NotFinite => InstanceError::NotFinite { instance, rows },
            BadTransform::Singular => InstanceError::Singular { instance, rows },
        }
    })
}

pub(super) fn build<T: HasTree>(
    placed: impl Iterator<Item = (Arc<T>, Affine3A)>,
) -> Result<Instances<T>, InstanceError> {
    let (mut instances, mut levels, mut is_exact, mut first) = (vec![], 1, true, 0_u32);
    // What is placed many times follows itself mostly.
    let mut last: Option<(Arc<T>, Extent)> = None;
    for (index, (of, to_world)) in placed.enumerate() {
        let transform = transform(index, to_world)?;
        if last.as_ref().is_none_or(|(other, _)| !Arc::ptr_eq(other, &of)) {
            let tree = of.tree();
            let extent = tree.extent();
            is_exact &= tree.contains(Vec3::new(f32::NAN, f32::NAN, f32::NAN)).is_ok();
            levels = levels.max(extent.levels + 1);
            last = Some((Arc::clone(&of), extent));
        }
        let Some((_, extent)) = &last else { continue };
        if levels > LEVELS {
            return Err(InstanceError::TooDeep { instance: index });
        }
        instances.push(Instance { of, transform, first, bounds: Corners::EMPTY });
        // The largest number stands for no triangle.
        let after = u32::try_from(extent.triangles).ok().and_then(|count| first.checked_add(count));
        first = after
            .filter(|after| *after < u32::MAX)
            .ok_or(InstanceError::TooMany { instance: index })?;
    }
    let mut built = Instances {
        placed: instances,
        top: boxes::build(&[]),
        built: 0.0,
        reach: 0.0,
        per_length: 0.0,
        least_direction: 0.0,
        levels,
        is_exact,
    };
    let bounds = built.fit_boxes();
    built.rebuild(&bounds);
    Ok(built)
}

impl<T: HasTree> Instances<T> {
    /// Moves one instance.
    ///
    /// # Errors
    /// When there is no such instance, or its transform is not finite or is singular; nothing has moved then.
    pub fn set_transform(
        &mut self,
        instance: usize,
        to_world: Affine3A,
    ) -> Result<Update, InstanceError> {
        let instances = self.placed.len();
        let moved = self.placed.get_mut(instance);
        let moved = moved.ok_or(InstanceError::NoInstance { instance, instances })?;
        moved.transform = transform(instance, to_world)?;
        Ok(self.update())
    }

    /// Moves all instances.
    ///
    /// # Errors
    /// When there are not as many transforms as instances, or one of them is not finite or is singular; nothing has
    /// moved then.
    pub fn set_transforms(
        &mut self,
        to_world: impl IntoIterator<Item = Affine3A>,
    ) -> Result<Update, InstanceError> {
        let to_world = to_world.into_iter().enumerate();
        let moved: Vec<Transform> =
            to_world.map(|(at, to_world)| transform(at, to_world)).collect::<Result<_, _>>()?;
        let (instances, given) = (self.placed.len(), moved.len());
        if instances != given {
            return Err(InstanceError::Count { instances, given });
        }
        for (instance, transform) in self.placed.iter_mut().zip(moved) {
            instance.transform = transform;
        }
        Ok(self.update())
    }

    /// Fits the top tree, or builds it anew.
    fn update(&mut self) -> Update {
        let bounds = self.fit_boxes();
        boxes::refit(&mut self.top, &bounds);
        let update = Update::of_cost(self.built, self.top.cost());
        if update == Update::Rebuilt {
            self.rebuild(&bounds);
        }
        update
    }

    fn rebuild(&mut self, bounds: &[Corners]) {
        self.top = boxes::build(bounds);
        self.built = self.top.cost();
    }

    /// Computes the boxes of all instances.
    #[allow(clippy::cast_possible_truncation, reason = "rounds, and there is room")]
    fn fit_boxes(&mut self) -> Vec<Corners> {
        let mut last: Option<(Arc<T>, Extent)> = None;
        let (mut reach, mut per_length, mut least) = (0.0_f64, 0.0_f64, LEAST_DIRECTION);
        let mut placings = Vec::with_capacity(self.placed.len());
        for Instance { of, transform, .. } in &self.placed {
            if last.as_ref().is_none_or(|(other, _)| !Arc::ptr_eq(other, of)) {
                last = Some((Arc::clone(of), of.tree().extent()));
            }
            let Some((_, extent)) = &last else { continue };
            let placing = Placing::new(transform, extent);
            if let Some([low, high]) = placing.around {
                reach = reach.max(low.abs().max(high.abs()).max_element());
                if placing.off.is_bounded() {
                    per_length = per_length.max(4.0 * placing.off.relative);
                }
                least = least.max(1.01 * placing.off.longer * extent.least_direction);
            }
            placings.push(placing);
        }
        // What is carried from there does not overflow, and scenes are not as large.
        self.reach = (reach as f32).min(f32::MAX / 4.0);
        self.per_length = (per_length * (1.0 + 1e-6)) as f32;
        self.least_direction = (least * (1.0 + 1e-6)) as f32;
        let reach = f64::from(self.reach);
        for (instance, placing) in self.placed.iter_mut().zip(&placings) {
            instance.bounds = match placing.around {
                Some(around) => placing.off.widened(around, reach),
                None => Corners::EMPTY,
            };
        }
        self.placed.iter().map(|instance| instance.bounds).collect()
    }
}
