"""Bundle adjustment beside pycolmap's: the same model, the same start, the same parameters free, the same loss.

usage: crosscheck.py CALIBSTAB MODEL... [--robust] [--at-least COMPARISONS]

COLMAP counts an observation that it cannot project as a zero residual, and stops at an absolute gradient: so observations that
are not projectable at COLMAP's start or end are deleted from the model first, with points that one image sees, and the
model is scaled to a median depth of 1. Then, per model and choice of parameters:
  squared loss: final cost within 1e-11 of pycolmap's or lower, intrinsics within 1e-4 of their std, covariance within 1e-5
  Cauchy and the other losses: final cost within 1e-4 of pycolmap's or lower, since that stops at its limit of iterations;
  Cauchy's, which is not convex, may be that of another minimum
Also: the refined model's point errors are those that pycolmap computes. Costs are computed here, for both, by pycolmap's projections.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pycolmap

pycolmap.logging.minloglevel = 3
LOSSES = {
    "squared": (pycolmap.LossFunctionType.TRIVIAL, lambda s: s),
    "huber": (pycolmap.LossFunctionType.HUBER, lambda s: np.where(s > 1, 2 * np.sqrt(s) - 1, s)),
    "soft-l1": (pycolmap.LossFunctionType.SOFT_L1, lambda s: 2 * (np.sqrt(1 + s) - 1)),
    "cauchy": (pycolmap.LossFunctionType.CAUCHY, lambda s: np.log1p(s)),
}
# What moves, for calibstab and for COLMAP: focal, principal point, extra.
CHOICES = {"focal,extra": (True, False, True), "all": (True, True, True), "focal": (True, False, False)}


def residuals(model):
    """Residuals of all observations, in the order of points and tracks; rows of nan where there is no projection."""
    points = {}
    for point in model.points3D.values():
        for element in point.track.elements:
            points.setdefault(element.image_id, []).append((element.point2D_idx, point.xyz))
    found = []
    for image_id in sorted(points):
        image = model.images[image_id]
        keypoints = np.array([image.points2D[index].xy for index, _ in points[image_id]])
        pose = image.cam_from_world().matrix()
        seen = np.array([xyz for _, xyz in points[image_id]]) @ pose[:, :3].T + pose[:, 3]
        pixels = model.cameras[image.camera_id].img_from_cam(seen)
        found += [((image_id, index), row) for (index, _), row in zip(points[image_id], pixels - keypoints)]
    return found


def cost(model, loss):
    rows = np.array([row for _, row in residuals(model)])
    return 0.5 * LOSSES[loss][1]((rows**2).sum(axis=1)).sum()


def delete_unprojectable(model, keys):
    """Deletes these observations, and points that fewer than two images see; tells whether there were any."""
    for image_id, index in keys:
        if model.images[image_id].points2D[index].has_point3D():
            model.delete_observation(image_id, index)
    lone = [p for p, point in model.points3D.items() if len({e.image_id for e in point.track.elements}) < 2]
    for point in lone:
        model.delete_point3D(point)
    return bool(keys or lone)


def unprojectable(model):
    return [key for key, row in residuals(model) if not np.isfinite(row).all()]


def median_depth(model):
    depths = []
    for point in model.points3D.values():
        for element in point.track.elements:
            depths.append((model.images[element.image_id].cam_from_world() * point.xyz)[2])
    return np.median(depths)


def adjust(model, choice, loss):
    """pycolmap's adjustment, in place; gives the adjuster, for the covariance, and Ceres' summary."""
    options = pycolmap.BundleAdjustmentOptions()
    focal, principal_point, extra = CHOICES[choice]
    options.refine_focal_length, options.refine_principal_point = focal, principal_point
    options.refine_extra_params, options.print_summary = extra, False
    options.ceres.loss_function_type, options.ceres.loss_function_scale = LOSSES[loss][0], 1.0
    options.ceres.solver_options.num_threads = 2
    config = pycolmap.BundleAdjustmentConfig()
    for image_id in model.reg_image_ids():
        config.add_image(image_id)
    config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    adjuster = pycolmap.create_default_ceres_bundle_adjuster(options, config, model)
    return adjuster, adjuster.solve().ceres_summary


def covariances(model, adjuster, summary):
    """Per camera, for the noise that the residuals show; none where pycolmap fails."""
    options = pycolmap.BACovarianceOptions()
    options.damping = 1e-12
    estimated = pycolmap.estimate_ba_covariance(options, model, adjuster)
    if estimated is None:
        return {}
    freedom = summary.num_residuals_reduced - summary.num_effective_parameters_reduced
    variance = 2 * summary.final_cost / freedom
    found = {i: estimated.get_other_params_cov(camera.params) for i, camera in model.cameras.items()}
    found = {i: variance * c for i, c in found.items() if c is not None}
    # Of a camera that nothing determines it gives variances of zero or less.
    return {i: c for i, c in found.items() if np.isfinite(c).all() and (np.diag(c) > 0).all()}


class Check:
    def __init__(self, calibstab):
        self.calibstab, self.count, self.faults = calibstab, 0, 0

    def that(self, is_so, text):
        self.count += 1
        self.faults += not is_so
        print(f"  {'ok   ' if is_so else 'FAULT'} {text}")

    def refine(self, start, choice, loss, scratch):
        start_folder, out = scratch / "start", scratch / "out"
        start_folder.mkdir(exist_ok=True)
        start.write_binary(start_folder)
        scale = "" if loss == "squared" else ":1"
        command = [self.calibstab, "refine", start_folder, "--out", out, "--quiet", "--json"]
        command += ["--refine", choice, "--loss", loss + scale]
        said = subprocess.run(list(map(str, command)), check=True, capture_output=True, text=True)
        return pycolmap.Reconstruction(str(out)), json.loads(said.stdout)

    def compare(self, path, choice, loss):
        print(f"{path} {choice} {loss}")
        start = pycolmap.Reconstruction(str(path))
        delete_unprojectable(start, unprojectable(start))
        start.transform(pycolmap.Sim3d(1 / median_depth(start), pycolmap.Rotation3d(), np.zeros(3)))
        while True:
            theirs = pycolmap.Reconstruction(start)
            adjuster, summary = adjust(theirs, choice, loss)
            if not delete_unprojectable(start, unprojectable(theirs) + unprojectable(start)):
                break
        with tempfile.TemporaryDirectory() as scratch:
            ours, outcome = self.refine(start, choice, loss, Path(scratch))
        self.errors(ours)
        dropped = outcome["dropped"]
        if any(dropped.values()):
            # Beyond the fold of a lens COLMAP goes on; calibstab does not.
            print(f"  left out of the comparison: calibstab drops {dropped}")
            return
        self.costs(theirs, ours, summary, outcome, (choice, loss))
        if loss == "squared" and summary.termination_type.name == "CONVERGENCE":
            self.intrinsics(theirs, ours, covariances(theirs, adjuster, summary), outcome)

    def errors(self, ours):
        written = ours.compute_mean_reprojection_error()
        ours.update_point_3d_errors()
        computed = ours.compute_mean_reprojection_error()
        self.that(abs(written - computed) <= 1e-9, f"mean reprojection error {written:.12f}, pycolmap's {computed:.12f}")

    def costs(self, theirs, ours, summary, outcome, how):
        choice, loss = how
        limit = 1e-11 if loss == "squared" else 1e-4
        their_cost, our_cost = cost(theirs, loss), cost(ours, loss)
        above = our_cost / their_cost - 1
        steps = f"{outcome['iterations']} steps, Ceres {summary.num_successful_steps + summary.num_unsuccessful_steps}"
        ending = f"{outcome['reason']}, Ceres {summary.termination_type.name}"
        if above > limit and loss == "cauchy":
            # The one loss that is not convex: from the same start two ways may lead to two minima. From ours pycolmap finds no other.
            print(f"  another minimum than pycolmap's, whose cost times (1 {above:+.1e}) it has")
            again = pycolmap.Reconstruction(ours)
            adjust(again, choice, loss)
            above = our_cost / cost(again, loss) - 1
        self.that(above <= limit, f"cost {our_cost:.12e}, pycolmap's times (1 {above:+.1e}); {steps}; {ending}")
        said = outcome["cost"] / our_cost - 1
        self.that(abs(said) <= 1e-9, f"the cost that calibstab states is the cost, times (1 {said:+.1e})")

    def intrinsics(self, theirs, ours, their_covariances, outcome):
        if not their_covariances:
            print("  pycolmap gives no covariance")
            return
        our_params = [(p["camera"], p["name"]) for p in outcome["covariance"]["params"]]
        if outcome["covariance"]["matrix"] is None:
            self.that(False, f"calibstab finds directions that are not determined: {outcome['covariance']['open']}")
            return
        matrix = np.array(outcome["covariance"]["matrix"])
        for camera_id, their_covariance in their_covariances.items():
            rows = [at for at, (camera, _) in enumerate(our_params) if camera == camera_id]
            names = theirs.cameras[camera_id].params_info.split(", ")
            places = [names.index(our_params[row][1]) for row in rows]
            our_covariance = matrix[np.ix_(rows, rows)]
            stds = np.sqrt(np.diag(their_covariance))
            shift = (ours.cameras[camera_id].params - theirs.cameras[camera_id].params)[places] / stds
            self.that(abs(shift).max() <= 1e-4, f"camera {camera_id}: intrinsics within {abs(shift).max():.1e} std")
            apart = abs(our_covariance - their_covariance) / np.outer(stds, stds)
            self.that(apart.max() <= 1e-5, f"camera {camera_id}: covariance within {apart.max():.1e}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("calibstab")
    parser.add_argument("models", nargs="+", type=Path)
    parser.add_argument("--at-least", type=int, default=1, help="fewer checks than these are a fault")
    parser.add_argument("--robust", action="store_true", help="the robust losses too")
    given = parser.parse_args()
    check = Check(Path(given.calibstab).resolve())
    for path in given.models:
        for choice in CHOICES:
            check.compare(path, choice, "squared")
        for loss in list(LOSSES)[1:] if given.robust else []:
            check.compare(path, "focal,extra", loss)
    print(f"{check.count} checks, {check.faults} faults")
    if check.count < given.at_least:
        print(f"too few checks: wanted {given.at_least}")
    sys.exit(check.faults > 0 or check.count < given.at_least)


if __name__ == "__main__":
    main()
