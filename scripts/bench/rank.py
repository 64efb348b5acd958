"""CPU seconds of the adjustments of `calibstab rank`, beside pycolmap adjusting the same images: rank.py CALIBSTAB [--rounds N]

A synthetic model of 50 images is made. In each round calibstab chooses half of them by chance 50 times and adjusts what it chose,
from a start that is off; pycolmap then adjusts the same choices, each from the same model with its intrinsics off by a hundredth
and points and poses as they are: an easier start. Of calibstab all is counted: reading, adjusting the whole, the poses of the images
held out, scores and report. Of pycolmap only making the configuration and solving. One thread each.
"""

import argparse
import json
import resource
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import pycolmap

REPEATS, SIZE = 50, 25


def choices(program, model, folder, seed):
    """The images of each choice, and what choosing and adjusting cost."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [program, "rank", model, "--sizes", str(SIZE), "--repeats", str(REPEATS), "--seed", str(seed)]
        + ["--pool", "random:1", "--heuristics", "random", "--threads", "1", "--quiet", "--out", folder],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    record = json.loads((folder / "selection.json").read_text())
    names = record["models"][0]["images"]
    samples = record["samples"]
    assert len(samples) == REPEATS and not any(sample["failure"] for sample in samples)
    return [[names[place] for place in sample["images"]] for sample in samples], (
        after.ru_utime - before.ru_utime
    )


def adjusted(model, chosen, random):
    """CPU seconds of pycolmap for one choice."""
    reconstruction = pycolmap.Reconstruction(model)
    for camera in reconstruction.cameras.values():
        params = np.array(camera.params)
        free = list(camera.focal_length_idxs()) + list(camera.extra_params_idxs())
        params[free] *= 1 + 0.01 * random.standard_normal(len(free))
        camera.params = params
    options = pycolmap.BundleAdjustmentOptions()
    options.print_summary = False
    options.ceres.solver_options.num_threads = 1
    start = time.process_time()
    config = pycolmap.BundleAdjustmentConfig()
    for image in reconstruction.images.values():
        if image.name in chosen:
            config.add_image(image.image_id)
    config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    solved = pycolmap.create_default_bundle_adjuster(options, config, reconstruction).solve()
    assert solved.is_solution_usable()
    return time.process_time() - start


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("calibstab")
    parser.add_argument("--rounds", type=int, default=4)
    arguments = parser.parse_args()
    ours, theirs = [], []
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "model"
        subprocess.run(
            [arguments.calibstab, "synth", "--images", "50", "--points", "5000", "--per-image", "600"]
            + ["--out", model, "--quiet"],
            check=True,
        )
        for seed in range(arguments.rounds):
            chosen, cpu = choices(arguments.calibstab, model, Path(folder) / f"ranking{seed}", seed)
            ours.append(cpu)
            random = np.random.default_rng(seed)
            theirs.append(sum(adjusted(model, set(names), random) for names in chosen))
            print(f"{REPEATS} adjustments of {SIZE} of 50 images: calibstab {cpu:.2f} s, pycolmap {theirs[-1]:.2f} s")
    print(f"in all: {sum(ours):.2f} s and {sum(theirs):.2f} s, {sum(theirs) / sum(ours):.1f} times as much")


if __name__ == "__main__":
    main()
