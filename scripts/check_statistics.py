#!/usr/bin/env python3
"""Compares everything that calibstab says with what pycolmap, numpy and scipy say.

Usage: check_statistics.py CALIBSTAB PATH [PATH ...] [--at-least N]

For each PATH it runs `CALIBSTAB analyze PATH --no-refine --out FOLDER --format json,csv`, reads the files named in the result once more
with pycolmap, and derives the result anew. Exit 1 when anything differs, or when fewer than N values were compared.

The reference is exact where numpy would lose digits: means, deviations, quantiles and correlations are computed on the
binary fractions that the doubles are. Tolerances are relative 1e-12, and 4 units in the last place of the largest sample
besides, for a mean rounds there and a deviation is a difference from one; ends of intervals 1e-9, on top of the std's own.
numpy's results must agree as well, but only to 1e-12 of the largest sample, since cancellation costs numpy digits too.
Samples, states, counts, hashes, names and the CSV files must be equal to the last bit.

The std in px comes from the mean camera in pycolmap: rays by cam_from_img, none where img_from_cam does not lead back or the
image folds on the way there; displacements by central differences of img_from_cam. COLMAP sees nothing beyond 90 degrees, so
there a formula in numpy stands in for its polynomial fisheyes, which must agree with pycolmap before the camera; other models
that have rays there are counted and skipped. The cells must be the same ones, for one more or less would change the std in px by
1e-4 of itself; differences of fourth order leave 1e-10 of it: the tolerance is relative 1e-8.
"""

import argparse
import csv
import hashlib
import json
import math
import statistics
import subprocess
import sys
import tempfile
from collections import Counter
from fractions import Fraction
from pathlib import Path

import jsonschema
import numpy as np
import pycolmap
from scipy.stats import chi2

from check_groups import check_groups

EPSILON = np.finfo(float).eps
MAD_TO_STD = 1.4826  # as the tool states it; 1 / Phi^-1(3/4) is 1.482602...
FAR_FROM_ZERO = 2  # a mean of as many std, all samples of one sign, can bear a relative std
FEW_IMAGES = Fraction(6, 10)  # of the group's median
SUBJECT = "group,camera,model,width,height,parameter,class,source".split(",")
SAMPLE_COLUMNS = SUBJECT + "run,camera_id,state,value,predicted_std,is_outlier".split(",")
NUMBERS = "mean,std,std_px,relative_std,std_low_95,std_high_95,min,q1,median,q3,max,mad_std,whisker_low,whisker_high".split(",")
STATISTICS_COLUMNS = SUBJECT + ["n", *NUMBERS, "predicted_std", "outliers"]


class Checks:
    """Counts what was compared and keeps what differs."""

    def __init__(self):
        self.count = 0
        self.differences = []
        self.std_px_count = 0
        self.group_count = 0  # values that are about several groups
        self.skipped = Counter()  # by model: std in px that nothing here can check

    def equal(self, what, got, want):
        self.count += 1
        if got != want:
            self.differences.append(f"{what}: {got!r}, expected {want!r}")

    def rows_equal(self, what, got, want):
        """Counts every field."""
        self.equal(f"{what}: number of rows", len(got), len(want))
        for one, other in zip(got, want):
            self.equal(what, one, other)
            self.count += len(other) - 1

    def near(self, what, got, want, tolerance):
        self.count += 1
        if not isinstance(got, float) or not abs(got - want) <= tolerance:
            self.differences.append(f"{what}: {got!r}, expected {want!r} +- {tolerance:.1e}")


def bits(value):
    """A spelling in which doubles are equal when their bits are; it tells -0 from 0."""
    return None if value is None else float(value).hex()


# What the files say, read by pycolmap.


def read_run(record):
    """Cameras of a run that took an image (all of them, without images) as id -> (model, width, height, params), and counts."""
    files = [Path(file["path"]) for file in record["files"]]
    (kind,) = {file.suffix for file in files}
    with tempfile.TemporaryDirectory() as scratch:
        for file in files:
            # pycolmap takes a byte order mark for a part of the first word.
            (Path(scratch) / file.name).write_bytes(file.read_bytes().removeprefix(b"\xef\xbb\xbf"))
        has_images = f"images{kind}" in {file.name for file in files}
        if not has_images:
            for name in ("images", "points3D"):
                (Path(scratch) / (name + kind)).write_bytes(b"" if kind == ".txt" else bytes(8))
        model = pycolmap.Reconstruction()
        model.read_text(scratch) if kind == ".txt" else model.read_binary(scratch)
    used = {image.camera_id for image in model.images.values()} if has_images else set(model.cameras)
    cameras = {
        camera_id: (camera.model.name, camera.width, camera.height, tuple(map(bits, camera.params)))
        for camera_id, camera in model.cameras.items()
        if camera_id in used
    }
    counts = (model.num_reg_images(), len(model.points3D), model.compute_num_observations())
    return cameras, counts if has_images else (None, None, None)


def check_runs(checks, path, analysis):
    """Every run below the path is there, as its files are. Returns their cameras by (group, run)."""
    if path.is_dir():
        found = {file.parent.resolve() for kind in ("txt", "bin") for file in path.rglob(f"cameras.{kind}")}
        listed = {Path(file["path"]).resolve().parent for run in analysis["runs"] for file in run["files"]}
        checks.equal(f"{path}: folders with a model", listed, found)
    cameras = {}
    for run in analysis["runs"]:
        name = f"{path}: {run['group']}/{run['run']}"
        checks.equal(f"{name} is listed twice", (run["group"], run["run"]) in cameras, False)
        for file in run["files"]:
            checks.equal(f"{name} sha256", file["sha256"], hashlib.sha256(Path(file["path"]).read_bytes()).hexdigest())
        cameras[run["group"], run["run"]], counts = read_run(run)
        for key, want in zip(("image_count", "point_count", "observation_count"), counts):
            checks.equal(f"{name} {key}", run[key], want)
    for group in {run["group"] for run in analysis["runs"]}:
        runs = [run for run in analysis["runs"] if run["group"] == group]
        check_duplicates(checks, f"{path}: {group}", runs, cameras)
        check_few_images(checks, f"{path}: {group}", runs)
    return cameras


def check_duplicates(checks, name, runs, cameras):
    """A duplicate has the cameras of an earlier run to the last bit. Equal files, or equal lone cameras, are duplicates;
    between equal cameras of unequal files this script does not judge. Duplicates do not count, all others do."""
    kept = []
    for run in runs:
        content = Counter(cameras[run["group"], run["run"]].values())
        twins = [other for other in kept if Counter(cameras[other["group"], other["run"]].values()) == content]
        checks.equal(f"{name}/{run['run']} is used", run["is_used"], run["duplicate_of"] is None)
        if run["duplicate_of"] is not None:
            names = [other["run"] for other in twins]
            checks.equal(f"{name}/{run['run']} duplicates {run['duplicate_of']}", run["duplicate_of"] in names, True)
            continue
        hashes = {file["sha256"] for file in run["files"]}
        same = [t for t in twins if hashes == {f["sha256"] for f in t["files"]} or t["image_count"] is run["image_count"] is None]
        checks.equal(f"{name}/{run['run']} duplicates nothing", same, [])
        kept.append(run)


def check_few_images(checks, name, runs):
    counts = [run["image_count"] for run in runs if run["image_count"] is not None]
    for run in runs:
        few = run["image_count"] is not None and run["image_count"] < FEW_IMAGES * Fraction(statistics.median(counts))
        checks.equal(f"{name}/{run['run']} is flagged for few images", "few-images" in run["flags"], few)


# The samples.


def vectors(population):
    """The parameters of a population's camera wherever it is: (run, camera_id) -> (bits, ...)."""
    columns = [
        {(s["run"], s["camera_id"]): bits(s["value"]) for s in p["samples"] if s["value"] is not None}
        for p in population["parameters"]
    ]
    return {key: tuple(column.get(key) for column in columns) for column in columns for key in column}


def check_samples(checks, path, analysis, cameras):
    """Every camera that took an image in a run that counts is the sample of exactly one population, to the last bit."""
    sampled = {(run["group"], run["run"]): [] for run in analysis["runs"]}
    for population in analysis["populations"]:
        for (run, camera_id), values in vectors(population).items():
            camera = (population["model"], population["width"], population["height"], values)
            sampled[population["group"], run].append((camera_id, camera))
            checks.count += len(values)
    for run in analysis["runs"]:
        key = run["group"], run["run"]
        want = sorted(cameras[key].items()) if run["is_used"] else []
        checks.equal(f"{path}: cameras sampled in {'/'.join(key)}", sorted(sampled[key]), want)


def check_names(checks, path, population):
    """Parameters are called, ordered and classed as COLMAP does; its own spelling names OPENCV's last two p1, p2."""
    camera = pycolmap.Camera.create_from_model_name(1, population["model"], 100.0, 100, 100)
    classes = {
        "focal": camera.focal_length_idxs(),
        "principal-point": camera.principal_point_idxs(),
        "extra": camera.extra_params_idxs(),
        "metadata": camera.metadata_params_idxs(),
    }
    got = [(parameter["name"], parameter["class"]) for parameter in population["parameters"]]
    class_at = {index: name for name, indices in classes.items() for index in indices}
    names = [name.strip() for name in camera.params_info.split(",")]
    checks.equal(f"{path}: parameters of {population['model']}", got, [(n, class_at[i]) for i, n in enumerate(names)])


def check_states(checks, name, population, index):
    """By the definition: held is what is bit-equal in two runs, or a principal point at the image centre in all; one run
    alone cannot tell, but for the centre."""
    parameter = population["parameters"][index]
    values = {key: vector[index] for key, vector in vectors(population).items()}
    count = Counter(values.values())
    class_of = [p["class"] for p in population["parameters"]]
    side = "height" if "principal-point" in class_of[:index] else "width"
    is_centred = parameter["class"] == "principal-point" and set(count) == {bits(population[side] / 2)}
    for s in parameter["samples"]:
        value = values.get((s["run"], s["camera_id"]))
        if value is None:
            state = "failed"
        elif is_centred or parameter["class"] == "metadata" or count[value] > 1:
            state = "presumed-held"
        else:
            state = "estimated" if len(values) > 1 else "unknown"
        checks.equal(f"{name} state in {s['run']}", s["state"], state)


# The statistics.


def quantile(ordered, share):
    """Type 7 of Hyndman and Fan, exactly."""
    at = (len(ordered) - 1) * share
    below = math.floor(at)
    above = min(below + 1, len(ordered) - 1)
    return ordered[below] + (at - below) * (ordered[above] - ordered[below])


def check_statistics(checks, name, parameter):
    """The statistics of one parameter, from the samples that were estimated."""
    samples = {(s["run"], s["camera_id"]): s["value"] for s in parameter["samples"] if s["state"] == "estimated"}
    got = parameter["statistics"]
    checks.equal(f"{name} has statistics", got is not None, len(samples) >= 2)
    if got is None or len(samples) < 2:
        checks.equal(f"{name} outliers", [s["run"] for s in parameter["samples"] if s["is_outlier"]], [])
        return
    n, values = len(samples), np.array(list(samples.values()))
    exact = {key: Fraction(value) for key, value in samples.items()}
    ordered = sorted(exact.values())
    largest = float(max(map(abs, ordered)))

    def near(key, value, want, by_numpy):
        checks.near(f"{name} {key}", value, float(want), 1e-12 * abs(float(want)) + 4 * EPSILON * largest)
        checks.near(f"{name} {key} by numpy", value, float(by_numpy), 1e-12 * largest)

    checks.equal(f"{name} n", got["n"], n)
    mean = statistics.mean(ordered)
    std = statistics.stdev(ordered)
    near("mean", got["mean"], mean, np.mean(values))
    near("std", got["std"], std, np.std(values, ddof=1))
    near("min", got["min"], ordered[0], np.min(values))
    near("max", got["max"], ordered[-1], np.max(values))
    q1, median, q3 = (quantile(ordered, Fraction(quarter, 4)) for quarter in (1, 2, 3))
    for key, want, share in (("q1", q1, 0.25), ("median", median, 0.5), ("q3", q3, 0.75)):
        near(key, got[key], want, np.quantile(values, share, method="linear"))
    deviations = sorted(abs(value - median) for value in ordered)
    by_numpy = MAD_TO_STD * np.median(np.abs(values - np.median(values)))
    near("mad_std", got["mad_std"], Fraction(MAD_TO_STD) * quantile(deviations, Fraction(1, 2)), by_numpy)

    check_relative(checks, name, got["relative_std"], std, mean, ordered)
    # (n - 1) s^2 / sigma^2 is chi-square with n - 1 degrees of freedom.
    for end, share in enumerate((0.975, 0.025)):
        want = float(std) * math.sqrt((n - 1) / chi2.ppf(share, n - 1))
        tolerance = 1e-9 * want + 4 * EPSILON * largest * want / float(std) if std else 0.0
        checks.near(f"{name} std_interval_95[{end}]", got["std_interval_95"][end], want, tolerance)

    reach = Fraction(3, 2) * (q3 - q1)
    inside = [value for value in ordered if q1 - reach <= value <= q3 + reach]
    checks.equal(f"{name} whiskers", list(map(bits, got["whiskers"])), [bits(inside[0]), bits(inside[-1])])
    for s in parameter["samples"]:
        value = exact.get((s["run"], s["camera_id"]))
        is_outlier = value is not None and not q1 - reach <= value <= q3 + reach
        checks.equal(f"{name} is an outlier in {s['run']}", s["is_outlier"], is_outlier)


def check_relative(checks, name, got, std, mean, ordered):
    """std / |mean|, where the mean is far from zero."""
    is_far = ordered[0] * ordered[-1] > 0 and abs(mean) >= FAR_FROM_ZERO * Fraction(std)
    checks.equal(f"{name} has a relative_std", got is not None, is_far)
    if got is not None and is_far:
        want = std / abs(float(mean))
        # d(s/m) = ds/m - s dm/m^2, either error below 4 units of the largest sample.
        largest = float(max(map(abs, ordered)))
        checks.near(f"{name} relative_std", got, want, 1e-12 * want + 4 * EPSILON * largest * (1 + want) / abs(float(mean)))


def check_compensation(checks, name, population):
    """Pearson's correlation of the first focal length that was estimated with every distortion parameter that was, over the
    runs that estimated both."""
    estimated = {
        p["name"]: {(s["run"], s["camera_id"]): s["value"] for s in p["samples"] if s["state"] == "estimated"}
        for p in population["parameters"]
    }
    of_class = {
        c: [p["name"] for p in population["parameters"] if p["class"] == c and len(estimated[p["name"]]) > 1]
        for c in ("focal", "extra")
    }
    pairs = [(focal, extra) for focal in of_class["focal"][:1] for extra in of_class["extra"]]
    checks.equal(f"{name} compensation", [(c["focal"], c["distortion"]) for c in population["compensation"]], pairs)
    for got in population["compensation"]:
        if (got["focal"], got["distortion"]) in pairs:
            x, y = estimated[got["focal"]], estimated[got["distortion"]]
            both = [key for key in x if key in y]
            checks.equal(f"{name} n of {got['focal']} with {got['distortion']}", got["n"], len(both))
            what = f"{name} correlation of {got['focal']} with {got['distortion']}"
            check_correlation(checks, what, got["correlation"], [x[key] for key in both], [y[key] for key in both])


def check_correlation(checks, name, got, x, y):
    constant = len(x) < 3 or len(set(x)) == 1 or len(set(y)) == 1
    checks.equal(f"{name} exists", got is not None, not constant)
    if constant or got is None:
        return
    dx, dy = ([Fraction(v) - statistics.mean(map(Fraction, values)) for v in values] for values in (x, y))
    xx, yy, xy = (sum(a * b for a, b in zip(*pair)) for pair in ((dx, dx), (dy, dy), (dx, dy)))
    want = math.copysign(math.sqrt(xy * xy / (xx * yy)), xy)
    # Each deviation is wrong by a unit of its largest sample; relative to the root of the sum of squares.
    lost = sum(max(map(abs, values)) / math.sqrt(square) for values, square in ((x, xx), (y, yy)))
    tolerance = 1e-12 + 4 * EPSILON * math.sqrt(len(x)) * lost
    checks.near(name, got, want, tolerance)
    checks.near(f"{name} by numpy", got, float(np.corrcoef(x, y)[0, 1]), 2 * tolerance)


# The std in px.

COLUMNS = 60  # of cells over the image
STD_PX_TOLERANCE = 1e-8
LEADS_BACK_PX = 1e-5  # cam_from_img stops 1e-10 off on the plane, and real focal lengths go up to 1e4 px
# Radial polynomials in the angle from the axis, by how many focal lengths they have.
POLYNOMIAL_FISHEYES = {
    "SIMPLE_FISHEYE": 1, "SIMPLE_RADIAL_FISHEYE": 1, "RADIAL_FISHEYE": 1, "FISHEYE": 2, "OPENCV_FISHEYE": 2,
}  # fmt: skip
# Other lenses that may see beyond 90 degrees, where pycolmap does not.
WIDE = {"FOV", "THIN_PRISM_FISHEYE", "RAD_TAN_THIN_PRISM_FISHEYE", "SIMPLE_DIVISION", "DIVISION", "EUCM", "EQUIRECTANGULAR"}


def cell_centres(width, height):
    rows = min(max(math.floor(Fraction(COLUMNS * height, width) + Fraction(1, 2)), 1), 10 * COLUMNS)
    x, y = np.meshgrid((np.arange(COLUMNS) + 0.5) * width / COLUMNS, (np.arange(rows) + 0.5) * height / rows)
    return np.c_[x.ravel(), y.ravel()]


def along(angle, axis):
    """Directions at an angle from the optical axis, each across it as its axis says."""
    return np.c_[np.sin(angle)[:, None] * axis, np.cos(angle)]


def polynomial_fisheye(focal_count, params, rays):
    """s = 1 + k1 theta^2 + ..., pixel = f theta s + c."""
    focal, centre, k = np.split(np.asarray(params), [focal_count, focal_count + 2])
    across = np.linalg.norm(rays[:, :2], axis=1)
    theta = np.arctan2(across, rays[:, 2])
    radius = theta * np.polynomial.polynomial.polyval(theta**2, [1, *k])
    return focal * rays[:, :2] * (radius / across)[:, None] + centre


def unproject_polynomial_fisheye(focal_count, params, pixels):
    """By bisection from the axis to where the radius stops growing; NaN beyond."""
    focal, centre, k = np.split(np.asarray(params), [focal_count, focal_count + 2])
    radius = np.polynomial.Polynomial([1 if i == 1 else k[i // 2 - 1] if i % 2 else 0 for i in range(2 * len(k) + 2)])
    still = [root.real for root in radius.deriv().roots() if abs(root.imag) < 1e-9 and 0 < root.real < math.pi]
    at = (pixels - centre) / focal
    wanted = np.linalg.norm(at, axis=1)
    low, high = np.zeros(len(at)), np.full(len(at), min(still, default=math.pi))
    beyond = radius(high) < wanted
    for _ in range(80):
        middle = (low + high) / 2
        is_below = radius(middle) < wanted
        low, high = np.where(is_below, middle, low), np.where(is_below, high, middle)
    return along(np.where(beyond, np.nan, low), at / wanted[:, None])


class Lens:
    """A camera model in pycolmap, and beyond 90 degrees where a formula is known."""

    def __init__(self, model, width, height):
        self.model, self.width, self.height = model, width, height
        self.focal_count = POLYNOMIAL_FISHEYES.get(model)

    def camera(self, params):
        return pycolmap.Camera(camera_id=1, model=self.model, width=self.width, height=self.height, params=params)

    def project(self, params, rays):
        pixels = self.camera(params).img_from_cam(rays)
        if self.focal_count is not None:
            by_formula = polynomial_fisheye(self.focal_count, params, rays)
            before = rays[:, 2] > 1e-3
            off = np.abs(pixels - by_formula)[before].max(initial=0.0)
            assert not off > 1e-9, f"the formula of {self.model} is {off} px off pycolmap's"
            pixels[~before] = by_formula[~before]
        return pixels

    def rays(self, params, pixels):
        """The unit rays of those pixels that have one."""
        return self.rays_at(params, pixels)[1]

    def rays_at(self, params, pixels):
        """The indices of those pixels that have a ray, and the unit rays: the pixel is their image, and grows towards it from
        the axis."""
        at = self.camera(params).cam_from_img(pixels)
        rays = np.c_[at, np.ones(len(at))]
        if self.focal_count is not None:
            beyond = ~(np.linalg.norm(self.project(params, rays) - pixels, axis=1) < LEADS_BACK_PX)
            rays[beyond] = unproject_polynomial_fisheye(self.focal_count, params, pixels[beyond])
        rays /= np.linalg.norm(rays, axis=1)[:, None]
        seen = np.flatnonzero(np.linalg.norm(self.project(params, rays) - pixels, axis=1) < LEADS_BACK_PX)
        rays = rays[seen]
        across = np.linalg.norm(rays[:, :2], axis=1)
        angle, axis = np.arctan2(across, rays[:, 2]), rays[:, :2] / across[:, None]
        steps = [self.project(params, along(angle * share, axis)) for share in np.linspace(1e-3, 1, 200)]
        grows = np.all([((b - a) * axis).sum(axis=1) > 0 for a, b in zip(steps, steps[1:])], axis=0)
        return seen[grows], rays[grows]

    def wrt_param(self, params, index, rays):
        """d pixel / d parameter, by differences of fourth order."""
        step = 1e-3 * max(abs(params[index]), 0.1)

        def moved(by):
            return self.project([*params[:index], params[index] + by, *params[index + 1 :]], rays)

        return (8 * (moved(step) - moved(-step)) - (moved(2 * step) - moved(-2 * step))) / (12 * step)


def mean_of(parameter):
    """Of the estimated samples where there are statistics of them, else of all."""
    all_values = [Fraction(s["value"]) for s in parameter["samples"] if s["value"] is not None]
    estimated = [Fraction(s["value"]) for s in parameter["samples"] if s["state"] == "estimated"]
    return float(statistics.mean(estimated if len(estimated) > 1 else all_values))


def check_std_px(checks, name, population):
    """The std in px of every parameter that has one."""
    lens = Lens(population["model"], population["width"], population["height"])
    params = [mean_of(parameter) for parameter in population["parameters"]]
    pixels = cell_centres(population["width"], population["height"])
    rays = lens.rays(params, pixels)
    share = len(rays) / len(pixels)
    estimated = [(i, p) for i, p in enumerate(population["parameters"]) if p["statistics"] is not None]
    if lens.model in WIDE and population["ray_share"] > share:
        checks.skipped[lens.model] += len(estimated)
        return
    checks.equal(f"{name} ray_share", population["ray_share"], share)
    for index, parameter in estimated:
        got, what = parameter["statistics"]["std_px"], f"{name} {parameter['name']} std_px"
        if len(rays) == 0:
            checks.equal(what, got, None)
            continue
        values = [Fraction(s["value"]) for s in parameter["samples"] if s["state"] == "estimated"]
        moved = lens.wrt_param(params, index, rays) * float(statistics.stdev(values))
        want = math.sqrt((moved**2).sum(axis=1).mean())
        checks.near(what, got, want, STD_PX_TOLERANCE * want)
        checks.std_px_count += 1


# The CSV files hold the same, to the last bit.


def read_csv(checks, file, columns):
    with open(file, newline="", encoding="utf-8") as lines:
        reader = csv.reader(lines)
        checks.equal(f"{file.name}: columns", next(reader), columns)
        return [dict(zip(columns, row, strict=True)) for row in reader]


def number(text):
    return bits(float(text)) if text else None


def check_csv(checks, path, folder, populations):
    samples, rows = [], []
    for population in populations:
        for parameter in population["parameters"]:
            subject = [*(str(population[key]) for key in SUBJECT[:5]), parameter["name"], parameter["class"], "colmap"]
            for s in parameter["samples"]:
                camera_id = "" if s["camera_id"] is None else str(s["camera_id"])
                outlier = "true" if s["is_outlier"] else "false"
                samples.append([*subject, s["run"], camera_id, s["state"], bits(s["value"]), "", outlier])
            rows.append(subject + statistics_row(parameter))
    checks.equal(f"{path}: subjects", len({tuple(row[:8]) for row in rows}), len(rows))

    got = read_csv(checks, folder / "samples.csv", SAMPLE_COLUMNS)
    got = [list((row | {"value": number(row["value"])}).values()) for row in got]
    checks.rows_equal(f"{path}: samples.csv", got, samples)
    got = read_csv(checks, folder / "statistics.csv", STATISTICS_COLUMNS)
    got = [list((row | {key: number(row[key]) for key in NUMBERS}).values()) for row in got]
    checks.rows_equal(f"{path}: statistics.csv", got, rows)


def statistics_row(parameter):
    """What statistics.csv says of a parameter, by analysis.json."""
    s = parameter["statistics"]
    if s is None:
        return ["0", *[None] * len(NUMBERS), "", ""]
    flat = s | dict(zip(("std_low_95", "std_high_95"), s["std_interval_95"]))
    flat |= dict(zip(("whisker_low", "whisker_high"), s["whiskers"]))
    outliers = ";".join(sample["run"] for sample in parameter["samples"] if sample["is_outlier"])
    return [str(s["n"]), *(bits(flat[key]) for key in NUMBERS), "", outliers]


# The thesis: std as it prints them, means as its rows give them (its own printed means of three parameters are slips).

THESIS = {
    ("opencv_camera1", "OPENCV"): {
        "fx": ("51.0312", 3215.44 / 3),
        "fy": ("6.4776", 3103.14 / 3),
        "k1": ("0.0107", -1.067677 / 3),
        "k2": ("0.0153", 0.411358 / 3),
        "p1": ("0.0020", 0.000346 / 3),
        "p2": ("0.0044", -0.00076791 / 3),
    },
    ("simple_radial_fisheye_camera3", "SIMPLE_RADIAL_FISHEYE"): {
        "f": ("9.9028", 2551.578 / 6),
        "k": ("0.0068", -0.4301 / 6),
    },
}


def check_thesis(checks, path, analysis):
    """When the thesis's fixtures are among the runs."""
    found = 0
    for (folder, model), printed in THESIS.items():
        groups = {r["group"] for r in analysis["runs"] if any(folder in Path(f["path"]).parts for f in r["files"])}
        found += len(groups)
        for group in groups:
            (population,) = [p for p in analysis["populations"] if p["group"] == group and p["model"] == model]
            got = {p["name"]: p["statistics"] for p in population["parameters"] if p["statistics"]}
            checks.equal(f"thesis, {folder}: parameters estimated", set(got), set(printed))
            for name, (std, mean) in printed.items():
                checks.equal(f"thesis, {folder} {name}: std", f"{got[name]['std']:.4f}", std)
                checks.near(f"thesis, {folder} {name}: mean", got[name]["mean"], mean, 1e-12 * abs(mean) + 1e-15)
    if path.name == "thesis":
        checks.equal(f"{path}: cameras of the thesis", found, len(THESIS))


def no_constant(name):
    raise ValueError(f"analysis.json holds {name}, which JSON does not know")


def check_path(checks, binary, path, validator):
    with tempfile.TemporaryDirectory() as scratch:
        out = Path(scratch) / "out"
        command = [binary, "analyze", str(path), "--no-refine", "--out", str(out), "--format", "json,csv"]
        done = subprocess.run(command, capture_output=True, text=True)
        checks.equal(f"{path}: exit code", done.returncode, 0)
        if done.returncode != 0:
            checks.differences.append(done.stderr.strip())
            return
        analysis = json.loads((out / "analysis.json").read_text(encoding="utf-8"), parse_constant=no_constant)
        errors = [f"{error.json_path}: {error.message}" for error in validator.iter_errors(analysis)]
        checks.equal(f"{path}: errors against the schema", errors, [])
        if errors:
            return
        cameras = check_runs(checks, path, analysis)
        check_samples(checks, path, analysis, cameras)
        for population in analysis["populations"]:
            name = f"{path}: {population['group']} {population['camera']} {population['model']}"
            check_names(checks, path, population)
            for index, parameter in enumerate(population["parameters"]):
                check_states(checks, f"{name} {parameter['name']}", population, index)
                check_statistics(checks, f"{name} {parameter['name']}", parameter)
            check_compensation(checks, name, population)
            check_std_px(checks, name, population)
        check_groups(checks, path, analysis, Lens, cell_centres, WIDE)
        check_csv(checks, path, out, analysis["populations"])
        check_thesis(checks, path, analysis)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("calibstab", type=Path)
    parser.add_argument("paths", type=Path, nargs="+")
    parser.add_argument("--at-least", type=int, default=100, help="values to compare in each path, or the check has failed")
    arguments = parser.parse_args()
    pycolmap.logging.minloglevel = 2

    binary = str(arguments.calibstab.resolve())
    schema = json.loads(subprocess.run([binary, "schema"], capture_output=True, check=True).stdout)
    validator_class = jsonschema.validators.validator_for(schema)
    validator_class.check_schema(schema)

    compared = 0
    differences = []
    for path in arguments.paths:
        checks = Checks()
        check_path(checks, binary, path, validator_class(schema))
        if checks.count < arguments.at_least:
            checks.differences.append(f"{path}: only {checks.count} values compared, at least {arguments.at_least} expected")
        skipped = "".join(f", {count} of {model} skipped" for model, count in sorted(checks.skipped.items()) if count)
        print(
            f"{path}: {checks.count} values compared, {len(checks.differences)} differ"
            f" ({checks.std_px_count} std in px, {checks.group_count} of several groups{skipped})",
            flush=True,
        )
        compared += checks.count
        differences += checks.differences
    for difference in differences[:50]:
        print(difference, file=sys.stderr)
    print(f"{compared} values compared, {len(differences)} differ")
    sys.exit(1 if differences else 0)


if __name__ == "__main__":
    main()
