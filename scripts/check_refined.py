#!/usr/bin/env python3
"""Compares what `analyze` says of refined runs with `refine`, with numpy, and with pycolmap's own adjustment.

Usage: check_refined.py CALIBSTAB GROUP [GROUP ...] [--at-least N]

Each GROUP is a folder of runs. It is analysed with refinement and without (`--no-refine`, which check_statistics.py checks), and
each run is refined by itself with `refine`. Equal to the last bit must be: what stands as COLMAP left it and the analysis without
refinement; the refined values, costs and covariances and those of `refine`, whose files pycolmap reads; samples.csv and
analysis.json. Means, standard deviations, predicted ones and correlations are derived anew by numpy to 1e-12 of the largest number
that enters them. Where pycolmap's adjustment of the same model converges, with a median depth of 1 and without unprojectable
observations, the samples are within 1e-4 of their std of its result.
"""

import argparse
import csv
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pycolmap

from crosscheck import adjust, delete_unprojectable, median_depth, unprojectable


class Checks:
    def __init__(self):
        self.count, self.by_pycolmap, self.differences = 0, 0, []

    def equal(self, what, got, want):
        self.count += 1
        if got != want:
            self.differences.append(f"{what}: {got!r}, expected {want!r}")

    def near(self, what, got, want, tolerance):
        self.count += 1
        if got is None or not abs(got - want) <= tolerance:
            self.differences.append(f"{what}: {got!r}, expected {want!r} +- {tolerance:.1e}")


def analysis(binary, group, out, *options):
    command = [binary, "analyze", str(group), "--out", str(out), "--format", "json,csv", "--quiet", *options]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return json.loads((out / "analysis.json").read_text(encoding="utf-8"))


def refine(binary, model, out):
    """What `refine` writes and says; none where it refuses."""
    done = subprocess.run([binary, "refine", str(model), "--out", str(out), "--json", "--quiet"], capture_output=True, text=True)
    return (pycolmap.Reconstruction(str(out)), json.loads(done.stdout)) if done.returncode == 0 else None


def check_run(checks, name, record, refined):
    """The record of a run against `refine`."""
    if refined is None:
        checks.equal(f"{name} failed", record["refinement"]["failure"] is not None, True)
        return
    model, said = refined
    adjustment = record["refinement"]["adjustment"]
    for key in ("iterations", "initial_cost", "cost", "images", "points", "observations", "components", "unknowns", "rank", "sigma_px"):
        checks.equal(f"{name} {key}", adjustment[key], said[key])
    for key in ("unprojectable", "lone_points", "of_lone_points"):
        checks.equal(f"{name} {key}", adjustment[key], said["dropped"][key])
    is_converged = said["reason"] in ("converged", "converged to rounding")
    checks.equal(f"{name} failed", record["refinement"]["failure"] is None, is_converged)
    matrix = said["covariance"]["matrix"]
    for camera in adjustment["cameras"]:
        own = [at for at, param in enumerate(said["covariance"]["params"]) if param["camera"] == camera["camera_id"]]
        what = f"{name} camera {camera['camera_id']}"
        checks.equal(f"{what} values", camera["refined"], list(model.cameras[camera["camera_id"]].params))
        checks.equal(f"{what} free", camera["free"], [said["covariance"]["params"][at]["name"] for at in own])
        want = None if matrix is None else [[matrix[row][column] for column in own] for row in own]
        checks.equal(f"{what} covariance", camera["covariance"], want)


def check_samples(checks, name, population, cameras):
    """Samples against the records of their runs' cameras, by run and camera."""
    used = set()
    for index, parameter in enumerate(population["parameters"]):
        for sample in parameter["samples"]:
            what = f"{name} {parameter['name']} in {sample['run']}"
            camera = cameras.get((sample["run"], sample["camera_id"]))
            if camera is None:
                checks.equal(f"{what} state", (sample["state"], sample["value"]), ("failed", None))
                continue
            used.add((sample["run"], sample["camera_id"]))
            checks.equal(f"{what} value", sample["value"], camera["refined"][index])
            is_free = parameter["name"] in camera["free"]
            checks.equal(f"{what} state", sample["state"], "estimated" if is_free else "held")
            std = None
            if is_free and camera["covariance"] is not None:
                place = camera["free"].index(parameter["name"])
                std = float(np.sqrt(camera["covariance"][place][place]))
            checks.equal(f"{what} predicted std", sample["predicted_std"], std)
    return used


def check_numbers(checks, name, population, cameras, used):
    for parameter in population["parameters"]:
        samples = [s for s in parameter["samples"] if s["state"] == "estimated"]
        values = np.array([s["value"] for s in samples])
        what = f"{name} {parameter['name']}"
        checks.equal(f"{what} has statistics", parameter["statistics"] is not None, len(values) >= 2)
        if len(values) >= 2:
            tolerance = 1e-12 * abs(values).max()
            checks.near(f"{what} mean", parameter["statistics"]["mean"], values.mean(), tolerance)
            checks.near(f"{what} std", parameter["statistics"]["std"], values.std(ddof=1), tolerance)
        stds = [s["predicted_std"] for s in samples]
        if stds and None not in stds:
            want = np.sqrt(np.mean(np.square(stds)))
            checks.near(f"{what} predicted std", parameter["predicted_std"], want, 1e-12 * want)
        else:
            checks.equal(f"{what} predicted std", parameter["predicted_std"], None)
    matrices = [cameras[key]["covariance"] for key in sorted(used)]
    found = population["predicted_correlations"]
    if not matrices or None in matrices or not matrices[0]:
        checks.equal(f"{name} predicted correlations", found, None)
        return
    mean = np.mean(matrices, axis=0)
    want = mean / np.sqrt(np.outer(np.diag(mean), np.diag(mean)))
    checks.near(f"{name} predicted correlations", abs(np.array(found["matrix"]) - want).max(), 0, 1e-12)


def check_against_pycolmap(checks, name, folder, record, cameras, run):
    """The intrinsics that pycolmap's adjustment finds, in units of their std."""
    model = pycolmap.Reconstruction(str(folder))
    if record["refinement"]["adjustment"]["unprojectable"] or unprojectable(model):
        return
    delete_unprojectable(model, [])
    model.transform(pycolmap.Sim3d(1 / median_depth(model), pycolmap.Rotation3d(), np.zeros(3)))
    _, summary = adjust(model, "focal,extra", "squared")
    if summary.termination_type.name != "CONVERGENCE" or unprojectable(model):
        return
    for (of_run, camera_id), camera in cameras.items():
        if of_run != run or camera["covariance"] is None:
            continue
        names = model.cameras[camera_id].params_info.split(", ")
        for free, row in zip(camera["free"], range(len(camera["free"]))):
            place, std = names.index(free), camera["covariance"][row][row] ** 0.5
            got, want = camera["refined"][place], model.cameras[camera_id].params[place]
            checks.near(f"{name} camera {camera_id} {free} by pycolmap", got, want, 1e-4 * std)
            checks.by_pycolmap += 1


def check_csv(checks, name, file, populations):
    """Every sample stands in samples.csv, as refined and as COLMAP left it, to the last bit."""
    want = []
    for population in populations:
        sides = [("refined", population["parameters"]), ("colmap", population["as_left"]["parameters"])]
        for source, parameters in sides:
            for parameter in parameters:
                for s in parameter["samples"]:
                    numbers = [None if s[key] is None else float(s[key]) for key in ("value", "predicted_std")]
                    want.append((population["group"], population["camera"], parameter["name"], source, s["run"], s["state"], *numbers))
    with open(file, newline="", encoding="utf-8") as lines:
        got = [
            (r["group"], r["camera"], r["parameter"], r["source"], r["run"], r["state"])
            + tuple(float(r[key]) if r[key] else None for key in ("value", "predicted_std"))
            for r in csv.DictReader(lines)
        ]
    checks.equal(f"{name} rows of samples.csv", len(got), len(want))
    for one, other in zip(got, want):
        checks.equal(f"{name} samples.csv", one, other)


def check_group(checks, binary, group):
    with tempfile.TemporaryDirectory() as scratch:
        scratch = Path(scratch)
        refined = analysis(binary, group, scratch / "refined")
        left = analysis(binary, group, scratch / "left", "--no-refine")
        checks.equal(f"{group}: populations", len(refined["populations"]), len(left["populations"]))
        cameras = {}
        for record in refined["runs"]:
            name, folder = f"{group}: {record['run']}", Path(record["files"][0]["path"]).parent
            check_run(checks, name, record, refine(binary, folder, scratch / record["group"] / record["run"]))
            failure, adjustment = record["refinement"]["failure"], record["refinement"]["adjustment"]
            if failure is None:
                good = [camera for camera in adjustment["cameras"] if camera["failure"] is None]
                cameras |= {(record["group"], record["run"], camera["camera_id"]): camera for camera in good}
                of_run = {(record["run"], camera["camera_id"]): camera for camera in good}
                check_against_pycolmap(checks, name, folder, record, of_run, record["run"])
        for population, other in zip(refined["populations"], left["populations"]):
            name = f"{group}: {population['group']} {population['camera']}"
            of_group = {key[1:]: camera for key, camera in cameras.items() if key[0] == population["group"]}
            used = check_samples(checks, name, population, of_group)
            check_numbers(checks, name, population, of_group, used)
            checks.equal(f"{name} parameters as left", population["as_left"]["parameters"], other["parameters"])
            spread, want = population["as_left"]["spread"], other["spread"]
            checks.equal(f"{name} has a spread as left", spread is None, want is None)
            for key in ("raw", "rotated") if spread and want else ():
                checks.equal(f"{name} {key} spread as left", spread[f"{key}_rms_px"], want[key]["rms_px"])
        check_csv(checks, group, scratch / "refined" / "samples.csv", refined["populations"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("calibstab", type=Path)
    parser.add_argument("groups", type=Path, nargs="+")
    parser.add_argument("--at-least", type=int, default=100, help="values to compare in all, or the check has failed")
    parser.add_argument("--by-pycolmap", type=int, default=1, help="of these with pycolmap's adjustment, or the check has failed")
    given = parser.parse_args()
    pycolmap.logging.minloglevel = 3
    checks = Checks()
    for group in given.groups:
        before = checks.count, checks.by_pycolmap
        check_group(checks, str(given.calibstab.resolve()), group)
        count, by_pycolmap = checks.count - before[0], checks.by_pycolmap - before[1]
        print(f"{group}: {count} values compared, {by_pycolmap} of them with pycolmap's adjustment", flush=True)
    if checks.count < given.at_least or checks.by_pycolmap < given.by_pycolmap:
        checks.differences.append("too few values compared")
    for difference in checks.differences[:50]:
        print(difference, file=sys.stderr)
    print(f"{checks.count} values compared, {len(checks.differences)} differ")
    sys.exit(1 if checks.differences else 0)


if __name__ == "__main__":
    main()
