"""Reads an event file with TensorBoard's own reader and compares it with the metrics beside it.

    python3 -m pip install tensorboard==2.20.0
    python3 tests/reference/check_tensorboard.py FOLDER

FOLDER holds `metrics.jsonl` and an event file: an artefact of the stage `learner` in the store.
"""

import json
import math
import pathlib
import sys

from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

folder = pathlib.Path(sys.argv[1])
lines = [json.loads(line) for line in (folder / "metrics.jsonl").read_text().splitlines()]
reader = EventAccumulator(str(folder), size_guidance={"scalars": 0})
reader.Reload()
tags = reader.Tags()["scalars"]


def flat(line):
    for name, value in line.items():
        # Warnings are a list of texts.
        if name in ("update", "samples", "samples_total") or value is None or isinstance(value, list):
            continue
        if isinstance(value, dict):
            yield from ((f"{name}/{part}", number) for part, number in value.items())
        else:
            yield name, value


expected = {}
for line in lines:
    for tag, number in flat(line):
        expected.setdefault(tag, []).append((line["samples"], number))
assert sorted(expected) == sorted(tags), set(expected) ^ set(tags)
for tag, points in expected.items():
    found = [(event.step, event.value) for event in reader.Scalars(tag)]
    assert len(found) == len(points), tag
    for (step, value), (samples, number) in zip(found, points):
        assert step == samples and math.isclose(value, number, rel_tol=1e-6, abs_tol=1e-30), (tag, step, value, number)
print(f"{len(tags)} scalars of {len(lines)} updates agree")
