#!/usr/bin/env python3
"""Makes fixtures/golden_pixels.csv and golden_rays.csv: what pycolmap 4.2.1 says that its camera models see, for
tests/golden_pixels.rs.

    scripts/make_golden_pixels.py            writes the tables
    scripts/make_golden_pixels.py --check    compares them with pycolmap to 1e-9 px, and writes nothing

One row a projection: model, parameters, point, pixel. Points lie before the camera, as COLMAP refuses others for most
models, and within the angle at which the lens folds: beyond it COLMAP wraps around without complaint. Its FOV model is wrong
for |omega| < 0.01, so no such camera is there.

Rays: model, parameters, pixel, the ray to which pycolmap unprojects it, and the pixel to which it projects that ray again:
the same to 5e-8 px, as near as it iterates. Below these are rows of its two known faults, where that pixel is another one.
"""

import csv
import math
import sys
from pathlib import Path

import numpy as np
import pycolmap

FIXTURES = Path(__file__).parent.parent / "fixtures"
PIXELS = FIXTURES / "golden_pixels.csv"
RAYS = FIXTURES / "golden_rays.csv"

# What a row is of: pycolmap's ray leads back to its pixel as near as it iterates, or it is wrong.
GOOD_PX, WRONG_PX = 5e-8, 1e-2

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


# COLMAP's known faults: cameras, and pixels at which they show. Its FOV model takes the series of the wrong function where
# |omega| < 0.01; its fisheyes, where a pixel sees more than 90 degrees, give rays that do not lead back to it.
FAULTS = [
    ("FOV", [500, 490, 320, 240, 0.0099], [(820, 240), (1070, 240), (1320, 1220)]),
    ("FOV", [500, 490, 320, 240, -0.009], [(1070, 240), (1320, 1220)]),
    ("OPENCV_FISHEYE", CAMERAS[7][1], [(0.5, 0.5), (0.5, 999.5), (999.5, 999.5)]),
    ("OPENCV_FISHEYE", CAMERAS[8][1], [(0.5, 0.5), (111.5, 0.5)]),
    ("OPENCV_FISHEYE", CAMERAS[9][1], [(0.5, 222.5), (74.5, 851.5), (999.5, 222.5)]),
    ("SIMPLE_RADIAL_FISHEYE", CAMERAS[14][1], [(0.5, 222.5), (740.5, 0.5)]),
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


def numbers(values) -> list[str]:
    return [repr(float(value)) for value in values]


def rays() -> list[list[str]]:
    made = [["model", "params", "px", "py", "x", "y", "z", "back_px", "back_py"]]
    good = [(model, params, np.round(seen(model, params, points(angle, 99)), 1)) for model, params, angle in CAMERAS]
    for (model, params, pixels), is_good in [(row, True) for row in good] + [(row, False) for row in FAULTS]:
        for pixel in np.array(pixels, dtype=float):
            ray, back = there_and_back(model, params, pixel)
            error = math.dist(pixel, back)
            assert error <= GOOD_PX if is_good else error > WRONG_PX, (model, params, pixel, error)
            made.append([model, " ".join(numbers(params)), *numbers([*pixel, *ray, *back])])
    return made


def seen(model: str, params: list[float], at: np.ndarray) -> np.ndarray:
    camera = pycolmap.Camera(camera_id=1, model=model, width=1000, height=1000, params=params)
    return np.array([camera.img_from_cam(point) for point in at])


def there_and_back(model: str, params: list[float], pixel: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    camera = pycolmap.Camera(camera_id=1, model=model, width=1000, height=1000, params=params)
    ray = camera.cam_ray_from_img(pixel)
    return ray, camera.img_from_cam(ray)


def check() -> None:
    """The points come from numpy's sines, whose last bit differs between machines: pycolmap sees the points of the files."""
    table = read(PIXELS)
    assert len(table) == len(rows()) - 1, "the table has not the rows that this script makes"
    for row in table:
        pixel = seen(row["model"], parsed(row["params"]), np.array([[float(row[axis]) for axis in "xyz"]]))[0]
        error = math.dist(pixel, (float(row["px"]), float(row["py"])))
        assert error <= 1e-9, (row, error)
    print(f"{len(table)} golden pixels compared, 0 differ")
    table = read(RAYS)
    assert len(table) == len(rays()) - 1, "the table has not the rows that this script makes"
    for row in table:
        pixel = np.array([float(row["px"]), float(row["py"])])
        ray, back = there_and_back(row["model"], parsed(row["params"]), pixel)
        was_wrong = math.dist(pixel, (float(row["back_px"]), float(row["back_py"]))) > WRONG_PX
        assert (math.dist(pixel, back) > WRONG_PX) == was_wrong, row
        # Where it is wrong, how wrong may depend on the machine.
        error = 0 if was_wrong else math.dist(ray, [float(row[axis]) for axis in "xyz"])
        assert error <= 1e-10, (row, error)
    print(f"{len(table)} golden rays compared, 0 differ")


def read(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def parsed(params: str) -> list[float]:
    return [float(value) for value in params.split(" ")]


def main() -> None:
    if sys.argv[1:] == ["--check"]:
        check()
        return
    for path, table in [(PIXELS, rows()), (RAYS, rays())]:
        with path.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(table)


if __name__ == "__main__":
    main()
