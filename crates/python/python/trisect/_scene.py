"""Scenes: what is asked of them, in arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _trisect
from ._arrays import (
    DTYPES, aligned, dtype_of, faces_of, joined, located, matrices, place, rows, starts, threads_of, triples,
)

Progress = Callable[[int, int], object]
Cull = Literal["none", "back", "front"]
Crossings = Literal["every", "owned"]


class Hits(NamedTuple):
    """The first hit of each ray; every array has the shape of the rays."""

    #: int32: the index of the face, −1 where nothing is hit.
    triangle: npt.NDArray[np.int32]
    #: The scene's dtype: how far along the ray, in lengths of its direction; infinity where nothing is hit.
    t: npt.NDArray[Any]
    #: The scene's dtype: the weight of the face's second corner, 0 where nothing is hit.
    u: npt.NDArray[Any]
    #: The same of its third corner. That of its first is 1 − u − v.
    v: npt.NDArray[Any]


class AllHits(NamedTuple):
    """All hits of n rays: those of ray i are `offsets[i]` to `offsets[i + 1]` of the other arrays, in order of `t`."""

    #: int64, (n + 1,): where the hits of each ray begin.
    offsets: npt.NDArray[np.int64]
    #: int32, (hits,): the index of the face.
    triangle: npt.NDArray[np.int32]
    #: The scene's dtype, (hits,): how far along the ray, in lengths of its direction.
    t: npt.NDArray[Any]
    #: The scene's dtype, (hits,): the weight of the face's second corner.
    u: npt.NDArray[Any]
    #: The same of its third corner.
    v: npt.NDArray[Any]

    @property
    def ray(self) -> npt.NDArray[np.int64]:
        """int64, (hits,): the index of each hit's ray."""
        return np.repeat(np.arange(len(self.offsets) - 1), np.diff(self.offsets))


class Located(NamedTuple):
    """Where hits are in a scene of instances; both arrays have the shape of the hits."""

    #: int32: the index of the instance, −1 where nothing is hit.
    instance: npt.NDArray[np.int32]
    #: int32: the triangle of the scene that is placed there, −1 where nothing is hit.
    triangle: npt.NDArray[np.int32]


class Scene:
    """A mesh that rays are asked of, from any number of threads.

    Parameters
    ----------
    vertices : (n, 3) floats
        Any layout. Those that no face names may be anything.
    faces : (m, 3) integers
        The vertices of each triangle, numbered from 0; fewer than 2²⁷.
    precision : "auto", "f32" or "f64"
        What the scene computes in. "auto" is the precision of `vertices`: they are never rounded, unless "f32" says
        so. Rays and points are converted to it. float32 and float16 are kept in "f32", all else in "f64".
    method : "exact", "fast" or "watertight"
        "exact": every decision, and which of two hits comes first, is that of exact arithmetic on the arrays as they
        are given; `t`, `u`, `v` are rounded once. "watertight": no ray passes between two triangles through their
        common edge. "fast": nothing is promised at edges.
    moving : bool
        Whether `update` will follow: the tree then stays as good as it can.
    threads : int, optional
        Of the build and of queries that say nothing else; all processors where there is no number.

    Raises
    ------
    ValueError
        For arrays of other shapes, a face that names a vertex which is not there or not finite, a precision or method
        that there is not.

    Notes
    -----
    Queries take origins of shape (..., 3) and directions of shape (..., 3), which are broadcast against each other;
    results have the shape that is left. Directions need no unit length. A ray that is not finite, or whose direction
    is zero, hits nothing. `tmin` and `tmax` are the interval of `t` that counts, numbers or arrays. `cull` leaves out
    "back" or "front" faces; the front is where corners run counter-clockwise. `progress(done, rays)` is called some
    times a second. The lock of Python is released; Ctrl-C ends a query within a tenth of a second.

    Scenes pickle to their mesh and settings, and are built again where they arrive; those of instances to what is placed,
    each once, and the transforms. `copy.copy` and `copy.deepcopy` share the tree until one of the two is moved.

    Examples
    --------
    >>> vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    >>> scene = Scene(vertices, [[0, 1, 2]])
    >>> scene
    <trisect.Scene of 1 triangle, f32, exact>
    """

    __slots__ = ("_raw", "_mask", "_placed", "__weakref__")

    def __init__(
        self,
        vertices: npt.ArrayLike,
        faces: npt.ArrayLike,
        *,
        precision: Literal["auto", "f32", "f64"] = "auto",
        method: Literal["exact", "fast", "watertight"] = "exact",
        moving: bool = False,
        threads: int | None = None,
    ) -> None:
        vertices = np.asarray(vertices)
        dtype = dtype_of(precision, vertices.dtype)
        self._raw = _trisect.Scene(
            rows("vertices", vertices, dtype), faces_of(faces), method, bool(moving), threads_of(threads)
        )
        self._mask: npt.NDArray[np.bool_] | None = None
        self._placed: tuple[tuple[Scene, ...], npt.NDArray[np.float32]] | None = None

    @classmethod
    def instances(
        cls, scenes: Scene | Sequence[Scene], transforms: npt.ArrayLike, *, threads: int | None = None
    ) -> Scene:
        """A scene of scenes, each in its place: meshes, or scenes of instances in turn, which share their trees.

        `scenes` are in f32: one for each transform, or a single one that all of them place, as it is now. `transforms`,
        (n, 4, 4) or (n, 3, 4), rounded to float32, lead from each one's space to that of the new scene: `p` is at
        `m[:3, :3] @ p + m[:3, 3]`. They may turn, stretch, shear and mirror.

        All queries work as on a mesh. The triangles are numbered one instance after another; `locate` says which
        is which. A ray is carried to an instance by rounding it, and is tested there exactly: so the triangles of one
        instance let no ray through between them; those of two that touch may.

        Raises `ValueError` where shapes do not fit, where a transform is not finite or has no inverse, and for scenes that
        are in f64 or filtered.

        >>> triangle = Scene(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32), [[0, 1, 2]])
        >>> moved = np.eye(4)
        >>> moved[:3, 3] = 5, 0, -3
        >>> scene = Scene.instances(triangle, [np.eye(4), moved])
        >>> scene
        <trisect.Scene of 2 triangles in 2 instances, f32, exact>
        >>> hits = scene.first([[0.25, 0.5, 1.0], [5.25, 0.5, 1.0], [9.0, 9.0, 1.0]], [0.0, 0.0, -1.0])
        >>> hits.t, scene.locate(hits).instance
        (array([ 1.,  4., inf], dtype=float32), array([ 0,  1, -1], dtype=int32))
        """
        placed = matrices(transforms)
        scenes = (scenes,) * len(placed) if isinstance(scenes, Scene) else tuple(scenes)
        if len(scenes) != len(placed):
            raise ValueError(f"each scene has a transform, but there are {len(scenes)} and {len(placed)}")
        for at, scene in enumerate(scenes):
            if scene.precision != "f32":
                raise ValueError(f'scene {at} is in f64, but instances are in f32: make it with precision="f32"')
            if scene._mask is not None:
                raise ValueError(f"scene {at} is filtered: filter the scene of instances")
        if sum(map(len, scenes)) > np.iinfo(np.int32).max:
            raise ValueError("the triangles of all instances are more than int32 can number")
        # As they are now; one that is placed again and again is one.
        copies = {id(scene): scene._copied() for scene in scenes}
        scenes = tuple(copies[id(scene)] for scene in scenes)
        new = cls.__new__(cls)
        new._raw = _trisect.Scene.instances([scene._raw for scene in scenes], placed, threads_of(threads))
        new._mask, new._placed = None, (scenes, placed)
        return new

    def first(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        *,
        tmin: npt.ArrayLike = 0.0,
        tmax: npt.ArrayLike = np.inf,
        cull: Cull = "none",
        out: tuple[npt.NDArray[Any], ...] | None = None,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> Hits:
        """The first hit of each ray: that of the smallest `t`; of several at one point, that of the lowest index.

        `out` may be the arrays of an earlier `Hits`: C-contiguous, of the rays' shape and the dtypes of `Hits`.

        Raises `ValueError` where shapes do not fit.

        >>> scene = Scene(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32), [[0, 1, 2]])
        >>> hits = scene.first([[0.25, 0.5, 1.0], [2.0, 2.0, 1.0]], [0.0, 0.0, -1.0])
        >>> hits.triangle, hits.t, hits.u, hits.v  # doctest: +NORMALIZE_WHITESPACE
        (array([ 0, -1], dtype=int32), array([ 1., inf], dtype=float32),
         array([0.25, 0.  ], dtype=float32), array([0.5, 0. ], dtype=float32))
        """
        shape, rays = self._rays(origins, directions, tmin, tmax)
        if out is not None and len(out) != 4:
            raise ValueError(f"out must be four arrays, triangle, t, u, v, not {len(out)}")
        kinds = (np.dtype(np.int32), self.dtype, self.dtype, self.dtype)
        hits = Hits(*(place(shape, kind, out and out[at]) for at, kind in enumerate(kinds)))
        flat = tuple(array.reshape(-1) for array in hits)
        self._raw.first(rays, self._how(cull, threads, progress), flat)  # type: ignore[arg-type]
        return hits if shape else Hits(*(array[()] for array in hits))

    def any(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        *,
        tmin: npt.ArrayLike = 0.0,
        tmax: npt.ArrayLike = np.inf,
        cull: Cull = "none",
        out: npt.NDArray[np.bool_] | None = None,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> npt.NDArray[np.bool_]:
        """Whether each ray hits anything, as bool of the rays' shape: faster than `first`.

        Raises `ValueError` where shapes do not fit.

        >>> scene = Scene(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32), [[0, 1, 2]])
        >>> scene.any([0.25, 0.5, 1.0], [0.0, 0.0, -1.0], tmax=[0.5, 2.0])
        array([False,  True])
        """
        shape, rays = self._rays(origins, directions, tmin, tmax)
        hits = place(shape, np.dtype(bool), out)
        self._raw.any(rays, self._how(cull, threads, progress), hits.reshape(-1))
        return hits if shape else hits[()]

    def all(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        *,
        tmin: npt.ArrayLike = 0.0,
        tmax: npt.ArrayLike = np.inf,
        cull: Cull = "none",
        crossings: Crossings = "every",
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> AllHits:
        """All hits of each ray, by `t`, then by index; every triangle once, however many.

        Where a ray meets an edge or a corner that triangles share, each of them counts; with `crossings="owned"` one of
        them where the surface goes through the ray, and none or two where it turns back, so that a closed surface is
        crossed an even number of times by a line. That takes the exact method. Rays of more dimensions are numbered in C order.

        Raises `ValueError` where shapes do not fit.

        >>> quad = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
        >>> scene = Scene(quad, [[0, 1, 2], [0, 2, 3]])
        >>> hits = scene.all([[0.5, 0.5, 1.0], [5.0, 0.0, 1.0], [0.5, 0.25, 1.0]], [0.0, 0.0, -1.0])
        >>> hits.offsets, hits.triangle, hits.ray
        (array([0, 2, 2, 3]), array([0, 1, 0], dtype=int32), array([0, 0, 2]))
        """
        _, rays = self._rays(origins, directions, tmin, tmax)
        return AllHits(*self._raw.all(rays, self._how(cull, threads, progress), crossings))

    def count(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        *,
        tmin: npt.ArrayLike = 0.0,
        tmax: npt.ArrayLike = np.inf,
        cull: Cull = "none",
        crossings: Crossings = "every",
        out: npt.NDArray[np.int32] | None = None,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> npt.NDArray[np.int32]:
        """How many hits `all` finds for each ray, as int32 of the rays' shape.

        Raises `ValueError` where shapes do not fit.

        >>> quad = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
        >>> scene = Scene(quad, [[0, 1, 2], [0, 2, 3]])
        >>> ray = [0.5, 0.5, 1.0], [0.0, 0.0, -1.0]
        >>> int(scene.count(*ray)), int(scene.count(*ray, crossings="owned"))
        (2, 1)
        """
        shape, rays = self._rays(origins, directions, tmin, tmax)
        counts = place(shape, np.dtype(np.int32), out)
        self._raw.count(rays, self._how(cull, threads, progress), crossings, counts.reshape(-1))
        return counts if shape else counts[()]

    def contains(
        self,
        points: npt.ArrayLike,
        *,
        surface: bool = False,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> npt.NDArray[np.bool_]:
        """Whether each of `points`, (..., 3), is inside of the closed surface, as bool; those on it are `surface`.

        Decided exactly, with the exact method alone. See `places`.

        >>> tetrahedron = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32)
        >>> scene = Scene(tetrahedron, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
        >>> scene.contains([[0.25, 0.25, 0.25], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
        array([ True, False, False])
        """
        places = self.places(points, threads=threads, progress=progress)
        return places >= 0 if surface else places > 0

    def places(
        self,
        points: npt.ArrayLike,
        *,
        out: npt.NDArray[np.int8] | None = None,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> npt.NDArray[np.int8]:
        """Where each of `points`, (..., 3), is, as int8: 1 inside, 0 on the surface, −1 outside.

        Inside is what is enclosed an odd number of times, so that a surface within another bounds a cavity; which way
        triangles face plays no part. The surface has to be closed. A point that is not finite is outside.

        Raises `ValueError` where the shape does not fit, where the method is not exact, and on what `filtered` returns.

        >>> tetrahedron = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32)
        >>> scene = Scene(tetrahedron, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
        >>> scene.places([[0.25, 0.25, 0.25], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
        array([ 1,  0, -1], dtype=int8)
        """
        if self._mask is not None:
            raise ValueError("a filtered scene has no inside: make a scene of the faces that bound it")
        array = triples("points", points, self.dtype)
        shape = array.shape[:-1]
        places = place(shape, np.dtype(np.int8), out)
        self._raw.places(array.reshape(-1, 3), self._how("none", threads, progress), places.reshape(-1))
        return places if shape else places[()]

    def filtered(self, mask: npt.ArrayLike) -> Scene:
        """The same scene, of which rays see the triangles alone whose `mask`, (triangles,) bool, is true.

        It shares the tree. A mask of a mask sees what both let be seen.

        Raises `ValueError` where the mask is not bool or not one for each triangle.

        >>> scene = Scene(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32), [[0, 1, 2], [0, 1, 2]])
        >>> int(scene.filtered([False, True]).first([0.25, 0.5, 1.0], [0.0, 0.0, -1.0]).triangle)
        1
        """
        mask = np.array(mask)
        if mask.dtype != bool or mask.shape != (len(self),):
            raise ValueError(f"mask must be bool of shape ({len(self)},), not {mask.dtype} of {mask.shape}")
        other = self._copied()
        other._mask = mask if self._mask is None else mask & self._mask
        return other

    def update(self, vertices: npt.ArrayLike) -> None:
        """Moves the vertices, as many as before, (n, 3): the tree is fitted to them, which is quicker than making it anew.

        Best where the scene was made with `moving=True`. The tree is made anew where a copy shares it, or where a triangle
        has an area that had none. On an error the scene is as before.

        Raises `ValueError` where the shape does not fit, or a vertex that a face names is not finite.

        >>> vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
        >>> scene = Scene(vertices, [[0, 1, 2]], moving=True)
        >>> scene.update(vertices + np.float32([0, 0, -1]))
        >>> float(scene.first([0.25, 0.5, 1.0], [0.0, 0.0, -1.0]).t)
        2.0
        """
        if self._placed is not None:
            raise ValueError("instances have no vertices of their own: move them by set_transforms, or place moved scenes")
        vertices, made = np.asarray(vertices), self._raw.count_of_vertices
        if vertices.shape != (made, 3):
            raise ValueError(f"vertices must have shape ({made}, 3), as before, not {vertices.shape}")
        self._raw.update(rows("vertices", vertices, self.dtype))

    def set_transforms(self, transforms: npt.ArrayLike) -> None:
        """Moves all instances, as many as before, (n, 4, 4) or (n, 3, 4): what is placed stays as it is.

        Raises `ValueError` as `instances` does, and where the scene is a mesh; it is as before then.

        >>> triangle = Scene(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32), [[0, 1, 2]])
        >>> scene = Scene.instances(triangle, [np.eye(4)])
        >>> moved = np.eye(4)
        >>> moved[2, 3] = 2
        >>> scene.set_transforms([moved])
        >>> float(scene.first([0.25, 0.5, 3.0], [0.0, 0.0, -1.0]).t)
        1.0
        """
        if self._placed is None:
            raise ValueError("a mesh has no instances: move its vertices by update")
        scenes, _ = self._placed
        placed = matrices(transforms)
        if len(placed) != len(scenes):
            raise ValueError(f"there are {len(scenes)} instances, but {len(placed)} transforms")
        if not self._raw.set_transforms(placed):
            # A copy shares them.
            self._raw = _trisect.Scene.instances([scene._raw for scene in scenes], placed, self._raw.threads)
        self._placed = scenes, placed

    def locate(self, hits: Hits | AllHits) -> Located:
        """Which instance each hit is in, and which triangle of what is placed there; where that is a scene of instances, its
        own `locate` leads on. A mesh counts as one instance.

        >>> triangle = Scene(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32), [[0, 1, 2]])
        >>> scene = Scene.instances([triangle, triangle], [np.eye(4)] * 2)
        >>> hits = scene.all([[0.25, 0.5, 1.0]], [0.0, 0.0, -1.0])
        >>> hits.triangle, scene.locate(hits).instance, scene.locate(hits).triangle
        (array([0, 1], dtype=int32), array([0, 1], dtype=int32), array([0, 0], dtype=int32))
        """
        return Located(*(array.astype(np.int32)[()] for array in located(self._parts(), hits.triangle)))

    def points(self, hits: Hits | AllHits) -> npt.NDArray[Any]:
        """The points that are hit, (..., 3) in float64, from the corners and their weights: nearer to the triangle than
        `origin + t·direction` where rays come from afar. NaN where nothing is hit.

        >>> scene = Scene(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32), [[0, 1, 2]])
        >>> scene.points(scene.first([[0.25, 0.5, 1.0]], [0.0, 0.0, -1.0]))
        array([[0.25, 0.5 , 0.  ]])
        """
        shape = np.shape(hits.triangle)
        if self._placed is not None:
            return self._points_of_instances(hits)
        u, v = (np.ravel(np.asarray(weight, self.dtype)) for weight in (hits.u, hits.v))
        return self._raw.points(np.ravel(np.asarray(hits.triangle, np.int32)), u, v).reshape(*shape, 3)

    @property
    def vertices(self) -> npt.NDArray[Any]:
        """The vertices, (n, 3), in the scene's dtype: a copy. Of instances those of each, where they are."""
        return self._raw.vertices() if self._placed is None else self._joined()[0]

    @property
    def faces(self) -> npt.NDArray[np.uint32]:
        """The faces, (m, 3) uint32: a copy. Of instances those of each, their corners in the order that they have there."""
        return self._raw.faces() if self._placed is None else self._joined()[1].astype(np.uint32)

    @property
    def transforms(self) -> npt.NDArray[np.float32] | None:
        """Where the instances are, (n, 3, 4) float32: a copy. None where the scene is a mesh."""
        return None if self._placed is None else self._placed[1].copy()

    @property
    def dtype(self) -> np.dtype[Any]:
        """The dtype of the scene: what rays are converted to, and `t`, `u`, `v` are."""
        return self._raw.dtype

    @property
    def precision(self) -> str:
        """ "f32" or "f64"."""
        return next(name for name, dtype in DTYPES.items() if dtype == self.dtype)

    @property
    def method(self) -> str:
        """By which method rays are tested; "mixed" where instances differ in that."""
        return self._raw.method

    @property
    def statistics(self) -> dict[str, Any]:
        """Facts about the tree: its builder, its nodes, blocks of triangles, references from leaves to triangles, depth,
        bytes, and the expected cost of a ray by the surface area heuristic.

        >>> scene = Scene(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32), [[0, 1, 2]])
        >>> sorted(scene.statistics)
        ['blocks', 'builder', 'bytes', 'cost', 'depth', 'nodes', 'references']
        """
        return self._raw.statistics()

    def __len__(self) -> int:
        return self._raw.triangles

    def __repr__(self) -> str:
        count = len(self)
        seen = "" if self._mask is None else f", {int(self._mask.sum())} seen"
        triangles = "triangle" if count == 1 else "triangles"
        placed = "" if self._placed is None else f" in {len(self._placed[0])} instances"
        return f"<trisect.Scene of {count} {triangles}{placed}{seen}, {self.precision}, {self.method}>"

    def __copy__(self) -> Scene:
        return self._copied()

    def __deepcopy__(self, memo: dict[int, Any]) -> Scene:
        return self._copied()

    def __reduce__(self) -> tuple[Any, ...]:
        raw = self._raw
        if self._placed is not None:
            return _unpickle_instances, (*self._placed, raw.threads, self._mask)
        mesh = self.vertices, self.faces
        return _unpickle, (*mesh, self.precision, raw.method, raw.moving, raw.threads, self._mask)

    def _copied(self) -> Scene:
        other = Scene.__new__(type(self))
        other._raw, other._mask, other._placed = self._raw.copy(), self._mask, self._placed
        return other

    def _parts(self) -> npt.NDArray[np.int64]:
        """Where the triangles of each instance begin."""
        return starts([len(self)] if self._placed is None else map(len, self._placed[0]))

    def _joined(self) -> tuple[npt.NDArray[Any], npt.NDArray[np.int64]]:
        """The mesh of all instances."""
        scenes, transforms = self._placed or ((), ())
        meshes = []
        for scene, at in zip(scenes, transforms):
            m = at.astype(np.float64)
            vertices = scene.vertices.astype(np.float64) @ m[:, :3].T + m[:, 3]
            meshes.append((vertices.astype(self.dtype), scene.faces))
        return joined(meshes)

    def _points_of_instances(self, hits: Hits | AllHits) -> npt.NDArray[np.float64]:
        scenes, transforms = self._placed or ((), np.zeros((0, 3, 4), np.float32))
        instance, triangle, u, v = map(np.asarray, (*self.locate(hits), hits.u, hits.v))
        points = np.full((*np.shape(instance), 3), np.nan)
        for scene in set(scenes):
            # The last is for −1: in none.
            is_in = np.array([*(other is scene for other in scenes), False])[instance]
            own = Hits(triangle[is_in], np.zeros(is_in.sum()), u[is_in], v[is_in])
            m = transforms[instance[is_in]].astype(np.float64)
            points[is_in] = np.einsum("nij,nj->ni", m[:, :, :3], scene.points(own)) + m[:, :, 3]
        return points

    def _how(self, cull: str, threads: int | None, progress: Progress | None) -> _trisect.How:
        return cull, self._mask, threads_of(threads), progress

    def _rays(
        self, origins: npt.ArrayLike, directions: npt.ArrayLike, tmin: npt.ArrayLike, tmax: npt.ArrayLike
    ) -> tuple[tuple[int, ...], _trisect.Rays]:
        """The shape of the rays, and the arrays in rows, copied where their layout leaves no other way."""
        dtype = self.dtype
        o, d = triples("origins", origins, dtype), triples("directions", directions, dtype)
        ends: list[npt.NDArray[Any] | None] = [None, None]
        for at, (interval, ordinary) in enumerate(((tmin, 0.0), (tmax, np.inf))):
            if interval is not ordinary and not (isinstance(interval, (int, float)) and interval == ordinary):
                ends[at] = aligned(np.asarray(interval, dtype))
        if o.shape == d.shape and o.ndim == 2 and ends == [None, None]:
            return o.shape[:1], (o, d, None, None)
        shapes = [o.shape[:-1], d.shape[:-1], *(end.shape for end in ends if end is not None)]
        try:
            shape = np.broadcast_shapes(*shapes)
        except ValueError:
            names = ", ".join(map(str, [o.shape, d.shape, *shapes[2:]]))
            raise ValueError(f"origins, directions, tmin and tmax do not go together: {names}") from None
        o, d = (np.broadcast_to(array, (*shape, 3)).reshape(-1, 3) for array in (o, d))
        lower, upper = (end if end is None else np.broadcast_to(end, shape).reshape(-1) for end in ends)
        return shape, (o, d, lower, upper)


def _unpickle(
    vertices: npt.NDArray[Any],
    faces: npt.NDArray[np.uint32],
    precision: Literal["f32", "f64"],
    method: Any,
    moving: bool,
    threads: int | None,
    mask: npt.NDArray[np.bool_] | None,
) -> Scene:
    scene = Scene(vertices, faces, precision=precision, method=method, moving=moving, threads=threads)
    scene._mask = mask
    return scene


def _unpickle_instances(
    scenes: tuple[Scene, ...],
    transforms: npt.NDArray[np.float32],
    threads: int | None,
    mask: npt.NDArray[np.bool_] | None,
) -> Scene:
    scene = Scene.instances(scenes, transforms, threads=threads)
    scene._mask = mask
    return scene
