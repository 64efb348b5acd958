#!/usr/bin/env python3
"""Compares the spreads that calibstab finds with those of scipy, on pycolmap's rays.

Usage: check_spread.py CALIBSTAB PATH [PATH ...] [--at-least N]

For each PATH it runs `CALIBSTAB analyze PATH --out FOLDER --format json`, and computes every spread in the result anew: the cells
are taken from it, the cameras from the
files. Rays are pycolmap's; scipy.optimize.least_squares finds the rotations, and for each of its trials the rays are settled cell
by cell. The shared fraction is counted by pairs of runs. Exit 1 when anything differs, or fewer than N values were compared.

Tolerances: pycolmap unprojects by an iteration that ends within 1e-6 px or so, and scipy ends where its own steps become small:
1e-5 of the spread, and 1e-5 px besides.
"""

import argparse
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pycolmap
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

MOST_RUNS = 8  # of a population: scipy is slow


def centres(population, cells):
    columns, rows = population["spread"]["columns"], population["spread"]["rows"]
    cells = np.array(cells)
    size = np.array([population["width"], population["height"]])
    at = np.stack([cells % columns, cells // columns], axis=1) + 0.5
    return at * size / np.array([columns, rows])


def cameras_of(population):
    """Each sample of the population as pycolmap's camera, by (run, camera_id)."""
    params = {}
    for parameter in population["parameters"]:
        for sample in parameter["samples"]:
            if sample["value"] is not None:
                params.setdefault((sample["run"], sample["camera_id"]), []).append(sample["value"])
    make = lambda p: pycolmap.Camera(model=population["model"], width=population["width"], height=population["height"], params=p)
    return {key: make(values) for key, values in params.items()}


def across(rays):
    """Two unit vectors across each ray."""
    axis = np.eye(3)[np.argmin(np.abs(rays), axis=1)]
    one = np.cross(rays, axis)
    one /= np.linalg.norm(one, axis=1, keepdims=True)
    return np.stack([one, np.cross(rays, one)], axis=1)


def rays_of(camera, pixels):
    plane = camera.cam_from_img(pixels)
    rays = np.column_stack([plane, np.ones(len(plane))])
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)


def settle(cameras, pixels, turns, rays):
    """The rays that the turned cameras see nearest to the pixels, cell by cell (Newton's method on differences), and how far off."""
    step = 1e-6
    for _ in range(30):
        basis = across(rays)
        see = lambda at: np.stack([camera.img_from_cam(turn.apply(at)) - pixels for camera, turn in zip(cameras, turns)])
        off = see(rays)
        moved = [(see(rays + step * basis[:, k]) - see(rays - step * basis[:, k])) / (2 * step) for k in range(2)]
        jacobian = np.stack(moved, axis=-1)  # run, cell, pixel axis, ray axis
        hessian = np.einsum("rgxi,rgxj->gij", jacobian, jacobian)
        gradient = np.einsum("rgxi,rgx->gi", jacobian, off)
        by = -np.linalg.solve(hessian, gradient[..., None])[..., 0]
        rays = rays + np.einsum("gk,gkx->gx", by, basis)
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        if np.abs(by).max() < 1e-8:  # the next step would be of its square
            break
    return off, rays


def least_spread(cameras, pixels, is_turned):
    """Root of the mean over the pixels of sum_r |deviation|^2 / (n - 1), and the spread in each, at the minimum."""
    n = len(cameras)
    start = np.mean([rays_of(camera, pixels) for camera in cameras], axis=0)
    start /= np.linalg.norm(start, axis=1, keepdims=True)
    still = [Rotation.identity()] * n
    off, rays = settle(cameras, pixels, still, start)
    if is_turned:
        # The first is not turned: only turns between them matter.
        def residuals(unknowns):
            nonlocal rays
            turns = [Rotation.identity(), *(Rotation.from_rotvec(v) for v in unknowns.reshape(-1, 3))]
            off, rays = settle(cameras, pixels, turns, rays)
            return off.ravel()

        found = least_squares(residuals, np.zeros(3 * (n - 1)), x_scale=1e-3, ftol=1e-12, xtol=1e-10, gtol=1e-12)
        off = found.fun.reshape(n, -1, 2)
    spread2 = (off**2).sum(axis=(0, 2)) / (n - 1)
    return math.sqrt(spread2.mean()), np.sqrt(spread2)


class Checks:
    def __init__(self):
        self.count, self.differences = 0, []

    def near(self, what, got, want, tolerance):
        self.count += 1
        if not abs(got - want) <= tolerance:
            self.differences.append(f"{what}: {got!r}, expected {want!r} +- {tolerance:.1e}")


def check_population(checks, name, population):
    spread = population["spread"]
    cameras = cameras_of(population)
    compared = [cameras[run["run"], run["camera_id"]] for run in spread["runs"]]
    if not 2 <= len(compared) <= MOST_RUNS:
        return
    pixels = centres(population, spread["cells"])
    for camera in compared:
        # pycolmap's iteration does not end everywhere; what it gives must then not be called a ray.
        back = camera.img_from_cam(rays_of(camera, pixels))
        if not np.abs(back - pixels).max() < 1e-4:
            print(f"{name}: skipped, as pycolmap finds no ray at some pixels")
            return
    for key, is_turned in (("raw", False), ("rotated", True)):
        got = spread[key]
        rms, each = least_spread(compared, pixels, is_turned)
        checks.near(f"{name} {key} rms", got["rms_px"], rms, 1e-5 * rms + 1e-5)
        checks.near(f"{name} {key} p95", got["p95_px"], np.quantile(each, 0.95), 1e-4 * rms + 1e-4)
        checks.near(f"{name} {key} max", got["max_px"], each.max(), 1e-3 * rms + 1e-3)
        for cell in range(0, len(each), 97):
            checks.near(f"{name} {key} map[{cell}]", got["map_px"][cell], each[cell], 1e-3 * rms + 1e-3)
    if spread["rotated"]["rms_px"] > spread["raw"]["rms_px"]:
        checks.differences.append(f"{name}: turned {spread['rotated']['rms_px']} above raw {spread['raw']['rms_px']}")


def check_overlap(checks, name, population, runs):
    """rho from the files, by pairs of runs."""
    overlap = population["overlap"]
    if overlap is None:
        return
    observed = []
    for run, camera_id in {(s["run"], s["camera_id"]) for p in population["parameters"] for s in p["samples"] if s["value"] is not None}:
        model = runs[run]
        observed.append({
            (image.name, *point.xy)
            for image in model.images.values() if image.camera_id == camera_id
            for point in image.points2D if point.has_point3D()
        })
    shared = total = 0.0
    for index, one in enumerate(observed):
        for other in observed[:index]:
            shared += len(one & other)
            total += (len(one) + len(other)) / 2
    checks.near(f"{name} shared fraction", overlap["shared_fraction"], shared / total, 1e-12)


def check_path(checks, binary, path):
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([binary, "analyze", str(path), "--out", out, "--format", "json", "--quiet"], check=True, stdout=subprocess.DEVNULL)
        analysis = json.loads((Path(out) / "analysis.json").read_text(encoding="utf-8"))
    groups = {}
    for run in analysis["runs"]:
        files = {Path(file["path"]).name: Path(file["path"]) for file in run["files"]}
        if run["image_count"] and "images.txt" in files:
            groups.setdefault(run["group"], {})[run["run"]] = files["images.txt"].parent
    for population in analysis["populations"]:
        name = f"{path}: {population['group']} {population['camera']} {population['model']}"
        if population["spread"]:
            check_population(checks, name, population)
        if population["overlap"] and population["group"] in groups:
            runs = {run: pycolmap.Reconstruction(str(folder)) for run, folder in groups[population["group"]].items()}
            check_overlap(checks, name, population, runs)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("calibstab", type=Path)
    parser.add_argument("paths", type=Path, nargs="+")
    parser.add_argument("--at-least", type=int, default=20, help="values to compare in all, or the check has failed")
    arguments = parser.parse_args()
    pycolmap.logging.minloglevel = 2
    checks = Checks()
    for path in arguments.paths:
        before = checks.count
        check_path(checks, str(arguments.calibstab.resolve()), path)
        print(f"{path}: {checks.count - before} values compared", flush=True)
    for difference in checks.differences[:50]:
        print(difference, file=sys.stderr)
    if checks.count < arguments.at_least:
        checks.differences.append("too few")
        print(f"only {checks.count} values compared, at least {arguments.at_least} expected", file=sys.stderr)
    print(f"{checks.count} values compared, {len(checks.differences)} differ")
    sys.exit(1 if checks.differences else 0)


if __name__ == "__main__":
    main()
