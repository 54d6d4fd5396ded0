"""trisect against trimesh with embreex, open3d, libigl, fcpw and vtk: wrong answers, and speed.

    python compare.py [--output FILE.json] [--quick]

Wrong answers are against rational arithmetic on the arrays as they are given, each library asked by its documented
interface; who computes in float32 gets them rounded, as it would. A triangle is right if it contains the point that is
truly hit first, so that any may be named where several meet. Speeds are medians of interleaved rounds, in millions of
rays or points per second, in a process that may run on one processor, and on two. Those that are not installed are left out.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import time
from fractions import Fraction
from importlib import metadata
from pathlib import Path

import numpy as np

import trisect

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "tests"))
import meshes
from exact import Truth, meets

BUNNY = HERE / "../../data/meshes/bunny.ply"


class Trisect:
    def __init__(self, vertices, faces, precision="auto", method="exact"):
        self.scene = trisect.Scene(vertices, faces, precision=precision, method=method)

    def first(self, origins, directions):
        return self.scene.first(origins, directions).triangle

    def any(self, origins, directions):
        return self.scene.any(origins, directions)

    def count(self, origins, directions):
        return np.diff(self.all(origins, directions).offsets)

    def all(self, origins, directions):
        return self.scene.all(origins, directions)

    def contains(self, points):
        return self.scene.contains(points)


class Fast(Trisect):
    """Möller and Trumbore's test, in float32, which decides nothing exactly."""

    contains = None

    def __init__(self, vertices, faces):
        super().__init__(vertices, faces, "f32", "fast")


class Embreex:
    """embreex alone: first hits."""

    def __init__(self, vertices, faces):
        from embreex import rtcore_scene
        from embreex.mesh_construction import TriangleMesh

        self.scene = rtcore_scene.EmbreeScene()
        TriangleMesh(scene=self.scene, vertices=vertices.astype(np.float32), indices=faces.astype(np.int32))

    def _run(self, origins, directions, **how):
        return self.scene.run(origins.astype(np.float32), directions.astype(np.float32), **how)

    def first(self, origins, directions):
        return self._run(origins, directions)

    def any(self, origins, directions):
        return self._run(origins, directions, query="OCCLUDED") != -1


class Trimesh:
    def __init__(self, vertices, faces):
        import trimesh

        self.mesh = trimesh.Trimesh(vertices, faces, process=False)
        assert "embree" in type(self.mesh.ray).__module__

    def first(self, origins, directions):
        return self.mesh.ray.intersects_first(origins, directions)

    def any(self, origins, directions):
        return self.mesh.ray.intersects_any(origins, directions)

    def all(self, origins, directions):
        return self.mesh.ray.intersects_id(origins, directions)

    def count(self, origins, directions):
        return np.bincount(self.all(origins, directions)[1], minlength=len(origins))

    def contains(self, points):
        return self.mesh.contains(points)


class Open3d:
    def __init__(self, vertices, faces):
        import open3d

        self.tensor = open3d.core.Tensor
        self.scene = open3d.t.geometry.RaycastingScene()
        self.scene.add_triangles(self.tensor(vertices.astype(np.float32)), self.tensor(faces.astype(np.uint32)))

    def _rays(self, origins, directions):
        return self.tensor(np.concatenate([origins, directions], axis=1).astype(np.float32))

    def first(self, origins, directions):
        return self.scene.cast_rays(self._rays(origins, directions))["primitive_ids"].numpy().astype(np.int32)

    def any(self, origins, directions):
        return self.scene.test_occlusions(self._rays(origins, directions)).numpy()

    def all(self, origins, directions):
        return self.scene.list_intersections(self._rays(origins, directions))

    def count(self, origins, directions):
        return self.scene.count_intersections(self._rays(origins, directions)).numpy()

    def contains(self, points):
        return self.scene.compute_occupancy(self.tensor(points.astype(np.float32))).numpy() > 0.5


class Igl:
    def __init__(self, vertices, faces):
        import igl

        self.igl, self.tree = igl, igl.AABB()
        self.mesh = np.asfortranarray(vertices, np.float64), np.asfortranarray(faces, np.int64)
        self.tree.init(*self.mesh)

    def first(self, origins, directions):
        return self.tree.intersect_ray_first(*self.mesh, *map(np.asfortranarray, (origins, directions)))[0]

    def all(self, origins, directions):
        return self.tree.intersect_ray(*self.mesh, *map(np.asfortranarray, (origins, directions)))

    def count(self, origins, directions):
        return np.array([len(hits) for hits in self.all(origins, directions)])

    def contains(self, points):
        return self.igl.fast_winding_number(*self.mesh, np.asfortranarray(points)) > 0.5


class Fcpw:
    def __init__(self, vertices, faces):
        import fcpw

        self.fcpw, self.scene = fcpw, fcpw.scene_3D()
        self.scene.set_object_count(1)
        self.scene.set_object_vertices(np.ascontiguousarray(vertices, np.float32), 0)
        self.scene.set_object_triangles(np.ascontiguousarray(faces, np.int32), 0)
        # By the surface area heuristic, for SIMD.
        self.scene.build(fcpw.aggregate_type.bvh_surface_area, True, False, False)

    def _hits(self, origins, directions, is_occlusion):
        origins, directions = np.float32(origins), np.float32(directions)
        # Directions are of unit length.
        directions = directions / np.linalg.norm(directions, axis=1, keepdims=True)
        ends, found = np.full(len(origins), np.inf, np.float32), self.fcpw.interaction_3D_list()
        self.scene.intersect(origins, directions, ends, found, is_occlusion)
        return found

    def first(self, origins, directions):
        # That of no hit is −1, as an unsigned number where it is one.
        found = self._hits(origins, directions, False)
        return np.fromiter((hit.primitive_index for hit in found), np.int64, len(found)).astype(np.int32)

    def contains(self, points):
        inside = self.fcpw.uint32_list()
        self.scene.contains(np.float32(points), inside)
        return np.array(inside, bool)


class Vtk:
    """One ray at a time, as lines of some length."""

    is_slow = True

    def __init__(self, vertices, faces):
        import vtk
        from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

        points, cells, self.mesh = vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkPolyData()
        points.SetData(numpy_to_vtk(np.ascontiguousarray(vertices, np.float64), deep=True))
        cells.SetData(3, numpy_to_vtkIdTypeArray(np.ascontiguousarray(faces, np.int64).ravel(), deep=True))
        self.mesh.SetPoints(points)
        self.mesh.SetPolys(cells)
        self.vtk, self.tree = vtk, vtk.vtkStaticCellLocator()
        self.tree.SetDataSet(self.mesh)
        self.tree.BuildLocator()
        self.low, self.high = vertices.min(axis=0), vertices.max(axis=0)

    def first(self, origins, directions):
        t, where, weights = self.vtk.reference(0.0), [0.0] * 3, [0.0] * 3
        part, cell = self.vtk.reference(0), self.vtk.reference(0)
        # Each line ends beyond the mesh.
        farthest = np.maximum(np.abs(self.low - origins), np.abs(self.high - origins)).sum(axis=1)
        ends = origins + directions * (farthest / np.abs(directions).max(axis=1))[:, None]
        found = np.full(len(origins), -1, np.int32)
        for ray, (start, end) in enumerate(zip(origins.tolist(), ends.tolist())):
            if self.tree.IntersectWithLine(start, end, 0.0, t, where, weights, part, cell):
                found[ray] = cell.get()
        return found

    def contains(self, points):
        from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

        asked, of = self.vtk.vtkPolyData(), self.vtk.vtkPoints()
        of.SetData(numpy_to_vtk(np.ascontiguousarray(points, np.float64), deep=True))
        asked.SetPoints(of)
        select = self.vtk.vtkSelectEnclosedPoints()
        select.SetInputData(asked)
        select.SetSurfaceData(self.mesh)
        select.SetTolerance(0.0)
        select.Update()
        return vtk_to_numpy(select.GetOutput().GetPointData().GetArray("SelectedPoints")) > 0


def library(name):
    libraries = {
        "trisect": Trisect,
        "trisect f32": lambda vertices, faces: Trisect(vertices, faces, "f32"),
        "trisect f32 fast": Fast,
        "embreex": Embreex,
        "trimesh + embreex": Trimesh,
        "open3d": Open3d,
        "libigl": Igl,
        "fcpw": Fcpw,
        "vtk": Vtk,
    }
    return libraries[name]


LIBRARIES = ["trisect", "trisect f32", "trisect f32 fast", "embreex", "trimesh + embreex", "open3d", "libigl"]
LIBRARIES += ["fcpw", "vtk"]


def can(peer, query):
    return getattr(peer, query, None) is not None


def installed():
    """The libraries that are there."""
    there = []
    for name in LIBRARIES:
        try:
            library(name)(*meshes.box())
        except ImportError as error:
            print(f"left out: {name} ({error})", file=sys.stderr)
        else:
            there.append(name)
    return there


def single(array):
    """The nearest of float32, so that nobody has to round it."""
    return np.asarray(array, np.float32).astype(np.float64)


def within_faces():
    """Rays that run within the planes of a box's faces, along its axes and aslant, towards it and past it."""
    for axis in range(3):
        for side in (0.0, 1.0):
            for angle in np.arange(0.0, 8.0):
                ahead = np.rint(2 * np.array([np.cos(angle * np.pi / 4), np.sin(angle * np.pi / 4)]))
                for place in (0.25, 0.5, 0.75):
                    origin, direction = np.full(3, side), np.zeros(3)
                    flat = [other for other in range(3) if other != axis]
                    origin[flat], direction[flat] = place - ahead, ahead
                    yield origin, direction


def cases():
    """Name, mesh, rays: what rounding decides, and what far coordinates lose. All but terrain and what is far away is
    given in numbers of float32."""
    down, random = np.array([0.0, 0.0, -1.0]), np.random.default_rng(1)
    falling = lambda origins: (origins, np.broadcast_to(down, origins.shape).copy())
    yield "grid, through vertices and edges", meshes.grid(16), meshes.rays_through_lattice(16, 2)
    vertices, faces = meshes.sphere(3)
    round_, edges = (single(vertices), faces), np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2))
    aims = np.concatenate([round_[0], round_[0][np.unique(edges, axis=0)].sum(axis=1)])
    yield "sphere from within, at vertices and edges", round_, (np.zeros_like(aims), single(aims))
    hills = meshes.grid(40, lambda x, y: 0.1 * np.sin(9 * x) * np.cos(7 * y))
    terrain = hills[0] * 40 + [443_211.3, 5_411_873.7, 312.9], hills[1]
    corners = terrain[0][hills[1][random.integers(len(hills[1]), size=600)]]
    weights = random.dirichlet([1, 1, 1], 600)
    yield "terrain in UTM coordinates", terrain, falling((corners * weights[..., None]).sum(axis=1) + [0, 0, 80])
    plate = meshes.box((0, 0, 0), (1e-3, 1e-3, 1e-6))
    above = np.column_stack([random.uniform(1e-5, 9.9e-4, (200, 2)), np.full(200, 2e-6)])
    yield "plate of 1 mm, wall of 1 µm", (single(plate[0]), plate[1]), falling(single(above))
    part = meshes.sphere(2, 1e-6)
    yield "part of 1 µm", (single(part[0]), part[1]), tuple(single(1e-6 * array) for array in meshes.random_rays(200, 2))
    yield "rays within faces of a box", meshes.box(), tuple(map(np.array, zip(*within_faces())))
    origins, directions = meshes.random_rays(100, 3)
    far = np.tile(origins, (3, 1)) / 3 * np.repeat([1e4, 1e5, 1e6], 100)[:, None]
    yield "from 1e4 to 1e6 away", (vertices, faces), (far, np.tile(origins + directions, (3, 1)) - far)
    angles = np.linspace(0, 2 * np.pi, 1 << 11, endpoint=False)
    rim = np.stack([np.cos(angles), np.sin(angles), np.sin(3 * angles) * 0.1], axis=1)
    corner = np.arange(len(rim))
    fan = np.stack([np.full(len(rim), len(rim)), corner, np.roll(corner, -1)], axis=1)
    near = np.column_stack([random.normal(size=(400, 2)) * 1e-6, np.full(400, 1.0)])
    yield "slivers about a point", (single(np.concatenate([rim, np.zeros((1, 3))])), fan), falling(single(near))


def depths():
    """Name, mesh, rays of which all hits are counted, through the interior of faces."""
    random = np.random.default_rng(2)
    place = random.uniform(0.05, 0.95, (50, 2))
    place[:, 1] *= place[:, 0] * 0.9
    for name, count, distance in (("250 layers", 250, 0.01), ("40 coincident faces", 40, 0.0)):
        origins, (vertices, faces) = np.column_stack([place, np.full(50, 9.0)]), meshes.layers(count, distance)
        yield name, (single(vertices), faces), (single(origins), np.broadcast_to([0.0, 0.0, -1.0], (50, 3)).copy())


def solids():
    """Name, mesh, points of a lattice that shares planes with vertices, none of them on the surface."""
    line = np.linspace(-1, 1, 17)
    lattice = np.stack(np.meshgrid(line, line, line), -1).reshape(-1, 3)
    vertices, faces = meshes.sphere(3)
    yield "points in a sphere", (single(vertices), faces), lattice[::5]
    yield "points in a box", meshes.box((-0.875, -0.875, -0.875), (0.875, 0.875, 0.875)), lattice[::5]


def wrongs(names, quick):
    """For each case how many answers there are, and how many of each library are wrong."""
    for name, mesh, (origins, directions) in cases():
        if quick:
            origins, directions = origins[::5], directions[::5]
        truth = Truth(*mesh)
        true = [truth.all(*ray) for ray in zip(origins, directions)]
        row = {"case": name, "answers": len(origins)}
        for each in names:
            found = library(each)(*mesh).first(origins, directions)
            amiss = [which(truth, *ray) for ray in zip(origins, directions, true, found)]
            row[each] = {kind: amiss.count(kind) for kind in ("missed", "false", "wrong triangle")}
        yield row
    for name, mesh, rays in depths():
        truth = Truth(*mesh)
        true = np.array([len(truth.all(*ray)) for ray in zip(*rays)])
        row = {"case": name, "answers": len(true)}
        for each in names:
            peer = library(each)(*mesh)
            row[each] = {"wrong": int((peer.count(*rays) != true).sum())} if can(peer, "count") else None
        yield row
    for name, mesh, points in solids():
        truth = Truth(*mesh)
        true = np.array([truth.place(point) for point in points])
        points, true = points[true != 0], true[true != 0] > 0
        row = {"case": name, "answers": len(true)}
        for each in names:
            peer = library(each)(*mesh)
            row[each] = {"wrong": int((peer.contains(points) != true).sum())} if can(peer, "contains") else None
        yield row


def which(truth, origin, direction, true, found):
    """What is amiss with a first hit, if anything."""
    if not true or found < 0:
        return None if not true and found < 0 else "missed" if true else "false"
    t = true[0][0]
    if any(face == found and other == t for other, face, _ in true):
        return None
    # One whose plane the ray runs within is right too, if it contains the point.
    point = [Fraction(float(o)) + t * Fraction(float(d)) for o, d in zip(origin, direction)]
    a, b, c = ([Fraction(float(x)) for x in corner] for corner in truth.corners[found])
    normal = [int(x) for x in np.eye(3, dtype=int)[np.argmax(np.abs(np.cross(*np.diff(truth.corners[found], axis=0))))]]
    met = meets((a, b, c), point, [Fraction(x) for x in normal])
    return None if met is not None and met[0] == 0 else "wrong triangle"


def bunny():
    import trimesh

    mesh = trimesh.load(BUNNY, process=False)
    return np.array(mesh.vertices), np.array(mesh.faces, np.int64)


def speeds(names, rounds, size):
    """The median speed of each library at each query on the bunny, in a process as it is bound to processors."""
    vertices, faces = bunny()
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle, reach = (low + high) / 2, np.linalg.norm(high - low)
    x, y = (side.ravel() for side in np.meshgrid(np.linspace(-0.5, 0.5, size), np.linspace(-0.5, 0.5, size)))
    camera = np.broadcast_to(middle + [0, 0, reach], (size * size, 3)).copy()
    coherent = camera, np.stack([x, y, -np.ones_like(x)], axis=1)
    random = np.random.default_rng(3)
    ends = random.uniform(low, high, (2, size * size, 3))
    incoherent = ends[0], ends[1] - ends[0]
    points = random.uniform(low, high, (size * size // 4, 3))
    # Each in its own precision: a conversion is nobody's speed.
    single = [tuple(array.astype(np.float32) for array in rays) for rays in (coherent, incoherent)]
    queries = {
        "first, coherent": ("first", 0), "first, incoherent": ("first", 1), "any, incoherent": ("any", 1),
        "all, incoherent": ("all", 1), "contains": ("contains", None),
    }
    peers = {name: library(name)(vertices, faces) for name in names}
    taken = {}
    for _ in range(rounds):
        for query, (method, rays) in queries.items():
            for name, peer in peers.items():
                if not can(peer, method):
                    continue
                in_f64 = name in ("trisect", "libigl", "trimesh + embreex", "vtk")
                given = (points,) if rays is None else (coherent, incoherent)[rays] if in_f64 else single[rays]
                # Of a loop in Python a part is enough.
                given = tuple(array[::50] for array in given) if hasattr(peer, "is_slow") else given
                start = time.perf_counter()
                getattr(peer, method)(*given)
                rate = len(given[0]) / (time.perf_counter() - start) / 1e6
                taken.setdefault(query, {}).setdefault(name, []).append(rate)
    return {query: {name: float(np.median(rates)) for name, rates in of.items()} for query, of in taken.items()}


def table(rows, names, cell):
    widths = [max(len(name), 9) for name in names]
    first = max(len(row[0]) for row in rows)
    print(" " * first, *(name.rjust(width) for name, width in zip(names, widths)), sep="  ")
    for title, of in rows:
        print(title.ljust(first), *(cell(of.get(name)).rjust(width) for name, width in zip(names, widths)), sep="  ")
    print()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, help="write what is printed as JSON too")
    parser.add_argument("--quick", action="store_true", help="a fifth of the rays, and fewer rounds")
    parser.add_argument("--rounds", type=int, default=9, help="interleaved rounds of the race")
    parser.add_argument("--speeds", type=int, metavar="THREADS", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    processors = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []
    if asked.speeds:
        # Before any library counts them.
        os.sched_setaffinity(0, processors[: asked.speeds])
    names = installed()
    rounds, size = (3, 200) if asked.quick else (asked.rounds, 500)
    if asked.speeds:
        print(json.dumps(speeds(names, rounds, size)))
        return
    record = {
        "machine": platform.machine(),
        "python": platform.python_version(),
        "versions": {
            name: metadata.version(name)
            for name in ("trisect", "numpy", "trimesh", "embreex", "open3d", "libigl", "fcpw", "vtk")
            if any(dist.name == name for dist in metadata.distributions(name=name))
        },
    }
    print(" ".join(f"{name} {version}" for name, version in record["versions"].items()), "\n")
    print("Wrong answers: missed + false + wrong triangle; of all hits and of points, how many are wrong")
    record["wrong"] = list(wrongs(names, asked.quick))
    total = lambda cell: "–" if cell is None else "+".join(map(str, cell.values())) if sum(cell.values()) else "0"
    table([(f"{row['case']} ({row['answers']})", row) for row in record["wrong"]], names, total)
    record["speed"] = {}
    for threads in (1, 2):
        if len(processors) < threads:
            print(f"left out: speed on {threads} threads, as there are {len(processors)} processors", file=sys.stderr)
            continue
        command = [sys.executable, __file__, "--speeds", str(threads), "--rounds", str(rounds)]
        command += ["--quick"] if asked.quick else []
        output = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
        record["speed"][threads] = json.loads(output)
        print(f"Million rays or points per second, bunny, threads: {threads}")
        table(list(record["speed"][threads].items()), names, lambda x: "–" if x is None else f"{x:.3g}")
    if asked.output:
        asked.output.write_text(json.dumps(record, indent=1) + "\n")


if __name__ == "__main__":
    main()
