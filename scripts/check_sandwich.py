#!/usr/bin/env python3
"""Holds the covariances of `calibstab refine`, plain and clustered by image, for every loss, against numpy on pycolmap's pixels.

Usage: check_sandwich.py CALIBSTAB MODEL... [--at-least COMPARISONS]

The model as calibstab refined it is read by pycolmap; J is made of fourth-order differences of its projections, whole and sparse.
psi = rho' r, W = d psi / d r, points and poses eliminated: Sigma = |psi|^2 / (2N - rank) B L B with L from J^T J, B from J^T W J,
and the clustered B (sum s s^T) B times what makes its mean ratio to the plain one 1 for independent noise (src/bundle/clustered.rs). Both
must agree to 1e-6 of the stds. The rank is 6 images + 3 points +
parameters - 7. Where a loss is straight calibstab keeps a thousandth of the weight along the residual, and where Cauchy's leaves a
point no minimum it takes the curvature of that point for positive; so does this.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pycolmap
import scipy.sparse as sp
from crosscheck import delete_unprojectable, unprojectable

# rho', rho'' of s = |r|^2 at a scale of 1 px.
LOSSES = {
    "squared": lambda s: (np.ones_like(s), np.zeros_like(s)),
    "huber:1": lambda s: (np.where(s > 1, s**-0.5, 1), np.where(s > 1, -0.5 * s**-1.5, 0)),
    "soft-l1:1": lambda s: ((1 + s) ** -0.5, -0.5 * (1 + s) ** -1.5),
    "cauchy:1": lambda s: (1 / (1 + s), -1 / (1 + s) ** 2),
}
STRAIGHT, MADE_POSITIVE = 1e-3, 0.3
CLOSE = 1e-6


def differences(function, step):
    """d function / d its argument at 0, to the fourth order."""
    return (8 * (function(step) - function(-step)) - (function(2 * step) - function(-2 * step))) / (12 * step)


def jacobian(model, free):
    """Residuals (N, 2), images (N), and J's columns of poses, intrinsics `free` (camera, place), points, in a scene of size 1."""
    images = {id: at for at, id in enumerate(sorted(model.reg_image_ids()))}
    points = {id: at for at, id in enumerate(sorted(model.points3D))}
    tracks = [(e.image_id, e.point2D_idx, p) for p in points for e in model.points3D[p].track.elements]
    tracks.sort()
    r, own, parts = np.zeros((len(tracks), 2)), np.array([images[i] for i, _, _ in tracks]), []
    for id, at in images.items():
        rows = np.flatnonzero(own == at)
        image, seen = model.images[id], [tracks[row] for row in rows]
        pose, camera = image.cam_from_world().matrix(), model.cameras[image.camera_id]
        X = np.array([model.points3D[p].xyz for _, _, p in seen]) @ pose[:, :3].T + pose[:, 3]
        r[rows] = camera.img_from_cam(X) - [image.points2D[k].xy for _, k, _ in seen]
        size = np.linalg.norm(X, axis=1)[:, None]
        # (n, pixel, axis), by a share of the distance: rounding and the unit of the scene do no harm.
        D = np.stack([differences(lambda h: camera.img_from_cam(X + h * size * np.eye(3)[k]), 1e-3) / size for k in range(3)], 2)
        cross = np.zeros((len(rows), 3, 3))
        for a, b, c in [(0, 1, 2), (1, 2, 0), (2, 0, 1)]:
            cross[:, b, a], cross[:, a, b] = X[:, c], -X[:, c]
        parts.append((rows, 6 * at + np.tile(np.arange(6), (len(rows), 1)), np.concatenate([-D @ cross, D], 2)))
        start = 6 * len(images)
        for column, (camera_id, place) in enumerate(free):
            if camera_id == image.camera_id:
                params = camera.params.copy()

                def moved(h):
                    camera.params = params + h * np.eye(len(params))[place]
                    return camera.img_from_cam(X)

                by_param = differences(moved, 1e-3 * max(1e-1, abs(params[place])))[:, :, None]
                camera.params = params
                parts.append((rows, np.full((len(rows), 1), start + column), by_param))
        where = start + len(free) + 3 * np.array([points[p] for _, _, p in seen])[:, None] + np.arange(3)
        parts.append((rows, where, D @ pose[:, :3]))
    width = 6 * len(images) + len(free) + 3 * len(points)
    J = sp.csr_matrix((2 * len(tracks), width))
    for rows, columns, values in parts:
        at = np.broadcast_to((2 * rows[:, None] + np.arange(2))[:, :, None], values.shape)
        where = np.broadcast_to(columns[:, None, :], values.shape)
        J = J + sp.csr_matrix((values.ravel(), (at.ravel(), where.ravel())), J.shape)
    return r, own, J, (len(images), len(points))


def blocks(values):
    """A block diagonal matrix of (n, k, k)."""
    n, k, _ = values.shape
    return sp.bsr_matrix((values, np.arange(n), np.arange(n + 1)), (n * k, n * k)).tocsr()


def of_points(J, W, counts, free):
    """J's columns of points, and each point's own block."""
    B = J[:, 6 * counts[0] + free :].tocsr()
    V, first = (B.T @ W @ B).tocsr(), 3 * np.arange(counts[1])
    return B, np.stack([np.stack([np.asarray(V[first + k, first + l]).ravel() for l in range(3)], 1) for k in range(3)], 1)


def projected(J, W, counts, free, held):
    """The intrinsics' columns after poses and points are projected out in W, and their own."""
    A, own = J[:, np.setdiff1d(np.arange(6 * counts[0]), held)], J[:, 6 * counts[0] : 6 * counts[0] + free]
    B, square = of_points(J, W, counts, free)
    inverse = blocks(np.linalg.inv(square))
    A, T = [M - B @ (inverse @ (B.T @ (W @ M))) for M in (A, own)]
    A, T = A @ sp.diags(1 / np.sqrt(np.asarray(A.multiply(A).sum(axis=0)).ravel())), T.toarray()
    return T - A @ np.linalg.solve((A.T @ (W @ A)).toarray(), A.T @ (W @ T)), own.toarray()


def sandwiches(model, loss, free):
    """The plain covariance, and the clustered one of any camera's parameters."""
    r, image, J, counts = jacobian(model, free)
    s = (r**2).sum(axis=1)
    slope, curvature = LOSSES[loss](s)
    along = 1 + 2 * s * curvature / slope
    # Convex losses: no less than a thousandth; Cauchy's: no nearer to zero.
    along = np.where(abs(along) > STRAIGHT, along, STRAIGHT) if loss.startswith("cauchy") else np.maximum(along, STRAIGHT)
    unit = r / np.sqrt(s)[:, None]
    weights = lambda along: blocks(slope[:, None, None] * (np.eye(2) + (along - 1)[:, None, None] * unit[:, :, None] * unit[:, None, :]))
    W = weights(along)
    B, square = of_points(J, W, counts, len(free))
    bent_down = np.linalg.eigvalsh(square)[:, 0] <= 1e-10 * np.trace(square, axis1=1, axis2=2)
    of_bent = (abs(B) @ np.repeat(bent_down, 3)).reshape(-1, 2).any(axis=1)
    W = weights(np.where(of_bent, np.maximum(abs(along), MADE_POSITIVE), along))
    psi = (slope[:, None] * r).ravel()
    far = 6 * int(np.argmax(np.bincount(image)[1:]) + 1)
    # Seven coordinates of two images, whichever: the last image's distance from the first is held by its largest part.
    baseline = model.images[sorted(model.reg_image_ids())[far // 6]].cam_from_world() * model.images[sorted(model.reg_image_ids())[0]].projection_center()
    held = [*range(6), far + 3 + int(np.argmax(abs(baseline)))]
    efficient, own = projected(J, sp.identity(2 * len(r), format="csr"), counts, len(free), held)
    bent, _ = projected(J, W, counts, len(free), held)
    bread = np.linalg.inv(own.T @ (W @ bent))
    freedom = 2 * len(r) - (6 * counts[0] + 3 * counts[1] + len(free) - 7)
    plain = bread @ (own.T @ efficient) @ bread * (psi @ psi) / freedom
    B, square = of_points(J, sp.identity(2 * len(r), format="csr"), counts, len(free))
    solved, B = B @ blocks(np.linalg.inv(square)), B.tocsr()
    of_pair = lambda a, b: np.asarray(solved[a::2].multiply(B[b::2]).sum(axis=1)).ravel()
    left = np.eye(2) - np.stack([np.stack([of_pair(a, b) for b in range(2)], 1) for a in range(2)], 1)

    def clustered(rows):
        """Of these parameters, those of one camera."""
        moved = (efficient @ bread[:, rows]).reshape(-1, 2, len(rows))
        scores = np.zeros((counts[0], len(rows)))
        np.add.at(scores, image, (moved * psi.reshape(-1, 2, 1)).sum(axis=1))
        shares = np.zeros((counts[0], len(rows), len(rows)))
        np.add.at(shares, image, np.einsum("nai,nab,nbj->nij", moved, left, moved))
        shares = np.linalg.solve(plain[np.ix_(rows, rows)] * freedom / (psi @ psi), shares)
        kept = np.einsum("gii->", shares) / len(rows)
        equal = np.einsum("gij,gji->", shares, shares) / len(rows) / kept**2
        return scores.T @ scores / (kept * (1 - equal)) * np.einsum("naa->", left) / freedom

    return plain, clustered


def check(calibstab, path, loss, scratch):
    """How far each comparison is off, by name."""
    start = pycolmap.Reconstruction(str(path))
    delete_unprojectable(start, unprojectable(start))
    (scratch / "start").mkdir(exist_ok=True)
    start.write_binary(scratch / "start")
    command = [calibstab, "refine", scratch / "start", "--out", scratch / "out", "--refine", "all", "--loss", loss, "--quiet", "--json"]
    said = json.loads(subprocess.run(list(map(str, command)), check=True, capture_output=True, text=True).stdout)
    if said["dropped"]["unprojectable"] or said["covariance"]["matrix"] is None:
        return {}
    model, params = pycolmap.Reconstruction(str(scratch / "out")), said["covariance"]["params"]
    places = [model.cameras[p["camera"]].params_info.split(", ").index(p["name"]) for p in params]
    plain, clustered = sandwiches(model, loss, [(p["camera"], at) for p, at in zip(params, places)])
    std = np.sqrt(np.diag(plain))
    found = {"plain": abs(said["covariance"]["matrix"] - plain) / np.outer(std, std)}
    for one in said["covariance"]["clustered"]:
        rows = [at for at, p in enumerate(params) if p["camera"] == one["camera"]]
        want, own = clustered(rows), std[rows]
        found[f"camera {one['camera']} clustered"] = abs(one["matrix"] - want) / np.outer(own, own)
        ratio = np.trace(np.linalg.solve(plain[np.ix_(rows, rows)], want)) / len(rows)
        found[f"camera {one['camera']} ratio {one['ratio']:.3f}"] = np.array(abs(one["ratio"] / ratio - 1))
    return {name: off.max() for name, off in found.items()}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("calibstab", type=lambda path: Path(path).resolve())
    parser.add_argument("models", nargs="+", type=Path)
    parser.add_argument("--at-least", type=int, default=1, help="fewer comparisons than these are a fault")
    given, count, faults = parser.parse_args(), 0, 0
    for path in given.models:
        for loss in LOSSES:
            with tempfile.TemporaryDirectory() as scratch:
                for name, off in check(given.calibstab, path, loss, Path(scratch)).items():
                    count, faults = count + 1, faults + (not off <= CLOSE)
                    print(f"{'ok   ' if off <= CLOSE else 'FAULT'} {path} {loss}: {name} within {off:.1e}")
    print(f"{count} comparisons, {faults} faults")
    sys.exit(faults > 0 or count < given.at_least)


if __name__ == "__main__":
    main()
