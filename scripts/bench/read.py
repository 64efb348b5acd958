"""Compares how fast calibstab and pycolmap read a model, and in how much memory: the table of README's "Fast".

usage: scripts/bench/read.py [--rounds N] [FOLDER]

Needs Linux, the packages of scripts/requirements.txt, and about 500 MB in FOLDER (target/bench unless named), where the
models are made once. In every round each reader reads each model in a process of its own; the ratios are of CPU seconds
within a round, and their median over the rounds is printed with the lowest and the highest.
"""

import argparse
import os
import statistics
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BENCH = Path(__file__).resolve().parent

# Images, points, keypoints an image beyond those that see a point.
MODELS = {"s200": (200, 40_000, 0), "t200_extra": (200, 40_000, 8_000), "s1000": (1000, 200_000, 0)}


def ours(model, threads):
    program = target() / "release/examples/read_model"
    return figures([program, model, "3"], RAYON_NUM_THREADS=str(threads))


def theirs(model):
    return figures([sys.executable, BENCH / "pycolmap_read.py", model, "2"])


def figures(command, **environment):
    """What a reader prints: name, figure, name, figure, ..."""
    environment = os.environ | environment
    words = subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout.split()
    return dict(zip(words[::2], map(float, words[1::2]), strict=True))


def target():
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))


def spread(ratios):
    return f"{statistics.median(ratios):5.1f} ({min(ratios):.1f} to {max(ratios):.1f})"


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--rounds", type=int, default=5)
    arguments.add_argument("folder", nargs="?", type=Path, default=target() / "bench")
    arguments = arguments.parse_args()

    build = ["cargo", "build", "--quiet", "--locked", "--release", "--example", "read_model"]
    subprocess.run(build, cwd=ROOT, check=True)
    for name, sizes in MODELS.items():
        if not (arguments.folder / name / "bin" / "points3D.bin").exists():
            make = [sys.executable, BENCH / "make_model.py", arguments.folder / name, *map(str, sizes)]
            subprocess.run(make, check=True)

    print("pycolmap / calibstab, median (lowest to highest) of", arguments.rounds, "rounds; memory calibstab / pycolmap")
    print(f"{'model':<12}{'form':<6}{'CPU s':<22}{'memory':<9}{'wall s, 2 threads':<22}{'memory':<9}")
    binary_seconds = {}
    for name in MODELS:
        for form in ("bin", "text"):
            model = arguments.folder / name / form
            rounds = [(theirs(model), ours(model, 1), ours(model, 2)) for _ in range(arguments.rounds)]
            cpu = [peer["cpu_s"] / one["cpu_s"] for peer, one, _ in rounds]
            wall = [peer["wall_s"] / two["wall_s"] for peer, _, two in rounds]
            memory = [statistics.median(r[i]["added_kib"] / r[0]["added_kib"] for r in rounds) for i in (1, 2)]
            print(f"{name:<12}{form:<6}{spread(cpu):<22}{memory[0]:<9.2f}{spread(wall):<22}{memory[1]:<9.2f}", flush=True)
            if form == "bin":
                binary_seconds[name] = statistics.median(peer["cpu_s"] for peer, _, _ in rounds)
            else:
                text_seconds = statistics.median(one["cpu_s"] for _, one, _ in rounds)
                print(f"{'':<12}our text against their binary: {binary_seconds[name] / text_seconds:.1f}", flush=True)


if __name__ == "__main__":
    main()
