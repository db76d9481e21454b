# SPDX-License-Identifier: GPL-3.0-or-later
"""Curvature energies by the definition, and their integrals over a cage's surface: the tests' slow, plain oracle.

Pointwise there are two routes, neither of which forms the covariant derivative of h from Christoffel symbols:

- `principal_route`: H and K as functions of (u, v) in dual numbers, so their gradients come with them; k1, k2 as roots
  of the characteristic polynomial, their directions as eigenvectors of the shape operator, and the derivatives of
  k1, k2 along those directions. This is the report's definition taken literally. It fails at umbilics.
- `monge_route`: the surface rewritten as a height z(x, y) over its tangent plane to third order. There the second
  and third derivatives of z are h and grad h, at umbilics too.

The surface is `ccref`'s deeply refined mesh, one bicubic patch a face, with faces at extraordinary vertices refined
again and again; integrals are tensor Gauss rules on all of those patches.
"""
from __future__ import annotations

from typing import Iterator, NamedTuple

import numpy as np

from ccref import (JET_ORDERS, Mesh, patch_jets, patch_points, refine, regular_faces, restrict, topology,
                   vertex_limit)

TERMS = ("willmore", "mvs", "mvs_cross", "variation", "mehlum_tarrou")


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a * b).sum(axis=-1)


class Dual:
    """A value with its derivatives along u and v."""

    def __init__(self, f, fu, fv):
        self.f, self.fu, self.fv = f, fu, fv

    def __add__(self, o):
        return Dual(self.f + o.f, self.fu + o.fu, self.fv + o.fv)

    def __sub__(self, o):
        return Dual(self.f - o.f, self.fu - o.fu, self.fv - o.fv)

    def __mul__(self, o):
        if not isinstance(o, Dual):
            return Dual(self.f * o, self.fu * o, self.fv * o)
        return Dual(self.f * o.f, self.fu * o.f + self.f * o.fu, self.fv * o.f + self.f * o.fv)

    __rmul__ = __mul__

    def __truediv__(self, o):
        q = self.f / o.f
        return Dual(q, (self.fu - q * o.fu) / o.f, (self.fv - q * o.fv) / o.f)

    def power(self, p: float) -> "Dual":
        """self ** p."""
        d = p * self.f ** (p - 1)
        return Dual(self.f ** p, d * self.fu, d * self.fv)


class Principal(NamedTuple):
    """Principal curvatures, their directions in the (u, v) plane, derivatives d[i, j] = dk_i / de_j, area density."""

    k: np.ndarray
    directions: np.ndarray
    d: np.ndarray
    area: np.ndarray


def forms(jets: np.ndarray) -> tuple[Dual, ...]:
    """E, F, G and the determinants [Suu,Su,Sv], [Suv,Su,Sv], [Svv,Su,Sv], each with first derivatives."""
    s, su, sv, suu, suv, svv, suuu, suuv, suvv, svvv = np.moveaxis(jets, -2, 0)
    du = {"u": (su, suu, suv), "v": (sv, suv, svv),
          "uu": (suu, suuu, suuv), "uv": (suv, suuv, suvv), "vv": (svv, suvv, svvv)}

    def dot(a, b):
        (p, pu, pv), (q, qu, qv) = du[a], du[b]
        return Dual(_dot(p, q), _dot(pu, q) + _dot(p, qu), _dot(pv, q) + _dot(p, qv))

    def det(a):
        (p, pu, pv), (q, qu, qv), (r, ru, rv) = du[a], du["u"], du["v"]
        triple = lambda x, y, z: _dot(x, np.cross(y, z))
        return Dual(triple(p, q, r), triple(pu, q, r) + triple(p, qu, r) + triple(p, q, ru),
                    triple(pv, q, r) + triple(p, qv, r) + triple(p, q, rv))

    return dot("u", "u"), dot("u", "v"), dot("v", "v"), det("uu"), det("uv"), det("vv")


def principal_route(jets: np.ndarray) -> Principal:
    """k1 >= k2 and their derivatives along the principal directions, from jets [..., 10, 3]."""
    e, f, g, l, m, n = forms(jets)
    w = e * g - f * f
    h = (e * n - f * m * 2.0 + g * l) / (w.power(1.5) * 2.0)
    k = (l * n - m * m) / (w * w)
    disc = h * h - k
    disc.f = np.maximum(disc.f, 1e-300)
    root = disc.power(0.5)
    curvatures = (h + root, h - root)
    size = np.sqrt(w.f)
    second = np.stack([np.stack([l.f, m.f], -1), np.stack([m.f, n.f], -1)], -2) / size[..., None, None]
    first = np.stack([np.stack([e.f, f.f], -1), np.stack([f.f, g.f], -1)], -2)
    directions = []
    for c in curvatures:
        a = second - c.f[..., None, None] * first  # its kernel is the principal direction
        one = np.stack([-a[..., 0, 1], a[..., 0, 0]], -1)
        two = np.stack([-a[..., 1, 1], a[..., 1, 0]], -1)
        t = np.where(((one ** 2).sum(-1) > (two ** 2).sum(-1))[..., None], one, two)
        length = np.sqrt((t[..., None, :] * first * t[..., :, None]).sum((-2, -1)))
        directions.append(t / length[..., None])
    d = np.stack([np.stack([c.fu * t[..., 0] + c.fv * t[..., 1] for t in directions], -1) for c in curvatures], -2)
    return Principal(np.stack([c.f for c in curvatures], -1), np.stack(directions, -2), d, size)


def monge_route(jets: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Second [..., 3] (xx, xy, yy) and third [..., 4] derivatives of the height over the tangent plane, area density.

    x(u, v) and z(u, v) are Taylor polynomials; u(x) is inverted to second order and put into z.
    """
    su, sv = jets[..., 1, :], jets[..., 2, :]
    normal = np.cross(su, sv)
    area = np.sqrt(_dot(normal, normal))
    normal = normal / area[..., None]
    e1 = su / np.sqrt(_dot(su, su))[..., None]
    e2 = np.cross(normal, e1)
    both = (0, 1)
    second = np.stack([np.stack([jets[..., 3 + a + b, :] for b in both], -2) for a in both], -3)
    third = np.stack([np.stack([np.stack([jets[..., 6 + a + b + c, :] for c in both], -2) for b in both], -3)
                      for a in both], -4)
    jacobian = np.stack([np.stack([_dot(su, e), _dot(sv, e)], -1) for e in (e1, e2)], -2)  # dx_a / du_i
    inverse = np.linalg.inv(jacobian.astype(float)).astype(jets.dtype)
    inverse = 2 * inverse - inverse @ jacobian @ inverse  # back to the precision of the jets
    x2 = np.stack([(second * e[..., None, None, :]).sum(-1) for e in (e1, e2)], -3)  # d2 x_a / du_i du_j
    z2 = (second * normal[..., None, None, :]).sum(-1)
    z3 = (third * normal[..., None, None, None, :]).sum(-1)
    turned = np.swapaxes(inverse, -1, -2)
    both = turned[..., None, :, :] @ x2 @ inverse[..., None, :, :]  # d2 x_a along the new coordinates
    u2 = -(inverse @ both.reshape(both.shape[:-2] + (4,))).reshape(both.shape)  # d2 u_k / dx_b dx_c
    zxx = turned @ z2 @ inverse
    mixed = ((turned @ z2) @ u2.reshape(u2.shape[:-2] + (4,))).reshape(u2.shape)  # [c, a, b] = z_ij u^j_c u^i_ab
    mixed = np.moveaxis(mixed, -3, -1)
    along = turned[..., None, :, :] @ z3 @ inverse[..., None, :, :]  # [i, b, c]
    zxxx = ((turned @ along.reshape(along.shape[:-2] + (4,))).reshape(along.shape) + mixed
            + np.moveaxis(mixed, -1, -2) + np.moveaxis(mixed, -1, -3))
    return (np.stack([zxx[..., 0, 0], zxx[..., 0, 1], zxx[..., 1, 1]], -1),
            np.stack([zxxx[..., 0, 0, 0], zxxx[..., 0, 0, 1], zxxx[..., 0, 1, 1], zxxx[..., 1, 1, 1]], -1), area)


def second_order(jets: np.ndarray) -> dict[str, np.ndarray]:
    """Integrands (per area) that need second derivatives alone, by the classical formulas for H and K."""
    su, sv = jets[..., 1, :], jets[..., 2, :]
    e, f, g = _dot(su, su), _dot(su, sv), _dot(sv, sv)
    normal = np.cross(su, sv)
    size = np.sqrt(_dot(normal, normal))
    l, m, n = (_dot(jets[..., i, :], normal) / size for i in (3, 4, 5))
    h, k = (e * n - 2 * f * m + g * l) / (2 * size ** 2), (l * n - m * m) / size ** 2
    return {"willmore": 4 * h * h - 2 * k, "gauss": k, "h2": h * h, "area": size}


def densities(jets: np.ndarray) -> dict[str, np.ndarray]:
    """Integrands (per area) of all terms, with `area`, `gauss` and `h2`."""
    p = principal_route(jets)
    z2, z3, area = monge_route(jets)
    theta = np.arange(8) * np.pi / 4  # exact for the trigonometric polynomial of degree 6
    c, s = np.cos(theta), np.sin(theta)
    along = z3[..., :1] * c ** 3 + 3 * z3[..., 1:2] * c * c * s + 3 * z3[..., 2:3] * c * s * s + z3[..., 3:] * s ** 3
    return {
        "willmore": z2[..., 0] ** 2 + 2 * z2[..., 1] ** 2 + z2[..., 2] ** 2,
        "mvs": p.d[..., 0, 0] ** 2 + p.d[..., 1, 1] ** 2,
        "mvs_cross": (p.d ** 2).sum((-2, -1)),
        "variation": z3[..., 0] ** 2 + 3 * z3[..., 1] ** 2 + 3 * z3[..., 2] ** 2 + z3[..., 3] ** 2,
        "mehlum_tarrou": 2 * (along ** 2).mean(axis=-1),
        "gauss": p.k[..., 0] * p.k[..., 1],
        "h2": (p.k.sum(-1) / 2) ** 2,
        "area": area,
    }


# --------------------------------------------------------------------------------- the report's blend, `plane` --

def _series_exp(a: np.ndarray) -> np.ndarray:
    """exp of Taylor coefficients [4, n]."""
    e = np.exp(a[0])
    return np.stack([e, e * a[1], e * (a[2] + a[1] ** 2 / 2), e * (a[3] + a[1] * a[2] + a[1] ** 3 / 6)])


def _series_reciprocal(a: np.ndarray) -> np.ndarray:
    out = [1 / a[0]]
    for k in range(1, 4):
        out.append(-sum(a[j] * out[k - j] for j in range(1, k + 1)) / a[0])
    return np.stack(out)


def _series_product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.stack([sum(a[j] * b[k - j] for j in range(k + 1)) for k in range(4)])


def blend_weight(t: np.ndarray) -> np.ndarray:
    """w, w', w'', w''' [4, n] of w = h(t) / (h(t) + h(1 - t)), h(t) = exp(2 exp(-1/t) / (t - 1)), for 0 < t < 1."""
    t = np.asarray(t)
    one, zero = np.ones_like(t), np.zeros_like(t)

    def h(start, slope):
        x = np.stack([start, slope * one, zero, zero])
        y = x.copy()
        y[0] = y[0] - 1
        return _series_exp(2 * _series_product(_series_exp(-_series_reciprocal(x)), _series_reciprocal(y)))

    a, b = h(t, 1), h(1 - t, -1)
    w = _series_product(a, _series_reciprocal(a + b))
    return w * np.array([1, 1, 2, 6], t.dtype)[:, None]


def blend_to_plane(jets: np.ndarray, u: np.ndarray, v: np.ndarray, corner: np.ndarray, limit: np.ndarray,
                   normal: np.ndarray) -> np.ndarray:
    """Jets of S - w(u) w(v) ((S - V) . n) n, with (u, v) counted from `corner` of the face; V, n per point."""
    flip_u, flip_v = (corner == 1) | (corner == 2), corner >= 2
    sign_u, sign_v = np.where(flip_u, -1, 1), np.where(flip_v, -1, 1)
    wu, wv = blend_weight(np.where(flip_u, 1 - u, u)), blend_weight(np.where(flip_v, 1 - v, v))
    height = (jets * normal[:, None, :]).sum(-1)
    height[:, 0] -= _dot(limit, normal)
    at = {order: i for i, order in enumerate(JET_ORDERS)}
    binomial = [[1], [1, 1], [1, 2, 1], [1, 3, 3, 1]]
    out = jets.copy()
    for i, (p, q) in enumerate(JET_ORDERS):
        total = np.zeros_like(height[:, 0])
        for a in range(p + 1):
            for b in range(q + 1):
                weight = wu[a] * sign_u ** a * wv[b] * sign_v ** b
                total = total + binomial[p][a] * binomial[q][b] * weight * height[:, at[(p - a, q - b)]]
        out[:, i] -= total[:, None] * normal
    return out


class Blend:
    """Extraordinary corner, limit position and normal of every face of an all-quad cage."""

    def __init__(self, mesh: Mesh):
        topo = topology(mesh)
        if (mesh.sizes != 4).any():
            raise ValueError("the cage is not all quads")
        odd = np.bincount(mesh.flat, minlength=mesh.n_vertices) != 4
        corners = odd[mesh.flat.reshape(-1, 4)]
        if (corners.sum(axis=1) > 1).any():
            raise ValueError("a face has two extraordinary corners")
        self.corner = np.where(corners.any(axis=1), corners.argmax(axis=1), -1)
        self.limit = np.zeros((mesh.n_faces, 3), mesh.xyz.dtype)
        self.normal = np.zeros((mesh.n_faces, 3), mesh.xyz.dtype)
        at = mesh.flat.reshape(-1, 4)[np.arange(mesh.n_faces), np.maximum(self.corner, 0)]
        for vertex in np.flatnonzero(odd):
            limit, normal = vertex_limit(mesh, topo, int(vertex))
            here = (at == vertex) & (self.corner >= 0)
            self.limit[here], self.normal[here] = limit, normal

    def apply(self, jets: np.ndarray, face: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Blend the jets of points (face, u, v) of the cage."""
        at = np.flatnonzero(self.corner[face] >= 0)
        out = jets.copy()
        if len(at):
            f = face[at]
            out[at] = blend_to_plane(jets[at], u[at], v[at], self.corner[f], self.limit[f], self.normal[f])
        return out


# ------------------------------------------------------------------------------------------------ integration --

def gauss_rule(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights on 0..1."""
    x, w = np.polynomial.legendre.leggauss(n)
    return (x + 1) / 2, w / 2


def samples(mesh: Mesh, n_gauss: int, levels: int, depth: int, recentre: bool = True,
            chunk: int = 2000) -> Iterator[tuple]:
    """(face, u, v, weight, jets) over the whole limit surface of an all-quad cage, in the cage faces' coordinates.

    Regular faces are split `levels` times before the rule; faces at extraordinary vertices `depth` times towards them,
    and what is left there is dropped. With `recentre` positions are relative to the extraordinary vertex from level
    RECENTRE_LEVEL on (derivatives are not concerned).
    """
    real = mesh.xyz.dtype.type
    x, w = (a.astype(mesh.xyz.dtype) for a in gauss_rule(n_gauss))
    gu, gv = (a.ravel() for a in np.meshgrid(x, x, indexing="ij"))
    gw = np.outer(w, w).ravel()
    face, origin, size = np.arange(mesh.n_faces), np.zeros((mesh.n_faces, 2), mesh.xyz.dtype), real(1)
    offset = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], mesh.xyz.dtype)
    wanted = np.ones(mesh.n_faces, bool)
    for level in range(depth + 1):
        topo = topology(mesh)
        good = regular_faces(mesh, topo) & wanted
        if level >= levels:
            flat = np.flatnonzero(good)
            for part in np.array_split(flat, max(1, -(-len(flat) * len(gw) // (chunk * 36)))):
                if len(part) == 0:
                    continue
                points = np.repeat(patch_points(mesh, topo, part), len(gw), axis=0)
                u, v = np.tile(gu, len(part)), np.tile(gv, len(part))
                where = np.repeat(origin[part], len(gw), axis=0) + size * np.stack([u, v], axis=1)
                yield (np.repeat(face[part], len(gw)), where[:, 0], where[:, 1], np.tile(gw, len(part)) * size * size,
                       patch_jets(points, u, v, 1 / size))
            wanted = wanted & ~good
        if level == depth or not wanted.any():
            return
        mesh, new_face = restrict(mesh, np.flatnonzero(wanted))
        kept = np.flatnonzero(new_face >= 0)
        face, origin, wanted = face[kept], origin[kept], wanted[kept]
        if recentre and level >= RECENTRE_LEVEL:
            mesh = _recentre(mesh, wanted)
        mesh = refine(mesh)
        size = size / 2
        face, wanted = np.repeat(face, 4), np.repeat(wanted, 4)
        origin = np.repeat(origin, 4, axis=0) + size * np.tile(offset, (len(kept), 1))


RECENTRE_LEVEL = 12


def _recentre(mesh: Mesh, wanted: np.ndarray) -> Mesh:
    """Move every extraordinary vertex, with the faces around it, to the origin: else rounding eats the small faces."""
    odd = np.bincount(mesh.flat, minlength=mesh.n_vertices)
    quads = mesh.flat.reshape(-1, 4)
    corners = quads[wanted]
    centre = corners[np.arange(len(corners)), (odd[corners] != 4).argmax(axis=1)]
    owner = np.full(mesh.n_vertices, -1)
    owner[corners.ravel()] = np.repeat(centre, 4)
    owner[quads.ravel()] = np.maximum(owner[quads.ravel()], np.repeat(owner[quads].max(axis=1), 4))
    return mesh.with_xyz(mesh.xyz - mesh.xyz[owner])


def energies(mesh: Mesh, surface: str = "limit", n_gauss: int = 6, levels: int = 1, depth: int = 40,
             dtype=np.float64) -> dict[str, float]:
    """All terms of a closed cage; third-order ones times the area. `plane` needs quads, extraordinary vertices apart.

    On `limit` with an extraordinary vertex the third-order terms do not exist and are left out. On `plane` a depth of
    24 leaves 1e-10 of the area; curvature vanishes long before.
    """
    if (mesh.sizes != 4).any():
        mesh = refine(mesh)
    mesh = mesh.with_xyz(mesh.xyz.astype(dtype))
    blend = Blend(mesh) if surface == "plane" else None
    third = blend is not None or bool((np.bincount(mesh.flat, minlength=mesh.n_vertices) == 4).all())
    total: dict[str, float] = {}
    for face, u, v, weight, jets in samples(mesh, n_gauss, levels, depth, blend is None):
        if blend:
            jets = blend.apply(jets, face, u, v)
        density = (densities if third else second_order)(jets.astype(float))
        area = density.pop("area") * weight.astype(float)
        total["area"] = total.get("area", 0.0) + float(area.sum())
        for name, value in density.items():
            total[name] = total.get(name, 0.0) + float((value * area).sum())
    for name in TERMS[1:] if third else ():
        total[name] *= total["area"]
    return total
