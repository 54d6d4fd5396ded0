//! What nodes show: their meshes' triangles, morphed and skinned as the document stands.

use std::collections::BTreeMap;

use super::accessor::{Component, Rule};
use super::document::{Mesh, Primitive};
use super::nodes::{IDENTITY, Matrix, determinant, multiply, transform};
use super::{GltfFile, element, malformed};
use crate::error::MeshProblem;
use crate::quote::quoted;
use crate::reading::Reading;

const FLOAT: (Component, bool) = (Component::F32, false);
const SHARES: [(Component, bool); 3] = [FLOAT, (Component::U8, true), (Component::U16, true)];
const POINTS: Rule = Rule { kind: "VEC3", components: &[FLOAT] };
const COORDINATES: Rule = Rule { kind: "VEC2", components: &SHARES };
const WEIGHTS: Rule = Rule { kind: "VEC4", components: &SHARES };
const JOINTS: Rule =
    Rule { kind: "VEC4", components: &[(Component::U8, false), (Component::U16, false)] };
const MATRICES: Rule = Rule { kind: "MAT4", components: &[FLOAT] };

/// A mesh of the document in the place that a node gives it.
pub struct PlacedMesh {
    /// The node.
    pub node: usize,
    /// The mesh.
    pub mesh: usize,
    /// From the mesh's space to the world's. A skinned mesh is in the world already: its joints carry
    /// it, and the node's own transform is without effect.
    pub world: Matrix,
    skin: Option<usize>,
    /// The node's own weights of morph targets.
    weights: Option<Vec<f64>>,
}

impl PlacedMesh {
    /// Whether the mesh looks the same wherever this is so.
    pub fn is_shared(&self) -> bool {
        self.skin.is_none() && self.weights.is_none()
    }
}

/// Triangles that share a material.
pub struct Part {
    /// The vertices' positions.
    pub positions: Vec<[f64; 3]>,
    /// The vertices' normals, of any length; empty where there are none.
    pub normals: Vec<[f64; 3]>,
    /// The vertices' coordinates in the material's texture, carried as it says; empty where there are none.
    pub coordinates: Vec<[f64; 2]>,
    /// The triangles' corners, as numbers of vertices, in range.
    pub corners: Vec<[usize; 3]>,
    /// The number of the material.
    pub material: Option<usize>,
    /// Stands for the part in messages.
    place: String,
    /// The box around the corners; none where there are no triangles.
    bounds: Option<[[f64; 3]; 2]>,
}

impl Part {
    /// The part as a matrix carries it. A mirror turns front to back; the corners' order turns it again.
    #[must_use]
    pub fn carried(&self, matrix: &Matrix) -> Self {
        let is_mirror = determinant(matrix) < 0.0;
        let turned = |&[a, b, c]: &[usize; 3]| if is_mirror { [a, c, b] } else { [a, b, c] };
        Self {
            positions: self.positions.iter().map(|&at| transform(matrix, at)).collect(),
            normals: self.normals.iter().map(|&normal| carried_normal(matrix, normal)).collect(),
            coordinates: self.coordinates.clone(),
            corners: self.corners.iter().map(turned).collect(),
            material: self.material,
            place: self.place.clone(),
            bounds: None,
        }
    }

    /// Whether all corners are finite in f32 where a matrix carries them.
    pub(super) fn check_range(&self, matrix: &Matrix) -> Result<(), MeshProblem> {
        let Some(bounds) = self.bounds else { return Ok(()) };
        let is_far = |at: [f64; 3]| !at.iter().all(|x| x.abs() <= f64::from(f32::MAX));
        let of_box = |i: usize| std::array::from_fn(|axis| bounds[i >> axis & 1][axis]);
        if !(0..8).any(|i| is_far(transform(matrix, of_box(i)))) {
            return Ok(());
        }
        for &vertex in self.corners.iter().flatten() {
            let at = self.positions[vertex];
            if is_far(transform(matrix, at)) {
                let what = format!("vertex {vertex} at {at:?} is not finite in f32 in its place");
                return Err(malformed(&self.place, what));
            }
        }
        Ok(())
    }
}

/// The box around the corners; it holds what is not finite, too.
fn bounds(positions: &[[f64; 3]], corners: &[[usize; 3]]) -> Option<[[f64; 3]; 2]> {
    let mut vertices = corners.iter().flatten().map(|&vertex| positions[vertex]);
    let first = vertices.next()?;
    let pick = |keeps: fn(f64, f64) -> bool, old: [f64; 3], new: [f64; 3]| {
        std::array::from_fn(
            |i| if keeps(old[i], new[i]) || old[i].is_nan() { old[i] } else { new[i] },
        )
    };
    Some(vertices.fold([first, first], |[low, high], at| {
        [pick(|old, new| old <= new, low, at), pick(|old, new| old >= new, high, at)]
    }))
}

impl GltfFile {
    /// The meshes of the nodes that are shown.
    ///
    /// # Errors
    /// When a node names a mesh or a skin that does not exist.
    pub fn placed_meshes(&self) -> Result<Vec<PlacedMesh>, MeshProblem> {
        let mut placed = Vec::new();
        for (number, world) in self.nodes() {
            let (place, node) = (format!("node {number}"), &self.document.nodes[number]);
            let Some(mesh) = node.mesh else { continue };
            element(&self.document.meshes, mesh, "mesh", &place)?;
            if let Some(skin) = node.skin {
                element(&self.document.skins, skin, "skin", &place)?;
            }
            let world = if node.skin.is_some() { IDENTITY } else { *world };
            let weights = node.weights.clone();
            placed.push(PlacedMesh { node: number, mesh, world, skin: node.skin, weights });
        }
        Ok(placed)
    }

    /// The name of a mesh; may be empty.
    pub fn mesh_name(&self, mesh: usize) -> &str {
        self.document.meshes.get(mesh).map_or("", |mesh| &mesh.name)
    }

    /// Checks that a mesh's corners are finite in f32 where it is placed.
    ///
    /// # Errors
    /// When one is not.
    pub fn check_range(&self, placed: &PlacedMesh, parts: &[Part]) -> Result<(), MeshProblem> {
        parts.iter().try_for_each(|part| part.check_range(&placed.world))
    }

    /// The triangles of a placed mesh. Points, lines, and what has no positions are left out.
    ///
    /// # Errors
    /// When an index is out of range, an accessor reaches beyond its data, or is of a kind that its
    /// purpose does not allow.
    pub fn parts(
        &self,
        placed: &PlacedMesh,
        reading: &mut Reading,
    ) -> Result<Vec<Part>, MeshProblem> {
        let mesh = &self.document.meshes[placed.mesh];
        let mut parts = Vec::new();
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let place = format!("mesh {} primitive {number}", placed.mesh);
            let left_out = match (primitive.mode, primitive.attributes.get("POSITION")) {
                (0, _) => Some("points, left out"),
                (1..=3, _) => Some("lines, left out"),
                (_, None) => Some("triangles without positions, left out"),
                _ => None,
            };
            match left_out {
                Some(what) => reading.remark(&self.file, &place, what),
                None => parts.push(self.part(placed, mesh, primitive, &place, reading)?),
            }
        }
        Ok(parts)
    }

    fn part(
        &self,
        placed: &PlacedMesh,
        mesh: &Mesh,
        primitive: &Primitive,
        place: &str,
        reading: &mut Reading,
    ) -> Result<Part, MeshProblem> {
        self.check_compression(primitive, place)?;
        let texture = self.document.base_texture(primitive.material);
        let set = format!("TEXCOORD_{}", texture.map_or(0, super::document::TextureInfo::set));
        let mut positions =
            self.morphed(mesh, placed, primitive, "POSITION", &POINTS, place, reading)?;
        let mut normals =
            self.morphed(mesh, placed, primitive, "NORMAL", &POINTS, place, reading)?;
        let mut coordinates =
            self.morphed::<2>(mesh, placed, primitive, &set, &COORDINATES, place, reading)?;
        if let Some(texture) = texture {
            if coordinates.is_empty() && !positions.is_empty() {
                let what =
                    "no coordinates of the set that the texture uses: one colour of it is shown";
                reading.note(&self.file, &format!("{place}, {set}"), what)?;
            }
            for at in &mut coordinates {
                *at = texture.carry(*at);
            }
        }
        let count = positions.len();
        for (name, other) in [("NORMAL", normals.len()), (&*set, coordinates.len())] {
            same_count(name, other, count, place)?;
        }
        let accessor = &self.document.accessors[primitive.attributes["POSITION"]];
        if accessor.min.is_none() || accessor.max.is_none() {
            reading.tolerate(place, "positions without min and max")?;
        }
        if let Some(skin) = placed.skin {
            self.skin(skin, primitive, &mut positions, &mut normals, place, reading)?;
        }
        if let Some(material) = primitive.material {
            element(&self.document.materials, material, "material", place)?;
        }
        let indices = match primitive.indices {
            None => (0..count).collect(),
            Some(accessor) => self.whole(accessor, place, reading)?,
        };
        if let Some(index) = indices.iter().find(|index| **index >= count) {
            let what = format!("index {index} is out of range, it has {count} vertices");
            return Err(malformed(place, what));
        }
        let corners = corners(primitive.mode, &indices, place)?;
        let bounds = bounds(&positions, &corners);
        let (material, place) = (primitive.material, place.to_owned());
        let part = Part { positions, normals, coordinates, corners, material, place, bounds };
        part.check_range(&IDENTITY)?;
        Ok(part)
    }

    /// Without its data, what is compressed would be read as zeros.
    fn check_compression(&self, primitive: &Primitive, place: &str) -> Result<(), MeshProblem> {
        let Some(name) = primitive.extensions.keys().find(|name| name.contains("compression"))
        else {
            return Ok(());
        };
        let accessors = primitive.attributes.values().chain(&primitive.indices);
        let has_data = |number: &usize| {
            let accessor = self.document.accessors.get(*number);
            accessor.is_none_or(|accessor| accessor.buffer_view.is_some())
        };
        if accessors.clone().all(has_data) {
            return Ok(());
        }
        Err(MeshProblem::Unsupported {
            what: format!("{place}: {} without uncompressed data is", quoted(name)),
            mend: "export it without compression",
        })
    }

    /// An attribute of a primitive, with its morph targets added by their weights; empty where the
    /// primitive lacks it.
    #[allow(clippy::too_many_arguments, reason = "an attribute's surroundings")]
    fn morphed<const N: usize>(
        &self,
        mesh: &Mesh,
        placed: &PlacedMesh,
        primitive: &Primitive,
        name: &str,
        rule: &Rule,
        place: &str,
        reading: &mut Reading,
    ) -> Result<Vec<[f64; N]>, MeshProblem> {
        let read = |attributes: &BTreeMap<String, usize>, reading: &mut Reading| {
            let accessor = attributes.get(name);
            accessor.map(|&number| self.numbers::<N>(number, rule, place, reading)).transpose()
        };
        let Some(mut values) = read(&primitive.attributes, reading)? else { return Ok(Vec::new()) };
        let weights = placed.weights.as_ref().unwrap_or(&mesh.weights);
        if ![0, weights.len()].contains(&primitive.targets.len()) && !weights.is_empty() {
            let (weights, targets) = (weights.len(), primitive.targets.len());
            let what = format!("it has {targets} morph targets and {weights} weights");
            return Err(malformed(place, what));
        }
        for (target, &weight) in primitive.targets.iter().zip(weights) {
            if weight == 0.0 {
                continue;
            }
            let Some(shifts) = read(target, reading)? else { continue };
            same_count(name, shifts.len(), values.len(), place)?;
            for (value, shift) in values.iter_mut().zip(shifts) {
                *value = std::array::from_fn(|i| value[i] + weight * shift[i]);
            }
        }
        Ok(values)
    }

    /// Carries vertices by the joints of a skin to the world.
    fn skin(
        &self,
        number: usize,
        primitive: &Primitive,
        positions: &mut [[f64; 3]],
        normals: &mut [[f64; 3]],
        place: &str,
        reading: &mut Reading,
    ) -> Result<(), MeshProblem> {
        let joints = self.joint_matrices(number, reading)?;
        let mut blended = vec![[[0.0; 4]; 4]; positions.len()];
        let mut sums = vec![0.0; positions.len()];
        reading.claim(blended.len() as u64 * size_of::<(Matrix, f64)>() as u64)?;
        let pairs = (0..).map_while(|set: usize| {
            let attribute = |name: &str| primitive.attributes.get(&format!("{name}_{set}"));
            Some((attribute("JOINTS")?, attribute("WEIGHTS")?))
        });
        for (numbers, weights) in pairs {
            let numbers = self.numbers::<4>(*numbers, &JOINTS, place, reading)?;
            let weights = self.numbers::<4>(*weights, &WEIGHTS, place, reading)?;
            same_count("JOINTS", numbers.len(), positions.len(), place)?;
            same_count("WEIGHTS", weights.len(), positions.len(), place)?;
            for (vertex, (numbers, weights)) in numbers.iter().zip(&weights).enumerate() {
                for (&joint, &weight) in numbers.iter().zip(weights).filter(|pair| *pair.1 != 0.0) {
                    #[allow(
                        clippy::cast_possible_truncation,
                        clippy::cast_sign_loss,
                        reason = "whole, and saturates"
                    )]
                    let matrix = element(&joints, joint as usize, "joint", place)?;
                    for (column, of) in blended[vertex].iter_mut().zip(matrix) {
                        *column = std::array::from_fn(|row| column[row] + weight * of[row]);
                    }
                    sums[vertex] += weight;
                }
            }
        }
        for (vertex, (matrix, sum)) in blended.iter_mut().zip(sums).enumerate() {
            // The weights are shares of 1, rounded.
            if (0.99..=1.01).contains(&sum) {
                *matrix = matrix.map(|column| column.map(|x| x / sum));
            } else if sum == 0.0 {
                let what =
                    "vertices of a skinned mesh without joints, left where the mesh has them";
                reading.note(&self.file, place, what)?;
                *matrix = IDENTITY;
            } else {
                let what = format!("vertex {vertex}: its joints' weights add up to {sum}, not 1");
                return Err(malformed(place, what));
            }
            positions[vertex] = transform(matrix, positions[vertex]);
            if let Some(normal) = normals.get_mut(vertex) {
                *normal = carried_normal(matrix, *normal);
            }
        }
        Ok(())
    }

    /// From the space that a skin's mesh is in to the world, joint by joint.
    fn joint_matrices(
        &self,
        number: usize,
        reading: &mut Reading,
    ) -> Result<Vec<Matrix>, MeshProblem> {
        let (place, skin) = (format!("skin {number}"), &self.document.skins[number]);
        let inverse = match skin.inverse_bind_matrices {
            None => vec![IDENTITY; skin.joints.len()],
            Some(accessor) => {
                let matrices = self.numbers::<16>(accessor, &MATRICES, &place, reading)?;
                let column =
                    |all: &[f64; 16], i: usize| std::array::from_fn(|row| all[4 * i + row]);
                matrices.iter().map(|all| std::array::from_fn(|i| column(all, i))).collect()
            }
        };
        if inverse.len() < skin.joints.len() {
            let (joints, matrices) = (skin.joints.len(), inverse.len());
            return Err(malformed(
                place,
                format!("it has {joints} joints and {matrices} matrices"),
            ));
        }
        let joints = skin.joints.iter().zip(&inverse).map(|(&joint, inverse)| {
            element(&self.worlds, joint, "node", &place).map(|world| multiply(world, inverse))
        });
        joints.collect()
    }
}

fn same_count(name: &str, found: usize, vertices: usize, place: &str) -> Result<(), MeshProblem> {
    if found == vertices || found == 0 {
        return Ok(());
    }
    Err(malformed(place, format!("{name} has {found} items, POSITION {vertices}")))
}

/// A normal stays at right angles to what a matrix carries.
fn carried_normal(m: &Matrix, n: [f64; 3]) -> [f64; 3] {
    let cross = |a: &[f64; 4], b: &[f64; 4]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let columns = [cross(&m[1], &m[2]), cross(&m[2], &m[0]), cross(&m[0], &m[1])];
    let sign = determinant(m).signum();
    std::array::from_fn(|row| sign * (0..3).map(|i| columns[i][row] * n[i]).sum::<f64>())
}

/// The corners of triangles, of strips, whose every second one is turned, and of fans: the order of
/// the specification, section 3.7.2.1.
fn corners(mode: u32, indices: &[usize], place: &str) -> Result<Vec<[usize; 3]>, MeshProblem> {
    let count = indices.len();
    Ok(match mode {
        4 if !count.is_multiple_of(3) => {
            let what = format!("{count} corners are not a multiple of three");
            return Err(malformed(place, what));
        }
        4 => indices.chunks_exact(3).map(|three| [three[0], three[1], three[2]]).collect(),
        5 => {
            let turned = |(i, three): (usize, &[usize])| match i % 2 {
                0 => [three[0], three[1], three[2]],
                _ => [three[0], three[2], three[1]],
            };
            indices.windows(3).enumerate().map(turned).collect()
        }
        6 => match indices {
            [first, rest @ ..] => rest.windows(2).map(|two| [two[0], two[1], *first]).collect(),
            [] => Vec::new(),
        },
        _ => return Err(malformed(place, format!("mode {mode} is none"))),
    })
}
