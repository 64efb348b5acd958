#!/usr/bin/env python3
"""The known calibrations of ../shared/data as cameras files, to be given to `calibstab compare --reference`.

    scripts/reference_cameras.py KNOWN.json OUT [--model OPENCV_FISHEYE] [--shift 0.5]

KNOWN.json is a reference_calibration.json or a ground_truth.json; OUT gets one cameras.txt, under the ids that stand there. --model chooses
where several are given; --shift moves the principal point of a tool whose first pixel has its centre at (0, 0).
"""

import argparse
import json
from pathlib import Path


def rows(known, model):
    """Id, model, size and parameters of every camera."""
    if "camera_matrix_px" in known:
        yield 1, "PINHOLE", [3072, 2048], list(known["camera_matrix_px"].values())
        return
    for camera_id, camera in known["cameras"].items():
        if "params" in camera:
            yield int(camera_id), camera["model"], [camera["width"], camera["height"]], camera["params"]
        else:
            yield int(camera_id), model, known["size"], list(camera[model].values())


def main():
    """Writes the file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("known", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--model", default="OPENCV")
    parser.add_argument("--shift", type=float, default=0.0)
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    lines = []
    for camera_id, model, size, params in rows(json.loads(given.known.read_text()), given.model):
        params[2:4] = [value + given.shift for value in params[2:4]]
        lines.append(" ".join(map(str, [camera_id, model, *size, *params])))
    (given.out / "cameras.txt").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
