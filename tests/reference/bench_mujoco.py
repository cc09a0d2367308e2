"""Times physics steps of MuJoCo's own `rollout` and of `mjbatch` on one of our robots.

    python3 -m pip install mujoco==3.14.0 mjbatch==0.1.4 numpy
    specforge robot show tocabi --format mjcf > tocabi.xml
    python3 tests/reference/bench_mujoco.py tocabi.xml [THREADS ...]

The robot stands on flat ground and follows random joint targets (normal, 0.15 rad around the default pose, drawn anew
every 50 steps of 2 ms) by the gains in its file. `rollout` and `mjbatch` step the same environments. Prints microseconds
per environment and step, the median of several rounds in turn; wall time counts only on a machine that does nothing else. To compare with the
engines of specforge, run `cargo bench --bench batch` in the same minutes.
"""

import re
import statistics
import sys
import time

import mjbatch
import mujoco
import mujoco.rollout
import numpy

ENVIRONMENTS = 64
STEPS = 250
HOLD = 50
ROUNDS = 5


def servo_model(text):
    """The robot's model with a position servo of the file's gains in place of each torque motor."""

    def gain(joint, name):
        return float(re.search(rf'name="{joint}\.{name}" data="([^"]+)"', text)[1])

    def servo(motor):
        joint, limit = motor[1], motor[2]
        stiffness, damping = gain(joint, "stiffness_gain"), gain(joint, "damping_gain")
        return (
            f'<general name="{joint}" joint="{joint}" gaintype="fixed" gainprm="{stiffness}" biastype="affine" '
            f'biasprm="0 {-stiffness} {-damping}" forcerange="-{limit} {limit}"/>'
        )

    text, count = re.subn(r'<motor name="(\w+)" joint="\w+" ctrlrange="-(\S+) \S+"/>', servo, text)
    assert count > 0, "the model has no torque motors"
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.timestep = 0.002
    return model


def targets(model, generator):
    """Control of every step: [environment, step, joint] in rad."""
    home = model.key_qpos[0][7:]
    drawn = home + generator.normal(0, 0.15, (ENVIRONMENTS, STEPS // HOLD, model.nu))
    return numpy.repeat(drawn, HOLD, axis=1)


def of_rollout(model, start, control, threads):
    data = [mujoco.MjData(model) for _ in range(threads)]
    with mujoco.rollout.Rollout(nthread=threads if threads > 1 else 0) as pool:
        return timed(lambda: pool.rollout(model, data, start, control))


def of_mjbatch(model, start, control, threads):
    batch = mjbatch.Batch(model, num_sims=ENVIRONMENTS, num_threads=threads)
    position, velocity, command = (batch.bind(name) for name in ("qpos", "qvel", "ctrl"))
    position[:], velocity[:] = start[:, 1 : 1 + model.nq], start[:, 1 + model.nq :]

    def run():
        for step in range(STEPS):
            command[:] = control[:, step]
            batch.step()

    return timed(run)


def timed(work):
    cpu, wall = time.process_time(), time.perf_counter()
    work()
    scale = 1e6 / (ENVIRONMENTS * STEPS)
    return scale * (time.process_time() - cpu), scale * (time.perf_counter() - wall)


def main():
    model = servo_model(open(sys.argv[1]).read())
    counts = [int(text) for text in sys.argv[2:]] or [1, 2]
    generator = numpy.random.default_rng(1)
    control = targets(model, generator)
    start = numpy.concatenate([[0.0], model.key_qpos[0], numpy.zeros(model.nv)])
    start = numpy.tile(start, (ENVIRONMENTS, 1))
    print(f"MuJoCo {mujoco.__version__}, {ENVIRONMENTS} environments, {STEPS} steps, random joint targets")
    print("| program | threads | us of CPU time per step | us of wall time per step |")
    print("|---|---|---|---|")
    for threads in counts:
        rounds = {"rollout": [], "mjbatch": []}
        for _ in range(ROUNDS):
            rounds["rollout"].append(of_rollout(model, start, control, threads))
            rounds["mjbatch"].append(of_mjbatch(model, start, control, threads))
        for name, times in rounds.items():
            cpu, wall = (statistics.median(column) for column in zip(*times))
            print(f"| {name} | {threads} | {cpu:.1f} | {wall:.1f} |")


main()
