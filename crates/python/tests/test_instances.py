"""Scenes of scenes, against the mesh of all instances."""

import copy
import pickle

import numpy as np
import pytest

import meshes
import trisect


def lumps():
    """A sphere whose corners are on a lattice, so that a move by whole numbers and a stretch by powers of two round
    nothing."""
    vertices, faces = meshes.sphere(3)
    return (np.rint(vertices * 64) / 64).astype(np.float32), faces


def placed():
    """Moved, mirrored, stretched by two, turned by a quarter, and in one another; apart."""
    matrices = np.tile(np.eye(4), (5, 1, 1))
    matrices[1, :3] = [[-1, 0, 0, 4], [0, 1, 0, 0], [0, 0, 1, 0]]
    matrices[2, :3] = [[2, 0, 0, 0], [0, 2, 0, 6], [0, 0, 0.5, 1]]
    matrices[3, :3] = [[0, -1, 0, 7], [1, 0, 0, 7], [0, 0, 1, 0]]
    matrices[4, :3] = [[1, 0, 0, 0.5], [0, 1, 0, 0.25], [0, 0, 1, 0]]
    return matrices


def lattice_rays(count=4000):
    """Rays on the lattice: carried to an instance they are as they were."""
    random = np.random.default_rng(5)
    origins = random.integers(-256, 640, (count, 3)) / 64
    directions = random.integers(-8, 9, (count, 3)).astype(np.float64)
    # Towards the middles of instances.
    aims = placed()[random.integers(5, size=count), :3, 3] + random.integers(-32, 33, (count, 3)) / 64
    directions[::2] = (aims - origins)[::2]
    directions[1::4] = [0, 0, -1]
    return origins.astype(np.float32), directions.astype(np.float32)


@pytest.fixture
def scene():
    return trisect.Scene.instances(trisect.Scene(*lumps()), placed())


@pytest.fixture
def flat(scene):
    vertices, faces = lumps()
    corners = [vertices.astype(np.float64) @ m[:3, :3].T + m[:3, 3] for m in placed()]
    together = [faces + at * len(vertices) for at in range(5)]
    flat = trisect.Scene(np.concatenate(corners).astype(np.float32), np.concatenate(together))
    assert np.array_equal(flat.vertices, scene.vertices) and np.array_equal(flat.faces, scene.faces)
    return flat


def same(one, other):
    return all(np.array_equal(np.asarray(a), np.asarray(b)) for a, b in zip(one, other, strict=True))


def test_answers_are_those_of_the_flattened_mesh(scene, flat):
    rays = lattice_rays()
    hits, expected = scene.first(*rays), flat.first(*rays)
    assert 0.2 < (hits.triangle >= 0).mean() < 0.9
    # Of hits in several instances at one point the first is taken, as in the mesh.
    assert np.array_equal(hits.triangle, expected.triangle) and np.array_equal(hits.t, expected.t)
    assert np.array_equal(scene.any(*rays), flat.any(*rays))
    assert np.array_equal(scene.count(*rays), flat.count(*rays))
    every, others = scene.all(*rays), flat.all(*rays)
    assert np.array_equal(every.offsets, others.offsets) and np.array_equal(every.t, others.t)
    # Hits of one `t` may be in another order, where they are in several instances.
    order = lambda hits: np.lexsort((hits.triangle, hits.t, hits.ray))
    assert np.array_equal(every.triangle[order(every)], others.triangle[order(others)])
    points = np.random.default_rng(6).integers(-128, 576, (2000, 3)) / 64
    # Those in two are in an even number.
    assert np.array_equal(scene.places(points), flat.places(points))
    assert len(scene) == len(flat)
    mask = np.random.default_rng(7).random(len(scene)) < 0.5
    assert np.array_equal(scene.filtered(mask).first(*rays).triangle, flat.filtered(mask).first(*rays).triangle)


def test_hits_name_the_instance_and_its_triangle(scene, flat):
    rays = lattice_rays()
    hits = scene.first(*rays)
    instance, triangle = scene.locate(hits)
    assert instance.dtype == triangle.dtype == np.int32 and instance.shape == hits.t.shape
    hit = hits.triangle >= 0
    count = len(lumps()[1])
    assert np.array_equal(instance[hit] * count + triangle[hit], hits.triangle[hit])
    assert set(instance[hit]) == set(range(5)) and (triangle[hit] < count).all()
    assert (instance[~hit] == -1).all() and (triangle[~hit] == -1).all()
    # Where that triangle is in its own space, and where the instance is.
    corners = lumps()[0].astype(np.float64)[lumps()[1][triangle[hit]]]
    weights = np.stack([1 - hits.u - hits.v, hits.u, hits.v], axis=1)[hit]
    at = placed()[instance[hit]]
    expected = np.einsum("nij,nj->ni", at[:, :3, :3], (weights[..., None] * corners).sum(axis=1)) + at[:, :3, 3]
    assert np.allclose(scene.points(hits)[hit], expected, atol=1e-6)
    assert np.allclose(scene.points(hits), flat.points(flat.first(*rays)), atol=1e-5, equal_nan=True)
    assert np.isnan(scene.points(hits)[~hit]).all()
    one = scene.first([0, 0, 9], [0, 0, -1])
    assert scene.locate(one).instance.shape == () and scene.points(one).shape == (3,)
    every = scene.all(*rays)
    assert scene.locate(every).instance.shape == every.t.shape and scene.points(every).shape == (len(every.t), 3)
    # A mesh counts as one.
    assert same(flat.locate(flat.first(*rays)), (np.where(hit, 0, -1), flat.first(*rays).triangle))


def test_turned_instances_are_near_the_flattened_mesh():
    random = np.random.default_rng(8)
    turned, _ = np.linalg.qr(random.normal(size=(20, 3, 3)))
    transforms = np.concatenate([turned, random.uniform(-9, 9, (20, 3, 1))], axis=2)
    mesh = trisect.Scene(*lumps())
    scene = trisect.Scene.instances(mesh, transforms)
    flat = trisect.Scene(scene.vertices, scene.faces)
    rays = [array.astype(np.float32) for array in meshes.random_rays(5000, radius=20)]
    hits, expected = scene.first(*rays), flat.first(*rays)
    assert (hits.triangle == expected.triangle).mean() > 0.99
    both = (hits.triangle >= 0) & (hits.triangle == expected.triangle)
    assert np.allclose(hits.t[both], expected.t[both], rtol=1e-4)


def test_instances_may_be_in_instances(scene):
    outer = np.tile(np.eye(4), (2, 1, 1))
    outer[1, :3, 3] = [0, 0, 16]
    nested = trisect.Scene.instances([scene, scene], outer)
    flat = trisect.Scene(nested.vertices, nested.faces)
    rays = lattice_rays(1000)
    for moved in (0, 16):
        origins = rays[0] + np.float32([0, 0, moved])
        hits = nested.first(origins, rays[1])
        assert np.array_equal(hits.triangle, flat.first(origins, rays[1]).triangle)
        assert np.allclose(nested.points(hits), flat.points(hits), atol=1e-5, equal_nan=True)
        located = nested.locate(hits)
        inner = scene.locate(hits._replace(triangle=located.triangle))
        hit = hits.triangle >= 0
        count = len(lumps()[1])
        assert np.array_equal((located.instance * 5 + inner.instance)[hit] * count + inner.triangle[hit], hits.triangle[hit])


def test_copies_and_pickles_answer_alike_and_move_apart(scene):
    rays = lattice_rays(1000)
    before = scene.first(*rays)
    moved = placed()
    moved[:, 2, 3] += 1
    expected = trisect.Scene.instances(trisect.Scene(*lumps()), moved).first(*rays)
    assert not same(before, expected)
    others = [copy.copy(scene), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))]
    for other in others:
        assert same(other.first(*rays), before) and repr(other) == repr(scene)
    scene.set_transforms(moved)
    assert same(scene.first(*rays), expected) and np.array_equal(scene.transforms, moved[:, :3].astype(np.float32))
    for other in others:
        assert same(other.first(*rays), before) and np.array_equal(other.transforms, placed()[:, :3])
    # Alone, its tree is fitted.
    scene.set_transforms(placed()[:, :3])
    assert same(scene.first(*rays), before)
    mask = np.arange(len(scene)) % 2 == 0
    again = pickle.loads(pickle.dumps(scene.filtered(mask)))
    assert same(again.first(*rays), scene.filtered(mask).first(*rays))


def test_a_mesh_travels_once_however_often_it_is_placed():
    mesh = trisect.Scene(*lumps())
    many = trisect.Scene.instances(mesh, np.tile(np.eye(4), (1000, 1, 1)))
    assert len(pickle.dumps(many)) < len(pickle.dumps(mesh)) + 1000 * 64
    again = pickle.loads(pickle.dumps(many))
    assert again.statistics["bytes"] == many.statistics["bytes"]


def test_instances_keep_the_mesh_as_it_was_placed():
    vertices, faces = lumps()
    mesh = trisect.Scene(vertices, faces, moving=True)
    scene = trisect.Scene.instances(mesh, [np.eye(4)])
    rays = lattice_rays(1000)
    before = scene.first(*rays)
    mesh.update(vertices * np.float32(0.5))
    assert same(scene.first(*rays), before) and not same(mesh.first(*rays), before)


SCENE = trisect.Scene(*lumps())
SHEARED = np.zeros((1, 4, 4))
SHEARED[0, 3, 3] = 1


@pytest.mark.parametrize("make, message", [
    (lambda: trisect.Scene.instances(SCENE, np.eye(4)), r"transforms must have shape \(n, 4, 4\) or \(n, 3, 4\), not \(4, 4\)"),
    (lambda: trisect.Scene.instances([SCENE], [np.eye(4)] * 2), "each scene has a transform, but there are 1 and 2"),
    (lambda: trisect.Scene.instances(SCENE, SHEARED), "the transform of instance 0 is singular"),
    (lambda: trisect.Scene.instances(SCENE, SHEARED * np.nan), "the last row of transform 0"),
    (lambda: trisect.Scene.instances(SCENE, np.full((1, 3, 4), np.nan)), "the transform of instance 0 is not finite"),
    (lambda: trisect.Scene.instances(trisect.Scene(*meshes.box()), [np.eye(4)]), "scene 0 is in f64, but instances are in f32"),
    (lambda: trisect.Scene.instances(SCENE.filtered(np.ones(len(SCENE), bool)), [np.eye(4)]), "scene 0 is filtered"),
    (lambda: trisect.Scene.instances(SCENE, [np.eye(4)]).update(lumps()[0]), "move them by set_transforms"),
    (lambda: trisect.Scene.instances(SCENE, [np.eye(4)]).set_transforms([np.eye(4)] * 2), "there are 1 instances, but 2 transforms"),
    (lambda: SCENE.set_transforms([np.eye(4)]), "a mesh has no instances"),
])
def test_what_is_amiss_is_said(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_no_instances_are_hit_by_nothing():
    nothing = trisect.Scene.instances([], [])
    assert len(nothing) == 0 and not nothing.any([0, 0, 0], [0, 0, 1]) and nothing.vertices.shape == (0, 3)
    assert nothing.transforms.shape == (0, 3, 4) and SCENE.transforms is None
    assert nothing.points(nothing.first([[0, 0, 0]], [0, 0, 1])).shape == (1, 3)


def test_methods_of_instances_are_theirs():
    fast = trisect.Scene(*lumps(), method="fast")
    assert trisect.Scene.instances(fast, [np.eye(4)]).method == "fast"
    mixed = trisect.Scene.instances([fast, SCENE], [np.eye(4)] * 2)
    assert mixed.method == "mixed"
    with pytest.raises(ValueError, match="exact"):
        mixed.contains([0, 0, 0])
