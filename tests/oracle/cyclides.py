# SPDX-License-Identifier: GPL-3.0-or-later
"""Ring Dupin cyclides that are Moebius images of the Clifford torus.

All of them have int H^2 dA = 2 pi^2, with H the mean of the two principal
curvatures.  The reduced volume v = V / (4 pi/3 (A / 4 pi)^(3/2)) runs from
the torus with ratio 1 / sqrt(2) (v = 0.7116...) to 1.

A ring cyclide with 0 <= c < d < a and b^2 = a^2 - c^2 is in its own frame

    x = (d (c - a cos u cos v) + b^2 cos u) / D
    y = b sin u (a - d cos v) / D
    z = b sin v (c cos u - d) / D,        D = a - c cos u cos v,

    (x^2 + y^2 + z^2 + b^2 - d^2)^2 = 4 (a x - c d)^2 + 4 b^2 y^2.

Its outer normal (c - a cos u cos v, -b sin u cos v, -b sin v) / D does not
depend on d, so the surfaces with the same a and c are parallel to each other,
with the area element b^2 (a - d cos v)(d - c cos u) / D^2 du dv.  With
k = c / a and complete elliptic integrals K, E of modulus k (parameter k^2),

    G = 2 E - (1 - k^2) K
    A = 8 pi a d G,          int H dA = A / (2 d),
    V = 4 pi a d^2 G + (4 pi a^3 / 3) ((1 + k^2) E - (1 - k^2) K).

The two circles cut out by the plane y = 0 have centres at x = a and x = -a
and radii d - c and d + c.  Their inversive distance
(2 a^2 - c^2 - d^2) / (d^2 - c^2) is a Moebius invariant, and it is 3 for the
Clifford torus, which gives d^2 = (a^2 + c^2) / 2.
"""
from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, least_squares
from scipy.spatial.transform import Rotation
from scipy.special import ellipe, ellipkm1

Array = NDArray[np.float64]

AREA = 4.0 * np.pi


def elliptic(k: float) -> tuple[float, float]:
    """Return the two combinations of E and K in the volume formula.

    They are 2 E - (1 - k^2) K and (1 + k^2) E - (1 - k^2) K, without unit.
    """
    complement = (1.0 - k) * (1.0 + k)
    e, k_part = ellipe(k * k), complement * ellipkm1(complement)
    return float(2.0 * e - k_part), float((1.0 + k * k) * e - k_part)


def reduced_volume(k: float) -> float:
    """Return the reduced volume of the Moebius image with c / a = k."""
    g, h = elliptic(k)
    d = np.sqrt(0.5 * (1.0 + k * k))
    area = 8.0 * np.pi * d * g
    volume = 4.0 * np.pi * (d * d * g + h / 3.0)
    return float(volume / (AREA / 3.0 * (area / AREA) ** 1.5))


@dataclass(frozen=True)
class Cyclide:
    """A ring cyclide with a pose in space.

    a, c, d: parameters in the module docstring, lengths, 0 <= c < d < a.
    rotation: (3, 3) matrix and shift: (3,) vector; a point X of the frame of
    the cyclide is at rotation @ X + shift in space.
    """

    a: float
    c: float
    d: float
    rotation: Array = field(default_factory=lambda: np.eye(3))
    shift: Array = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        if not 0.0 <= self.c < self.d < self.a:
            raise ValueError("a ring cyclide needs 0 <= c < d < a")

    @property
    def b(self) -> float:
        """Half minor axis of the focal ellipse, a length."""
        return float(np.sqrt((self.a - self.c) * (self.a + self.c)))

    @property
    def k(self) -> float:
        """Eccentricity c / a of the focal ellipse, without unit."""
        return self.c / self.a

    def area(self) -> float:
        """Return the area in closed form."""
        return 8.0 * np.pi * self.a * self.d * elliptic(self.k)[0]

    def volume(self) -> float:
        """Return the enclosed volume in closed form."""
        g, h = elliptic(self.k)
        return float(4.0 * np.pi * self.a * (self.d ** 2 * g
                                             + self.a ** 2 * h / 3.0))

    def total_mean_curvature(self) -> float:
        """Return int H dA in closed form, a length."""
        return self.area() / (2.0 * self.d)

    def to_space(self, local: Array) -> Array:
        """Map points (..., 3) of the cyclide's frame to space."""
        return local @ self.rotation.T + self.shift

    def to_frame(self, points: Array) -> Array:
        """Map points (..., 3) of space to the cyclide's frame."""
        return (points - self.shift) @ self.rotation

    def position(self, u: Array, v: Array) -> Array:
        """Return surface points x(u, v) in space, (..., 3), angles in rad."""
        a, b, c, d = self.a, self.b, self.c, self.d
        cu, su, cv, sv = np.cos(u), np.sin(u), np.cos(v), np.sin(v)
        denominator = a - c * cu * cv
        local = np.stack([d * (c - a * cu * cv) + b * b * cu,
                          b * su * (a - d * cv),
                          b * sv * (c * cu - d)], axis=-1)
        return self.to_space(local / denominator[..., None])

    def normal(self, u: Array, v: Array) -> Array:
        """Return outer unit normals at x(u, v) in space, (..., 3)."""
        a, b, c = self.a, self.b, self.c
        cu, su, cv, sv = np.cos(u), np.sin(u), np.cos(v), np.sin(v)
        denominator = a - c * cu * cv
        local = np.stack([c - a * cu * cv, -b * su * cv, -b * sv], axis=-1)
        return local / denominator[..., None] @ self.rotation.T

    def mean_curvature(self, u: Array, v: Array) -> Array:
        """Return H at x(u, v), positive for a sphere, an inverse length."""
        first = 1.0 / (self.d - self.c * np.cos(u))
        second = -np.cos(v) / (self.a - self.d * np.cos(v))
        return 0.5 * (first + second)

    def implicit(self, points: Array) -> Array:
        """Return the implicit polynomial at points (..., 3), negative inside.

        The unit is the fourth power of a length.
        """
        p = self.to_frame(points)
        square = np.sum(p * p, axis=-1) + self.b ** 2 - self.d ** 2
        return (square ** 2 - 4.0 * (self.a * p[..., 0] - self.c * self.d) ** 2
                - 4.0 * self.b ** 2 * p[..., 1] ** 2)

    def signed_distance(self, points: Array, grid: int = 256) -> Array:
        """Return the signed distance of points (n, 3), negative inside, (n,).

        The solid is the union of the balls with centre (a cos u, b sin u, 0)
        and radius d - c cos u.  Hence the distance of an outer point is the
        minimum over u of |point - centre| - radius.  The same holds inside:
        at the nearest surface point the inscribed ball around the point is
        no larger than the focal ball, because its curvature cannot be less
        than the principal curvature of the surface, so it lies in the focal
        ball and touches it.  The minimum is found on a grid; the three lowest
        local minima are improved by a golden section search, which also
        copes with the corner of the function at a centre.
        """
        p = self.to_frame(np.asarray(points, dtype=float).reshape(-1, 3))

        def excess(u: Array) -> Array:
            centre = np.stack([self.a * np.cos(u), self.b * np.sin(u),
                               np.zeros_like(u)], axis=-1)
            return (np.linalg.norm(p[:, None, :] - centre, axis=-1)
                    - self.d + self.c * np.cos(u))

        h = 2.0 * np.pi / grid
        nodes = h * np.arange(grid)
        values = excess(nodes[None, :])
        is_low = ((values <= np.roll(values, 1, axis=1))
                  & (values <= np.roll(values, -1, axis=1)))
        ranked = np.where(is_low, values, np.inf)
        lowest = np.argpartition(ranked, 2, axis=1)[:, :3]
        left, right = nodes[lowest] - h, nodes[lowest] + h
        golden = 0.5 * (np.sqrt(5.0) - 1.0)
        inner = right - golden * (right - left)
        outer = left + golden * (right - left)
        f_inner, f_outer = excess(inner), excess(outer)
        for _ in range(75):
            shrink = f_inner < f_outer
            left, right = (np.where(shrink, left, inner),
                           np.where(shrink, outer, right))
            new = np.where(shrink, right - golden * (right - left),
                           left + golden * (right - left))
            f_new = excess(new)
            inner, outer, f_inner, f_outer = (
                np.where(shrink, new, outer), np.where(shrink, inner, new),
                np.where(shrink, f_new, f_outer),
                np.where(shrink, f_inner, f_new))
        return np.minimum(f_inner, f_outer).min(axis=1)

    def distance(self, points: Array) -> Array:
        """Return the distance of points (n, 3) to the surface, (n,)."""
        return np.abs(self.signed_distance(points))


def willmore_cyclide(v: float, rotation: Array | None = None,
                     shift: Array | None = None) -> Cyclide:
    """Return the Moebius image of the Clifford torus of reduced volume v.

    It has area 4 pi.  Without a pose the symmetry planes are y = 0 and z = 0,
    and the thicker side of the tube is at negative x.
    """
    if not reduced_volume(0.0) <= v < 1.0:
        raise ValueError("v must lie between 0.7116... and 1")
    k = 0.0
    if v > reduced_volume(0.0):
        k = float(brentq(lambda x: reduced_volume(x) - v, 0.0, 1.0 - 1e-12,
                         xtol=1e-15, rtol=1e-14))
    ratio = np.sqrt(0.5 * (1.0 + k * k))
    a = float(np.sqrt(AREA / (8.0 * np.pi * ratio * elliptic(k)[0])))
    return Cyclide(a, k * a, float(ratio * a),
                   np.eye(3) if rotation is None else rotation,
                   np.zeros(3) if shift is None else shift)


def fitted(points: Array, v: float, few: int = 600) -> Cyclide:
    """Return willmore_cyclide(v) in the pose nearest to points (n, 3).

    The area of their surface is 4 pi.  Least squares of signed distances of
    about `few` of them, from the principal axes of their cloud, turned by
    quarters about the axis of least extent.
    """
    middle = points.mean(axis=0)
    axes = np.linalg.eigh(np.cov((points - middle).T))[1][:, ::-1]
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    some = points[::max(1, len(points) // few)]

    def posed(base: Array, move: Array) -> Cyclide:
        turn = Rotation.from_rotvec(move[:3]).as_matrix()
        return willmore_cyclide(v, base @ turn, middle + move[3:])

    found = []
    for quarter in range(4):
        base = axes @ Rotation.from_euler("z", quarter * 0.5 * np.pi
                                          ).as_matrix()
        best = least_squares(
            lambda move: posed(base, move).signed_distance(some, 64),
            np.zeros(6), x_scale=0.1)
        found.append((best.cost, quarter, posed(base, best.x)))
    return min(found, key=lambda item: item[:2])[2]


def quadrature(cyclide: Cyclide, count: int) -> dict[str, float]:
    """Return area, volume, int H dA and int H^2 dA from x(u, v) alone.

    The points x(u, v) on a count x count grid are differentiated with the
    Fourier transform and summed by the trapezoidal rule, so nothing but the
    parametrization enters.  The grid is even in angles that crowd where D is
    small: tan(u/2) = w tan(s/2) with w^2 = b / (a + c), the same for v.
    """
    grid = 2.0 * np.pi * np.arange(count) / count
    width = np.sqrt(cyclide.b / (cyclide.a + cyclide.c))
    angle = 2.0 * np.arctan2(width * np.sin(0.5 * grid), np.cos(0.5 * grid))
    x = cyclide.position(*np.meshgrid(angle, angle, indexing="ij"))
    wave = np.fft.fftfreq(count, 1.0 / count)
    wave[count // 2] = 0.0

    def derive(f: Array, axis: int) -> Array:
        shape = [1, 1, 1]
        shape[axis] = count
        return np.fft.ifft(1j * wave.reshape(shape)
                           * np.fft.fft(f, axis=axis), axis=axis).real

    xs, xt = derive(x, 0), derive(x, 1)
    xss, xst, xtt = derive(xs, 0), derive(xs, 1), derive(xt, 1)
    cross = np.cross(xs, xt)
    # The normal is turned outwards, where the volume is positive.
    sign = np.sign(np.sum(x * cross))
    element = np.linalg.norm(cross, axis=-1)
    n = sign * cross / element[..., None]
    e, f, g = (np.sum(p * q, axis=-1) for p, q in
               ((xs, xs), (xs, xt), (xt, xt)))
    l, m, o = (-np.sum(p * n, axis=-1) for p in (xss, xst, xtt))
    mean = (l * g - 2.0 * m * f + o * e) / (2.0 * element ** 2)
    cell = (2.0 * np.pi / count) ** 2
    return {"area": float(element.sum() * cell),
            "volume": float(sign * np.sum(x * cross) * cell / 3.0),
            "mean": float(np.sum(mean * element) * cell),
            "willmore": float(np.sum(mean ** 2 * element) * cell)}


VOLUMES = [0.72, 0.75, 0.78, 0.81, 0.84, 0.87, 0.90, 0.93, 0.96, 0.98]
