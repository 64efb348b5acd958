"""CPU seconds, steps and memory of bundle adjustment beside pycolmap's, in turn.

usage: against_pycolmap.py BENCH MODEL... [--rounds N] [--threads N] [--most-steps N] [--only adjust|covariance|subsets]
BENCH: cargo build --release --locked --manifest-path scripts/bench/bundle/Cargo.toml; then its target/release/bench-bundle
MODEL: binary models, as make_perf_model.py writes them (init/bin)

All intrinsics move. For each model:
  adjust      `solve`: pycolmap's solve(), and calibstab's steps alone (src/main.rs says how); per step, pycolmap's without Ceres'
              preprocessing. `whole`: pycolmap's building of the problem, solve() and new point errors; all of calibstab's `adjust`,
              the covariance of the intrinsics included. Memory is what the process grows by after reading, at its peak. Models of
              more than MANY_IMAGES take at most --most-steps, and are compared per step.
  covariance  at the optimum: estimate_ba_covariance of everything, without building its problem; what calibstab's `adjust` takes more
              than its steps: the covariance of the intrinsics, plain and clustered, and writing back. Not for MANY_IMAGES.
  subsets     SUBSETS adjustments of a random half of the images, from the optimum of all: a loop over pycolmap's building of the
              problem and solve() for the first of them, counted for all, and calibstab's Subsets. Only for models of FEW_IMAGES.
Neither side counts reading and writing files. A ratio is theirs to ours in one round: the median of the rounds.
"""

import argparse
import json
import random
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import pycolmap

FEW_IMAGES, MANY_IMAGES, SUBSETS, LOOPED = 60, 500, 200, 20
START = """
import json, resource, sys, time, pycolmap
pycolmap.logging.minloglevel = 3
model = pycolmap.Reconstruction(sys.argv[1])
def peak_kb():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
read_kb = peak_kb()
options = pycolmap.BundleAdjustmentOptions()
options.refine_principal_point, options.print_summary = True, False
options.ceres.solver_options.num_threads = int(sys.argv[2])
def adjuster_of(model, images):
    config = pycolmap.BundleAdjustmentConfig()
    for image in images:
        config.add_image(image)
    config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    return pycolmap.create_default_ceres_bundle_adjuster(options, config, model)
def steps_of(summary):
    # Ceres counts the start as a step.
    return summary.num_successful_steps + summary.num_unsuccessful_steps - 1
"""
ADJUST = START + """
options.ceres.solver_options.max_num_iterations = min(int(sys.argv[3]), options.ceres.solver_options.max_num_iterations)
begin = time.process_time()
adjuster = adjuster_of(model, model.reg_image_ids())
start, wall = time.process_time(), time.perf_counter()
summary = adjuster.solve().ceres_summary
solve, wall = time.process_time() - start, time.perf_counter() - wall
model.update_point_3d_errors()
whole = time.process_time() - begin
share = 1 - summary.preprocessor_time_in_seconds / summary.total_time_in_seconds
said = {"solve": solve, "in_steps": solve * share, "whole": whole, "wall": wall, "steps": steps_of(summary), "cost": summary.final_cost}
print(json.dumps(said | {"read_kb": read_kb, "peak_kb": peak_kb()}))
"""
COVARIANCE = START + """
adjuster = adjuster_of(model, model.reg_image_ids())
adjuster.solve()
start = time.process_time()
assert pycolmap.estimate_ba_covariance(pycolmap.BACovarianceOptions(), model, adjuster) is not None
print(json.dumps({"solve": time.process_time() - start}))
"""
SUBSETS_LOOP = START + """
import copy
adjuster_of(model, model.reg_image_ids()).solve()
lines = [list(map(int, line.split())) for line in open(sys.argv[3])]
spent, steps, costs = 0.0, 0, []
for images in lines[: int(sys.argv[4])]:
    own = copy.deepcopy(model)
    for image in set(own.reg_image_ids()) - set(images):
        own.deregister_frame(own.images[image].frame_id)
    start = time.process_time()
    summary = adjuster_of(own, images).solve().ceres_summary
    spent += time.process_time() - start
    steps += steps_of(summary)
    costs.append(summary.final_cost)
scale = len(lines) / int(sys.argv[4])
print(json.dumps({"solve": spent * scale, "steps": steps * scale, "costs": costs[:5]}))
"""


def run(*command):
    return json.loads(subprocess.check_output(list(map(str, command))))


def theirs(script, *arguments):
    return run(sys.executable, "-c", script, *arguments)


def compared(rounds, of_theirs, of_ours=None):
    """Medians and the median of ratios."""
    pairs = [(of_theirs(one), (of_ours or of_theirs)(other)) for one, other in rounds]
    one, other = (statistics.median(pair[side] for pair in pairs) for side in (0, 1))
    return f"{one:.4g} / {other:.4g} = {statistics.median(one / other for one, other in pairs):.1f}"


def adjust(given, model, images):
    steps = given.most_steps if images > MANY_IMAGES else 1000
    rounds = []
    for _ in range(given.rounds):
        one = theirs(ADJUST, model, given.threads, steps)
        rounds.append((one, run(given.bench, "adjust", model, given.threads, steps)))
    one, other = rounds[0]
    walls = [statistics.median(said[side]["wall"] for said in rounds) for side in (0, 1)]
    grown = [(said["peak_kb"] - said["read_kb"]) / 1000 for said in rounds[0]]
    yield "solve s " + compared(rounds, lambda said: said["solve"])
    yield "whole s " + compared(rounds, lambda said: said["whole"])
    per_step = [lambda said, key=key: said[key] / said["steps"] for key in ("in_steps", "solve")]
    yield "a step s " + compared(rounds, *per_step)
    yield f"wall s {walls[0]:.2f} / {walls[1]:.2f}"
    yield f"steps {one['steps']} / {other['steps']}"
    yield f"memory MB {grown[0]:.0f} / {grown[1]:.0f} = {grown[0] / grown[1]:.1f}"
    yield f"cost pycolmap's times (1 {other['cost'] / one['cost'] - 1:+.1e})"


def covariance(given, model, images):
    if images <= MANY_IMAGES:
        rounds = []
        for _ in range(given.rounds):
            one = theirs(COVARIANCE, model, given.threads)
            rounds.append((one, run(given.bench, "covariance", model, given.threads)))
        yield "s " + compared(rounds, lambda said: said["solve"])


def subsets(given, model, images):
    if images > FEW_IMAGES:
        return
    ids = sorted(pycolmap.Reconstruction(model).reg_image_ids())
    choice = random.Random(1)
    with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
        for _ in range(SUBSETS):
            print(*sorted(choice.sample(ids, len(ids) // 2)), file=file)
        file.flush()
        rounds = []
        for _ in range(given.rounds):
            one = theirs(SUBSETS_LOOP, model, given.threads, file.name, LOOPED)
            rounds.append((one, run(given.bench, "subsets", model, given.threads, file.name)))
    one, other = rounds[0]
    yield f"{SUBSETS} adjustments s " + compared(rounds, lambda said: said["solve"])
    yield f"steps {one['steps']:.0f} / {other['steps']}"
    above = max(ours / theirs - 1 for theirs, ours in zip(one["costs"], other["costs"]))
    yield f"cost pycolmap's times (1 {above:+.1e}) at most"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("bench", type=Path)
    parser.add_argument("models", nargs="+", type=Path)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--most-steps", type=int, default=5)
    parser.add_argument("--only", choices=["adjust", "covariance", "subsets"])
    given = parser.parse_args()
    given.bench = given.bench.resolve()
    print("pycolmap / calibstab = ratio; s are CPU seconds unless wall is said")
    for model in given.models:
        images = pycolmap.Reconstruction(model).num_reg_images()
        for part in (adjust, covariance, subsets):
            if given.only in (None, part.__name__):
                columns = list(part(given, model, images))
                if columns:
                    print(f"{'/'.join(model.parts[-3:])} {part.__name__}", *columns, sep="; ", flush=True)


main()
