//! What tests share.
#![allow(dead_code, reason = "each test asks for a part")]

use trisect_core::Triangle;
use trisect_moller_trumbore::MollerTrumbore;
use trisect_pipeline::{BuildTree, Builder, Geometry, Graph, NodeId, Primitive};
use trisect_tracer::ErasedBvh;

/// Builds a tree whose method is behind calls.
pub(crate) const BUILD: BuildTree = |triangles, builder, leaves| {
    Ok(Box::new(ErasedBvh::build_with::<MollerTrumbore>(triangles, builder, leaves)?))
};

pub(crate) fn mesh(triangles: Vec<Triangle<f32>>, builder: Builder) -> Geometry {
    Geometry::triangles(triangles, builder, BUILD).expect("the method takes every mesh")
}

/// A square of two triangles at a height, from −half to half; its front is above.
pub(crate) fn square(y: f32, half: f32) -> Vec<Triangle<f32>> {
    let corner = |x: f32, z: f32| [x * half, y, z * half];
    let [a, b, c, d] = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
    vec![Triangle::new(a, b, c), Triangle::new(a, c, d)]
}

/// Adds an instance of one shape with a material.
pub(crate) fn add<P: Primitive, M>(graph: &mut Graph<M>, shape: P::Shape, material: M) -> NodeId {
    let geometry = Geometry::of::<P>(vec![shape], Builder::Binned).expect("it is taken");
    let (geometry, material) = (graph.geometry(geometry), graph.material(material));
    graph.instance(geometry, material)
}
