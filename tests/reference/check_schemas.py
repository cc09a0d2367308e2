"""Checks the committed JSON Schemas with an independent validator: every committed file meets its schema, and what is
wrong is found at its place. `.ci/run` installs the validator (jsonschema) into a folder of its own and runs this."""

import json
import sys
import tomllib
from pathlib import Path

from jsonschema import Draft202012Validator

ROOT = Path(__file__).resolve().parents[2]


def validator(subject):
    schema = json.loads((ROOT / f"specs/schema/{subject}-1.json").read_text())
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator(schema)


def places(subject, text):
    errors = validator(subject).iter_errors(tomllib.loads(text))
    return ["/" + "/".join(str(step) for step in error.absolute_path) for error in errors]


# The lines of a child spec, and where they are wrong.
WRONG = [
    ('[action]\nrate = "250 rad/s"', "/action/rate"),
    ("[action]\nrate = 250", "/action/rate"),
    ('[action]\nkind = "torqe"', "/action/kind"),
    ('[action]\nkind = "torque"\nstiffness = "100 %"', "/action/stiffness"),
    ("[action]\nstd = 0.1", "/action/std"),
    ("[lern]\nseed = 1", "/"),
    ("[learn]\nseed = 1.5", "/learn/seed"),
    ("[learn]\ngamma = 2.0", "/learn/gamma"),
    ('[learn]\nsamples = "80 X"', "/learn/samples"),
    ('[reward.torque]\nk = "1 /N"', "/reward/torque/k"),
    ("[reward.torque]\nweihgt = 1", "/reward/torque"),
    ('[reward.mine]\nkind = "torque"\nk = "1 m"', "/reward/mine/k"),
    ("[randomize.link_mass]\nscale = { unifrom = [0.5, 1.5] }", "/randomize/link_mass/scale"),
    ("[randomize.link_mass]\nscale = { uniform = [0.5] }", "/randomize/link_mass/scale/uniform"),
    ('[task.command]\nspeed = { uniform = ["0 m/s", "1 m"] }', "/task/command/speed/uniform/1"),
    ("[learn]\nlearning_rate = { linear = [5e-5] }", "/learn/learning_rate/linear"),
    ("[evaluate.sets]\nkind = \"parameter_sets\"\nscale = [0.7, 1.0, 1.3]", "/evaluate/sets/scale"),
    ('[observe.base_orientation]\nscale = ["0.1 rad", "0.2 rad"]', "/observe/base_orientation/scale"),
    ("[observe.joint_position]\nscale = []", "/observe/joint_position/scale"),
    ('[profile.quick]\nphysics.rate = "500 ms"', "/profile/quick/physics/rate"),
    ('[profile.quick]\nname = "b"', "/profile/quick"),
    ('[allow]\nE0101 = "no"', "/allow"),
]

# Texts of suites that are wrong somewhere.
WRONG_SUITES = [
    "spec = 1\n[sweep]\nseeds = 3",
    'spec = 1\nsuite = "a"\n[sweep]\nseeds = 0',
    'spec = 1\nsuite = "a"\n[sweep.x]\npath = "a.b"',
    'spec = 1\nsuite = "a"\n[sweep.x]\none = { action.rate = "1 m" }',
    'spec = 1\nsuite = "a"\n[[claim]]\nid = "a"',
    'spec = 1\nsuite = "a"\nname = "b"',
]


def main():
    failures = []
    checked = 0
    for path in sorted([*ROOT.glob("specs/**/*.toml"), *ROOT.glob("robots/*.toml")]):
        text = path.read_text()
        first = text.splitlines()[0]
        if first.startswith("#:schema "):
            subject = Path(first.split()[1]).name.removesuffix("-1.json")
        else:
            subject = "suite" if "suite" in tomllib.loads(text) else "spec"
        found = places(subject, text)
        failures += [f"{path.relative_to(ROOT)}: {place}" for place in found]
        checked += 1
    whole = (ROOT / "tests/language/whole.toml").read_text()
    failures += [f"whole.toml: {place}" for place in places("spec", whole)]
    if not places("spec", whole.replace("[robot]\n", "[removed]\n")):
        failures.append("a whole spec without a robot is accepted")
    for lines, place in WRONG:
        found = places("spec", f'spec = 1\nextends = "base/run.toml"\n{lines}\n')
        hit = any(place in (each, f"{each.rstrip('/')}/{place.rsplit('/', 1)[1]}") for each in found)
        if not hit:
            failures.append(f"{lines!r}: expected {place}, found {found}")
    failures += [f"accepted: {text!r}" for text in WRONG_SUITES if not places("suite", text)]
    walk = (ROOT / "specs/motions/walk.toml").read_text()
    for old, new in [("harmonics", "harmonix"), ("kind ", "kin "), ("1.8 s", "1.8 Hz")]:
        if not places("motion", walk.replace(old, new)):
            failures.append(f"a motion with {new!r} is accepted")
    atlas = (ROOT / "robots/atlas.toml").read_text()
    for old, new in [("axis = ", "axle = "), ("12 rad/s", "12 rad")]:
        if not places("robot", atlas.replace(old, new)):
            failures.append(f"a robot with {new!r} is accepted")
    for line in failures or [f"{checked} files meet their schemas"]:
        print(line)
    return 1 if failures or checked < 25 else 0


if __name__ == "__main__":
    sys.exit(main())
