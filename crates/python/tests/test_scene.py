"""What a scene answers, to arrays of every layout, and what it refuses."""

import copy
import multiprocessing
import os
import pickle
import signal
import threading
import time

import numpy as np
import pytest

import meshes
import trisect
from exact import Truth

PRECISIONS = {"f32": np.float32, "f64": np.float64}


@pytest.fixture(params=PRECISIONS)
def precision(request):
    return request.param


@pytest.fixture
def dtype(precision):
    return PRECISIONS[precision]


@pytest.fixture
def sphere(dtype):
    vertices, faces = meshes.sphere(4)
    return vertices.astype(dtype), faces


@pytest.fixture
def scene(sphere):
    return trisect.Scene(*sphere)


@pytest.fixture
def rays(dtype):
    return tuple(array.astype(dtype) for array in meshes.random_rays(20_000))


def same(one, other):
    """Equal bit for bit."""
    return all(np.asarray(a).tobytes() == np.asarray(b).tobytes() for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize("mesh, rays", [
    (meshes.grid(16), meshes.rays_through_lattice(16, 2)),
    (meshes.grid(8, lambda x, y: np.sin(9 * x) * y), meshes.random_rays(300)),
    (meshes.sphere(3), meshes.random_rays(300, radius=1e4)),
    (meshes.sphere(3), (np.zeros((258, 3)), meshes.sphere(3)[0])),
    (meshes.box(), meshes.random_rays(300)),
    (meshes.layers(250), (np.array([[0.5, 0.25, 9.0], [0.5, 0.5, 9.0]]), np.array([[0.0, 0.0, -1.0]] * 2))),
])
def test_answers_are_those_of_rational_arithmetic(mesh, rays, dtype):
    vertices, faces = mesh[0].astype(dtype), mesh[1]
    origins, directions = (array.astype(dtype) for array in rays)
    scene, truth = trisect.Scene(vertices, faces), Truth(vertices, faces)
    first = scene.first(origins, directions)
    every = scene.all(origins, directions)
    counts, anything = scene.count(origins, directions), scene.any(origins, directions)
    for ray, (origin, direction) in enumerate(zip(origins, directions)):
        hits = truth.all(origin, direction)
        found = slice(every.offsets[ray], every.offsets[ray + 1])
        assert every.triangle[found].tolist() == [face for _, face, _ in hits]
        truly = np.array([float(t) for t, _, _ in hits])
        assert np.allclose(every.t[found], truly, rtol=np.finfo(dtype).eps, atol=0)
        assert (counts[ray], anything[ray]) == (len(hits), bool(hits))
        expected = hits[0][1] if hits else -1
        assert first.triangle[ray] == expected
    assert every.ray.tolist() == np.repeat(np.arange(len(origins)), counts).tolist()


def test_containment_is_that_of_rational_arithmetic(dtype):
    vertices, faces = meshes.sphere(2)
    vertices = vertices.astype(dtype)
    line = np.linspace(-1, 1, 9)
    lattice = np.stack(np.meshgrid(line, line, line), -1).reshape(-1, 3)
    points = np.concatenate([lattice, vertices, 0.5 * vertices]).astype(dtype)
    scene, truth = trisect.Scene(vertices, faces), Truth(vertices, faces)
    places = scene.places(points)
    assert places.tolist() == [truth.place(point) for point in points]
    assert {-1, 0, 1} == set(places.tolist())
    assert (scene.contains(points) == (places == 1)).all()
    assert (scene.contains(points, surface=True) == (places >= 0)).all()


def test_layouts_answer_alike(scene, rays):
    origins, directions = rays
    expected = scene.first(origins, directions)
    together = np.concatenate(rays, axis=1)
    turned = np.asfortranarray(origins), np.asfortranarray(directions)
    spaced = np.zeros((3 * len(origins), 4), origins.dtype)
    spaced[::3, :3] = origins
    unaligned = np.zeros(len(origins), [("skip", "u1"), ("o", origins.dtype, 3)])
    unaligned["o"] = origins
    for others in [
        (together[:, :3], together[:, 3:]),
        turned,
        (spaced[::3, :3], directions),
        (unaligned["o"], directions),
        (origins.astype(origins.dtype.newbyteorder()), directions),
    ]:
        assert same(scene.first(*others), expected)
    backwards = scene.first(origins[::-1], directions[::-1])
    assert same([array[::-1] for array in backwards], expected)


def test_shapes_are_kept_and_broadcast(scene, rays):
    origins, directions = (array[:60].reshape(3, 4, 5, 3) for array in rays)
    hits = scene.first(origins, directions)
    assert hits.t.shape == (3, 4, 5) and hits.t.dtype == scene.dtype
    assert same([hits.t.ravel()], [scene.first(rays[0][:60], rays[1][:60]).t])
    one = scene.first([0, 0, 3], [0, 0, -1])
    assert one.triangle.shape == () and float(one.t) == 2.0
    many = scene.first([0, 0, 3], directions)
    assert many.t.shape == (3, 4, 5)
    assert scene.any([0, 0, 3], [0, 0, -1], tmax=[1, 2, 3]).tolist() == [False, True, True]
    assert scene.count(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0,)
    assert scene.all(np.zeros((0, 3)), np.zeros((0, 3))).offsets.tolist() == [0]


def test_intervals_and_culling(scene):
    ray = [0.1, 0.2, 3.0], [0.0, 0.0, -1.0]
    near, far = scene.all(*ray).t
    assert scene.first(*ray, tmin=near + 0.1).t == far
    assert not scene.any(*ray, tmax=near - 0.1)
    assert scene.first(*ray, cull="front").t == far
    assert scene.first(*ray, cull="back").t == near
    assert scene.count(*ray, tmin=[0, near + 0.1], tmax=9).tolist() == [2, 1]


def test_results_go_into_out(scene, rays):
    expected = scene.first(*rays)
    out = trisect.Hits(*(np.empty_like(array) for array in expected))
    hits = scene.first(*rays, out=out)
    assert all(a is b for a, b in zip(hits, out)) and same(hits, expected)
    places = np.empty(len(rays[0]), bool)
    assert scene.any(*rays, out=places) is places
    for wrong in (np.empty(3, bool), np.empty(len(rays[0]), int), np.empty(2 * len(rays[0]), bool)[::2]):
        with pytest.raises(ValueError, match="out must be bool of shape"):
            scene.any(*rays, out=wrong)


def test_numbers_of_threads_answer_alike(scene, rays):
    queries = [
        lambda threads: scene.first(*rays, threads=threads),
        lambda threads: [scene.any(*rays, threads=threads)],
        lambda threads: scene.all(*rays, threads=threads),
        lambda threads: [scene.count(*rays, threads=threads)],
        lambda threads: [scene.places(rays[0] / 3, threads=threads)],
    ]
    for query in queries:
        assert same(query(1), query(4))
    singly = [scene.first(origin, direction).triangle for origin, direction in zip(*rays)]
    assert singly == scene.first(*rays).triangle.tolist()


@pytest.mark.parametrize("method", ["fast", "watertight"])
def test_methods_agree_on_random_rays(sphere, rays, scene, method):
    other = trisect.Scene(*sphere, method=method)
    assert (other.first(*rays).triangle == scene.first(*rays).triangle).mean() > 0.999
    assert other.method == method
    with pytest.raises(ValueError, match="exact"):
        other.contains([0, 0, 0])


def test_filtered_sees_what_the_mask_lets_it(sphere, rays, scene):
    vertices, faces = sphere
    random = np.random.default_rng(1)
    mask = random.random(len(faces)) < 0.5
    seen, apart = scene.filtered(mask), trisect.Scene(vertices, faces[mask])
    kept = np.flatnonzero(mask)
    hits, others = seen.first(*rays), apart.first(*rays)
    assert (hits.triangle == np.where(others.triangle < 0, -1, kept[others.triangle])).all()
    assert same([hits.t, seen.any(*rays), seen.count(*rays)], [others.t, apart.any(*rays), apart.count(*rays)])
    assert (seen.all(*rays).triangle == kept[apart.all(*rays).triangle]).all()
    assert not seen.filtered(~mask).any(*rays).any()
    assert "seen" in repr(seen)
    with pytest.raises(ValueError, match="no inside"):
        seen.contains([0, 0, 0])
    with pytest.raises(ValueError, match="mask must be bool of shape"):
        scene.filtered(mask[1:])


def test_update_moves_the_scene_and_no_copy(sphere, rays):
    vertices, faces = sphere
    moved = vertices * vertices.dtype.type(1.25)
    for moving in (True, False):
        scene = trisect.Scene(vertices, faces, moving=moving)
        before, expected = scene.first(*rays), trisect.Scene(moved, faces).first(*rays)
        copied, deep = copy.copy(scene), copy.deepcopy(scene)
        scene.update(moved)
        assert same(scene.first(*rays), expected) and same([scene.vertices], [moved])
        assert same(copied.first(*rays), before) and same(deep.first(*rays), before)
        scene.update(vertices)
        assert same(scene.first(*rays), before)
    with pytest.raises(ValueError, match=r"must have shape \(1026, 3\), as before, not \(1025, 3\)"):
        scene.update(vertices[1:])
    broken = vertices.copy()
    broken[7] = np.nan
    with pytest.raises(ValueError, match="vertex 7"):
        scene.update(broken)
    assert same(scene.first(*rays), before)


def test_update_gives_an_area_to_what_had_none(dtype):
    flat = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 0]], dtype)
    scene = trisect.Scene(flat, [[0, 1, 2]])
    assert not scene.any([0.5, 0.25, 1], [0, 0, -1])
    scene.update(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0]], dtype))
    assert scene.any([0.5, 0.25, 1], [0, 0, -1])


def test_pickles_answer_alike(sphere, rays):
    scene = trisect.Scene(*sphere, moving=True, threads=2)
    scene.update(sphere[0] * sphere[0].dtype.type(0.75))
    mask = np.arange(len(scene)) % 3 > 0
    for original in (scene, scene.filtered(mask)):
        other = pickle.loads(pickle.dumps(original))
        assert same(other.first(*rays), original.first(*rays))
        assert same(other.all(*rays), original.all(*rays))
        assert repr(other) == repr(original)


def trace_in_child(scene, rays, answers):
    answers.put(scene.first(*rays).triangle)


@pytest.mark.parametrize("start", multiprocessing.get_all_start_methods())
def test_processes_answer_alike(start, scene, rays):
    context = multiprocessing.get_context(start)
    expected = scene.first(*rays).triangle  # The threads of this process run by now.
    answers = context.Queue()
    child = context.Process(target=trace_in_child, args=(scene, rays, answers))
    child.start()
    assert same([answers.get(timeout=60)], [expected])
    child.join(60)
    assert child.exitcode == 0



@pytest.mark.parametrize("query", ["first", "any", "all", "count", "places"])
def test_interrupts_are_heard(query, dtype):
    vertices, faces = meshes.layers(400, 1 / 512)
    scene = trisect.Scene(vertices.astype(dtype), faces)

    # Where these tests run in the background it may be ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)

    def interrupt():
        time.sleep(0.2)
        os.kill(os.getpid(), signal.SIGINT)

    # Each takes minutes where nobody listens: through all layers, from within them.
    origins = np.broadcast_to(np.array([0.5, 0.5, 2], dtype), (30_000_000, 3))
    down = np.array([0, 0, -1], dtype)
    calls = {
        "first": lambda: scene.filtered(np.arange(len(scene)) < 2).first(origins, down),
        "any": lambda: scene.filtered(np.arange(len(scene)) < 2).any(origins, down),
        "all": lambda: scene.all(origins, down),
        "count": lambda: scene.count(origins, down),
        "places": lambda: scene.places(np.broadcast_to(np.array([0.5, 0.5, -1], dtype), (30_000_000, 3))),
    }
    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        calls[query]()
    thread.join()
    assert scene.any([0.5, 0.5, 2], down)


def test_progress_is_told_and_may_raise(scene, rays):
    told = []
    origins, directions = (np.tile(array, (4, 1)) for array in rays)
    scene.all(origins, directions, progress=lambda done, total: told.append((done, total)))
    assert told[-1] == (80_000, 80_000)
    assert [done for done, _ in told] == sorted(done for done, _ in told)

    def stop(done, total):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        scene.first(origins, directions, progress=stop)


def test_other_threads_run_meanwhile(scene, rays):
    results = [None] * 4

    def ask(at):
        results[at] = scene.first(*rays, threads=1 + at % 2)

    threads = [threading.Thread(target=ask, args=(at,)) for at in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(same(result, results[0]) for result in results)


QUAD = np.zeros((4, 3), np.float32)


@pytest.mark.parametrize("make, message", [
    (lambda: trisect.Scene(QUAD[:, :2], [[0, 1, 2]]), r"vertices must have shape \(n, 3\), not \(4, 2\)"),
    (lambda: trisect.Scene(QUAD, [0, 1, 2]), r"faces must have shape \(n, 3\), not \(3,\)"),
    (lambda: trisect.Scene(QUAD, [[0, 1, 2.0]]), "faces must be integers, not float64"),
    (lambda: trisect.Scene(QUAD, [[0, 1, 2], [0, 1, 4]]), "face 1 names vertex 4, but there are 4"),
    (lambda: trisect.Scene(QUAD, [[0, 1, -2]]), "face 0 names vertex -2"),
    (lambda: trisect.Scene(QUAD * np.float32("nan"), [[0, 1, 2]]), "vertex 0, a corner of face 0, is not finite"),
    (lambda: trisect.Scene(QUAD, [[0, 1, 2]], precision="f16"), "precision must be"),
    (lambda: trisect.Scene(QUAD, [[0, 1, 2]], method="quick"), "method must be"),
    (lambda: trisect.Scene(QUAD, [[0, 1, 2]], threads=0), "threads must be at least 1, not 0"),
    (lambda: SCENE.first([[0, 0]], [[0, 0, 1]]), r"origins must have shape \(..., 3\), not \(1, 2\)"),
    (lambda: SCENE.first([[0, 0, 1], [0]], [[0, 0, 1]]), "origins must be an array"),
    (lambda: SCENE.first(np.zeros((4, 3)), np.zeros((5, 3))), r"do not go together: \(4, 3\), \(5, 3\)"),
    (lambda: SCENE.first([0, 0, 0], [0, 0, 1], cull="left"), 'cull must be "none", "back" or "front"'),
    (lambda: SCENE.all([0, 0, 0], [0, 0, 1], crossings="odd"), 'crossings must be "every" or "owned"'),
    (lambda: SCENE.contains(0.0), r"points must have shape \(..., 3\), not \(\)"),
    (lambda: SCENE.first([0, 0, 0], [0, 0, 1], threads=-1), "threads must be at least 1"),
])
def test_what_is_amiss_is_said(make, message):
    with pytest.raises(ValueError, match=message):
        make()


SCENE = trisect.Scene(QUAD, [[0, 1, 2]])


def test_empty_scenes_and_odd_rays(scene, dtype):
    empty = trisect.Scene(np.zeros((0, 3), dtype), np.zeros((0, 3), int))
    assert len(empty) == 0 and not empty.any([0, 0, 0], [0, 0, 1]) and not empty.contains([0, 0, 0])
    odd = np.array([[np.nan, 0, 0], [np.inf, 0, 0], [0, 0, 0]], dtype)
    assert scene.first(odd, [[1, 0, 0], [1, 0, 0], [0, 0, 0]]).triangle.tolist() == [-1, -1, -1]


def test_points_lie_on_their_triangles(scene, rays):
    hits = scene.first(*rays)
    points, hit = scene.points(hits), hits.triangle >= 0
    along = rays[0] + hits.t[:, None] * rays[1]
    assert np.allclose(points[hit], along[hit], atol=1e-5) and np.isnan(points[~hit]).all()
    assert scene.points(scene.all(*rays)).shape == (len(scene.all(*rays).t), 3)


def test_facts(scene):
    assert len(scene) == 2048 and scene.precision == {4: "f32", 8: "f64"}[scene.dtype.itemsize]
    assert scene.statistics["bytes"] > 0 and scene.statistics["references"] >= 2048
    assert scene.vertices.shape == (1026, 3) and scene.faces.shape == (2048, 3)
