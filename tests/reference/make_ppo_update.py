"""One PPO update by autograd, in double precision: the numbers that the learner's own update is compared with.

    python3 -m pip install --target FOLDER torch==2.13.0
    PYTHONPATH=FOLDER python3 tests/reference/make_ppo_update.py

Writes ppo_update.json beside this file; the test `tests/update.rs` reads it. Written from Schulman et al. 2017 (clipped
surrogate), Schulman et al. 2016 (generalised advantages, here as the plain sum of the definition) and Kingma and Ba 2015
(Adam, here torch.optim.Adam); shares nothing with the learner but the inputs.

The inputs are not stored: both sides make them with the linear congruential generator of `uniform`, whose numbers are
multiples of 2^-15 and therefore exact in single precision; the file holds their sums. The orders in which the samples are
learned from (ppo_orders.json) are the learner's own, written by the test under SPECFORGE_BLESS=1.
"""

import json
from pathlib import Path

import torch
from torch.distributions import Normal, kl_divergence
from torch.nn.utils import clip_grad_norm_

FOLDER = Path(__file__).parent
ENVIRONMENTS, STEPS, OBSERVED, TRUTHS, ACTIONS = 3, 40, 30, 4, 13
HIDDEN = [32, 32]
STD = 0.1
# Failures and time-outs as (environment, step); the last environment has neither.
FAILURES, TIMEOUTS = [(0, 12), (1, 7), (1, 8)], [(0, 25), (1, 39)]
CASES = {
    "minibatch_normalised": {
        "minibatch": 40, "epochs": 3, "rate": 1e-3, "kl_target": None, "value_rate": 2e-3,
        "gamma": 0.99, "lambda": 0.95, "clip": 0.2, "max_grad_norm": 0.5, "normalise": "minibatch", "every": 1,
    },
    # A last minibatch of 20 samples, and passes that end when the policy has moved too far.
    "batch_normalised": {
        "minibatch": 50, "epochs": 4, "rate": 1e-3, "kl_target": 0.02, "value_rate": 1e-3,
        "gamma": 0.97, "lambda": 0.9, "clip": 0.1, "max_grad_norm": 10.0, "normalise": "batch", "every": 5,
    },
}


def uniform(seed, *shape):
    """Numbers in [-1, 1) from the generator of Numerical Recipes, row-major."""
    count = torch.Size(shape).numel()
    values, state = [], seed
    for _ in range(count):
        state = (1664525 * state + 1013904223) % 2**32
        values.append((state >> 16) / 2**15 - 1.0)
    return torch.tensor(values, dtype=torch.float64).reshape(shape)


def network(seed, widths):
    """Parameters, a weight and a bias per layer; factors are powers of two, so nothing is rounded."""
    parameters = []
    for layer, (inputs, outputs) in enumerate(zip(widths, widths[1:])):
        factor = 0.25 if layer + 2 < len(widths) else 0.125
        parameters.append(factor * uniform(seed + 2 * layer, outputs, inputs))
        parameters.append(0.125 * uniform(seed + 2 * layer + 1, outputs))
    return [parameter.requires_grad_() for parameter in parameters]


def forward(parameters, x):
    for layer in range(0, len(parameters), 2):
        x = torch.nn.functional.linear(x, parameters[layer], parameters[layer + 1])
        if layer + 2 < len(parameters):
            x = torch.relu(x)
    return x


def advantages(rewards, values, last, timeouts, gamma, decay):
    """The sum over l of (gamma lambda)^l delta_(t+l), up to the end of the episode or of the rollout."""
    result = torch.zeros(ENVIRONMENTS, STEPS, dtype=torch.float64)
    for e in range(ENVIRONMENTS):
        for start in range(STEPS):
            factor = 1.0
            for t in range(start, STEPS):
                if (e, t) in FAILURES:
                    following = 0.0
                elif (e, t) in TIMEOUTS:
                    following = timeouts[TIMEOUTS.index((e, t))]
                else:
                    following = values[e, t + 1] if t + 1 < STEPS else last[e]
                result[e, start] += factor * (rewards[e, t] + gamma * following - values[e, t])
                factor *= gamma * decay
                if (e, t) in FAILURES or (e, t) in TIMEOUTS:
                    break
    return result


def inputs():
    return {
        "observations": uniform(1, ENVIRONMENTS, STEPS, OBSERVED),
        "truths": uniform(2, ENVIRONMENTS, STEPS, TRUTHS),
        "noise": uniform(3, ENVIRONMENTS, STEPS, ACTIONS),
        "rewards": uniform(4, ENVIRONMENTS, STEPS) + 0.5,
        "last_states": uniform(5, ENVIRONMENTS, OBSERVED + TRUTHS),
        "timeout_states": uniform(6, len(TIMEOUTS), OBSERVED + TRUTHS),
    }


def rollout(data, actor, critic, case):
    """What the update learns from, one row per sample; sample i is step i % STEPS of environment i // STEPS."""
    with torch.no_grad():
        states = torch.cat([data["observations"], data["truths"]], dim=2)
        values = forward(critic, states).squeeze(2)
        last = forward(critic, data["last_states"]).squeeze(1)
        timeouts = forward(critic, data["timeout_states"]).squeeze(1)
        estimate = advantages(data["rewards"], values, last, timeouts, case["gamma"], case["lambda"])
        means = forward(actor, data["observations"])
        flat = lambda x: x.reshape(ENVIRONMENTS * STEPS, *x.shape[2:])
        return {
            "observations": flat(data["observations"]), "states": flat(states), "means": flat(means),
            "actions": flat(means + 0.125 * data["noise"]), "advantages": flat(estimate),
            "targets": flat(estimate + values),
        }


def improve_actor(actor, batch, orders, case):
    optimiser = torch.optim.Adam(actor, lr=case["rate"], eps=1e-5)
    samples = ENVIRONMENTS * STEPS
    old = Normal(batch["means"], STD)
    old_log = old.log_prob(batch["actions"]).sum(1)
    norms, clipped, divergence, passes = [], 0.0, 0.0, 0
    for order in orders[: case["epochs"]]:
        divergence = 0.0
        for at in torch.tensor(order).split(case["minibatch"]):
            policy = Normal(forward(actor, batch["observations"][at]), STD)
            ratio = (policy.log_prob(batch["actions"][at]).sum(1) - old_log[at]).exp()
            over = batch["advantages"] if case["normalise"] == "batch" else batch["advantages"][at]
            advantage = (batch["advantages"][at] - over.mean()) / (over.std() + 1e-8)
            clip = ratio.clamp(1.0 - case["clip"], 1.0 + case["clip"])
            loss = -torch.min(ratio * advantage, clip * advantage).mean()
            optimiser.zero_grad()
            loss.backward()
            norms.append(float(clip_grad_norm_(actor, case["max_grad_norm"])))
            optimiser.step()
            clipped += float(((ratio - 1.0).abs() > case["clip"]).sum())
            before = Normal(old.loc[at], STD)
            divergence += float(kl_divergence(before, Normal(policy.loc.detach(), STD)).sum())
        divergence /= samples
        passes += 1
        if case["kl_target"] is not None and divergence > 1.5 * case["kl_target"]:
            break
    return {
        "divergence": divergence, "clip_fraction": clipped / (passes * samples), "epochs": passes,
        "actor_norm": sum(norms) / len(norms), "actor_norms": norms,
    }


def improve_critic(critic, batch, orders, case):
    optimiser = torch.optim.Adam(critic, lr=case["value_rate"], eps=1e-5)
    norms, squares = [], 0.0
    for order in orders[: case["epochs"]]:
        for at in torch.tensor(order).split(case["minibatch"]):
            error = forward(critic, batch["states"][at]).squeeze(1) - batch["targets"][at]
            optimiser.zero_grad()
            (0.5 * error.square().mean()).backward()
            norms.append(float(clip_grad_norm_(critic, case["max_grad_norm"])))
            optimiser.step()
            squares += float(error.detach().square().sum())
    return {
        "value_loss": squares / (case["epochs"] * ENVIRONMENTS * STEPS),
        "critic_norm": sum(norms) / len(norms), "critic_norms": norms,
    }


def next_rate(rate, divergence, target):
    """How a step size is steered to a KL divergence (the page of the kind `ppo`)."""
    if target is None:
        return rate
    ratio = divergence / target
    factor = 1 / 1.5 if ratio > 2 else 1 / 1.1 if ratio > 1.3 else 1.2 if ratio < 0.5 else 1.05 if ratio < 0.8 else 1.0
    return rate * factor


def flat(parameters, every):
    """All parameters, layer by layer, weights before biases; every so many of them."""
    numbers = torch.cat([parameter.detach().reshape(-1) for parameter in parameters])[::every]
    return [float(f"{number:.9g}") for number in numbers.tolist()]


def run(case, orders):
    data = inputs()
    actor, critic = network(100, [OBSERVED, *HIDDEN, ACTIONS]), network(200, [OBSERVED + TRUTHS, *HIDDEN, 1])
    batch = rollout(data, actor, critic, case)
    outcome = improve_actor(actor, batch, orders, case) | improve_critic(critic, batch, orders, case)
    outcome["next_rate"] = next_rate(case["rate"], outcome["divergence"], case["kl_target"])
    digits = lambda x: [float(f"{number:.9g}") for number in x.tolist()]
    return {
        "settings": case, "outcome": outcome, "advantages": digits(batch["advantages"]),
        "targets": digits(batch["targets"]), "actor": flat(actor, case["every"]), "critic": flat(critic, case["every"]),
    }


def main():
    torch.set_num_threads(1)
    orders = json.loads((FOLDER / "ppo_orders.json").read_text())
    sums = {name: float(values.sum()) for name, values in inputs().items()}
    cases = {name: run(case, orders) for name, case in CASES.items()}
    text = json.dumps({"torch": torch.__version__, "sums": sums, "cases": cases}, separators=(",", ":"))
    (FOLDER / "ppo_update.json").write_text(text.replace('"actor":', '\n"actor":').replace('"critic":', '\n"critic":') + "\n")


if __name__ == "__main__":
    main()
