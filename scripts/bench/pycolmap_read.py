"""Reads one model again and again with pycolmap, and prints what a read costs: pycolmap_read.py MODEL READS"""

import gc
import sys
import time
from pathlib import Path

import pycolmap

pycolmap.logging.minloglevel = 2


def kib(name):
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(name))


def main():
    model, reads = sys.argv[1], int(sys.argv[2])
    before = kib("VmRSS:")
    scene = pycolmap.Reconstruction(model)
    added = kib("VmHWM:") - before
    del scene
    gc.collect()

    cpu, wall = time.process_time(), time.perf_counter()
    for _ in range(reads):
        pycolmap.Reconstruction(model)
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    print(f"cpu_s {cpu / reads:.5f} wall_s {wall / reads:.5f} added_kib {added}")


if __name__ == "__main__":
    main()
