//! What may be written in `[learn]` of kind `ppo`. `learn::Settings` reads it.

use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Length, Param, Ty};

const ACTIVATIONS: Ty = Ty::Choice(&["elu", "relu", "tanh"]);

const HIDDEN: Param = Param::default("hidden", Ty::List(&Ty::Count), "[256, 256]")
    .doc("Width of each hidden layer. The paper: two layers of 256.")
    .range(1.0, 8192.0);

const ACTIVATION: Param =
    Param::default("activation", ACTIVATIONS, "\"relu\"").doc("The activation after each hidden layer.");

const POLICY: &[Param] = &[HIDDEN, ACTIVATION];

const VALUE: &[Param] = &[
    HIDDEN,
    ACTIVATION,
    Param::default("learning_rate", Ty::Number, "5e-4")
        .doc("Adam's step size of the critic, constant.")
        .range(0.0, 1.0),
    Param::optional("hidden_learning_rate", Ty::Choice(&["value", "policy"])).doc(
        "Whose step size the critic's hidden layers learn with: its own, which is also what is meant without this key, or \
         the actor's at the beginning of the update, which leaves `learning_rate` to the last layer (the authors' code).",
    ),
    Param::optional("coefficient", Ty::Number)
        .doc(
            "Factor of the mean squared error in the critic's loss; without it 0.5. Adam takes it out again, but for \
             `adam_epsilon` and what `max_grad_norm` bounds.",
        )
        .range(1e-6, 1e6),
    Param::default("privileged", Ty::Flag, "false").doc(
        "Whether the critic also sees what the robot cannot measure: base velocity, height, contacts, foot loads.",
    ),
];

const STD_DECAY: &[Param] = &[
    Param::required("to", Ty::Ratio("`action.std`")).doc("The exploration at the end of the decay.").range(1e-6, 100.0),
    Param::required("over", Ty::Ratio("`learn.samples`"))
        .doc("The first part of the samples, over which it falls linearly; then it stays.")
        .range(1e-6, 1.0),
];

/// A step size: constant, falling linearly over the training, or steered by the KL divergence of an update.
pub const LEARNING_RATE: Ty = Ty::OneOf(&[
    Ty::Number,
    Ty::Table(&[Param::required("linear", Ty::List(&Ty::Number))
        .doc("Step size at the first and at the last sample.")
        .range(0.0, 1.0)
        .length(Length::Each(&["first", "last"]))]),
    Ty::Table(&[
        Param::required("kl_target", Ty::Number)
            .doc("KL divergence between the policy before and after an update that the step size is steered to.")
            .range(1e-6, 1.0),
        Param::required("start", Ty::Number).doc("Step size of the first update.").range(0.0, 1.0),
    ]),
]);

/// Proximal policy optimisation with a Gaussian policy of fixed standard deviation.
pub const PPO: Kind = Kind {
    name: "ppo",
    since: Edition::ONE,
    doc: include_str!("ppo.md"),
    params: &[
        Param::required("samples", Ty::Count)
            .doc(
                "Control steps to learn from, over all environments. The paper: 80 M. With 0 nothing is learned, and the \
                 policy is the pre-trained network alone.",
            )
            .range(0.0, 1e12),
        Param::optional("stop_at", Ty::Count)
            .doc(
                "Ends the training after this many samples, rounded up to whole updates, while step size and exploration \
                 follow the schedule of all `samples`. A longer training with otherwise equal keys continues from its end.",
            )
            .range(1.0, 1e12),
        Param::default("rollout", Ty::Count, "16384")
            .doc("Samples per update, over all environments.")
            .range(1.0, 1e8),
        Param::default("environments", Ty::Count, "64")
            .doc("Environments that are stepped side by side; they divide `rollout`.")
            .range(1.0, 65536.0),
        Param::default("minibatch", Ty::Count, "128").doc("Samples per gradient step.").range(1.0, 1e8),
        Param::default("epochs", Ty::Count, "3").doc("Passes over a rollout.").range(1.0, 1000.0),
        Param::default("learning_rate", LEARNING_RATE, "{ linear = [5e-5, 1e-6] }").doc(
            "Adam's step size of the actor: a number, `{ linear = [first, last] }`, or `{ kl_target = ..., start = ... }`.",
        )
        .range(0.0, 1.0),
        Param::default("gamma", Ty::Number, "0.99")
            .doc("Discount per control step; `discount_time` overrides it.")
            .range(0.0, 1.0),
        Param::optional("discount_time", Ty::Quantity(Dimension::TIME))
            .doc("Time after which a reward counts 1/e: gamma = exp(-step / discount_time), the same horizon at every control rate.")
            .range(1e-6, 1e6),
        Param::default("lambda", Ty::Number, "0.95")
            .doc("Decay of generalised advantage estimation per control step.")
            .range(0.0, 1.0),
        Param::default("clip", Ty::Number, "0.2")
            .doc("Probability ratios beyond 1 +- clip earn no gradient.")
            .range(1e-3, 10.0),
        Param::default("advantages", Ty::Choice(&["batch", "minibatch"]), "\"minibatch\"")
            .doc("Over which samples advantages are normalised to mean 0 and standard deviation 1."),
        Param::default("reward_scale", Ty::Choice(&["none", "one_minus_gamma"]), "\"none\"")
            .doc("Factor on all rewards before learning; `one_minus_gamma` makes values as large as one step's reward."),
        Param::default("warm_up", Ty::Count, "0")
            .range(0.0, 1e9)
            .doc("First updates in which only the critic learns, so that a pre-trained actor survives them."),
        Param::default("symmetry", Ty::Choice(&["none", "phase_mirror"]), "\"none\"")
            .doc("`phase_mirror`: in the second half of the cycle the actor sees and acts in the mirror."),
        Param::default("policy", Ty::Table(POLICY), "{}").doc("The actor's network."),
        Param::default("value", Ty::Table(VALUE), "{}").doc("The critic's network and its step size."),
        Param::default("max_grad_norm", Ty::Number, "0.5")
            .doc("Each network's gradient is shortened to this norm.")
            .range(1e-9, 1e9),
        Param::optional("grad_norm_of", Ty::Choice(&["each", "both"])).doc(
            "Whose gradient `max_grad_norm` bounds: each network's by itself, which is also what is meant without this key, \
             or both as one (the authors' code), so that the critic's errors shorten the actor's steps.",
        ),
        Param::default("adam_epsilon", Ty::Number, "1e-5").doc("Adam's epsilon.").range(1e-12, 1.0),
        Param::optional("std_decay", Ty::Table(STD_DECAY))
            .doc("The exploration falls over the training. Without it, as printed, it stays what `action.std` says."),
        Param::optional("time_limit", Ty::Choice(&["bootstrap", "failure"])).doc(
            "What follows an episode's time limit: the critic's value of its last state, which is also what is meant without \
             this key, or nothing, as after a fall.",
        ),
        Param::default("seed", Ty::Count, "1").doc("Names all random streams of the run."),
        Param::default("checkpoint_every", Ty::Count, "10")
            .doc("Updates between two checkpoints. It changes no result, so a training that was interrupted goes on with another value.")
            .range(1.0, 1e9),
        Param::optional("backend", Ty::Choice(&["native", "torch"])).doc(
            "What computes the updates: plain Rust, which is also what is meant without this key, or libtorch, which needs a \
             build with the feature `torch` (R0005). They differ in the order of sums, so `torch` makes another policy.",
        ),
        Param::optional("device", Ty::Choice(&["cpu", "cuda"])).doc(
            "Where the networks learn: `cuda` needs `backend = \"torch\"` and a libtorch for CUDA (R0006). Left out it is \
             the CPU, whose last bits are others, so `cuda` makes another policy.",
        ),
    ],
    needs: &[],
};
