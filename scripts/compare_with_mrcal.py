#!/usr/bin/env python3
"""Differences of two calibrations, as `calibstab compare` and as mrcal 2 see them.

    scripts/compare_with_mrcal.py CALIBSTAB FROM.txt TO.txt [FROM.txt TO.txt ...]

Takes cameras files with one OPENCV camera each; needs Debian's python3-mrcal (say its Python, /usr/bin/python3). Without mrcal it says so
and exits with 0. As they are, mrcal must find the same pixel in every cell to 1e-6 px. Turned, mrcal fits the angles between rays
and calibstab pixels: so calibstab's RMS must not be the greater one, and mrcal's own map, on its own grid, must be near to it.
Exit 1 when anything differs.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

try:
    import mrcal
except ImportError:
    print("skipped: mrcal is not installed (Debian: python3-mrcal)")
    sys.exit(0)

FIRST_PIXEL = 0.5  # COLMAP's centre of the first pixel; mrcal has it at 0
CELL_TOLERANCE_PX = 1e-6
MAP_TOLERANCE = 0.06  # its grid reaches to the edges of the image, where lenses differ most; the cells here have centres
EVERYWHERE = 1e8


def camera_model(path):
    """The OPENCV camera of a cameras file as mrcal has it, and its size."""
    rows = [line.split() for line in Path(path).read_text().splitlines() if line.strip() and not line.startswith("#")]
    if len(rows) != 1 or rows[0][1] != "OPENCV":
        sys.exit(f"{path}: not one OPENCV camera")
    size = [int(rows[0][2]), int(rows[0][3])]
    params = np.array([float(value) for value in rows[0][4:]])
    params[2:4] -= FIRST_PIXEL
    return mrcal.cameramodel(intrinsics=("LENSMODEL_OPENCV4", params), imagersize=size), size


def differences(calibstab, paths):
    """What calibstab says of the way from the first to the second."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            [calibstab, "compare", *paths, "--match", "single", "--region", "all", "--out", folder],
            check=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        comparison = json.loads((Path(folder) / "comparison.json").read_text())
    return comparison["cameras"][0]["differences"][0]


def rms(field):
    """Of two-dimensional differences, in px."""
    return float(np.sqrt(np.mean(np.sum(np.asarray(field) ** 2, axis=-1))))


def compare(calibstab, paths):
    """The faults found between two calibrations, and a line on them."""
    (one, size), (other, other_size) = (camera_model(path) for path in paths)
    if size != other_size:
        sys.exit(f"{paths}: image sizes differ")
    told = differences(calibstab, paths)
    cells, columns = np.array(told["cells"]), told["columns"]
    cell = np.array([size[0] / columns, size[1] / told["rows"]])
    pixels = (np.stack([cells % columns, cells // columns], axis=-1) + 0.5) * cell - FIRST_PIXEL
    rays = mrcal.unproject(pixels, *one.intrinsics(), normalize=True)

    faults = []
    raw = mrcal.project(rays, *other.intrinsics()) - pixels
    worst = float(np.abs(raw - np.array(told["raw"]["px"])).max())
    if not worst <= CELL_TOLERANCE_PX:
        faults.append(f"as they are, a cell differs by {worst:.3g} px")

    other_rays = mrcal.unproject(pixels, *other.intrinsics(), normalize=True)
    turn = mrcal.implied_Rt10__from_unprojections(
        pixels, rays, other_rays, focus_center=(np.array(size) - 1) / 2, focus_radius=EVERYWHERE
    )
    turned = rms(mrcal.project(mrcal.rotate_point_R(turn[:3], rays), *other.intrinsics()) - pixels)
    ours = told["rotated"]["rms_px"]
    if not ours <= turned * (1 + 1e-9):
        faults.append(f"turned as mrcal does it is {turned:.6f} px RMS, less than {ours:.6f}")

    maps = []
    for intrinsics_only, alignment in [(True, "raw"), (False, "rotated")]:
        _, field, _, _ = mrcal.projection_diff(
            (one, other), intrinsics_only=intrinsics_only, use_uncertainties=False, focus_radius=EVERYWHERE
        )
        maps.append(rms(field))
        if not abs(maps[-1] / told[alignment]["rms_px"] - 1) <= MAP_TOLERANCE:
            faults.append(f"mrcal's map, {alignment}, is {maps[-1]:.3f} px RMS, here {told[alignment]['rms_px']:.3f}")
    line = (
        f"as they are {told['raw']['rms_px']:.3f} px (largest difference of a cell {worst:.1e}, mrcal's map {maps[0]:.3f}); "
        f"turned {ours:.4f} px (by mrcal's rotation {turned:.4f}, mrcal's map {maps[1]:.3f})"
    )
    return faults, line


def main():
    """Compares every pair that was given."""
    calibstab, *paths = sys.argv[1:]
    if not paths or len(paths) % 2:
        sys.exit(__doc__)
    found = 0
    for pair in zip(paths[::2], paths[1::2]):
        faults, line = compare(calibstab, list(pair))
        print(f"{pair[0]} to {pair[1]}: {line}")
        for fault in faults:
            print(f"  {fault}")
        found += len(faults)
    print(f"{len(paths) // 2} pairs compared, {found} differences")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
