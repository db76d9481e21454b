# SPDX-License-Identifier: GPL-3.0-or-later
"""Axisymmetric closed surfaces that are stationary for int (H - c0 / 2)^2 dA.

H is the mean of the two principal curvatures, so W = int H^2 dA = 4 pi for a
round sphere.  c0 is the spontaneous curvature of k1 + k2 (Helfrich), and with
M = int H dA the energy is F = W - c0 M + c0^2 A / 4.
Area is scaled to 4 pi and the reduced volume is v = 3 V / (4 pi).

The profile is described by arc length s = L t with t in [0, 1], running from
the lower pole (t = 0) to the upper pole (t = 1).  psi is the angle of the
tangent against the r axis, u = dpsi/ds is the meridional curvature, and
q = sin(psi) / r is the other principal curvature, positive for a sphere.
With the multipliers sigma (tension) and p (pressure) of

    delta (F + sigma A + p V) = 0,        hence  dF/dV = -p  at fixed area,

and the multiplier gamma of the constraint r' = cos(psi), the Lagrangian per
arc length, over pi, is

    L = r (u + q - c0)^2 / 2 + 2 sigma r + p r^2 sin(psi)
        + gamma (r' - cos(psi)).

Its equations by psi and r are those of Seifert, Berndl and Lipowsky (1991),

    psi'   = u
    u'     = (q - u) cos(psi) / r + gamma sin(psi) / r + p r cos(psi)
    r'     = cos(psi)
    gamma' = ((u - c0)^2 - q^2) / 2 + 2 sigma + 2 p r sin(psi),

(from d/ds [r (u + q - c0)] the c0 cos(psi) goes against that of dL/dpsi), with
the first integral

    E = r (u^2 - (q - c0)^2) / 2 - 2 sigma r - p r^2 sin(psi)
        + gamma cos(psi) = 0.

The boundary conditions are psi = r = gamma = 0 at the lower pole and
psi = pi, r = 0 at the upper pole; gamma = 0 there follows from E = 0.
Area, volume and one continuation condition fix L, p, sigma and v.

The system is solved by Gauss collocation on a graded mesh with a Newton
method.  Gauss points never coincide with a pole, so the removable
singularities of the right hand side are never evaluated.  The bounded
solutions are smooth at the poles: the only local solution excluded by
psi = r = gamma = 0 behaves like 1/s, and a logarithm would need a point
force, which the system does not contain.
"""
from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import SuperLU, splu

Array = NDArray[np.float64]

STAGES = 6
PSI, U, R, GAMMA = range(4)
LENGTH, PRESSURE, TENSION, VOLUME = range(4)
AREA = 4.0 * np.pi
SPHERE_VOLUME = 4.0 * np.pi / 3.0


def gauss_tableau(stages: int) -> tuple[Array, Array, Array]:
    """Return the Gauss collocation nodes, matrix and weights on [0, 1].

    Shapes: (m,), (m, m), (m,); all without unit.
    """
    x, w = np.polynomial.legendre.leggauss(stages)
    nodes, weights = 0.5 * (x + 1.0), 0.5 * w
    powers = np.arange(1, stages + 1)
    vandermonde = nodes[:, None] ** (powers - 1)
    integrals = nodes[:, None] ** powers / powers
    return nodes, integrals @ np.linalg.inv(vandermonde), weights


NODES, MATRIX, WEIGHTS = gauss_tableau(STAGES)


@dataclass(frozen=True)
class Shape:
    """A collocation solution (or a guess for one).

    mesh: (N + 1,) values of t, without unit.
    ends: (N + 1, 4) psi, u, r, gamma at the mesh points.
    stages: (N, m, 4) the same at the Gauss points.
    params: (4,) length L, pressure p, tension sigma, reduced volume v.
    residual: largest absolute residual of the discrete equations.
    spontaneous: c0, an inverse length.
    Lengths are in units where the area is 4 pi.
    """

    mesh: Array
    ends: Array
    stages: Array
    params: Array
    residual: float = np.inf
    spontaneous: float = 0.0

    @property
    def volume(self) -> float:
        """Reduced volume v."""
        return float(self.params[VOLUME])

    @property
    def step(self) -> Array:
        """Element widths in t, shape (N,)."""
        return np.diff(self.mesh)

    def vector(self) -> Array:
        """Return all unknowns in one vector, shape (4 N (m + 1) + 8,)."""
        body = np.concatenate([self.ends[:-1, None, :], self.stages], axis=1)
        return np.concatenate([body.ravel(), self.ends[-1], self.params])

    def with_vector(self, x: Array, residual: float = np.inf) -> Shape:
        """Return the shape on the same mesh with the unknowns x."""
        count = len(self.mesh) - 1
        body = x[:-8].reshape(count, STAGES + 1, 4)
        ends = np.concatenate([body[:, 0], x[None, -8:-4]])
        return replace(self, ends=ends, stages=body[:, 1:].copy(),
                       params=x[-4:].copy(), residual=residual)

    def integral(self, density: Array) -> float:
        """Integrate a density per arc length given at the stages, (N, m)."""
        return float(self.params[LENGTH]
                     * np.einsum("n,nm,m->", self.step, density, WEIGHTS))

    def curvatures(self) -> tuple[Array, Array]:
        """Return u and q at the stages, each (N, m), inverse lengths."""
        y = self.stages
        return y[..., U], np.sin(y[..., PSI]) / y[..., R]

    def willmore(self) -> float:
        """Return W = int H^2 dA."""
        u, q = self.curvatures()
        return self.integral(0.5 * np.pi * (u + q) ** 2 * self.stages[..., R])

    def energy(self) -> float:
        """Return F = int (H - c0 / 2)^2 dA."""
        u, q = self.curvatures()
        density = (u + q - self.spontaneous) ** 2 * self.stages[..., R]
        return self.integral(0.5 * np.pi * density)

    def total_mean_curvature(self) -> float:
        """Return int H dA, a length."""
        u, q = self.curvatures()
        return self.integral(np.pi * (u + q) * self.stages[..., R])

    def area(self) -> float:
        """Return the area by quadrature."""
        return self.integral(2.0 * np.pi * self.stages[..., R])

    def enclosed_volume(self) -> float:
        """Return the volume by quadrature."""
        y = self.stages
        return self.integral(np.pi * y[..., R] ** 2 * np.sin(y[..., PSI]))

    def first_integral(self) -> float:
        """Return the largest |E| over all mesh points (exactly 0 at t = 0).

        The poles have r = 0, where E reduces to gamma cos(psi).
        """
        _, p, sigma, _ = self.params
        psi, u, r, gamma = self.ends[1:-1].T
        q = np.sin(psi) / r
        energy = (0.5 * r * (u * u - (q - self.spontaneous) ** 2)
                  - 2.0 * sigma * r - p * r * r * np.sin(psi)
                  + gamma * np.cos(psi))
        return float(max(np.abs(energy).max(), abs(self.ends[-1, GAMMA])))

    def scaling_defect(self) -> float:
        """Return 2 sigma A + 3 p V - c0 M + c0^2 A / 2.

        It vanishes: W is scale-free, M is a length and A its square.
        """
        _, p, sigma, v = self.params
        c0 = self.spontaneous
        return float(2.0 * sigma * AREA + 3.0 * p * v * SPHERE_VOLUME
                     - c0 * self.total_mean_curvature()
                     + 0.5 * c0 * c0 * AREA)

    def profile(self) -> tuple[Array, Array, Array]:
        """Return t, r and z at the mesh points, each (N + 1,); z(0) = 0."""
        rise = np.einsum("n,nm,m->n", self.step,
                         np.sin(self.stages[..., PSI]), WEIGHTS)
        z = self.params[LENGTH] * np.concatenate([[0.0], np.cumsum(rise)])
        return self.mesh, self.ends[:, R], z

    def pole_gap(self) -> float:
        """Return z(upper pole) - z(lower pole); negative if they crossed."""
        return float(self.profile()[2][-1])

    def embedded(self) -> bool:
        """Return whether the polygon of the profile is free of crossings.

        Segments that share an end point are not compared.
        """
        _, r, z = self.profile()
        point = np.stack([r, z], axis=-1)
        a, d = point[:-1], np.diff(point, axis=0)
        cross = d[:, None, 0] * d[None, :, 1] - d[:, None, 1] * d[None, :, 0]
        gap = a[None, :, :] - a[:, None, :]
        with np.errstate(divide="ignore", invalid="ignore"):
            first = (gap[..., 0] * d[None, :, 1]
                     - gap[..., 1] * d[None, :, 0]) / cross
            second = (gap[..., 0] * d[:, None, 1]
                      - gap[..., 1] * d[:, None, 0]) / cross
        index = np.arange(len(a))
        distant = index[None, :] > index[:, None] + 1
        inside = (first >= 0) & (first <= 1) & (second >= 0) & (second <= 1)
        return not bool(np.any(inside & distant))

    def asymmetry(self) -> float:
        """Return psi - pi/2 half way along the profile (zero if symmetric)."""
        return float(self.evaluate(np.array([0.5]))[0, PSI] - 0.5 * np.pi)

    def evaluate(self, t: Array) -> Array:
        """Evaluate the collocation polynomials at t (k,), giving (k, 4)."""
        count = len(self.mesh) - 1
        index = np.clip(np.searchsorted(self.mesh, t, "right") - 1, 0,
                        count - 1)
        local = (t - self.mesh[index]) / self.step[index]
        points = np.concatenate([[0.0], NODES])
        values = np.concatenate([self.ends[:-1, None, :], self.stages], axis=1)
        basis = np.ones((len(t), STAGES + 1))
        for i in range(STAGES + 1):
            for j in range(STAGES + 1):
                if i != j:
                    basis[:, i] *= (local - points[j]) / (points[i] - points[j])
        return np.einsum("ki,kic->kc", basis, values[index])

    def remeshed(self, count: int) -> Shape:
        """Interpolate to a mesh of `count` elements graded by curvature.

        Half of the elements are spread by total curvature and half by arc
        length, in small pieces, so that necks receive enough elements.
        """
        fine = np.linspace(0.0, 1.0, 4001)
        middle = self.evaluate(0.5 * (fine[1:] + fine[:-1]))
        q = np.sin(middle[:, PSI]) / middle[:, R]
        bend = np.sqrt(middle[:, U] ** 2 + q * q)
        density = bend / bend.mean() + 1.0
        total = np.concatenate([[0.0], np.cumsum(density)])
        mesh = np.interp(np.linspace(0.0, total[-1], count + 1), total, fine)
        return self.on_mesh(mesh)

    def on_mesh(self, mesh: Array) -> Shape:
        """Interpolate to the given mesh, shape (K + 1,)."""
        gauss = mesh[:-1, None] + np.diff(mesh)[:, None] * NODES
        stages = self.evaluate(gauss.ravel()).reshape(*gauss.shape, 4)
        return Shape(mesh, self.evaluate(mesh), stages, self.params.copy(),
                     spontaneous=self.spontaneous)

    def refined(self) -> Shape:
        """Interpolate to the mesh with every element halved."""
        middle = 0.5 * (self.mesh[1:] + self.mesh[:-1])
        return self.on_mesh(np.sort(np.concatenate([self.mesh, middle])))


def right_hand_side(y: NDArray, length: complex, p: complex,
                    sigma: complex, spontaneous: float) -> NDArray:
    """Return dy/dt = L dy/ds for y (..., 4); accepts complex arguments."""
    psi, u, r, gamma = (y[..., i] for i in range(4))
    sin, cos = np.sin(psi), np.cos(psi)
    q = sin / r
    return length * np.stack([
        u,
        (q - u) * cos / r + gamma * q + p * r * cos,
        cos,
        0.5 * ((u - spontaneous) ** 2 - q * q) + 2.0 * sigma
        + 2.0 * p * r * sin], axis=-1)


@dataclass(frozen=True)
class Condition:
    """A linear closing condition row . x = value, with row like x."""

    row: Array
    value: float


def volume_condition(shape: Shape, v: float) -> Condition:
    """Return the condition that the reduced volume is v."""
    row = np.zeros(shape.vector().size)
    row[-4 + VOLUME] = 1.0
    return Condition(row, v)


def asymmetry_condition(shape: Shape, angle: float) -> Condition:
    """Return the condition psi(1/2) = pi/2 + angle.

    The mesh must contain t = 1/2 as a mesh point.
    """
    element = int(np.argmin(np.abs(shape.mesh - 0.5)))
    if shape.mesh[element] != 0.5:
        raise ValueError("the mesh has no point at t = 1/2")
    row = np.zeros(shape.vector().size)
    row[element * 4 * (STAGES + 1) + PSI] = 1.0
    return Condition(row, 0.5 * np.pi + angle)


def factorize(matrix: csc_matrix) -> SuperLU:
    """Factorize a Jacobian.

    The area and volume rows are dense, and the default column ordering of
    SuperLU would fill the factors; this ordering keeps them banded.
    """
    return splu(matrix, permc_spec="MMD_AT_PLUS_A")


def equations(shape: Shape, condition: Condition) -> tuple[Array, csc_matrix]:
    """Return the residual (M,) and Jacobian (M, M) of the discrete system."""
    count = len(shape.mesh) - 1
    width = 4 * (STAGES + 1)
    size = width * count + 8
    h = shape.step
    length, p, sigma, v = shape.params
    y = shape.stages

    c0 = shape.spontaneous
    slope = right_hand_side(y, length, p, sigma, c0)
    tiny = 1e-30
    jac = np.empty(y.shape + (4,))
    for c in range(4):
        z = y.astype(complex)
        z[..., c] += 1j * tiny
        jac[..., c] = right_hand_side(z, length, p, sigma, c0).imag / tiny
    jac_params = np.empty(y.shape + (3,))
    for c in range(3):
        args = [complex(a) for a in (length, p, sigma)]
        args[c] += 1j * tiny
        jac_params[..., c] = right_hand_side(y, *args, c0).imag / tiny

    # Row i < m of a block is Y_i - y - h sum_k a_ik f(Y_k); row m is the same
    # for the right end point with the weights b in place of a_i.
    table = np.concatenate([MATRIX, WEIGHTS[None, :]])
    targets = np.concatenate([y, shape.ends[1:, None, :]], axis=1)
    defect = (targets - shape.ends[:-1, None, :]
              - h[:, None, None] * np.einsum("ik,nkc->nic", table, slope))

    block = np.zeros((count, STAGES + 1, 4, STAGES + 2, 4))
    for c in range(4):
        block[:, :, c, 0, c] = -1.0
        for i in range(STAGES + 1):
            block[:, i, c, i + 1, c] = 1.0
    block[:, :, :, 1:STAGES + 1, :] -= np.einsum(
        "n,ik,nkcd->nickd", h, table, jac)
    params_block = -np.einsum("n,ik,nkcd->nicd", h, table, jac_params)

    start = width * np.arange(count)
    rows_local = np.arange(width)
    columns_local = np.arange(width + 4)
    shape_block = (count, width, width + 4)
    rows = [np.broadcast_to((start[:, None] + rows_local)[:, :, None],
                            shape_block).ravel()]
    columns = [np.broadcast_to((start[:, None] + columns_local)[:, None, :],
                               shape_block).ravel()]
    values = [block.reshape(-1)]
    shape_params = (count, width, 3)
    rows.append(np.broadcast_to((start[:, None] + rows_local)[:, :, None],
                                shape_params).ravel())
    columns.append(np.broadcast_to(size - 4 + np.arange(3),
                                   shape_params).ravel())
    values.append(params_block.reshape(-1))

    def put(row: int, column: NDArray | list[int], value: NDArray | list[float]
            ) -> None:
        column = np.asarray(column).ravel()
        rows.append(np.full(column.size, row))
        columns.append(column)
        values.append(np.asarray(value, dtype=float).ravel())

    base = width * count
    first, last = shape.ends[0], shape.ends[-1]
    boundary = [first[PSI], first[R], first[GAMMA], last[PSI] - np.pi, last[R]]
    for row, column in enumerate([PSI, R, GAMMA, base + PSI, base + R]):
        put(base + row, [column], [1.0])

    psi, r = y[..., PSI], y[..., R]
    weight = length * h[:, None] * WEIGHTS
    stage_columns = (start[:, None] + 4 + 4 * np.arange(STAGES))
    area, volume = shape.area(), shape.enclosed_volume()
    put(base + 5, stage_columns + R, 2.0 * np.pi * weight)
    put(base + 5, [size - 4 + LENGTH], [area / length])
    put(base + 6, stage_columns + R, 2.0 * np.pi * weight * r * np.sin(psi))
    put(base + 6, stage_columns + PSI, np.pi * weight * r * r * np.cos(psi))
    put(base + 6, [size - 4 + LENGTH, size - 4 + VOLUME],
        [volume / length, -SPHERE_VOLUME])
    nonzero = np.flatnonzero(condition.row)
    put(base + 7, nonzero, condition.row[nonzero])

    closing = [area - AREA, volume - v * SPHERE_VOLUME,
               condition.row @ shape.vector() - condition.value]
    residual = np.concatenate([defect.ravel(), boundary, closing])
    matrix = csc_matrix((np.concatenate(values),
                         (np.concatenate(rows), np.concatenate(columns))),
                        shape=(size, size))
    return residual, matrix


def solve(guess: Shape, condition: Condition, max_steps: int = 25) -> Shape:
    """Solve the discrete system with Newton's method from a guess.

    Raises RuntimeError when the iteration does not converge.
    """
    shape = guess
    best = np.inf
    stalled = 0
    for _ in range(max_steps):
        residual, matrix = equations(shape, condition)
        worst = float(np.abs(residual).max())
        shape = replace(shape, residual=worst)
        if not np.isfinite(worst) or worst > 1e6:
            raise RuntimeError("Newton iteration diverged")
        stalled = stalled + 1 if worst > 0.5 * best and worst < 1e-9 else 0
        if stalled >= 2 or worst < 3e-15:
            return shape
        best = min(best, worst)
        update = factorize(matrix).solve(residual)
        # A large first step is shortened; close to a solution it is full.
        damping = min(1.0, 1.0 / max(1e-30, float(np.abs(update[:-8]).max())))
        shape = shape.with_vector(shape.vector() - damping * update)
    raise RuntimeError(f"Newton iteration stopped at residual {worst:.1e}")
