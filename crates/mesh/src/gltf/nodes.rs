//! The nodes' trees: which of them are shown, and where.

use super::document::{Document, Node};
use super::{element, malformed};
use crate::error::MeshProblem;
use crate::reading::Reading;

/// Columns of a 4×4 matrix; f64, so that a vertex is rounded once.
pub type Matrix = [[f64; 4]; 4];

pub(super) const IDENTITY: Matrix =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// Each node's matrix to the world, and the nodes that are shown, parents before their children.
pub(super) fn place(
    file: &str,
    document: &Document,
    reading: &mut Reading,
) -> Result<(Vec<Matrix>, Vec<usize>), MeshProblem> {
    let nodes = &document.nodes;
    let mut parents: Vec<Option<usize>> = vec![None; nodes.len()];
    for (number, node) in nodes.iter().enumerate() {
        let place = format!("node {number}");
        for &child in &node.children {
            element(nodes, child, "node", &place)?;
            if let Some(other) = parents[child].replace(number) {
                let what = format!("its child {child} is one of node {other} too");
                return Err(malformed(place, what));
            }
        }
    }
    let roots = (0..nodes.len()).filter(|&node| parents[node].is_none());
    let mut worlds = vec![None; nodes.len()];
    // The stack is ours because a file may nest deeper than the program's.
    let mut open: Vec<(usize, Matrix)> = roots.map(|root| (root, IDENTITY)).collect();
    while let Some((number, parent)) = open.pop() {
        let world = multiply(&parent, &local(file, number, &nodes[number], reading)?);
        worlds[number] = Some(world);
        open.extend(nodes[number].children.iter().map(|&child| (child, world)));
    }
    let worlds: Option<Vec<Matrix>> = worlds.iter().copied().collect();
    let worlds = worlds.ok_or_else(|| malformed("nodes", "some are their own ancestors"))?;

    let mut seen = vec![false; nodes.len()];
    let mut shown = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    for root in roots_shown(file, document, &parents, reading)? {
        open.push(root);
        while let Some(node) = open.pop() {
            if std::mem::replace(&mut seen[node], true) {
                continue;
            }
            shown.push(node);
            open.extend(nodes[node].children.iter().rev());
        }
    }
    Ok((worlds, shown))
}

/// The nodes that the scene to show names. Which it is where the document does not say is left to
/// whoever shows it: the first; and all that there is where there are no scenes.
fn roots_shown(
    file: &str,
    document: &Document,
    parents: &[Option<usize>],
    reading: &mut Reading,
) -> Result<Vec<usize>, MeshProblem> {
    let scenes = &document.scenes;
    let (number, scene) = match (document.scene, scenes.as_slice()) {
        (Some(number), _) => (number, element(scenes, number, "scene", "scene")?),
        (None, [scene]) => (0, scene),
        (None, [scene, ..]) => {
            let what = "several scenes, and none of them named to be shown: the first is";
            reading.remark(file, "scenes", what);
            (0, scene)
        }
        (None, []) => {
            reading.remark(file, "scenes", "no scenes: all nodes are shown");
            return Ok((0..parents.len()).filter(|&node| parents[node].is_none()).collect());
        }
    };
    let place = format!("scene {number}");
    // A node that is listed beside an ancestor is shown in the ancestor's tree.
    let mut listed = vec![false; parents.len()];
    for &node in &scene.nodes {
        element(&document.nodes, node, "node", &place)?;
        if std::mem::replace(&mut listed[node], true) {
            reading.tolerate(&place, "a node that is listed twice")?;
        }
    }
    let mut roots = Vec::new();
    for &node in &scene.nodes {
        if !std::mem::take(&mut listed[node]) {
            continue;
        }
        if parents[node].is_some() {
            let what = "a node that is listed in the scene and has a parent, shown once where its parents \
                        put it";
            reading.note(file, &place, what)?;
        }
        roots.push(node);
    }
    Ok(roots)
}

/// A node's matrix to its parent.
fn local(
    file: &str,
    number: usize,
    node: &Node,
    reading: &mut Reading,
) -> Result<Matrix, MeshProblem> {
    let place = format!("node {number}");
    let has_parts = node.translation.is_some() || node.rotation.is_some() || node.scale.is_some();
    if let Some(matrix) = &node.matrix {
        if has_parts {
            reading.note(
                file,
                &place,
                "a matrix beside other transforms, which are passed over",
            )?;
        }
        let matrix: Matrix =
            std::array::from_fn(|column| std::array::from_fn(|row| matrix[4 * column + row]));
        if matrix.map(|column| column[3]) != [0.0, 0.0, 0.0, 1.0] {
            let what = "its matrix is not affine: the last row is not 0 0 0 1";
            return Err(malformed(place, what));
        }
        return Ok(matrix);
    }
    let [x, y, z] = node.scale.unwrap_or([1.0; 3]);
    let mut turn = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let square: f64 = turn.iter().map(|part| part * part).sum();
    if (square - 1.0).abs() > 1e-4 {
        if !(square > 0.0 && square.is_finite()) {
            return Err(malformed(place, "its rotation has no direction"));
        }
        reading.tolerate(&place, "a rotation that is not of unit length")?;
        turn = turn.map(|part| part / square.sqrt());
    }
    let [i, j, k, w] = turn;
    let [tx, ty, tz] = node.translation.unwrap_or_default();
    Ok([
        [
            (1.0 - 2.0 * (j * j + k * k)) * x,
            2.0 * (i * j + w * k) * x,
            2.0 * (i * k - w * j) * x,
            0.0,
        ],
        [
            2.0 * (i * j - w * k) * y,
            (1.0 - 2.0 * (i * i + k * k)) * y,
            2.0 * (j * k + w * i) * y,
            0.0,
        ],
        [
            2.0 * (i * k + w * j) * z,
            2.0 * (j * k - w * i) * z,
            (1.0 - 2.0 * (i * i + j * j)) * z,
            0.0,
        ],
        [tx, ty, tz, 1.0],
    ])
}

pub(super) fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    b.map(|column| {
        [0, 1, 2, 3].map(|row| {
            a[0][row] * column[0]
                + a[1][row] * column[1]
                + a[2][row] * column[2]
                + a[3][row] * column[3]
        })
    })
}

/// Where a matrix carries a point.
pub(super) fn transform(m: &Matrix, [x, y, z]: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|row| m[0][row] * x + m[1][row] * y + m[2][row] * z + m[3][row])
}

/// The determinant of a matrix's linear part; below 0 it mirrors.
pub(super) fn determinant(m: &Matrix) -> f64 {
    m[0][0] * (m[1][1] * m[2][2] - m[2][1] * m[1][2])
        - m[1][0] * (m[0][1] * m[2][2] - m[2][1] * m[0][2])
        + m[2][0] * (m[0][1] * m[1][2] - m[1][1] * m[0][2])
}
