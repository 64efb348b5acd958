"""CPU seconds of `calibstab analyze` on folders of repeated runs, beside a pycolmap script that reads and refines the same models.

usage: analyze_beside_pycolmap.py CALIBSTAB FOLDER... [--rounds N]
Both with one thread. calibstab also computes covariances, tests what was held, and reports; pycolmap only adjusts.
"""

import argparse
import os
import resource
import statistics
import subprocess
import sys
from pathlib import Path

REFINE = """
import sys, pycolmap
pycolmap.logging.minloglevel = 3
for folder in sys.argv[1:]:
    model = pycolmap.Reconstruction(folder)
    options = pycolmap.BundleAdjustmentOptions()
    options.print_summary, options.ceres.solver_options.num_threads = False, 1
    config = pycolmap.BundleAdjustmentConfig()
    for image in model.reg_image_ids():
        config.add_image(image)
    config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    pycolmap.create_default_ceres_bundle_adjuster(options, config, model).solve()
"""


def cpu_s(command):
    def spent():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    before = spent()
    environment = os.environ | {"RAYON_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    subprocess.run(list(map(str, command)), check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)
    return spent() - before


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("calibstab", type=Path)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    start = [sys.executable, "-c", "import pycolmap"]
    for folder in given.folders:
        models = sorted({path.parent for name in ("cameras.txt", "cameras.bin") for path in folder.rglob(name)})
        rounds = []
        for _ in range(given.rounds):
            theirs = cpu_s([sys.executable, "-c", REFINE, *models]) - cpu_s(start)
            rounds.append((theirs, cpu_s([given.calibstab.resolve(), "analyze", folder])))
        theirs, ours = (statistics.median(one[side] for one in rounds) for side in (0, 1))
        ratio = statistics.median(one / other for one, other in rounds)
        print(f"{folder.name}: {len(models)} models; pycolmap {theirs:.2f} s / calibstab {ours:.2f} s = {ratio:.1f}", flush=True)


main()
