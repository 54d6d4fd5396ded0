"""The truth, in rational arithmetic on the arrays as they are given: slow, plain, and independent of the package."""

from fractions import Fraction

import numpy as np


def _rational(array):
    return [Fraction(float(x)) for x in array]


def _minus(a, b):
    return [x - y for x, y in zip(a, b)]


def _cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def meets(triangle, origin, direction):
    """Where a line meets a triangle of rational corners: `t`, and whether at an edge; nothing where it does not, or runs
    within its plane."""
    a, b, c = (_minus(corner, origin) for corner in triangle)
    weights = [_dot(direction, _cross(q, p)) for p, q in ((b, c), (c, a), (a, b))]
    total = sum(weights)
    if total == 0 or any(weight * total < 0 for weight in weights):
        return None
    normal = _cross(_minus(b, a), _minus(c, a))
    return Fraction(_dot(a, normal)) / _dot(direction, normal), 0 in weights


class Truth:
    """A mesh as its floats are, without rounding."""

    def __init__(self, vertices, faces):
        self.corners = np.asarray(vertices, np.float64)[np.asarray(faces)]
        self.rational = {}

    def _candidates(self, origin, direction):
        """Triangles that the line may meet, by floating point with a bound far above its error."""
        a, b, c = (self.corners[:, corner] - origin for corner in range(3))
        signs, bounds = [], []
        for p, q in ((b, c), (c, a), (a, b)):
            signs.append(np.cross(q, p) @ direction)
            lengths = np.linalg.norm(p, axis=1) * np.linalg.norm(q, axis=1)
            bounds.append(1e-13 * lengths * np.linalg.norm(direction))
        signs, bounds = np.array(signs), np.array(bounds)
        may = np.all(signs >= -bounds, axis=0) | np.all(signs <= bounds, axis=0)
        return np.flatnonzero(may)

    def _corners(self, face):
        if face not in self.rational:
            self.rational[face] = [_rational(corner) for corner in self.corners[face]]
        return self.rational[face]

    def all(self, origin, direction):
        """All hits of a ray in order: (t, face, whether at an edge)."""
        origin, direction = np.asarray(origin, np.float64), np.asarray(direction, np.float64)
        exact = _rational(origin), _rational(direction)
        met = ((int(face), meets(self._corners(face), *exact)) for face in self._candidates(origin, direction))
        return sorted((hit[0], face, hit[1]) for face, hit in met if hit is not None and hit[0] >= 0)

    def first(self, origin, direction):
        """The face that a ray hits first, −1 for none, and `t`."""
        hits = self.all(origin, direction)
        return (hits[0][1], float(hits[0][0])) if hits else (-1, np.inf)

    def place(self, point):
        """1 inside, 0 on the surface, −1 outside: by rays in directions that meet no edge."""
        random = np.random.default_rng(0)
        while True:
            direction = random.integers(-1000, 1000, 3)
            hits = self.all(point, direction)
            if any(t == 0 for t, _, _ in hits):
                return 0
            if not any(is_edge for _, _, is_edge in hits) and direction.any():
                return 1 if len(hits) % 2 else -1
