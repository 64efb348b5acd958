"""Makes a model to time readers with: make_model.py FOLDER IMAGES POINTS EXTRA_KEYPOINTS

Every point is seen by some eight images near each other, and each image has EXTRA_KEYPOINTS more that are seen as no point.
The numbers are random, with the 17 digits that pycolmap writes; nothing but reading can be done with such a model. It is
written to FOLDER/text and FOLDER/bin.
"""

import sys
from pathlib import Path

import numpy as np
import pycolmap

WIDTH, HEIGHT, MEAN_TRACK = 4000, 3000, 8


def sightings(random, image_count, point_count):
    """Image and point of every sighting, ordered by image."""
    lengths = np.clip(random.geometric(1 / (MEAN_TRACK - 2), point_count) + 2, 3, image_count // 8)
    centres = random.integers(0, image_count, point_count)
    pairs = []
    for point, (length, centre) in enumerate(zip(lengths, centres, strict=True)):
        near = random.choice(image_count // 8, length, replace=False)
        pairs.extend(((centre + step) % image_count, point) for step in near)
    return np.array(sorted(pairs))


def main():
    folder, (image_count, point_count, extra) = Path(sys.argv[1]), map(int, sys.argv[2:])
    random = np.random.default_rng(7)
    pairs = sightings(random, image_count, point_count)
    starts = np.searchsorted(pairs[:, 0], np.arange(image_count + 1))

    model = pycolmap.Reconstruction()
    camera = pycolmap.Camera.create_from_model_name(1, "OPENCV", 3200.0, WIDTH, HEIGHT)
    model.add_camera_with_trivial_rig(camera)
    for index in range(image_count):
        count = starts[index + 1] - starts[index] + extra
        keypoints = random.uniform(0, [WIDTH, HEIGHT], (count, 2))
        name = f"img_{index:05d}.jpg"
        image = pycolmap.Image(name=name, keypoints=keypoints, camera_id=1, image_id=index + 1)
        rotation = pycolmap.Rotation3d(random.normal(size=4))
        pose = pycolmap.Rigid3d(rotation, random.normal(size=3) * 10)
        model.add_image_with_trivial_frame(image, pose)
    tracks = [pycolmap.Track() for _ in range(point_count)]
    for place, (image, point) in enumerate(pairs):
        tracks[point].add_element(int(image) + 1, int(place - starts[image]))
    for track in tracks:
        colour = random.integers(0, 256, 3).astype(np.uint8)
        point = model.add_point3D(random.uniform(-4, 4, 3), track, colour)
        model.points3D[point].error = random.uniform(0.2, 1.0)
    for form, write in (("text", model.write_text), ("bin", model.write_binary)):
        (folder / form).mkdir(parents=True, exist_ok=True)
        write(str(folder / form))


if __name__ == "__main__":
    main()
