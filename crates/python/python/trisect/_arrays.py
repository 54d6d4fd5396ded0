"""Arrays as users give them, checked and brought into the layouts that the compiled half takes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

DTYPES: dict[str, np.dtype[Any]] = {"f32": np.dtype(np.float32), "f64": np.dtype(np.float64)}


def starts(counts: Iterable[int]) -> npt.NDArray[np.int64]:
    """Where each of several begins that follow each other; and the end."""
    return np.cumsum([0, *counts])


def located(begins: npt.NDArray[np.int64], triangle: npt.ArrayLike) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Of triangles that are numbered one mesh after another: the mesh, and the triangle there; −1 for none."""
    triangle = np.asarray(triangle, np.int64)
    mesh = np.where(triangle < 0, -1, np.searchsorted(begins, triangle, side="right") - 1)
    return mesh, np.where(triangle < 0, -1, triangle - begins[mesh])


def joined(meshes: Sequence[tuple[npt.NDArray[Any], npt.NDArray[Any]]]) -> tuple[npt.NDArray[Any], npt.NDArray[np.int64]]:
    """One mesh, in float32, of several."""
    firsts = starts(len(vertices) for vertices, _ in meshes)
    faces = [faces.astype(np.int64) + first for (_, faces), first in zip(meshes, firsts)]
    vertices = [np.zeros((0, 3), np.float32), *(vertices for vertices, _ in meshes)]
    return np.concatenate(vertices), np.concatenate([np.zeros((0, 3), np.int64), *faces])


def matrices(given: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """The upper three rows of matrices."""
    whole = np.asarray(given, np.float64)
    if whole.shape == (0,):
        whole = whole.reshape(0, 4, 4)
    if whole.ndim != 3 or whole.shape[1:] not in ((3, 4), (4, 4)):
        raise ValueError(f"transforms must have shape (n, 4, 4) or (n, 3, 4), not {whole.shape}")
    is_affine = (whole[:, 3:] == [0, 0, 0, 1]).all(axis=(1, 2))
    if not is_affine.all():
        raise ValueError(f"the last row of transform {np.argmin(is_affine)} is not 0, 0, 0, 1")
    return np.ascontiguousarray(whole[:, :3], np.float32)


def dtype_of(precision: str, given: np.dtype[Any]) -> np.dtype[Any]:
    if precision not in ("auto", *DTYPES):
        raise ValueError(f'precision must be "auto", "f32" or "f64", not {precision!r}')
    is_small = given.kind == "f" and given.itemsize <= 4
    return DTYPES[("f32" if is_small else "f64") if precision == "auto" else precision]


def aligned(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return array if array.flags.aligned else array.copy()


def triples(name: str, given: npt.ArrayLike, dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    """An array of points or vectors in any layout."""
    try:
        array = np.asarray(given, dtype)
    except ValueError as error:
        raise ValueError(f"{name} must be an array of shape (..., 3): {error}") from None
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{name} must have shape (..., 3), not {array.shape}")
    return aligned(array)


def rows(name: str, given: npt.NDArray[Any], dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    """An array of rows of three, one after another."""
    if given.size == 0 and given.ndim < 2:
        given = given.reshape(0, 3)
    if given.ndim != 2 or given.shape[1] != 3:
        raise ValueError(f"{name} must have shape (n, 3), not {given.shape}")
    return np.require(given, dtype, ["C", "A"])


def faces_of(given: npt.ArrayLike) -> npt.NDArray[np.uint32]:
    faces = np.asarray(given)
    if faces.size and faces.dtype.kind not in "iu":
        raise ValueError(f"faces must be integers, not {faces.dtype}")
    if faces.size and faces.ndim == 2:
        for amiss in (faces < 0, faces > np.iinfo(np.uint32).max) if faces.dtype != np.uint32 else ():
            if amiss.any():
                face, corner = np.argwhere(amiss)[0]
                raise ValueError(f"face {face} names vertex {faces[face, corner]}, which there is not")
    return rows("faces", faces, np.dtype(np.uint32))


def threads_of(threads: int | None) -> int | None:
    if threads is not None and threads < 1:
        raise ValueError(f"threads must be at least 1, not {threads}")
    return threads


def place(shape: tuple[int, ...], dtype: np.dtype[Any], out: npt.NDArray[Any] | None) -> npt.NDArray[Any]:
    """Where results go: an array of their shape."""
    if out is None:
        return np.empty(shape, dtype)
    if out.shape != shape or out.dtype != dtype or not (out.flags.c_contiguous and out.flags.writeable):
        have = f"{out.dtype} of shape {out.shape}"
        raise ValueError(f"out must be {dtype} of shape {shape}, C-contiguous and writeable, not {have}")
    return out
