#!/usr/bin/env python3
"""Compares every number of COLMAP models with calibstab's copies of them, as pycolmap and Python read both.

Usage: check_copies.py CALIBSTAB PATH [PATH ...] [--at-least N]

Every model below each PATH is copied by `CALIBSTAB copy` as text and as binary, and each copy once more in the other form.
- pycolmap must read the same from the original and from both copies;
- Python's own reading of the original (poses included that pycolmap passes over) must find the same in the copy;
- text -> binary -> text and binary -> text -> binary must give the same bytes;
- what pycolmap writes itself, calibstab must copy to the same lines, each spelled the same, and its two forms to one text.
So it goes with one model more, whose doubles are random bits. Doubles are equal when their bits are. Exit 1 when anything differs, or when fewer than N values were compared.
"""

import argparse
import math
import struct
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from random import Random

import pycolmap

KINDS = ("cameras", "images", "points3D", "rigs", "frames")
FORMS = {"--text": ".txt", "--binary": ".bin"}
NO_POINT = 2**64 - 1


class Checks:
    """Counts what was compared and keeps what differs."""

    def __init__(self):
        self.count = 0
        self.differences = []

    def equal(self, what, got, want, values=1):
        self.count += values
        if got != want:
            self.differences.append(f"{what}: {first_difference(got, want)}")


def first_difference(got, want):
    if isinstance(want, dict) and isinstance(got, dict):
        for key in [*want, *(got.keys() - want.keys())]:
            if got.get(key) != want.get(key):
                return f"{key}: {got.get(key)!r:.200}, expected {want.get(key)!r:.200}"
    if isinstance(got, str) and isinstance(want, str):
        pairs = zip(got.split("\n"), want.split("\n"))
        got, want = next(((one, other) for one, other in pairs if one != other), (len(got), len(want)))
    return f"{got!r:.200}, expected {want!r:.200}"


def size(value):
    """How many numbers and words a record holds."""
    return sum(map(size, value)) if isinstance(value, (tuple, list)) else 1


def doubles(values):
    """A spelling in which doubles are equal when their bits are; it tells -0 from 0."""
    return tuple(float(value).hex() for value in values)


# A model as pycolmap reads it.


def pose_of(pose):
    return None if pose is None else doubles([*pose.rotation.quat, *pose.translation])


def sensor_of(sensor):
    return sensor.type.name, sensor.id


def records(model):
    """Everything that pycolmap knows of a model, as (kind, id) -> record; names up to their first blank."""
    found = {}
    for camera_id, camera in model.cameras.items():
        found["camera", camera_id] = (camera.model.name, camera.width, camera.height, doubles(camera.params))
    for image_id, image in model.images.items():
        keypoints = [(doubles(point.xy), point.point3D_id) for point in image.points2D]
        pose = pose_of(image.cam_from_world())
        found["image", image_id] = (image.name.split()[0], image.camera_id, image.frame_id, pose, keypoints)
    for point_id, point in model.points3D.items():
        track = [(seen.image_id, seen.point2D_idx) for seen in point.track.elements]
        found["point", point_id] = (doubles(point.xyz), tuple(map(int, point.color)), doubles([point.error]), track)
    for rig_id, rig in model.rigs.items():
        sensors = {sensor_of(sensor): pose_of(pose) for sensor, pose in rig.non_ref_sensors.items()}
        reference = sensor_of(rig.ref_sensor_id) if rig.num_sensors() else None
        found["rig", rig_id] = (reference, sorted(sensors.items()))
    for frame_id, frame in model.frames.items():
        data = sorted((*sensor_of(datum.sensor_id), datum.id) for datum in frame.data_ids)
        found["frame", frame_id] = (frame.rig_id, pose_of(frame.rig_from_world), data)
    return found


def reconstruction(folder, ending):
    """pycolmap's reading of a folder; a lone cameras file is given files without images and points."""
    model = pycolmap.Reconstruction()
    with tempfile.TemporaryDirectory() as scratch:
        for kind in KINDS:
            file = folder / (kind + ending)
            if file.exists():
                # pycolmap takes a byte order mark for a part of the first word.
                content = file.read_bytes().removeprefix(b"\xef\xbb\xbf")
            elif kind in ("rigs", "frames"):
                continue
            else:
                content = b"" if ending == ".txt" else bytes(8)
            (Path(scratch) / file.name).write_bytes(content)
        model.read_text(scratch) if ending == ".txt" else model.read_binary(scratch)
    return model


# A model as its files say.


def lines(file):
    """The lines of a text file that are no comments, one for each record; of images.txt each second line may be empty."""
    text = file.read_text(encoding="utf-8-sig")
    kept = [line for line in text.replace("\r\n", "\n").split("\n") if not line.startswith("#")]
    if file.name == "images.txt":
        return [(first.split(maxsplit=9), second.split()) for first, second in zip(kept[::2], kept[1::2])]
    return [(line.split(), []) for line in kept if line]


def number_or_word(field):
    """Ids beyond 2^53 are left to pycolmap's reading."""
    try:
        return float(field).hex()
    except ValueError:
        return field.strip()


def values(file):
    """Every field of a text file by the id in front of its record: numbers as doubles to the last bit, and words."""
    found = {}
    for first, second in lines(file):
        found[first[0]] = [number_or_word(field) for field in first + second]
    return found


def images_of_binary(file):
    """An images.bin in the fields of an images.txt."""
    data, at, found = file.read_bytes(), 8, {}
    for _ in range(*struct.unpack_from("<Q", data)):
        image_id, *pose, camera_id = struct.unpack_from("<I7dI", data, at)
        end = data.index(b"\0", at + 64)
        name = data[at + 64 : end].decode()
        (count,) = struct.unpack_from("<Q", data, end + 1)
        fields = [image_id, *pose, camera_id, name]
        at = end + 9
        for x, y, point_id in struct.iter_unpack("<ddQ", data[at : at + 24 * count]):
            fields += [x, y, -1 if point_id == NO_POINT else point_id]
        found[str(image_id)] = [field if isinstance(field, str) else float(field).hex() for field in fields]
        at += 24 * count
    return found


# The checks.


class Copier:
    def __init__(self, calibstab, scratch):
        self.calibstab, self.scratch, self.count = calibstab, Path(scratch), 0

    def copy(self, folder, form):
        self.count += 1
        out = self.scratch / str(self.count)
        subprocess.run([self.calibstab, "copy", folder, out, form, "--quiet"], check=True, stderr=subprocess.DEVNULL)
        return out


def same_files(checks, what, got, want):
    names = sorted(file.name for file in want.iterdir())
    checks.equal(f"{what}: files", sorted(file.name for file in got.iterdir()), names)
    for name in names:
        checks.equal(f"{what}: {name} has the same bytes", (got / name).read_bytes() == (want / name).read_bytes(), True)


def check_model(checks, name, cameras, copier):
    """`cameras` is the cameras file of the model."""
    folder, ending = cameras.parent, cameras.suffix
    original = reconstruction(folder, ending)
    want = records(original)
    copies = {form: copier.copy(cameras, form) for form in FORMS}
    for form, copied in copies.items():
        got = records(reconstruction(copied, FORMS[form]))
        checks.equal(f"{name} {form}", got, want, values=sum(map(size, want.values())))
    text, binary = copies["--text"], copies["--binary"]
    check_files(checks, name, folder, ending, text)
    same_files(checks, f"{name}: text -> binary -> text", copier.copy(binary, "--text"), text)
    same_files(checks, f"{name}: binary -> text -> binary", copier.copy(text, "--binary"), binary)
    if (folder / f"images{ending}").exists():
        check_own_writing(checks, name, original, copier)


def check_files(checks, name, folder, ending, text):
    """What the original's files say is what the text copy says."""
    for kind in KINDS:
        file = folder / (kind + ending)
        copied = text / f"{kind}.txt"
        checks.equal(f"{name}: {copied.name} is there", copied.exists(), file.exists())
        if not file.exists() or (ending == ".bin" and kind != "images"):
            continue
        want = values(file) if ending == ".txt" else images_of_binary(file)
        checks.equal(f"{name}: {copied.name}", values(copied), want, values=sum(map(len, want.values())))


def check_own_writing(checks, name, original, copier):
    """What pycolmap writes, calibstab spells the same; and pycolmap's text and binary are one text to it."""
    written = {}
    for form in FORMS:
        written[form] = Path(tempfile.mkdtemp(dir=copier.scratch))
        original.write_text(written[form]) if form == "--text" else original.write_binary(written[form])
    copied = copier.copy(written["--text"], "--text")
    for kind in KINDS:
        file = f"{kind}.txt"
        got, want = (folder.joinpath(file).read_text() for folder in (copied, written["--text"]))
        if kind != "images":
            checks.equal(f"{name}: {file} spelled by pycolmap", got, want, values=want.count("\n"))
            continue
        # COLMAP's order of images is its own: records are compared with their two lines, and the comments above.
        pairs = [Counter(zip(text.split("\n")[4::2], text.split("\n")[5::2])) for text in (got, want)]
        checks.equal(f"{name}: {file} spelled by pycolmap", *pairs, values=want.count("\n"))
        heads = [text.split("\n")[:4] for text in (got, want)]
        checks.equal(f"{name}: comments of {file}", *heads)
    same_files(checks, f"{name}: pycolmap's two forms", copier.copy(written["--binary"], "--text"), copied)


def hostile_model(folder):
    """A model whose doubles are random bits, with all that COLMAP's text can hold: ids at the ends, empty lines and tracks."""
    random = Random(20180525)

    def double():
        while True:
            (value,) = struct.unpack("<d", random.randbytes(8))
            if math.isfinite(value):
                return value

    def spell(*fields):
        return " ".join(repr(field) if isinstance(field, float) else str(field) for field in fields) + "\n"

    camera_ids, image_ids, point_ids = [0, 7, 2**32 - 2], [0, 5, 2**32 - 2], [0, 3, *range(100, 400), 2**63 - 1]
    doubles_of = {camera_id: [double() for _ in range(12)] for camera_id in camera_ids}
    cameras = [spell(camera_id, "FULL_OPENCV", 2**64 - 1, 1, *params) for camera_id, params in doubles_of.items()]
    images, points = [], []
    tracks = {point_id: [] for point_id in point_ids}
    for image_id in image_ids:
        pose = [random.gauss(0, 1) for _ in range(7)]
        images.append(spell(image_id, *pose, random.choice(camera_ids), f"ä/{image_id}.jpg"))
        seen = [] if image_id == 5 else random.choices([-1, *point_ids[1:]], k=500)
        for index, point_id in enumerate(seen):
            if point_id >= 0:
                tracks[point_id] += [image_id, index]
        images.append(spell(*(field for point_id in seen for field in (double(), double(), point_id))))
    for point_id, track in tracks.items():
        points.append(spell(point_id, double(), double(), -0.0, 0, 255, 128, double(), *track))
    for name, content in {"cameras": cameras, "images": images, "points3D": points}.items():
        (folder / f"{name}.txt").write_text("".join(content))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("calibstab")
    parser.add_argument("paths", nargs="+", type=Path)
    parser.add_argument("--at-least", type=int, default=1)
    options = parser.parse_args()
    checks, model_count = Checks(), 0
    for path in options.paths:
        for cameras in sorted(file for file in path.rglob("cameras.*") if file.suffix in FORMS.values()):
            with tempfile.TemporaryDirectory() as scratch:
                check_model(checks, cameras.parent, cameras, Copier(Path(options.calibstab).resolve(), scratch))
            model_count += 1
    with tempfile.TemporaryDirectory() as scratch, tempfile.TemporaryDirectory() as folder:
        hostile_model(Path(folder))
        check_model(checks, "random bits", Path(folder) / "cameras.txt", Copier(Path(options.calibstab).resolve(), scratch))
        model_count += 1
    for difference in checks.differences[:20]:
        print(difference)
    print(f"{checks.count} values of {model_count} models compared, {len(checks.differences)} differences")
    if checks.count < options.at_least:
        print(f"fewer than the {options.at_least} that there are")
    return 1 if checks.differences or checks.count < options.at_least else 0


if __name__ == "__main__":
    sys.exit(main())
