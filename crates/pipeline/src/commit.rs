//! From a graph to trees over instances, and a record for each of them.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt;
use std::sync::Arc;

use glam::{Affine3A, DAffine3};
use trisect_tracer::{BadTransform, HasTree, InstanceError, Instances, Transform, Tree, Update};

use crate::geometry::Geometry;
use crate::graph::{GeometryId, Graph, MaterialId, Node, NodeId};
use crate::scene::Scene;
use crate::selector::Selected;
use crate::variables::Scope;

/// Nodes below each other at most.
const LEVELS: usize = 256;

/// Instances at most, each counted wherever it is placed.
const RECORDS: usize = 1 << 26;

/// A graph cannot be made a scene of.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CommitError {
    /// A node is among what is below it.
    #[error("node {node} is below itself: take it out of the children of what is below it")]
    Cycle {
        /// The number of the node.
        node: u32,
    },
    /// There are too many nodes in a chain.
    #[error("node {node} is more than {LEVELS} nodes below the root: join transforms and groups")]
    TooDeep {
        /// The number of the node.
        node: u32,
    },
    /// A node cannot be placed.
    #[error("node {node} cannot be placed: {problem}")]
    Place {
        /// The number of the node.
        node: u32,
        /// Why.
        problem: InstanceError,
    },
    /// A transform has no inverse.
    #[error("node {node} cannot be placed where the transforms above it take it: {problem}")]
    Transform {
        /// The number of the node.
        node: u32,
        /// Why.
        problem: BadTransform,
    },
    /// There are too many instances.
    #[error(
        "with node {node} there are more than {RECORDS} instances, each counted wherever it is placed"
    )]
    TooMany {
        /// The number of the node.
        node: u32,
    },
    /// A variable has no value.
    #[error(
        "variable `{variable}` has no value at node {node}: set it on that node, its geometry, its material or the context"
    )]
    Unset {
        /// The name of the variable.
        variable: String,
        /// The number of the instance's node.
        node: u32,
    },
}

/// A graph that could not be committed, and why.
pub struct Uncommitted<M> {
    /// The graph, as it was: it can be mended, and committed again.
    pub graph: Graph<M>,
    /// What stands in the way.
    pub error: CommitError,
}

impl<M> fmt::Debug for Uncommitted<M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.error.fmt(f)
    }
}

impl<M> fmt::Display for Uncommitted<M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.error, f)
    }
}

impl<M> Error for Uncommitted<M> {}

impl<M> From<Box<Uncommitted<M>>> for CommitError {
    fn from(of: Box<Uncommitted<M>>) -> Self {
        of.error
    }
}

/// What is placed in a tree over instances.
pub(crate) enum Placed {
    Geometry(Geometry),
    Group(Instances<Self>),
    Choice(Selected),
}

impl HasTree for Placed {
    fn tree(&self) -> &dyn Tree {
        match self {
            Self::Geometry(geometry) => geometry.tree(),
            Self::Group(instances) => instances,
            Self::Choice(selected) => selected,
        }
    }
}

/// The trees of a graph that was committed.
pub(crate) struct Built {
    root: NodeId,
    pub(crate) top: Instances<Placed>,
    /// Whether every instance is in the top tree itself.
    is_flat: bool,
}

/// An instance of a geometry: what is found by the number of a triangle.
pub(crate) struct Record {
    /// The number of its first shape.
    pub(crate) first: u32,
    pub(crate) node: NodeId,
    pub(crate) geometry: GeometryId,
    pub(crate) material: MaterialId,
    pub(crate) transform: Transform,
}

/// Makes a scene of what is below a node.
pub(crate) fn commit<M>(
    mut graph: Graph<M>,
    root: NodeId,
) -> Result<Scene<M>, Box<Uncommitted<M>>> {
    match resolve(&mut graph, root) {
        Ok(resolved) => Ok(Scene { graph, resolved }),
        Err(error) => Err(Box::new(Uncommitted { graph, error })),
    }
}

/// What is known of a graph once it is committed, beside the trees.
pub(crate) struct Resolved {
    pub(crate) records: Vec<Record>,
    /// Of all variables, for one record after another.
    pub(crate) values: Vec<[u32; 4]>,
    /// Whether a program may be offered a shape more than once.
    pub(crate) is_split: bool,
    /// What was done with the tree over instances.
    pub(crate) update: Update,
}

fn resolve<M>(graph: &mut Graph<M>, root: NodeId) -> Result<Resolved, CommitError> {
    let parents = check(graph, root)?;
    let last = graph.built.take().filter(|built| built.root == root && built.is_flat);
    let (built, update) = match last {
        Some(mut built) => {
            let mut places = vec![];
            each(graph, root, DAffine3::IDENTITY, &mut |leaf| {
                places.push((leaf.node, leaf.place.as_affine3a()));
                Ok(())
            })?;
            let update = built
                .top
                .set_transforms(places.iter().map(|(_, place)| *place))
                .map_err(|problem| unplaced(problem, |at| places[at].0))?;
            (built, update)
        }
        None => (build(graph, parents, root)?, Update::Rebuilt),
    };
    let (mut records, mut first) = (vec![], 0);
    each(graph, root, DAffine3::IDENTITY, &mut |Leaf { node, geometry, material, place }| {
        if records.len() == RECORDS {
            return Err(CommitError::TooMany { node: node.0 });
        }
        let transform = Transform::new(place.as_affine3a())
            .map_err(|problem| CommitError::Transform { node: node.0, problem })?;
        records.push(Record { first, node, geometry, material, transform });
        // They were counted when the trees were built.
        first += u32::try_from(graph.of(geometry).count()).unwrap_or(u32::MAX);
        Ok(())
    })?;
    let values = values(graph, &records)?;
    let is_split = graph.geometries.iter().any(|placed| match &**placed {
        Placed::Geometry(geometry) => geometry.is_split(),
        Placed::Group(_) | Placed::Choice(_) => false,
    });
    graph.built = Some(built);
    Ok(Resolved { records, values, is_split, update })
}

impl<M> Graph<M> {
    #[inline]
    pub(crate) fn of(&self, geometry: GeometryId) -> &Geometry {
        match &*self.geometries[geometry.at()] {
            Placed::Geometry(geometry) => geometry,
            Placed::Group(_) | Placed::Choice(_) => unreachable!("a geometry was added as one"),
        }
    }
}

/// How many parents each node has below the root, unless a node is below itself or too deep.
fn check<M>(graph: &Graph<M>, root: NodeId) -> Result<Vec<u32>, CommitError> {
    /// What is known of a node.
    #[derive(Clone, Copy, PartialEq)]
    enum State {
        New,
        Open,
        /// With so many nodes below each other, itself among them.
        Done(usize),
    }
    fn visit<M>(
        graph: &Graph<M>,
        node: NodeId,
        depth: usize,
        states: &mut [State],
        parents: &mut [u32],
    ) -> Result<usize, CommitError> {
        match states[node.at()] {
            State::Open => return Err(CommitError::Cycle { node: node.0 }),
            State::Done(levels) if depth + levels <= LEVELS => return Ok(levels),
            State::New if depth < LEVELS => {}
            State::New | State::Done(_) => return Err(CommitError::TooDeep { node: node.0 }),
        }
        states[node.at()] = State::Open;
        let mut levels = 0;
        for &child in graph.nodes[node.at()].children() {
            parents[child.at()] += 1;
            levels = levels.max(visit(graph, child, depth + 1, states, parents)?);
        }
        states[node.at()] = State::Done(levels + 1);
        Ok(levels + 1)
    }
    let mut parents = vec![0; graph.nodes.len()];
    visit(graph, root, 0, &mut vec![State::New; graph.nodes.len()], &mut parents)?;
    Ok(parents)
}

/// An instance on the way down a graph.
struct Leaf<'a> {
    node: NodeId,
    geometry: GeometryId,
    material: MaterialId,
    place: &'a DAffine3,
}

/// Visits the instances below a node wherever they are placed, in the order in which trees number their shapes.
fn each<M>(
    graph: &Graph<M>,
    node: NodeId,
    place: DAffine3,
    take: &mut dyn FnMut(Leaf<'_>) -> Result<(), CommitError>,
) -> Result<(), CommitError> {
    match &graph.nodes[node.at()] {
        &Node::Instance(geometry, material) => {
            take(Leaf { node, geometry, material, place: &place })
        }
        Node::Transform(to_parent, child) => each(graph, *child, place * *to_parent, take),
        Node::Group(children) | Node::Selector(_, children) => {
            children.iter().try_for_each(|&child| each(graph, child, place, take))
        }
    }
}

/// The trees over instances.
struct Build<'g, M> {
    graph: &'g Graph<M>,
    parents: Vec<u32>,
    /// Those that have several parents.
    shared: BTreeMap<NodeId, Arc<Placed>>,
    is_flat: bool,
}

fn build<M>(graph: &Graph<M>, parents: Vec<u32>, root: NodeId) -> Result<Built, CommitError> {
    let mut build = Build { graph, parents, shared: BTreeMap::new(), is_flat: true };
    let top = build.tree(&[root])?;
    Ok(Built { root, top, is_flat: build.is_flat })
}

/// What is placed in a tree, by whom, and where.
type Placing = (NodeId, Arc<Placed>, Affine3A);

impl<M> Build<'_, M> {
    /// The tree over what is below some nodes.
    fn tree(&mut self, nodes: &[NodeId]) -> Result<Instances<Placed>, CommitError> {
        let mut placed = vec![];
        for &node in nodes {
            self.gather(node, DAffine3::IDENTITY, &mut placed)?;
        }
        let instances = placed.iter().map(|(_, of, place)| (Arc::clone(of), *place));
        Instances::new(instances).map_err(|problem| unplaced(problem, |at| placed[at].0))
    }

    fn gather(
        &mut self,
        node: NodeId,
        place: DAffine3,
        placed: &mut Vec<Placing>,
    ) -> Result<(), CommitError> {
        let graph = self.graph;
        let of = match &graph.nodes[node.at()] {
            Node::Instance(geometry, _) => Arc::clone(&graph.geometries[geometry.at()]),
            Node::Transform(to_parent, child) => {
                return self.gather(*child, place * *to_parent, placed);
            }
            Node::Group(children) if self.parents[node.at()] < 2 => {
                return children.iter().try_for_each(|&child| self.gather(child, place, placed));
            }
            Node::Group(children) => {
                self.once(node, |build| Ok(Placed::Group(build.tree(children)?)))?
            }
            Node::Selector(visit, children) => self.once(node, |build| {
                let trees = children.iter().map(|&child| build.tree(&[child]));
                let trees = trees.collect::<Result<_, _>>()?;
                Ok(Placed::Choice(Selected::new(Arc::clone(visit), trees)))
            })?,
        };
        placed.push((node, of, place.as_affine3a()));
        Ok(())
    }

    /// What a node is made of, made once.
    fn once(
        &mut self,
        node: NodeId,
        make: impl FnOnce(&mut Self) -> Result<Placed, CommitError>,
    ) -> Result<Arc<Placed>, CommitError> {
        self.is_flat = false;
        if let Some(made) = self.shared.get(&node) {
            return Ok(Arc::clone(made));
        }
        let made = Arc::new(make(self)?);
        self.shared.insert(node, Arc::clone(&made));
        Ok(made)
    }
}

/// What stands in the way of an instance, by its node.
fn unplaced(problem: InstanceError, node: impl FnOnce(usize) -> NodeId) -> CommitError {
    let instance = match &problem {
        InstanceError::NotFinite { instance, .. }
        | InstanceError::Singular { instance, .. }
        | InstanceError::TooMany { instance }
        | InstanceError::TooDeep { instance }
        | InstanceError::NoInstance { instance, .. } => *instance,
        _ => 0,
    };
    CommitError::Place { node: node(instance).0, problem }
}

/// The values of all variables, for one instance after another.
fn values<M>(graph: &Graph<M>, records: &[Record]) -> Result<Vec<[u32; 4]>, CommitError> {
    let count = graph.variables.count();
    let mut values = Vec::with_capacity(count * records.len());
    for record in records {
        let scopes = [
            Scope::Instance(record.node),
            Scope::Geometry(record.geometry),
            Scope::Material(record.material),
            Scope::Context,
        ];
        for number in 0..count {
            let value = graph.variables.resolve(number, &scopes);
            values.push(value.ok_or_else(|| CommitError::Unset {
                variable: graph.variables.name(number).to_owned(),
                node: record.node.0,
            })?);
        }
    }
    Ok(values)
}
