"""CPU seconds and steps of `calibstab refine` beside pycolmap's solve(), one thread each, in turn.

usage: against_pycolmap.py CALIBSTAB MODEL... [--rounds N]    (binary models, as make_perf_model.py writes them: init/bin)

The principal point is free. pycolmap's figure is that of solve() alone; calibstab's is that of the whole process, reading and
writing the model included, less that of `calibstab copy` of the same model, which does only that.
"""

import argparse
import json
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

PYCOLMAP = """
import json, sys, time, pycolmap
pycolmap.logging.minloglevel = 3
model = pycolmap.Reconstruction(sys.argv[1])
options = pycolmap.BundleAdjustmentOptions()
options.refine_principal_point, options.print_summary = True, False
options.ceres.solver_options.num_threads = 1
config = pycolmap.BundleAdjustmentConfig()
for image in model.reg_image_ids():
    config.add_image(image)
config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
adjuster = pycolmap.create_default_ceres_bundle_adjuster(options, config, model)
start = time.process_time()
summary = adjuster.solve().ceres_summary
seconds = time.process_time() - start
steps = summary.num_successful_steps + summary.num_unsuccessful_steps
print(json.dumps({"seconds": seconds, "steps": steps, "cost": summary.final_cost}))
"""


def cpu_seconds(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    said = subprocess.run(list(map(str, command)), check=True, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, said.stdout


def ours(calibstab, model, out):
    common = ["--quiet", "--threads", "1"]
    whole, said = cpu_seconds([calibstab, "refine", model, "--out", out, "--refine", "all", "--json", *common])
    copied, _ = cpu_seconds([calibstab, "copy", model, out, "--binary", *common])
    said = json.loads(said)
    return {"seconds": whole - copied, "steps": said["iterations"], "cost": said["cost"]}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("calibstab", type=Path)
    parser.add_argument("models", nargs="+", type=Path)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    print("model                 CPU s pycolmap  calibstab  ratio   steps          cost of calibstab")
    for model in given.models:
        rounds = []
        with tempfile.TemporaryDirectory() as out:
            for _ in range(given.rounds):
                theirs = json.loads(subprocess.check_output([sys.executable, "-c", PYCOLMAP, str(model)]))
                rounds.append((theirs, ours(given.calibstab, model, out)))
        seconds = [statistics.median(r[side]["seconds"] for r in rounds) for side in (0, 1)]
        ratio = statistics.median(r[0]["seconds"] / r[1]["seconds"] for r in rounds)
        theirs, our = rounds[0]
        above = our["cost"] / theirs["cost"] - 1
        name = "/".join(model.parts[-3:])
        print(f"{name:30} {seconds[0]:8.3f} {seconds[1]:8.3f} {ratio:6.1f}  {theirs['steps']:3} / {our['steps']:3}  pycolmap's times (1 {above:+.1e})")


main()
