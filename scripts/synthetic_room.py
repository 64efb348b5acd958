"""A synthetic room seen by a hand-carried pair of cameras, as reconstructions that pycolmap then adjusts.

The truth is known, the noise is drawn. Metres; x right, y down, z forward.
"""

import math
from dataclasses import dataclass

import numpy as np
import pycolmap

NOISE_PX = 0.5


@dataclass(frozen=True)
class Lens:
    """A camera with its true parameters, and how it sits on the carrier."""

    name: str
    model: str
    width: int
    height: int
    params: tuple
    yaw_degrees: float = 0.0
    at: tuple = (0.0, 0.0, 0.0)

    def camera(self, camera_id, params=None):
        return pycolmap.Camera(
            camera_id=camera_id, model=self.model, width=self.width, height=self.height, params=list(params or self.params)
        )

    def start(self, rng):
        """Parameters as a mapper might begin: the focal length some 2 % off, no distortion, principal point at the centre."""
        camera = self.camera(1)
        params = np.zeros(len(self.params))
        params[camera.focal_length_idxs()] = self.params[0] * (1 + rng.normal(0, 0.02))
        params[camera.principal_point_idxs()] = self.width / 2, self.height / 2
        return params.tolist()


FRONT = Lens("front", "OPENCV", 640, 480, (500.0, 497.0, 320, 240, -0.28, 0.09, 0.0006, -0.0004))
SIDE = Lens("side", "OPENCV_FISHEYE", 640, 640, (255.0, 256.5, 320, 320, 0.02, -0.012, 0.004, -0.001), 50.0, (0.3, 0.0, 0.0))
LEFT = Lens("left", "SIMPLE_RADIAL", 640, 480, (520.0, 320, 240, -0.08), -15.0, (-0.2, 0.0, 0.0))
RIGHT = Lens("right", "SIMPLE_RADIAL", 640, 480, (480.0, 320, 240, -0.05), 15.0, (0.2, 0.0, 0.0))
WIDE = Lens("wide", "SIMPLE_RADIAL", 640, 480, (400.0, 320, 240, -0.04))


def rotation(yaw, pitch, roll):
    """World from body: yaw about y, then pitch about x, then roll about z; radians."""
    (cy, sy), (cx, sx), (cz, sz) = ((math.cos(a), math.sin(a)) for a in (yaw, pitch, roll))
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return about_y @ about_x @ about_z


def room(rng, count):
    """Points on three walls, floor, ceiling and furniture."""
    points = rng.uniform((-5, -2, -4), (5, 2, 5), (count, 3))
    surface = rng.integers(0, 7, count)
    for index, (axis, value) in enumerate([(0, -5), (0, 5), (2, 5), (1, 2), (1, -2)]):
        points[surface == index, axis] = value
    return points


def walk(rng, count):
    """Poses of the carrier, (world_from_body, centre) each; well turned, so that the focal lengths are determined."""
    poses = []
    for index in range(count):
        along = index / (count - 1)
        turn = rng.uniform(-1, 1, 3) * np.radians([35, 20, 60])
        centre = np.array([4 * along - 2, 0, -1.0]) + rng.uniform(-1, 1, 3) * (0.5, 0.7, 1.2)
        poses.append((rotation(*turn), centre))
    return poses


def rigid(matrix, translation):
    return pycolmap.Rigid3d(pycolmap.Rotation3d(matrix), translation)


def sensor_from_body(lens):
    turned = rotation(math.radians(lens.yaw_degrees), 0, 0)
    return turned.T, -turned.T @ np.array(lens.at)


@dataclass(frozen=True)
class Shot:
    """One image to take."""

    name: str
    lens: Lens
    camera_id: int
    pose: tuple  # of the carrier

    def sensor_from_world(self):
        (turn, shift), (world_from_body, centre) = sensor_from_body(self.lens), self.pose
        return turn @ world_from_body.T, shift - turn @ world_from_body.T @ centre


def observe(rng, shot, world, count):
    """Indices of up to `count` visible points, and their noisy pixels, to 3 decimals."""
    turn, shift = shot.sensor_from_world()
    local = world @ turn.T + shift
    pixels = shot.lens.camera(1).img_from_cam(local)
    angle = np.degrees(np.arctan2(np.hypot(local[:, 0], local[:, 1]), local[:, 2]))
    # Past its edge a polynomial folds back into the image: OPENCV here beyond 50 degrees, the fisheye nowhere near 80.
    limit = 80 if "FISHEYE" in shot.lens.model else 45
    size = (shot.lens.width - 2, shot.lens.height - 2)
    inside = (angle < limit) & np.isfinite(pixels).all(1) & (pixels > 2).all(1) & (pixels < size).all(1)
    visible = np.flatnonzero(inside)
    seen = np.sort(rng.permutation(visible)[:count])
    return seen, np.round(pixels[seen] + rng.normal(0, NOISE_PX, (len(seen), 2)), 3)


def build(rng, shots, world, per_image, rig=False, blind=()):
    """A reconstruction of these images as a mapper would hold it before its last adjustment: everything a little off.

    `rig`: shots with the same pose are one frame of a rig whose first camera is the reference. `blind`: names of images
    that see nothing.
    """
    lenses = {shot.camera_id: shot.lens for shot in shots}
    model = pycolmap.Reconstruction()
    for camera_id, lens in sorted(lenses.items()):
        model.add_camera(lens.camera(camera_id, lens.start(rng)))
    sensors = {camera_id: model.cameras[camera_id].sensor_id for camera_id in sorted(lenses)}
    add_rigs(model, lenses, sensors, rig)

    seen_in, images, frames = {}, [], {}
    for image_id, shot in enumerate(shots, 1):
        seen, pixels = observe(rng, shot, world, 0 if shot.name in blind else per_image)
        images.append((image_id, shot, seen, pixels))
        for at, index in enumerate(seen.tolist()):
            seen_in.setdefault(index, []).append((image_id, at))
        frame_id = 1 + id_of_pose(shots, shot) if rig else image_id
        if frame_id not in frames:
            frame = frames[frame_id] = pycolmap.Frame()
            frame.frame_id, frame.rig_id = frame_id, 1 if rig else shot.camera_id
            turn, shift = shot.sensor_from_world()
            frame.rig_from_world = rigid(rotation(*rng.normal(0, 0.003, 3)) @ turn, shift + rng.normal(0, 0.02, 3))
        frames[frame_id].add_data_id(pycolmap.data_t(sensors[shot.camera_id], image_id))
    for frame in frames.values():
        model.add_frame(frame)
    for image_id, shot, _, pixels in images:
        image = pycolmap.Image(name=shot.name, keypoints=pixels, camera_id=shot.camera_id, image_id=image_id)
        image.frame_id = 1 + id_of_pose(shots, shot) if rig else image_id
        model.add_image(image)
    for frame_id in frames:
        model.register_frame(frame_id)
    # Points seen twice say little; the rest of their observations stay as 2D points without a 3D point.
    least = min(3, len(shots))
    for index, observations in sorted(seen_in.items()):
        if len(observations) >= least:
            track = pycolmap.Track()
            for observation in observations:
                track.add_element(*observation)
            model.add_point3D(world[index] + rng.normal(0, 0.05, 3), track, rng.integers(40, 220, 3).astype(np.uint8))
    return model


def id_of_pose(shots, shot):
    poses = list({id(other.pose): None for other in shots})
    return poses.index(id(shot.pose))


def add_rigs(model, lenses, sensors, joined):
    """One rig of all cameras, or a rig for each."""
    groups = [sorted(lenses)] if joined else [[camera_id] for camera_id in sorted(lenses)]
    for group in groups:
        reference = group[0]
        rig = pycolmap.Rig(rig_id=reference)
        rig.add_ref_sensor(sensors[reference])
        ref_turn, ref_shift = sensor_from_body(lenses[reference])
        for camera_id in group[1:]:
            turn, shift = sensor_from_body(lenses[camera_id])
            relative = turn @ ref_turn.T
            rig.add_sensor(sensors[camera_id], rigid(relative, shift - relative @ ref_shift))
        model.add_rig(rig)


def adjust(model):
    """COLMAP's bundle adjustment with its defaults (focal and extra move), run to the end. Returns solver and summary."""
    options = pycolmap.BundleAdjustmentOptions()
    options.print_summary = False
    options.ceres.solver_options.num_threads = 1  # sums in one order
    options.ceres.solver_options.max_num_iterations = 300
    options.ceres.solver_options.gradient_tolerance = 1e-8
    config = pycolmap.BundleAdjustmentConfig()
    for image_id in sorted(model.reg_image_ids()):
        config.add_image(image_id)
    config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    solver = pycolmap.create_default_ceres_bundle_adjuster(options, config, model)
    summary = solver.solve().ceres_summary
    model.update_point_3d_errors()
    return solver, summary


def sigmas_off(model, solver, lenses):
    """How far each estimate lies from the truth, in its standard deviations."""
    estimate = pycolmap.estimate_ba_covariance(pycolmap.BACovarianceOptions(), model, solver)
    off = []
    for camera_id, lens in sorted(lenses.items()):
        camera = model.cameras[camera_id]
        moved = sorted([*camera.focal_length_idxs(), *camera.extra_params_idxs()])
        covariance = estimate.get_other_params_cov(camera.params)
        std = NOISE_PX * np.sqrt(np.diag(covariance))
        off.extend((camera.params[moved] - np.array(lens.params)[moved]) / std)
    return np.array(off)
