#!/usr/bin/env python3
"""Makes fixtures/golden_pixels.csv: what pycolmap 4.2.1 says that its camera models see, for tests/golden_pixels.rs.

    scripts/make_golden_pixels.py            writes the table
    scripts/make_golden_pixels.py --check    compares it with pycolmap to 1e-9 px, and writes nothing

One row a projection: model, parameters, point, pixel. Points lie before the camera, as COLMAP refuses others for most
models, and within the angle at which the lens folds: beyond it COLMAP wraps around without complaint. Its FOV model is wrong
for |omega| < 0.01, so no such camera is here.
"""

import csv
import math
import sys
from pathlib import Path

import numpy as np
import pycolmap

OUT = Path(__file__).parent.parent / "fixtures" / "golden_pixels.csv"

# Mild to strong, with the cameras of the 2018 thesis; the last number is the largest angle from the axis in degrees.
CAMERAS = [
    ("SIMPLE_PINHOLE", [500, 320, 240], 80),
    ("PINHOLE", [1200.5, 800, 500, 700], 80),
    ("SIMPLE_RADIAL", [1011.91, 640, 480, -0.241569], 48),
    ("SIMPLE_RADIAL", [2759, 1536, 1024, 0.02], 70),
    ("RADIAL", [700, 640, 480, -0.35, 0.15], 60),
    ("OPENCV", [1061.6, 1035.29, 640, 480, -0.333951, 0.121122, 0.0025596, 0.00419425], 50),
    ("OPENCV", [465.7, 465, 376, 240, -0.275, 0.067, 0.0014, -0.00044], 45),
    ("OPENCV_FISHEYE", [402.294, 437.448, 512, 512, -0.0814756, 0.121485, -0.0880346, 0.0181435], 75),
    ("OPENCV_FISHEYE", [428.331, 444.79, 512, 512, 0.00974985, 0.0337692, -0.0801194, 0.0217839], 70),
    ("OPENCV_FISHEYE", [419.591, 418.346, 512, 512, -0.0748247, 0.00877295, -0.00344216, 0.000329053], 85),
    ("FULL_OPENCV", [500, 490, 320, 240, -0.3, 0.12, 0.001, -0.002, -0.02, 0.01, -0.01, 0.002], 40),
    ("FULL_OPENCV", [500, 490, 320, 240, 12, 3, 0.0005, -0.0002, 0.1, 12.3, 5.5, 0.4], 40),
    ("FOV", [500, 490, 320, 240, 0.9], 80),
    ("FOV", [500, 490, 320, 240, 0.02], 60),
    ("SIMPLE_RADIAL_FISHEYE", [427.761, 512, 512, -0.0768701], 85),
    ("RADIAL_FISHEYE", [419.312, 512, 512, 0.05, -0.02], 70),
    ("THIN_PRISM_FISHEYE", [402, 437, 512, 512, -0.08, 0.02, 0.001, -0.0005, -0.004, 0.0005, 0.002, -0.001], 70),
    (
        "RAD_TAN_THIN_PRISM_FISHEYE",
        [610, 612, 704, 704, 0.03, -0.01, 0.004, -0.002, 0.0005, -4e-5, 0.0005, -0.0003, 0.0008, -0.0001, -0.0004, 5e-5],
        75,
    ),
    ("SIMPLE_DIVISION", [500, 320, 240, -0.2], 80),
    ("SIMPLE_DIVISION", [500, 320, 240, 0.1], 50),
    ("DIVISION", [427, 425, 512, 512, -0.6], 80),
    ("SIMPLE_FISHEYE", [427.761, 512, 512], 85),
    ("FISHEYE", [300, 310, 320, 240], 85),
    ("EUCM", [500, 490, 320, 240, 0.6, 1.1], 80),
    ("EUCM", [420, 420, 512, 512, 0.8, 1.3], 85),
    ("EQUIRECTANGULAR", [2000, 1000], 180),
]


def points(widest_deg: float, seed: int) -> np.ndarray:
    """Directions within the angle, even the axis, at distances from 0.2 to 20."""
    random = np.random.default_rng(seed)
    angle = np.radians(widest_deg) * np.sqrt(np.linspace(0, 0.98, 16))
    around = random.uniform(0, 2 * math.pi, len(angle))
    far = 10 ** random.uniform(-0.7, 1.3, len(angle))
    across = np.sin(angle)
    return np.c_[across * np.cos(around), across * np.sin(around), np.cos(angle)] * far[:, None]


def rows() -> list[list[str]]:
    made = [["model", "params", "x", "y", "z", "px", "py"]]
    for seed, (model, params, widest_deg) in enumerate(CAMERAS):
        camera = pycolmap.Camera(camera_id=1, model=model, width=1000, height=1000, params=params)
        for point in points(widest_deg, seed):
            pixel = camera.img_from_cam(point)
            assert pixel is not None, (model, point)
            numbers = [repr(float(number)) for number in [*point, *pixel]]
            made.append([model, " ".join(repr(float(value)) for value in params), *numbers])
    return made


def check() -> None:
    """The points come from numpy's sines, whose last bit differs between machines: pycolmap sees the points of the file."""
    with OUT.open(newline="") as file:
        table = list(csv.DictReader(file))
    assert len(table) == len(rows()) - 1, "the table has not the rows that this script makes"
    for row in table:
        params = [float(value) for value in row["params"].split(" ")]
        camera = pycolmap.Camera(camera_id=1, model=row["model"], width=1000, height=1000, params=params)
        pixel = camera.img_from_cam(np.array([float(row[axis]) for axis in "xyz"]))
        error = math.dist(pixel, (float(row["px"]), float(row["py"])))
        assert error <= 1e-9, (row, error)
    print(f"{len(table)} golden pixels compared, 0 differ")


def main() -> None:
    if sys.argv[1:] == ["--check"]:
        check()
        return
    with OUT.open("w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows())


if __name__ == "__main__":
    main()
