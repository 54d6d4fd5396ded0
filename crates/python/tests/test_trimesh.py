"""trisect in trimesh's place."""

import copy
import pickle

import numpy as np
import pytest

trimesh = pytest.importorskip("trimesh")

import meshes
import trisect.trimesh
from trisect.trimesh import RayMeshIntersector


@pytest.fixture(autouse=True)
def installed():
    trisect.trimesh.install()
    yield
    trisect.trimesh.uninstall()


def test_every_way_to_a_mesh_leads_to_it():
    import trimesh.ray.ray_pyembree

    box = trimesh.creation.box()
    others = [box, box.copy(), copy.deepcopy(box), box.submesh([[0, 1]], append=True), pickle.loads(pickle.dumps(box))]
    assert all(isinstance(mesh.ray, RayMeshIntersector) for mesh in others)
    assert trimesh.ray.ray_pyembree.RayMeshIntersector is RayMeshIntersector
    assert not isinstance(trimesh.creation.box(use_embree=False).ray, RayMeshIntersector)
    trisect.trimesh.uninstall()
    assert not isinstance(trimesh.creation.box().ray, RayMeshIntersector)


def test_scenes_follow_their_mesh():
    box = trimesh.creation.box()
    scene = box.ray.scene
    assert box.ray.scene is scene
    box.apply_translation([5, 0, 0])
    assert box.ray.intersects_any([[5, 0, 2], [0, 0, 2]], [[0, 0, -1]] * 2).tolist() == [True, False]


def test_all_layers_are_found_in_order():
    mesh = trimesh.Trimesh(*meshes.layers(250), process=False)
    ray = [[0.5, 0.25, 9.0]], [[0.0, 0.0, -2.0]]
    locations, rays, triangles = mesh.ray.intersects_location(*ray)
    assert triangles.tolist() == list(range(498, -1, -2)) and set(rays) == {0}
    assert np.allclose(locations, [[0.5, 0.25, z] for z in mesh.vertices[mesh.faces[triangles, 0], 2]], atol=1e-15)
    assert mesh.ray.intersects_id(*ray, max_hits=7)[0].tolist() == triangles[:7].tolist()
    assert mesh.ray.intersects_id(*ray, multiple_hits=False)[0].tolist() == [498]
    assert mesh.ray.intersects_first(*ray).tolist() == [498]


def test_one_triangle_counts_at_what_several_share():
    vertices, faces = meshes.grid(4)
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    origins, directions = meshes.rays_through_lattice(4, 2)
    triangles, rays = mesh.ray.intersects_id(origins, directions)
    assert rays.tolist() == list(range(len(origins)))
    first = mesh.ray.intersects_first(origins, directions)
    assert all(set(vertices[mesh.faces[a]][:, 0]) & set(vertices[mesh.faces[b]][:, 0]) for a, b in zip(triangles, first))
    coincident = trimesh.Trimesh(vertices, np.tile(faces, (40, 1)), process=False)
    assert len(coincident.ray.intersects_id([[0.3, 0.2, 1]], [[0, 0, -1]])[0]) == 40


def test_containment_is_right_on_lattices():
    vertices, faces = meshes.sphere(3)
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    line = np.linspace(-1, 1, 9)
    points = np.stack(np.meshgrid(line, line, line), -1).reshape(-1, 3)
    radius = np.linalg.norm(points, axis=1)
    assert mesh.contains(points[radius < 0.98]).all() and not mesh.contains(points[radius > 1.0]).any()


def test_shapes_have_to_match():
    box = trimesh.creation.box()
    with pytest.raises(ValueError, match=r"not \(2, 3\) and \(1, 3\)"):
        box.ray.intersects_any(np.zeros((2, 3)), np.zeros((1, 3)))


def test_rays_miss_nothing_far_from_the_origin():
    vertices, faces = meshes.grid(40, lambda x, y: 0.1 * np.sin(9 * x) * np.cos(7 * y))
    place = np.array([443_000.0, 5_411_000.0, 300.0])
    mesh = trimesh.Trimesh(vertices * 100 + place, faces, process=False)
    middles = mesh.triangles_center
    hit = mesh.ray.intersects_first(middles + [0, 0, 500], np.broadcast_to([0.0, 0, -1], middles.shape))
    assert hit.tolist() == list(range(len(faces)))


def test_pyvista_goes_through_it():
    pyvista = pytest.importorskip("pyvista")
    sphere = pyvista.Sphere()
    origins = np.array([[0.0, 0.1, 5.0], [0.1, 0.0, 5.0], [3.0, 3.0, 5.0]])
    directions = np.broadcast_to([0.0, 0.0, -1.0], origins.shape)
    asked = []
    before = RayMeshIntersector.intersects_location
    try:
        RayMeshIntersector.intersects_location = lambda *args, **how: asked.append(args) or before(*args, **how)
        points, rays, cells = sphere.multi_ray_trace(origins, directions, first_point=True)
    finally:
        RayMeshIntersector.intersects_location = before
    assert asked and sorted(rays) == [0, 1] and np.allclose(points[:, 2], 0.49, atol=0.02)
