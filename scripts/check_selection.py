"""`calibstab rank` beside pycolmap, numpy and its own schema.

usage: check_selection.py CALIBSTAB MODEL [--size N] [--at-least COMPARISONS]

With `--noise keep` a choice is adjusted to the optimum of its own observations, wherever it starts: pycolmap, from the optimum of the
whole model, must find the same intrinsics, within 1e-4 of their std. Cells are computed anew from their samples by numpy.
"""

import argparse
import itertools
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import jsonschema
import numpy as np
import pycolmap
from crosscheck import adjust, covariances, delete_unprojectable, median_depth, unprojectable

HEURISTICS, REPEATS, ADJUSTED = ["random", "covisibility", "growing-error"], 4, 6


class Check:
    def __init__(self):
        self.count, self.faults = 0, 0

    def that(self, is_so, text):
        self.count += 1
        self.faults += not is_so
        if not is_so:
            print(f"  FAULT {text}")

    def close(self, said, computed, text):
        self.that(abs(said - computed) <= 1e-12 * max(1.0, abs(computed)), f"{text}: {said}, computed {computed}")


def run(*command):
    return subprocess.run(list(map(str, command)), check=True, capture_output=True, text=True).stdout


def check_adjusted(check, whole, names, sample):
    """One choice, adjusted by pycolmap."""
    model = pycolmap.Reconstruction(str(whole))
    for image_id in list(model.reg_image_ids()):
        if model.images[image_id].name not in names:
            model.deregister_frame(model.images[image_id].frame_id)
    with tempfile.TemporaryDirectory() as folder:
        # A model read anew has no frames without a pose, at which covariances fail.
        model.write_text(folder)
        model = pycolmap.Reconstruction(folder)
    delete_unprojectable(model, unprojectable(model))
    # COLMAP stops at an absolute gradient.
    model.transform(pycolmap.Sim3d(1 / median_depth(model), pycolmap.Rotation3d(), np.zeros(3)))
    adjuster, summary = adjust(model, "focal,extra", "squared")
    found = covariances(model, adjuster, summary)
    for camera in sample["cameras"]:
        theirs = model.cameras[camera["camera_id"]]
        free = list(theirs.focal_length_idxs()) + list(theirs.extra_params_idxs())
        stds = np.sqrt(np.diag(found[camera["camera_id"]]))
        stds = stds[free] if len(stds) > len(free) else stds
        shift = abs((np.array(camera["params"]) - theirs.params)[free] / stds).max()
        check.that(shift <= 1e-4, f"{sample['heuristic']} {sample['images']}: intrinsics within {shift:.1e} std")


def check_cell(check, cell, samples):
    """What a cell says of its samples."""
    name = f"{cell['heuristic']} of {cell['size']}"
    good = [sample for sample in samples if sample["failure"] is None]
    check.that((cell["n"], cell["failures"]) == (len(good), len(samples) - len(good)), f"{name}: counts")
    for key, of in (("error", "error_px"), ("raw", "raw_error_px")):
        squares = [sample[of] ** 2 for sample in good]
        check.close(cell[key]["rms_px"], np.sqrt(np.mean(squares)), f"{name}: {key}")
        for camera in cell["cameras"]:
            parts = camera[key]
            # Bias and spread are what the squared error is made of.
            whole = np.hypot(parts["bias_px"], np.sqrt((len(good) - 1) / len(good)) * parts["spread_px"])
            check.that(abs(whole / parts["rms_px"] - 1) < 0.01, f"{name}: {key} {parts}, together {whole}")
    chosen = np.bincount(sum((sample["images"] for sample in good), []), minlength=len(cell["chosen"]))
    check.that(list(chosen) == cell["chosen"], f"{name}: how often each image was chosen")
    shared = [len({*one["images"]} & {*other["images"]}) / cell["size"] for one, other in itertools.combinations(good, 2)]
    check.close(cell["overlap"], np.mean(shared), f"{name}: overlap")
    for camera in cell["cameras"]:
        for place, (parameter, said) in enumerate(camera["parameters"]):
            own = [next(it["params"] for it in sample["cameras"] if it["camera_id"] == camera["camera_id"]) for sample in good]
            values = np.array(own)
            match = [at for at in range(values.shape[1]) if abs(values[:, at].mean() - said["mean"]) <= 1e-9 * abs(said["mean"])]
            check.that(len(match) == 1, f"{name}: mean of {parameter}")
            for at in match:
                check.that(np.isclose(values[:, at].std(ddof=1), said["std"], rtol=1e-9), f"{name}: std of {parameter}")
                check.that(np.isclose(np.median(values[:, at]), said["median"], rtol=1e-12), f"{name}: median of {parameter}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("calibstab", type=Path)
    parser.add_argument("model", type=Path)
    parser.add_argument("--size", type=int, default=10)
    parser.add_argument("--at-least", type=int, default=1, help="fewer checks than these are a fault")
    given = parser.parse_args()
    pycolmap.logging.minloglevel = 3
    check, calibstab = Check(), given.calibstab.resolve()
    schema = json.loads(run(calibstab, "schema", "selection"))
    validator = jsonschema.validators.validator_for(schema)
    validator.check_schema(schema)
    with tempfile.TemporaryDirectory() as folder:
        whole, out = Path(folder) / "whole", Path(folder) / "ranking"
        run(calibstab, "refine", given.model, "--out", whole, "--quiet")
        command = ["rank", given.model, "--noise", "keep", "--sizes", given.size, "--repeats", REPEATS, "--out", out]
        run(calibstab, *command, "--heuristics", ",".join(HEURISTICS), "--quiet")
        found = json.loads((out / "selection.json").read_text())
        for error in validator(schema).iter_errors(found):
            check.that(False, f"schema: {error.message} at {list(error.absolute_path)}")
        names = found["models"][0]["images"]
        good = [sample for sample in found["samples"] if sample["failure"] is None]
        for sample in good[:: max(1, len(good) // ADJUSTED)]:
            check_adjusted(check, whole, {names[at] for at in sample["images"]}, sample)
        for cell in found["cells"]:
            own = [it for it in found["samples"] if (it["heuristic"], it["size"]) == (cell["heuristic"], cell["size"])]
            check_cell(check, cell, own)
    print(f"{given.model}: {check.count} checks, {check.faults} faults")
    sys.exit(check.faults > 0 or check.count < given.at_least)


if __name__ == "__main__":
    main()
