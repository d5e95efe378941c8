"""Which side of a surface is free space: what two surfaces enclose is thin, what they leave free is wide.

Goes in: a sample of a surface with its normals. Comes out: a number from −1 (inside out) to 1.
"""

from __future__ import annotations

import numpy as np

from scenewidget.engine.mesh import FloatArray

__all__ = ["right_side_out"]

N_RAYS, N_TARGETS = 600, 6_000
THICK = 0.9  # metres; closets are wider, and what people own is mostly thinner
OPPOSITE = -0.5  # cosine of normals from which on two surfaces face each other, or lie back to back


def right_side_out(centers: FloatArray, normals: FloatArray, areas: FloatArray) -> float:
    """Evidence that normals point into free space, from −1 (inside out) to 1, 0 where nothing tells.

    From points of the surface one looks along the normal and against it for the nearest surface that faces
    the other way. Behind the right side that is the back of the same thing, near; before it, the opposite
    wall, far. In a room seen from inside, nothing at all lies behind the walls.

    Parameters
    ----------
    centers : (n, 3) float
        Metres.
    normals : (n, 3) float
        Unit, or zero.
    areas : (n,) float
        How much of the surface each stands for.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import sphere
    >>> ball = sphere(2)
    >>> shape = ball.face_centroids, ball.face_normals, ball.face_areas
    >>> right_side_out(0.1 * shape[0], shape[1], 0.01 * shape[2]) > 0.5  # a ball of 20 cm
    True
    """
    solid = np.flatnonzero((areas > 0) & (np.abs(normals).sum(axis=1) > 0.5))
    if len(solid) < 10:
        return 0.0
    rng = np.random.default_rng(0)
    chance = areas[solid] / areas[solid].sum()
    targets = rng.choice(solid, N_TARGETS, p=chance)
    starts = targets[:N_RAYS]
    patch = max(areas[solid].sum() / N_TARGETS, float(np.median(areas[targets])))
    reach = 1.2 * np.sqrt(patch)  # at which the targets leave no holes
    before, behind = _nearest_facing(centers[targets], normals[targets], len(starts), reach)
    near, far = np.minimum(before, behind), np.maximum(before, behind)
    says = np.isfinite(near)
    is_before_near = before < behind
    # one hit: thin things lie behind, rooms before; two: what is nearer is the thing itself
    is_right = np.where(np.isfinite(far), ~is_before_near, (near > THICK) == is_before_near)
    return float(np.where(is_right, 1.0, -1.0)[says].sum() / len(starts))


def _nearest_facing(
    centers: FloatArray, normals: FloatArray, n_starts: int, reach: float
) -> tuple[FloatArray, FloatArray]:
    """How far before and behind each of the first points the nearest one lies that faces the other way.

    In arrays though it is a loop, for the first frame of the widget waits for it, and not for a compiler.
    """
    before, behind = np.full((2, n_starts), np.inf)
    (x, y, z), (u, v, w) = np.ascontiguousarray(centers.T), np.ascontiguousarray(normals.T)
    for i in range(n_starts):
        a, b, c = u[i], v[i], w[i]
        other = np.flatnonzero(a * u + b * v + c * w < OPPOSITE)
        aside, up, along = x[other] - x[i], y[other] - y[i], z[other] - z[i]
        depth = aside * a + up * b + along * c
        depth = depth[aside * aside + up * up + along * along - depth * depth < reach * reach]
        before[i] = depth[depth > 0.2 * reach].min(initial=np.inf)
        behind[i] = (-depth[depth < -0.2 * reach]).min(initial=np.inf)
    return before, behind
