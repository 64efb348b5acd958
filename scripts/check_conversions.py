#!/usr/bin/env python3
"""Compares conversions between camera models with pycolmap's pixels and scipy's least squares.

Usage: check_conversions.py CALIBSTAB

Each camera below is converted by `CALIBSTAB convert` into another model of COLMAP's. Over the centres of the image's cells
- a conversion that is called exact moves no pixel by 1e-9 px, as pycolmap sees it;
- the RMS and the largest error of a fit are those that pycolmap's pixels show;
- scipy's least squares, from the camera found and from others near it, reaches no RMS that is lower by more than a millionth.
Exit 1 when anything differs.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pycolmap
from scipy.optimize import least_squares

COLUMNS = 60
MILLIONTH = 1e-6
EXACT_PX = 1e-9
# Half of the last digit that is printed, of three.
PRINTED = 6e-3

EUROC = ("OPENCV", 752, 480, [465.7, 465.0, 376.0, 240.0, -0.275, 0.067, 0.0014, -0.00044])
CASTLE = ("SIMPLE_RADIAL", 3072, 2048, [2759.0, 1536.0, 1024.0, 0.02])
# Far from any EUCM: the best one ends 11 px off, with alpha near 0 and a huge beta.
WAVY = ("RADIAL", 1280, 960, [700.0, 640.0, 480.0, -0.35, 0.15])
MILD = ("RADIAL", 1280, 960, [900.0, 640.0, 480.0, -0.12, 0.03])
FISHEYE = ("OPENCV_FISHEYE", 800, 600, [420.0, 418.0, 400.0, 300.0, -0.0748, 0.0088, -0.0034, 0.0003])
# Camera, target, whether the target contains it.
CASES = [
    (CASTLE, "OPENCV", True),
    (MILD, "FULL_OPENCV", True),
    (FISHEYE, "THIN_PRISM_FISHEYE", True),
    (FISHEYE, "RAD_TAN_THIN_PRISM_FISHEYE", True),
    (("FISHEYE", 640, 480, [300.0, 310.0, 320.0, 240.0]), "FOV", True),
    (EUROC, "RADIAL_FISHEYE", False),
    (EUROC, "FULL_OPENCV", True),
    (EUROC, "OPENCV_FISHEYE", False),
    (EUROC, "EUCM", False),
    (EUROC, "DIVISION", False),
    (CASTLE, "SIMPLE_PINHOLE", False),
    (CASTLE, "RADIAL_FISHEYE", False),
    (WAVY, "EUCM", False),
    (MILD, "FOV", False),
    (MILD, "OPENCV_FISHEYE", False),
    (FISHEYE, "EUCM", False),
    (FISHEYE, "FOV", False),
    (FISHEYE, "RADIAL_FISHEYE", False),
    (("EUCM", 640, 480, [500.0, 490.0, 320.0, 240.0, 0.6, 1.1]), "OPENCV", False),
    (("DIVISION", 640, 480, [500.0, 490.0, 320.0, 240.0, -0.2]), "OPENCV", False),
]


def camera(model, width, height, params):
    return pycolmap.Camera(model=model, width=width, height=height, params=params)


def cell_centres(width, height):
    rows = (2 * COLUMNS * height + width) // (2 * width)
    columns, rows = np.meshgrid(np.arange(COLUMNS), np.arange(rows))
    cells = np.stack([columns.ravel(), rows.ravel()], axis=1) + 0.5
    return cells * [width / COLUMNS, height / (rows.max() + 1)]


def errors(target, params, rays, pixels):
    target.params = params
    return target.img_from_cam(rays) - pixels


def rms_px(differences):
    return np.sqrt((differences**2).sum(axis=1).mean())


def best_rms(target, found, rays, pixels):
    """The lowest RMS that scipy reaches, from the parameters found and from some near them."""
    random = np.random.default_rng(4)

    def residuals(params):
        return np.nan_to_num(errors(target, params, rays, pixels).ravel(), nan=1e6)

    rms = []
    for spread in (0.0, 1e-3, 1e-2):
        start = found * (1 + spread * random.standard_normal(len(found)))
        end = least_squares(residuals, start, method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=3000)
        rms.append(rms_px(end.fun.reshape(-1, 2)))
    return min(rms)


def printed(line):
    """RMS and largest error as calibstab printed them; none when it said exact."""
    if line.endswith(": exact"):
        return None
    words = line.replace(",", "").split()
    return [float(words[words.index(word) + 1]) for word in ("rms", "max")]


def check(calibstab, source, to, is_contained, folder):
    name, width, height, params = source
    (folder / "cameras.txt").write_text(f"1 {name} {width} {height} {' '.join(map(repr, params))}\n")
    out = folder / "converted.txt"
    command = [calibstab, "--quiet", "convert", folder / "cameras.txt", "--to", to, "--out", out]
    run = subprocess.run(command, check=True, capture_output=True, text=True)
    figures = printed(run.stdout.splitlines()[0])
    fields = next(line for line in out.read_text().splitlines() if not line.startswith("#")).split()
    if fields[1:4] != [to, str(width), str(height)]:
        return f"wrote {' '.join(fields)}"
    found = np.array([float(field) for field in fields[4:]])
    rays = camera(*source).cam_from_img(cell_centres(width, height))
    rays = np.column_stack([rays, np.ones(len(rays))])
    # Back again, since cam_from_img ends 1e-8 px short of the centres.
    pixels = camera(*source).img_from_cam(rays)
    target = camera(to, width, height, found)
    differences = errors(target, found, rays, pixels)
    rms, largest = rms_px(differences), np.linalg.norm(differences, axis=1).max()
    if is_contained != (figures is None):
        return f"called {run.stdout.splitlines()[0]}"
    if is_contained:
        return f"{largest:.1e} px off" if largest > EXACT_PX else None
    for what, said, true in zip(("rms", "max"), figures, (rms, largest)):
        if abs(said - true) > PRINTED * true:
            return f"{what} {said} px, pycolmap has {true}"
    best = best_rms(target, found, rays, pixels)
    print(f"  {name} -> {to}: rms {rms:.6g} px, scipy {best:.6g} px")
    return f"rms {rms:.9g} px, scipy reaches {best:.9g}" if best < rms * (1 - MILLIONTH) else None


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    faults = []
    for source, to, is_contained in CASES:
        with tempfile.TemporaryDirectory() as folder:
            fault = check(sys.argv[1], source, to, is_contained, Path(folder))
        if fault:
            faults.append(f"{source[0]} -> {to}: {fault}")
    print("\n".join(faults) or f"{len(CASES)} conversions are as exact and as near as they say")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
