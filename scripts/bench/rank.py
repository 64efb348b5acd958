"""CPU seconds of the adjustments of `calibstab rank`, beside pycolmap adjusting the same images: rank.py CALIBSTAB [--rounds N]

A synthetic model of 50 images is made, and brought to its optimum. In each round calibstab chooses half of the images by chance
200 times and adjusts what it chose; pycolmap adjusts the first 20 of these choices, counted ten times: the model of these images
alone, as pycolmap holds points that other images see too. Both start off the optimum by the same: focal lengths and distortion by a
hundredth, rotations by 0.001 rad, centres and points by a thousandth of their distance. Of calibstab all is counted: reading,
adjusting the whole, drawing noise, the poses of the images held out, scores, plots and report. Of pycolmap only making the
configuration and solving. One thread each.
"""

import argparse
import json
import resource
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import pycolmap

REPEATS, SIZE, LOOPED = 200, 25, 20
OFF, OF_ROTATIONS_AND_PLACES = 0.01, 0.1


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
    return [{names[place] for place in sample["images"]} for sample in samples], (
        after.ru_utime - before.ru_utime
    )


def set_off(reconstruction, random):
    """Puts a reconstruction off its optimum as `rank` does."""
    for camera in reconstruction.cameras.values():
        params = np.array(camera.params)
        free = list(camera.focal_length_idxs()) + list(camera.extra_params_idxs())
        params[free] *= 1 + OFF * random.standard_normal(len(free))
        camera.params = params
    points = reconstruction.points3D.values()
    first = [reconstruction.images[point.track.elements[0].image_id] for point in points]
    distances = [np.linalg.norm(image.cam_from_world() * point.xyz) for image, point in zip(first, points)]
    turned = OFF * OF_ROTATIONS_AND_PLACES
    moved = turned * np.median(distances)
    for image_id in reconstruction.reg_image_ids():
        image = reconstruction.images[image_id]
        rotation = pycolmap.Rotation3d(turned * random.standard_normal(3)) * image.cam_from_world().rotation
        centre = image.projection_center() + moved * random.standard_normal(3)
        # Each camera is a rig of its own here.
        image.frame.rig_from_world = pycolmap.Rigid3d(rotation, -(rotation * centre))
    for point in points:
        point.xyz = point.xyz + moved * random.standard_normal(3)


def adjusted(model, chosen, random):
    """CPU seconds of pycolmap for one choice."""
    reconstruction = pycolmap.Reconstruction(model)
    for image_id in list(reconstruction.reg_image_ids()):
        if reconstruction.images[image_id].name not in chosen:
            reconstruction.deregister_frame(reconstruction.images[image_id].frame_id)
    set_off(reconstruction, random)
    options = pycolmap.BundleAdjustmentOptions()
    options.print_summary = False
    options.ceres.solver_options.num_threads = 1
    start = time.process_time()
    config = pycolmap.BundleAdjustmentConfig()
    for image_id in reconstruction.reg_image_ids():
        config.add_image(image_id)
    config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    solved = pycolmap.create_default_bundle_adjuster(options, config, reconstruction).solve()
    assert solved.is_solution_usable()
    return time.process_time() - start


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("calibstab")
    parser.add_argument("--rounds", type=int, default=4)
    arguments = parser.parse_args()
    ratios = []
    with tempfile.TemporaryDirectory() as folder:
        made, model = Path(folder) / "made", Path(folder) / "model"
        subprocess.run(
            [arguments.calibstab, "synth", "--images", "50", "--points", "5000", "--per-image", "600"]
            + ["--out", made, "--quiet"],
            check=True,
        )
        subprocess.run(
            [arguments.calibstab, "refine", made, "--out", model, "--quiet"],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        for seed in range(arguments.rounds):
            random = np.random.default_rng(seed)
            chosen, ours = choices(arguments.calibstab, model, Path(folder) / f"ranking{seed}", seed)
            spent = sum(adjusted(model, names, random) for names in chosen[:LOOPED])
            theirs = spent * REPEATS / LOOPED
            ratios.append(theirs / ours)
            print(
                f"{REPEATS} adjustments of {SIZE} of 50 images: calibstab {ours:.2f} s, pycolmap {theirs:.2f} s,"
                f" {ratios[-1]:.1f} times as much",
                flush=True,
            )
    print(f"the median: {statistics.median(ratios):.1f} times as much")


if __name__ == "__main__":
    main()
