"""CPU seconds, steps and memory of bundle adjustment beside pycolmap's, in turn.

usage: against_pycolmap.py BENCH MODEL... [--rounds N] [--threads N]    (binary models, as make_perf_model.py writes them: init/bin)
BENCH: cargo build --release --locked --manifest-path scripts/bench/bundle/Cargo.toml; then its target/release/bench-bundle

All intrinsics move. `solve`: pycolmap's solve(), and calibstab's steps alone (src/main.rs says how). `whole`: pycolmap's building of
the problem, solve() and new point errors; all of calibstab's `adjust`, the covariance of the intrinsics included. Neither counts
reading and writing files. A ratio is theirs to ours in one round: the median of the rounds. Memory is what the process grows by
after reading, at its peak.
"""

import argparse
import json
import statistics
import subprocess
import sys
from pathlib import Path

PYCOLMAP = """
import json, resource, sys, time, pycolmap
pycolmap.logging.minloglevel = 3
model = pycolmap.Reconstruction(sys.argv[1])
def peak_kb():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
read_kb = peak_kb()
begin = time.process_time()
options = pycolmap.BundleAdjustmentOptions()
options.refine_principal_point, options.print_summary = True, False
options.ceres.solver_options.num_threads = int(sys.argv[2])
config = pycolmap.BundleAdjustmentConfig()
for image in model.reg_image_ids():
    config.add_image(image)
config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
adjuster = pycolmap.create_default_ceres_bundle_adjuster(options, config, model)
start, wall = time.process_time(), time.perf_counter()
summary = adjuster.solve().ceres_summary
solve, wall = time.process_time() - start, time.perf_counter() - wall
model.update_point_3d_errors()
whole = time.process_time() - begin
steps = summary.num_successful_steps + summary.num_unsuccessful_steps
said = {"solve": solve, "whole": whole, "wall": wall, "steps": steps, "cost": summary.final_cost}
print(json.dumps(said | {"read_kb": read_kb, "peak_kb": peak_kb()}))
"""


def run(*command):
    return json.loads(subprocess.check_output(list(map(str, command))))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("bench", type=Path)
    parser.add_argument("models", nargs="+", type=Path)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=1)
    given = parser.parse_args()
    print("model; CPU s pycolmap / calibstab = ratio of solve, of whole, of solve per step; wall s; steps; MB; cost")
    for model in given.models:
        rounds = []
        for _ in range(given.rounds):
            theirs = run(sys.executable, "-c", PYCOLMAP, model, given.threads)
            rounds.append((theirs, run(given.bench.resolve(), model, given.threads)))
        columns = []
        for measure in (lambda said: said["solve"], lambda said: said["whole"], lambda said: said["solve"] / said["steps"]):
            theirs, ours = (statistics.median(measure(said[side]) for said in rounds) for side in (0, 1))
            ratio = statistics.median(measure(theirs) / measure(ours) for theirs, ours in rounds)
            columns.append(f"{theirs:.4f} / {ours:.4f} = {ratio:.1f}")
        walls = [statistics.median(said[side]["wall"] for said in rounds) for side in (0, 1)]
        grown = [(said["peak_kb"] - said["read_kb"]) / 1000 for said in rounds[0]]
        theirs, ours = rounds[0]
        above = ours["cost"] / theirs["cost"] - 1
        columns.append(f"wall {walls[0]:.2f} / {walls[1]:.2f}")
        columns.append(f"steps {theirs['steps']} / {ours['steps']}")
        columns.append(f"memory {grown[0]:.0f} / {grown[1]:.0f} MB")
        columns.append(f"cost pycolmap's times (1 {above:+.1e})")
        print("/".join(model.parts[-3:]), *columns, sep="; ", flush=True)


main()
