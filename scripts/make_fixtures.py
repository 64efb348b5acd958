#!/usr/bin/env python3
"""Makes the models under fixtures/; its README.md is written by hand, golden_pixels.csv made by make_golden_pixels.py.

Usage: make_fixtures.py [--check]

Seeded: on one machine a second call gives the same bytes. The estimates come out of pycolmap's bundle adjustment, whose
last bits depend on the processor, so --check (which writes nothing here) compares them with the committed files
number by number, to 2e-5, and everything else byte by byte. Exit 1 when something differs.
"""

import argparse
import filecmp
import math
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np
import pycolmap

from make_golden_pixels import CAMERAS
from synthetic_room import FRONT, LEFT, RIGHT, SIDE, WIDE, Shot, adjust, build, room, rotation, sigmas_off, walk

FIXTURES = Path(__file__).resolve().parent.parent / "fixtures"
# More than this many standard deviations off the truth is a failed adjustment, not noise: one in 30 000 by chance.
MAX_SIGMAS = 4.2
# Start values moved by one part in 1e15, as another processor's rounding would, move no estimate by more than 2.5e-6 of
# itself; numbers shortened to six digits jump by 1e-5.
NEAR = 2e-5
# Where that may show; all else must be equal to the byte.
ESTIMATED = ("runs", "formats", "renumbered", "failed", "one_camera_per_image", "bad/unknown_camera", "bad/truncated_images")
NOT_MADE_HERE = {"README.md", ".gitattributes", "golden_pixels.csv"}
# A comparison of fewer files has lost some.
LEAST_FILES = 150


# Writing.


def short(text, spec):
    plain = format(float(text), spec)
    return plain.rstrip("0").rstrip(".") if "." in plain and "e" not in plain else plain


def shorten(folder):
    """Cut the digits of a text model: pixels to 3 decimals, which they have, points to 10 digits, errors to 6."""
    lines = (folder / "images.txt").read_text().split("\n")
    first = next(i for i, line in enumerate(lines) if line and not line.startswith("#"))
    for at in range(first + 1, len(lines), 2):
        fields = lines[at].split()
        fields[0::3] = [short(x, ".3f") for x in fields[0::3]]
        fields[1::3] = [short(y, ".3f") for y in fields[1::3]]
        lines[at] = " ".join(fields)
    (folder / "images.txt").write_text("\n".join(lines))

    lines = (folder / "points3D.txt").read_text().split("\n")
    for at, line in enumerate(lines):
        if line and not line.startswith("#"):
            fields = line.split()
            fields[1:4] = [short(x, ".10g") for x in fields[1:4]]
            fields[7] = short(fields[7], ".6g")
            lines[at] = " ".join(fields)
    (folder / "points3D.txt").write_text("\n".join(lines))


def write(model, folder):
    folder.mkdir(parents=True)
    model.write_text(folder)
    shorten(folder)


def write_cameras(folder, *rows):
    folder.mkdir(parents=True)
    header = "# Camera list with one line of data per camera:\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
    (folder / "cameras.txt").write_text(header + f"# Number of cameras: {len(rows)}\n" + "\n".join(rows) + "\n")


# The fixtures.


def thesis(out):
    camera1 = """1104.37 1029.92 640 480 -0.364639 0.143539 0.001229 0.00258186
1098.07 1031.41 640 480 -0.359058 0.148217 0.001335 0.00193668
1013.00 1041.81 640 480 -0.34398 0.119602 -0.002218 -0.00528645"""
    for run, row in enumerate(camera1.split("\n"), 1):
        write_cameras(out / f"opencv_camera1/run{run}", f"1 OPENCV 1280 960 {row}")
    camera3 = "421.001 -0.0709 / 411.932 -0.0615 / 419.312 -0.0678 / 430.513 -0.0729 / 440.073 -0.0814 / 428.747 -0.0756"
    for run, row in enumerate(camera3.split(" / "), 1):
        f, k = row.split()
        row = f"3 SIMPLE_RADIAL_FISHEYE 1024 1024 {f} 512 512 {k}"
        write_cameras(out / f"simple_radial_fisheye_camera3/run{run}", row)
    write_cameras(
        out / "examples/opencv",
        "1 OPENCV 1280 960 1061.6 1035.29 640 480 -0.333951 0.121122 0.0025596 0.00419425",
        "2 OPENCV_FISHEYE 1024 1024 402.294 437.448 512 512 -0.0814756 0.121485 -0.0880346 0.0181435",
        "3 OPENCV_FISHEYE 1024 1024 428.331 444.79 512 512 0.00974985 0.0337692 -0.0801194 0.0217839",
        "4 OPENCV_FISHEYE 1024 1024 419.591 418.346 512 512 -0.0748247 0.00877295 -0.00344216 0.000329053",
    )
    write_cameras(
        out / "examples/simple_radial",
        "1 SIMPLE_RADIAL 1280 960 1011.91 640 480 -0.241569",
        "2 SIMPLE_RADIAL_FISHEYE 1024 1024 427.761 512 512 -0.0768701",
        "3 SIMPLE_RADIAL_FISHEYE 1024 1024 419.312 512 512 -0.0677735",
        "4 SIMPLE_RADIAL_FISHEYE 1024 1024 429.323 512 512 -0.0755503",
    )


def shots_of(lenses, poses, frames):
    """Each of these frames by each camera, as a car's cameras store them: a folder a camera."""
    return [
        Shot(f"{lens.name}/{frame + 1:04d}.jpg", lens, camera_id, poses[frame])
        for camera_id, lens in enumerate(lenses, 1)
        for frame in frames
    ]


def converged(rng, shots, world, per_image, **options):
    """A reconstruction and its solver, once the adjustment has converged."""
    model = build(rng, shots, world, per_image, **options)
    solver, summary = adjust(model)
    if summary.termination_type.name != "CONVERGENCE":
        sys.exit(f"the adjustment did not converge: {summary.BriefReport()}")
    return model, solver


def estimated(rng, shots, world, per_image):
    """A reconstruction with its estimates where the truth makes them likely, and how far off in sigmas they are."""
    model, solver = converged(rng, shots, world, per_image)
    sigmas = sigmas_off(model, solver, {shot.camera_id: shot.lens for shot in shots})
    if np.abs(sigmas).max() > MAX_SIGMAS:
        sys.exit(f"an estimate of {shots[0].name} ... lies {np.abs(sigmas).max():.1f} sigma off the truth")
    return model, sigmas


def runs(out):
    """Two ways of calibrating one pair of cameras: from few images, from many."""
    scene = np.random.default_rng(20)
    world, poses = room(scene, 170), walk(scene, 40)
    for seed, (group, frame_count) in enumerate([("few_images", 8), ("many_images", 20)]):
        off = []
        for run in range(1, 7):
            rng = np.random.default_rng([21, seed, run])
            frames = np.sort(rng.choice(len(poses), frame_count, replace=False)).tolist()
            model, sigmas = estimated(rng, shots_of((FRONT, SIDE), poses, frames), world, 45)
            write(model, out / group / f"run{run}")
            off.append(sigmas)
        off = np.array(off)
        print(f"runs/{group}: off the truth by {np.sqrt((off**2).mean()):.2f} sigma (rms), {np.abs(off).max():.2f} at most")


def formats(out):
    """One small model in every form that it may come in."""
    scene = np.random.default_rng(30)
    world, poses = room(scene, 60), walk(scene, 4)
    shots = shots_of((FRONT, SIDE), poses, range(4))
    model, _ = estimated(np.random.default_rng(31), shots, world, 30)
    text = out / "text"
    write(model, text)

    legacy = ("cameras", "images", "points3D")
    again = pycolmap.Reconstruction()
    again.read_text(text)  # the shortened numbers, so that both kinds hold the same
    for folder in ("binary", "binary_legacy"):
        (out / folder).mkdir()
        again.write_binary(out / folder)
    for new in ("rigs.bin", "frames.bin"):
        (out / "binary_legacy" / new).unlink()
    for folder in ("text_legacy", "text_crlf", "text_bom", "lone_cameras"):
        (out / folder).mkdir()
    for name in legacy:
        shutil.copyfile(text / f"{name}.txt", out / "text_legacy" / f"{name}.txt")
    for file in sorted(text.iterdir()):
        content = file.read_bytes()
        (out / "text_crlf" / file.name).write_bytes(content.replace(b"\n", b"\r\n"))
        (out / "text_bom" / file.name).write_bytes(b"\xef\xbb\xbf" + content)
    shutil.copyfile(text / "cameras.txt", out / "lone_cameras" / "cameras.txt")

    joined, _ = converged(np.random.default_rng(31), shots, world, 30, rig=True)
    write(joined, out / "rig")

    odd = {1: "front/view of the yard 1.jpg", 2: "front/Straße.jpg", 5: "side/вид (2).jpg", 6: "side/ 写真 .jpg"}
    for image_id, name in odd.items():
        model.image(image_id).name = name
    write(model, out / "odd_names")

    model, _ = converged(np.random.default_rng(31), shots, world, 30, blind={shots[3].name})
    model.add_camera_with_trivial_rig(
        pycolmap.Camera(camera_id=77, model="FULL_OPENCV", width=640, height=480, params=[500, 500, 320, 240] + [0] * 8)
    )
    write(model, out / "empty_points_line")


def bad(out, good_text, good_binary):
    """What must be refused, each with its own words."""
    write_cameras(out / "wrong_parameter_count", "1 OPENCV 640 480 500 497 320 240 -0.28 0.09 0.0006")
    write_cameras(out / "misspelled_model", "1 OPENCV_FISHEY 640 640 255 256.5 320 320 0.02 -0.012 0.004 -0.001")
    write_cameras(out / "nan", "1 OPENCV 640 480 500 497 320 240 -0.28 nan 0.0006 -0.0004")
    (out / "empty_file").mkdir()
    (out / "empty_file" / "cameras.txt").touch()

    truncated = out / "truncated_images"
    shutil.copytree(good_binary, truncated)
    content = (truncated / "images.bin").read_bytes()
    (truncated / "images.bin").write_bytes(content[: len(content) * 2 // 3])

    unknown = out / "unknown_camera"
    shutil.copytree(good_text, unknown)
    images = (unknown / "images.txt").read_text()
    (unknown / "images.txt").write_text(images.replace(" 2 side/0003.jpg", " 7 side/0003.jpg"))


def identical(out):
    """The same numbers three times, once spelled otherwise."""
    row = "1 OPENCV 640 480 501.25 498.5 320 240 -0.28125 0.09375 0.0006 -0.0004"
    write_cameras(out / "run1", row)
    write_cameras(out / "run2", row)
    write_cameras(out / "run3", "1 OPENCV 640 480 5.0125e2 498.50 320.0 240 -0.28125 9.375E-02 6e-4 -4e-004")


def lenses(out):
    """Every camera model of COLMAP, three times, all of its parameters a little off; its width and height are what they are.
    The last camera folds inside its image."""
    first = {name: params for name, params, _ in reversed(CAMERAS)}
    # These see beyond 90 degrees, which pycolmap does not: with a longer lens, the corners of the image do not.
    for name in ("DIVISION", "THIN_PRISM_FISHEYE"):
        first[name] = [1.4 * focal for focal in first[name][:2]] + first[name][2:]
    cameras = [*sorted(first.items()), ("SIMPLE_RADIAL", [1011.91, 640, 480, -0.27])]
    for run, off in (("run1", -1.0), ("run2", 0.25), ("run3", 1.5)):
        rows = []
        for camera_id, (name, params) in enumerate(cameras, 1):
            camera = pycolmap.Camera(camera_id=1, model=name, width=100, height=100, params=params)
            kept = camera.metadata_params_idxs()
            moved = [v if i in kept else v * (1 + off * (3 + i) / 1000) for i, v in enumerate(params)]
            size = params if kept else [2 * params[i] for i in camera.principal_point_idxs()]
            rows.append(" ".join([f"{camera_id} {name}", *(format(v, ".10g") for v in [*size, *moved])]))
        write_cameras(out / run, *rows)


def renumbered(out):
    """Two cameras of one model and size; run2 numbers them the other way round."""
    scene = np.random.default_rng(40)
    world, poses = room(scene, 90), walk(scene, 10)
    for run, lenses in enumerate([(LEFT, RIGHT), (RIGHT, LEFT)], 1):
        rng = np.random.default_rng([41, run])
        frames = np.sort(rng.choice(len(poses), 6, replace=False)).tolist()
        model, _ = estimated(rng, shots_of(lenses, poses, frames), world, 30)
        write(model, out / f"run{run}")


def standing(rng, pose):
    """Two images from nearly one place, which do not determine six intrinsics: the adjustment ends where it likes."""
    world_from_body, centre = pose
    next_pose = world_from_body @ rotation(*rng.normal(0, 0.03, 3)), centre + rng.normal(0, 0.05, 3)
    return [Shot("front/0007.jpg", FRONT, 1, pose), Shot("front/0008.jpg", FRONT, 1, next_pose)]


def failed(out):
    """Four mappings of 16 images each; the third broke off after its first pair."""
    scene = np.random.default_rng(50)
    world, poses = room(scene, 150), walk(scene, 24)
    for run in range(1, 5):
        rng = np.random.default_rng([51, run, 0])
        if run == 3:
            model = build(rng, standing(rng, poses[6]), world, 120)
            adjust(model)
            if not model.cameras[1].has_bogus_params(0.1, 10.0, 1.0):
                sys.exit("failed/run3 is no failure")
        else:
            frames = np.sort(rng.choice(len(poses), 16, replace=False)).tolist()
            model, _ = estimated(rng, shots_of((FRONT,), poses, frames), world, 35)
        write(model, out / f"run{run}")


def one_camera_per_image(out):
    """Six images, each with a camera of its own, mapped twice."""
    scene = np.random.default_rng(60)
    world, poses = room(scene, 160), walk(scene, 6)
    for run in range(1, 3):
        rng = np.random.default_rng([61, run])
        shots = [Shot(f"{frame + 1:04d}.jpg", WIDE, frame + 1, poses[frame]) for frame in range(6)]
        model, _ = estimated(rng, shots, world, 45)
        write(model, out / f"run{run}")


def make(out):
    thesis(out / "thesis")
    runs(out / "runs")
    (out / "formats").mkdir()
    formats(out / "formats")
    bad(out / "bad", out / "formats/text", out / "formats/binary")
    identical(out / "identical")
    lenses(out / "lenses")
    renumbered(out / "renumbered")
    failed(out / "failed")
    one_camera_per_image(out / "one_camera_per_image")


# Comparing, for --check.


def is_near(ours, theirs):
    """Equal as words, or as numbers to NEAR."""
    if ours == theirs:
        return True
    try:
        return math.isclose(float(ours), float(theirs), rel_tol=NEAR, abs_tol=1e-7)
    except ValueError:
        return False


def is_near_text(ours, theirs):
    """Whether two files have the same lines of the same words, their numbers to NEAR."""
    ours, theirs = ([line.split(" ") for line in file.read_bytes().decode().split("\n")] for file in (ours, theirs))
    return [len(line) for line in ours] == [len(line) for line in theirs] and all(
        is_near(a, b) for one, other in zip(ours, theirs) for a, b in zip(one, other)
    )


def compare(made, kept):
    """Names of the files that are equal, near, and neither."""
    equal, near, differ = [], [], []
    names = ({str(file.relative_to(top)) for file in top.rglob("*") if file.is_file()} for top in (made, kept))
    for name in sorted(set.union(*names) - NOT_MADE_HERE, key=lambda name: (name.endswith(".bin"), name)):
        ours, theirs = made / name, kept / name
        if not (ours.exists() and theirs.exists()):
            differ.append(f"{name}: only {'made' if ours.exists() else 'committed'}")
        elif filecmp.cmp(ours, theirs, shallow=False):
            equal.append(name)
        elif not name.startswith(tuple(f"{folder}/" for folder in ESTIMATED)):
            differ.append(f"{name}: the content differs")
        elif name.endswith(".txt") and is_near_text(ours, theirs):
            near.append(name)
        # The binary models are formats/text written again: they may differ when its numbers do.
        elif name.endswith(".bin") and "formats/text/images.txt" in near and ours.stat().st_size == theirs.stat().st_size:
            near.append(name)
        else:
            differ.append(f"{name}: the content differs")
    return equal, near, differ


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; compare with what is committed")
    arguments = parser.parse_args()
    pycolmap.logging.minloglevel = 2
    with tempfile.TemporaryDirectory() as scratch:
        made = Path(scratch) / "fixtures"
        made.mkdir()
        make(made)
        if arguments.check:
            equal, near, differ = compare(made, FIXTURES)
            print("\n".join([*differ, f"{len(equal)} files equal, {len(near)} equal to {NEAR}, {len(differ)} differ"]))
            sys.exit(1 if differ or len(equal) + len(near) < LEAST_FILES else 0)
        for folder in sorted(made.iterdir()):
            shutil.rmtree(FIXTURES / folder.name, ignore_errors=True)
            shutil.copytree(folder, FIXTURES / folder.name)


if __name__ == "__main__":
    main()
