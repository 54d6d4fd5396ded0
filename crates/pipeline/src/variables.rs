//! Variables: values that are set on a node, a geometry, a material or for all, and that programs read by name.
//!
//! What a variable is for each instance is looked up when the graph is committed; a program reads it from a table.

use std::collections::BTreeMap;
use std::marker::PhantomData;

use glam::{Vec2, Vec3, Vec4};

use crate::graph::{GeometryId, MaterialId, NodeId};

/// What a variable may hold: four numbers of 32 bits at most.
pub trait Value: Copy {
    /// As it is stored.
    fn store(self) -> [u32; 4];
    /// From there.
    fn load(stored: [u32; 4]) -> Self;
}

impl Value for f32 {
    fn store(self) -> [u32; 4] {
        [self.to_bits(), 0, 0, 0]
    }
    fn load([x, ..]: [u32; 4]) -> Self {
        f32::from_bits(x)
    }
}

impl Value for u32 {
    fn store(self) -> [u32; 4] {
        [self, 0, 0, 0]
    }
    fn load([x, ..]: [u32; 4]) -> Self {
        x
    }
}

impl Value for Vec2 {
    fn store(self) -> [u32; 4] {
        self.extend(0.0).store()
    }
    fn load(stored: [u32; 4]) -> Self {
        Vec3::load(stored).truncate()
    }
}

impl Value for Vec3 {
    fn store(self) -> [u32; 4] {
        self.extend(0.0).store()
    }
    fn load(stored: [u32; 4]) -> Self {
        Vec4::load(stored).truncate()
    }
}

impl Value for Vec4 {
    fn store(self) -> [u32; 4] {
        self.to_array().map(f32::to_bits)
    }
    fn load(stored: [u32; 4]) -> Self {
        stored.map(f32::from_bits).into()
    }
}

/// A variable that holds a `T`: what programs read it by.
#[derive(Debug)]
pub struct Variable<T> {
    pub(crate) number: usize,
    holds: PhantomData<fn() -> T>,
}

impl<T> Clone for Variable<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Variable<T> {}

/// What a value is set on. A program reads that of the first of these that has one: the instance, its geometry, its
/// material, the context. What belongs to a program alone is a field of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scope {
    /// A geometry with a material, wherever it is placed.
    Instance(NodeId),
    /// A geometry, in all of its instances.
    Geometry(GeometryId),
    /// A material, in all instances that have it.
    Material(MaterialId),
    /// Everything.
    Context,
}

/// All variables and their values.
#[derive(Default)]
pub(crate) struct Variables {
    names: Vec<String>,
    values: BTreeMap<(usize, Scope), [u32; 4]>,
}

impl Variables {
    pub(crate) fn declare<T: Value>(&mut self, name: &str) -> Variable<T> {
        self.names.push(name.to_owned());
        Variable { number: self.names.len() - 1, holds: PhantomData }
    }

    pub(crate) fn set<T: Value>(&mut self, scope: Scope, variable: Variable<T>, value: T) {
        self.values.insert((variable.number, scope), value.store());
    }

    pub(crate) fn count(&self) -> usize {
        self.names.len()
    }

    pub(crate) fn name(&self, number: usize) -> &str {
        &self.names[number]
    }

    /// The value in the first scope that has one.
    pub(crate) fn resolve(&self, number: usize, scopes: &[Scope]) -> Option<[u32; 4]> {
        scopes.iter().find_map(|scope| self.values.get(&(number, *scope)).copied())
    }
}
