#!/usr/bin/env python3
"""Holds the reconstructions of `calibstab synth` against pycolmap, for every camera model that COLMAP has.

Usage: check_synthetic.py CALIBSTAB

pycolmap must read the truth and the runs, reproject the truth to 1e-9 px, the runs with an error that noise alone
explains, and start values that are off with the errors that calibstab wrote. Exit 1 when one does not hold.
"""

import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pycolmap

NOISE_PX = 0.5
EXACT_PX = 1e-9
# Within 1/100 of the axis COLMAP's FOV is a series cut short, 1.2e-9 px off here.
EXACT_PX_OF_FOV = 1e-8
# A mean this many of its deviations off is no chance: once in 500 000.
MAX_DEVIATIONS = 4.9
# COLMAP has so many models (4.2), and each of them must be seen often enough to say something.
MODEL_COUNT = 18
LEAST_OBSERVATIONS = 1000


def make(calibstab, model, out, *more):
    """A run and its truth; nothing beyond 85 degrees, where COLMAP's fisheyes stop."""
    command = [calibstab, "synth", "--camera", model, "--out", out, "--images", "20", "--points", "1500"]
    subprocess.run([*map(str, command), "--max-angle", "85", "--noise", str(NOISE_PX), *more, "--quiet"], check=True, stderr=subprocess.DEVNULL)
    return pycolmap.Reconstruction(out), pycolmap.Reconstruction(Path(out) / "truth")


def errors(model):
    """The lengths of the residuals of every point, in px."""
    by_point = {}
    for id, point in model.points3D.items():
        images = [(model.images[element.image_id], element.point2D_idx) for element in point.track.elements]
        residuals = [image.project_point(point.xyz) - image.points2D[index].xy for image, index in images]
        by_point[id] = np.linalg.norm(residuals, axis=1)
    return by_point


def check(calibstab, model, out):
    """What does not hold for this model."""
    faults = []
    run, truth = make(calibstab, model, out / "noise", "--start-off", "0")
    exact = np.concatenate(list(errors(truth).values())).max()
    noisy = np.concatenate(list(errors(run).values()))
    if not exact <= (EXACT_PX_OF_FOV if model == "FOV" else EXACT_PX):
        faults.append(f"the truth is reprojected {exact:.1e} px off")
    # Lengths of normal errors: Rayleigh's distribution.
    mean, deviation = NOISE_PX * math.sqrt(math.pi / 2), NOISE_PX * math.sqrt((2 - math.pi / 2) / len(noisy))
    if not abs(noisy.mean() - mean) <= MAX_DEVIATIONS * deviation:
        faults.append(f"the mean error is {noisy.mean():.4f} px, expected {mean:.4f} +- {deviation:.4f}")
    start, _ = make(calibstab, model, out / "start", "--start-off", "0.001", "--binary")
    apart = max(abs(lengths.mean() - start.points3D[id].error) for id, lengths in errors(start).items())
    if not apart <= EXACT_PX:
        faults.append(f"a point's error is {apart:.1e} px off what was written")
    if len(noisy) < LEAST_OBSERVATIONS:
        faults.append(f"only {len(noisy)} observations")
    print(f"{model:28} {len(noisy):6} observations, truth {exact:.1e} px, mean {noisy.mean():.4f} px, errors {apart:.1e} px", *faults)
    return faults


def main():
    calibstab = sys.argv[1]
    names = [name for name, model in pycolmap.CameraModelId.__members__.items() if model != pycolmap.CameraModelId.INVALID]
    with tempfile.TemporaryDirectory() as folder:
        faults = [fault for name in names for fault in check(calibstab, name, Path(folder) / name)]
    if len(names) != MODEL_COUNT:
        faults.append(f"{len(names)} models, expected {MODEL_COUNT}")
    return len(faults) > 0


if __name__ == "__main__":
    sys.exit(main())
