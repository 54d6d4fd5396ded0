"""Scenes: what is asked of them, in arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _trisect

Progress = Callable[[int, int], object]
Cull = Literal["none", "back", "front"]
Crossings = Literal["every", "owned"]

_DTYPES: dict[str, np.dtype[Any]] = {"f32": np.dtype(np.float32), "f64": np.dtype(np.float64)}


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

    Scenes pickle to their mesh and settings, and are built again where they arrive; `copy.copy` and `copy.deepcopy`
    share the tree until one of the two is moved.

    Examples
    --------
    >>> vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    >>> scene = Scene(vertices, [[0, 1, 2]])
    >>> scene
    <trisect.Scene of 1 triangle, f32, exact>
    """

    __slots__ = ("_raw", "_mask", "__weakref__")

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
        dtype = _dtype(precision, vertices.dtype)
        self._raw = _trisect.Scene(
            _rows("vertices", vertices, dtype), _faces(faces), method, bool(moving), _threads(threads)
        )
        self._mask: npt.NDArray[np.bool_] | None = None

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
        hits = Hits(*(_place(shape, kind, out and out[at]) for at, kind in enumerate(kinds)))
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
        hits = _place(shape, np.dtype(bool), out)
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
        counts = _place(shape, np.dtype(np.int32), out)
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
        array = _triples("points", points, self.dtype)
        shape = array.shape[:-1]
        places = _place(shape, np.dtype(np.int8), out)
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
        vertices, made = np.asarray(vertices), self._raw.count_of_vertices
        if vertices.shape != (made, 3):
            raise ValueError(f"vertices must have shape ({made}, 3), as before, not {vertices.shape}")
        self._raw.update(_rows("vertices", vertices, self.dtype))

    def points(self, hits: Hits | AllHits) -> npt.NDArray[Any]:
        """The points that are hit, (..., 3) in float64, from the corners and their weights: nearer to the triangle than
        `origin + t·direction` where rays come from afar. NaN where nothing is hit.

        >>> scene = Scene(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32), [[0, 1, 2]])
        >>> scene.points(scene.first([[0.25, 0.5, 1.0]], [0.0, 0.0, -1.0]))
        array([[0.25, 0.5 , 0.  ]])
        """
        shape = np.shape(hits.triangle)
        u, v = (np.ravel(np.asarray(weight, self.dtype)) for weight in (hits.u, hits.v))
        return self._raw.points(np.ravel(np.asarray(hits.triangle, np.int32)), u, v).reshape(*shape, 3)

    @property
    def vertices(self) -> npt.NDArray[Any]:
        """The vertices, (n, 3), in the scene's dtype: a copy."""
        return self._raw.vertices()

    @property
    def faces(self) -> npt.NDArray[np.uint32]:
        """The faces, (m, 3) uint32: a copy."""
        return self._raw.faces()

    @property
    def dtype(self) -> np.dtype[Any]:
        """The dtype of the scene: what rays are converted to, and `t`, `u`, `v` are."""
        return self._raw.dtype

    @property
    def precision(self) -> str:
        """ "f32" or "f64"."""
        return next(name for name, dtype in _DTYPES.items() if dtype == self.dtype)

    @property
    def method(self) -> str:
        """By which method rays are tested."""
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
        return f"<trisect.Scene of {count} {triangles}{seen}, {self.precision}, {self.method}>"

    def __copy__(self) -> Scene:
        return self._copied()

    def __deepcopy__(self, memo: dict[int, Any]) -> Scene:
        return self._copied()

    def __reduce__(self) -> tuple[Any, ...]:
        raw = self._raw
        mesh = self.vertices, self.faces
        return _unpickle, (*mesh, self.precision, raw.method, raw.moving, raw.threads, self._mask)

    def _copied(self) -> Scene:
        other = Scene.__new__(type(self))
        other._raw, other._mask = self._raw.copy(), self._mask
        return other

    def _how(self, cull: str, threads: int | None, progress: Progress | None) -> _trisect.How:
        return cull, self._mask, _threads(threads), progress

    def _rays(
        self, origins: npt.ArrayLike, directions: npt.ArrayLike, tmin: npt.ArrayLike, tmax: npt.ArrayLike
    ) -> tuple[tuple[int, ...], _trisect.Rays]:
        """The shape of the rays, and the arrays in rows, copied where their layout leaves no other way."""
        dtype = self.dtype
        o, d = _triples("origins", origins, dtype), _triples("directions", directions, dtype)
        ends: list[npt.NDArray[Any] | None] = [None, None]
        for at, (interval, ordinary) in enumerate(((tmin, 0.0), (tmax, np.inf))):
            if interval is not ordinary and not (isinstance(interval, (int, float)) and interval == ordinary):
                ends[at] = _aligned(np.asarray(interval, dtype))
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


def _dtype(precision: str, given: np.dtype[Any]) -> np.dtype[Any]:
    if precision not in ("auto", *_DTYPES):
        raise ValueError(f'precision must be "auto", "f32" or "f64", not {precision!r}')
    is_small = given.kind == "f" and given.itemsize <= 4
    return _DTYPES[("f32" if is_small else "f64") if precision == "auto" else precision]


def _aligned(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return array if array.flags.aligned else array.copy()


def _triples(name: str, given: npt.ArrayLike, dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    """An array of points or vectors in any layout."""
    try:
        array = np.asarray(given, dtype)
    except ValueError as error:
        raise ValueError(f"{name} must be an array of shape (..., 3): {error}") from None
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{name} must have shape (..., 3), not {array.shape}")
    return _aligned(array)


def _rows(name: str, given: npt.NDArray[Any], dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    """An array of rows of three, one after another."""
    if given.size == 0 and given.ndim < 2:
        given = given.reshape(0, 3)
    if given.ndim != 2 or given.shape[1] != 3:
        raise ValueError(f"{name} must have shape (n, 3), not {given.shape}")
    return np.require(given, dtype, ["C", "A"])


def _faces(given: npt.ArrayLike) -> npt.NDArray[np.uint32]:
    faces = np.asarray(given)
    if faces.size and faces.dtype.kind not in "iu":
        raise ValueError(f"faces must be integers, not {faces.dtype}")
    if faces.size and faces.ndim == 2:
        for amiss in (faces < 0, faces > np.iinfo(np.uint32).max) if faces.dtype != np.uint32 else ():
            if amiss.any():
                face, corner = np.argwhere(amiss)[0]
                raise ValueError(f"face {face} names vertex {faces[face, corner]}, which there is not")
    return _rows("faces", faces, np.dtype(np.uint32))


def _threads(threads: int | None) -> int | None:
    if threads is not None and threads < 1:
        raise ValueError(f"threads must be at least 1, not {threads}")
    return threads


def _place(shape: tuple[int, ...], dtype: np.dtype[Any], out: npt.NDArray[Any] | None) -> npt.NDArray[Any]:
    """Where results go: an array of their shape."""
    if out is None:
        return np.empty(shape, dtype)
    if out.shape != shape or out.dtype != dtype or not (out.flags.c_contiguous and out.flags.writeable):
        have = f"{out.dtype} of shape {out.shape}"
        raise ValueError(f"out must be {dtype} of shape {shape}, C-contiguous and writeable, not {have}")
    return out
