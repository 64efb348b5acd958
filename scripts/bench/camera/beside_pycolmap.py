"""Compares what projecting and unprojecting costs with calibstab and with pycolmap: beside_pycolmap.py [ROUNDS]

Both go over the same 4096 points, on one core, in turns. Printed are ns of CPU time a point, the median of the rounds, and
the ratio within a round: its median, lowest and highest; and how far the rays that are found project from their pixels.
"""

import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pycolmap

HERE = Path(__file__).resolve().parent
POINTS, PASSES = 4096, 61


def ours(what):
    """What our program prints, a list of words for each model."""
    program = Path(os.environ.get("CARGO_TARGET_DIR", HERE / "target")) / "release/bench-camera"
    lines = subprocess.run([program, what], check=True, capture_output=True, text=True).stdout.splitlines()
    return [line.split() for line in lines]


def cost(work, argument):
    """The median ns of CPU time a point."""
    times = []
    for _ in range(PASSES):
        start = time.process_time_ns()
        work(argument)
        times.append((time.process_time_ns() - start) / POINTS)
    return statistics.median(times)


def camera_and_points(words):
    numbers = np.array(words[1:], dtype=float)
    params, rows = numbers[: -5 * POINTS], numbers[-5 * POINTS :].reshape(POINTS, 5)
    camera = pycolmap.Camera(model=words[0], width=1024, height=1024, params=params)
    return camera, np.ascontiguousarray(rows[:, :3]), np.ascontiguousarray(rows[:, 3:])


def main():
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    subprocess.run(["cargo", "build", "--quiet", "--release", "--locked"], cwd=HERE, check=True)
    scenes = {words[0]: camera_and_points(words) for words in ours("points")}
    costs = {name: [] for name in scenes}
    for _ in range(rounds):
        for (name, (camera, points, pixels)), our in zip(scenes.items(), ours("ours"), strict=True):
            theirs = cost(camera.img_from_cam, points), cost(camera.cam_from_img, pixels)
            costs[name].append((*map(float, our), *theirs))
    print(f"{'model':<16}{'work':<11}{'ours':>6}{'pycolmap':>10}  ratio                  error of rays, px: ours, pycolmap")
    for name, (camera, _, pixels) in scenes.items():
        at = np.array(camera.cam_from_img(pixels))
        back = np.array(camera.img_from_cam(np.c_[at, np.ones(POINTS)]))
        error = np.linalg.norm(back - pixels, axis=1).max()
        for index, work in enumerate(["project", "unproject"]):
            ours_ns, theirs_ns = ([one[place] for one in costs[name]] for place in (index, 3 + index))
            ratios = [theirs / our for our, theirs in zip(ours_ns, theirs_ns, strict=True)]
            ratio = f"{statistics.median(ratios):5.1f} ({min(ratios):.1f} to {max(ratios):.1f})"
            errors = f"{costs[name][0][2]:.1e}, {error:.1e}" if work == "unproject" else ""
            medians = f"{statistics.median(ours_ns):6.1f}{statistics.median(theirs_ns):10.1f}"
            print(f"{name:<16}{work:<11}{medians}  {ratio:<22} {errors}")


if __name__ == "__main__":
    main()
