//! The part of a user's rays and triangles that kernels are tried on.

use trisect_catalog::find;
use trisect_method::Culling;

use crate::comparison::Family;
use crate::kernels::REFERENCE;
use crate::subject::{Inputs, Subject, Unrounded};

/// Rays of a user that kernels answer, at most.
const RAYS: usize = 256;

/// Triangles of a mesh that kernels are tried on, at most: such as the second cache holds in every
/// precision, so that kernels are told apart and not memories.
const TRIANGLES: usize = 2048;

/// The first rays in an order of choice, those triangles that they hit, and of the others some from all
/// over the mesh, in its order.
pub(super) fn sample(inputs: &Inputs, order: &[usize]) -> Subject {
    let order = &order[..RAYS.min(order.len())];
    let rays: Vec<_> = order.iter().map(|&ray| inputs.rays[ray]).collect();
    let triangles = &inputs.triangles;
    let mut chosen = vec![false; triangles.len()];
    let reference = find(REFERENCE).expect("it is in the catalogue");
    let scene = (reference.f32.prepare)(triangles, &rays).expect("the reference takes every mesh");
    let finder = reference.f32.plain_finder(None, None).expect("one is compiled everywhere");
    let mut count = 0;
    finder.find(&scene, Culling::None, &mut |_, triangle, _| {
        // Half of them are left for what is missed, as most of a mesh is.
        if count < TRIANGLES / 2 && !std::mem::replace(&mut chosen[triangle as usize], true) {
            count += 1;
        }
        std::ops::ControlFlow::Continue(())
    });
    let missing = TRIANGLES.min(triangles.len()) - count;
    let rest: Vec<usize> = (0..triangles.len()).filter(|&number| !chosen[number]).collect();
    for place in 0..missing {
        chosen[rest[place * rest.len() / missing]] = true;
    }
    let of_chosen = |number: &usize| chosen[*number];
    let numbers: Vec<usize> = (0..triangles.len()).filter(of_chosen).collect();
    let unrounded = inputs.unrounded.as_ref().map(|wide| Unrounded {
        rays: order.iter().map(|&ray| wide.rays[ray]).collect(),
        triangles: numbers.iter().map(|&number| wide.triangles[number]).collect(),
        rounding: wide.rounding,
    });
    let triangles = numbers.iter().map(|&number| triangles[number]).collect();
    let (name, says) = ("mesh".to_owned(), "a part of a mesh, and of its rays".to_owned());
    Subject::new(name, says, Family::Mesh, Inputs { rays, triangles, unrounded })
}

#[cfg(test)]
mod tests {
    use super::*;
    use trisect_core::FloatFormat;

    #[test]
    fn a_sample_holds_what_the_rays_hit() {
        let mesh = trisect_workloads::Mesh::bunny();
        let rays = trisect_workloads::primary(&mesh, 8, 8).rays;
        let order: Vec<usize> = (0..64).rev().collect();
        let mut inputs = Inputs::new(rays, mesh.triangles.to_vec());
        let subject = sample(&inputs, &order);
        let counts = (subject.single.rays.len(), subject.single.triangles.len());
        assert_eq!(counts, (64, TRIANGLES));
        assert_eq!(subject.single.rays[0], inputs.rays[63]);
        let hits = subject.of(FloatFormat::F64).known().closest.iter().flatten().count();
        assert!(hits >= 8, "some rays meet the bunny");
        inputs.triangles.truncate(3);
        assert_eq!(sample(&inputs, &order).single.triangles, &mesh.triangles[..3]);
    }
}
