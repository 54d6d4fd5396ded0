//! The graph of nodes: what is where, with which material.

use std::sync::Arc;

use glam::{Affine3A, DAffine3};
use trisect_tracer::Update;

use crate::commit::{Built, Placed};
use crate::geometry::{Change, Geometry, ReshapeError};
use crate::scene::Scene;
use crate::selector::Visit;
use crate::variables::{Scope, Value, Variable, Variables};
use crate::{Uncommitted, commit};

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub(crate) u32);

        impl $name {
            pub(crate) fn at(self) -> usize {
                self.0 as usize
            }

            /// The next one of so many.
            ///
            /// # Panics
            /// When there are 2³² of them.
            fn next(count: usize) -> Self {
                Self(u32::try_from(count).expect("they are counted in u32"))
            }

            /// Its number, in the order in which they were added.
            pub fn number(self) -> u32 {
                self.0
            }
        }
    };
}
id!(/** A geometry of a [`Graph`]. */ GeometryId);
id!(/** A material of a [`Graph`]. */ MaterialId);
id!(/** A node of a [`Graph`]. */ NodeId);

/// What a node is.
pub(crate) enum Node {
    /// A geometry with a material.
    Instance(GeometryId, MaterialId),
    /// All of some nodes.
    Group(Vec<NodeId>),
    /// A node in its place.
    Transform(DAffine3, NodeId),
    /// One of some nodes, chosen for each ray.
    Selector(Arc<dyn Visit>, Vec<NodeId>),
}

impl Node {
    pub(crate) fn children(&self) -> &[NodeId] {
        match self {
            Self::Instance(..) => &[],
            Self::Group(children) | Self::Selector(_, children) => children,
            Self::Transform(_, child) => std::slice::from_ref(child),
        }
    }
}

/// What cannot be done to a node.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GraphError {
    /// It is no transform.
    #[error("node {0} is no transform: add one above what is to be moved")]
    NotTransform(u32),
    /// It has no list of children.
    #[error("node {0} is neither a group nor a selector: it has no list of children")]
    NotGroup(u32),
    /// It is no instance.
    #[error("node {0} is no instance of a geometry: it has no material")]
    NotInstance(u32),
}

/// Geometries, materials and variables, and a graph of nodes over them. Ids belong to the graph that gave them.
///
/// Groups and transforms may be shared by several parents, and any node may be the root. `M` is what materials are: a
/// type, an enumeration, or a box of a trait, as the programs that read it want.
pub struct Graph<M> {
    pub(crate) geometries: Vec<Arc<Placed>>,
    pub(crate) materials: Vec<M>,
    pub(crate) nodes: Vec<Node>,
    pub(crate) variables: Variables,
    /// What was committed before, as far as it still holds.
    pub(crate) built: Option<Built>,
}

impl<M> Default for Graph<M> {
    fn default() -> Self {
        Self {
            geometries: vec![],
            materials: vec![],
            nodes: vec![],
            variables: Variables::default(),
            built: None,
        }
    }
}

impl<M> Graph<M> {
    /// With nothing in it.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a geometry: it is seen where it has an instance.
    ///
    /// # Panics
    /// When there are 2³² of them, as all that add something.
    pub fn geometry(&mut self, geometry: Geometry) -> GeometryId {
        let id = GeometryId::next(self.geometries.len());
        self.geometries.push(Arc::new(Placed::Geometry(geometry)));
        id
    }

    /// Adds a material.
    pub fn material(&mut self, material: M) -> MaterialId {
        let id = MaterialId::next(self.materials.len());
        self.materials.push(material);
        id
    }

    /// A material, to be changed.
    pub fn material_mut(&mut self, material: MaterialId) -> &mut M {
        &mut self.materials[material.at()]
    }

    fn node(&mut self, node: Node) -> NodeId {
        self.built = None;
        let id = NodeId::next(self.nodes.len());
        self.nodes.push(node);
        id
    }

    /// Adds an instance of a geometry with a material. Instances share the geometry and its tree.
    pub fn instance(&mut self, geometry: GeometryId, material: MaterialId) -> NodeId {
        self.node(Node::Instance(geometry, material))
    }

    /// Adds a group of nodes. One with several parents has a tree of its own, which they share; the instances of others
    /// are in the tree of their parent.
    pub fn group(&mut self, children: impl IntoIterator<Item = NodeId>) -> NodeId {
        self.node(Node::Group(children.into_iter().collect()))
    }

    /// Adds a transform: from the space of its child to its own.
    pub fn transform(&mut self, to_parent: Affine3A, child: NodeId) -> NodeId {
        self.node(Node::Transform(to_parent.as_daffine3(), child))
    }

    /// Adds a selector: a program that chooses one child for each ray.
    pub fn selector(
        &mut self,
        visit: impl Visit,
        children: impl IntoIterator<Item = NodeId>,
    ) -> NodeId {
        self.node(Node::Selector(Arc::new(visit), children.into_iter().collect()))
    }

    /// Moves what is below a transform.
    ///
    /// # Errors
    /// When the node is no transform.
    pub fn set_transform(&mut self, node: NodeId, to_parent: Affine3A) -> Result<(), GraphError> {
        match &mut self.nodes[node.at()] {
            Node::Transform(place, _) => {
                *place = to_parent.as_daffine3();
                Ok(())
            }
            _ => Err(GraphError::NotTransform(node.0)),
        }
    }

    /// Gives a group or a selector other children.
    ///
    /// # Errors
    /// When the node is neither.
    pub fn set_children(
        &mut self,
        node: NodeId,
        children: impl IntoIterator<Item = NodeId>,
    ) -> Result<(), GraphError> {
        match &mut self.nodes[node.at()] {
            Node::Group(own) | Node::Selector(_, own) => {
                *own = children.into_iter().collect();
                self.built = None;
                Ok(())
            }
            _ => Err(GraphError::NotGroup(node.0)),
        }
    }

    /// Gives an instance another material.
    ///
    /// # Errors
    /// When the node is no instance.
    pub fn set_material(&mut self, node: NodeId, material: MaterialId) -> Result<(), GraphError> {
        match &mut self.nodes[node.at()] {
            Node::Instance(_, own) => {
                *own = material;
                Ok(())
            }
            _ => Err(GraphError::NotInstance(node.0)),
        }
    }

    /// Gives a geometry other shapes of its kind, and says what became of its tree.
    ///
    /// # Errors
    /// When they are of another kind, the tree cannot be fitted to them, or the method cannot take them. The geometry is
    /// as before then.
    pub fn reshape<S: 'static>(
        &mut self,
        geometry: GeometryId,
        shapes: Vec<S>,
        change: Change,
    ) -> Result<Update, ReshapeError> {
        // The trees above it are built anew, and hold it no longer.
        self.built = None;
        let placed = Arc::get_mut(&mut self.geometries[geometry.at()]);
        match placed {
            Some(Placed::Geometry(geometry)) => geometry.reshape(shapes, change),
            _ => unreachable!("a geometry belongs to its graph and the trees over it alone"),
        }
    }

    /// Declares a variable. Its name is for messages.
    pub fn variable<T: Value>(&mut self, name: &str) -> Variable<T> {
        self.variables.declare(name)
    }

    /// Sets a variable.
    pub fn set<T: Value>(&mut self, scope: Scope, variable: Variable<T>, value: T) {
        self.variables.set(scope, variable, value);
    }

    /// Makes a scene of what is below a node: resolves transforms, groups and variables, and builds the trees over
    /// instances; where nothing but transforms changed since the last time they are fitted.
    ///
    /// # Errors
    /// When a node is below itself, an instance cannot be placed, there are too many, or a variable has no value
    /// somewhere. The message names the node; the graph comes back with it.
    pub fn commit(self, root: NodeId) -> Result<Scene<M>, Box<Uncommitted<M>>> {
        commit::commit(self, root)
    }
}
