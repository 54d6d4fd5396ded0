"""Meshes and rays that are hard for those who round, and some that are not."""

import numpy as np


def grid(size, height=lambda x, y: 0 * x):
    """A square of `size`² cells of two triangles, from 0 to 1."""
    line = np.linspace(0.0, 1.0, size + 1)
    x, y = (side.ravel() for side in np.meshgrid(line, line, indexing="ij"))
    vertices = np.stack([x, y, height(x, y)], axis=1)
    corner = np.arange((size + 1) ** 2).reshape(size + 1, size + 1)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    faces = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], 2).reshape(-1, 3)
    return vertices, faces


def box(low=(0.0, 0.0, 0.0), high=(1.0, 1.0, 1.0)):
    """A box, its faces seen from outside."""
    ends = np.array([low, high], np.float64)
    vertices = np.array([[ends[i >> axis & 1, axis] for axis in range(3)] for i in range(8)])
    faces = [[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4]]
    faces += [[2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]]
    return vertices, np.array(faces)


def sphere(divisions=3, radius=1.0):
    """A sphere, by dividing an octahedron."""
    vertices = np.concatenate([np.eye(3), -np.eye(3)])
    faces = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    for _ in range(divisions):
        edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, at = np.unique(edges, axis=0, return_inverse=True)
        middle = at.reshape(-1, 3) + len(vertices)
        vertices = np.concatenate([vertices, vertices[edges].sum(axis=1)])
        vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
        (a, b, c), (ab, bc, ca) = faces.T, middle.T
        faces = np.concatenate([np.stack(part, 1) for part in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return vertices * radius, faces


def layers(count, distance=0.01):
    """Squares above each other, of two triangles each."""
    vertices, faces = grid(1)
    at = np.arange(count)
    stacked = vertices[None] + np.array([0.0, 0.0, distance]) * at[:, None, None]
    return stacked.reshape(-1, 3), (faces[None] + len(vertices) * at[:, None, None]).reshape(-1, 3)


def rays_through_lattice(size, fraction=1):
    """Rays straight down through the vertices of a grid, and through points between them."""
    line = np.linspace(0.0, 1.0, size * fraction + 1)
    x, y = (side.ravel() for side in np.meshgrid(line, line, indexing="ij"))
    origins = np.stack([x, y, np.full_like(x, 2.0)], axis=1)
    return origins, np.broadcast_to([0.0, 0.0, -1.0], origins.shape).copy()


def random_rays(count, seed=0, around=(0.0, 0.0, 0.0), radius=3.0):
    """Rays from a sphere towards points within."""
    random = np.random.default_rng(seed)
    origins = random.normal(size=(count, 3))
    origins *= radius / np.linalg.norm(origins, axis=1, keepdims=True)
    return origins + around, random.uniform(-0.7, 0.7, (count, 3)) - origins
