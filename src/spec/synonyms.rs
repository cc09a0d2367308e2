//! Names of keys, kinds and sections in other programs: legged_gym, Isaac Lab, Stable-Baselines3 and the
//! papers that use them. Source of suggestions, `explain` and `docs/reference/synonyms.md`.

/// Names of the same thing elsewhere and here.
#[derive(Clone, Copy, Debug)]
pub struct Synonym {
    /// The names elsewhere, in lower case with underscores.
    pub theirs: &'static [&'static str],
    /// The paths here: sections, keys (`learn.gamma`) and kinds (`reward.torque`); `*` is the name of a term.
    pub ours: &'static [&'static str],
    /// What differs besides the name; empty if nothing does.
    pub note: &'static str,
}

const fn same(theirs: &'static [&'static str], ours: &'static [&'static str]) -> Synonym {
    Synonym { theirs, ours, note: "" }
}

const fn differs(
    theirs: &'static [&'static str],
    ours: &'static [&'static str],
    note: &'static str,
) -> Synonym {
    Synonym { theirs, ours, note }
}

/// A part of the table, with a title.
pub struct Part {
    /// Its heading.
    pub title: &'static str,
    /// Its rows.
    pub rows: &'static [Synonym],
}

/// The table.
pub const PARTS: &[Part] = &[
    Part { title: "Learning", rows: LEARNING },
    Part { title: "Actions and control", rows: CONTROL },
    Part { title: "Task and episodes", rows: TASK },
    Part { title: "Rewards", rows: REWARDS },
    Part { title: "Observations", rows: OBSERVATIONS },
    Part { title: "Randomization, pushes and noise", rows: RANDOMIZATION },
    Part { title: "Terminations", rows: TERMINATIONS },
    Part { title: "Terrain and curricula", rows: TERRAIN },
    Part { title: "Evaluation, export and sweeps", rows: EVALUATION },
];

const LEARNING: &[Synonym] = &[
    same(&["num_envs", "n_envs", "num_environments", "num_actors"], &["learn.environments"]),
    same(&["total_timesteps", "timesteps", "total_steps", "num_timesteps"], &["learn.samples"]),
    differs(
        &["max_iterations", "num_iterations", "max_epochs", "num_updates"],
        &["learn.samples"],
        "Samples instead of updates: the number of updates times `learn.rollout`.",
    ),
    differs(
        &["n_steps", "num_steps", "num_steps_per_env", "num_transitions_per_env", "horizon_length"],
        &["learn.rollout"],
        "Samples of all environments together: steps per environment times `learn.environments`.",
    ),
    same(&["batch_size", "minibatch_size", "mini_batch_size"], &["learn.minibatch"]),
    differs(
        &["num_mini_batches", "n_minibatches", "num_minibatches"],
        &["learn.minibatch"],
        "The size of a minibatch instead of their number: `learn.rollout` divided by it.",
    ),
    same(&["n_epochs", "num_learning_epochs", "mini_epochs", "update_epochs"], &["learn.epochs"]),
    same(&["lr", "step_size", "actor_lr"], &["learn.learning_rate"]),
    same(&["critic_lr", "value_lr"], &["learn.value.learning_rate"]),
    same(&["discount", "discount_factor"], &["learn.gamma"]),
    same(&["gae_lambda", "lam", "tau"], &["learn.lambda"]),
    same(&["clip_range", "clip_param", "clip_eps", "e_clip", "clip_coef", "cliprange"], &["learn.clip"]),
    differs(
        &["ent_coef", "entropy_coef", "entropy_coefficient", "entropy"],
        &["action.std"],
        "The exploration is fixed, so there is no entropy bonus: set its standard deviation.",
    ),
    differs(
        &["init_noise_std", "log_std", "log_std_init", "action_noise", "exploration", "exploration_noise"],
        &["action.std"],
        "Fixed, and a share of the joint's effort limit or range; `learn.std_decay` lowers it over time.",
    ),
    same(&["vf_coef", "value_loss_coef", "critic_coef"], &["learn.value.coefficient"]),
    same(&["grad_norm", "clip_grad_norm", "gradient_clip", "max_gradient_norm"], &["learn.max_grad_norm"]),
    same(&["desired_kl", "target_kl", "kl_threshold"], &["learn.learning_rate.kl_target"]),
    same(
        &["hidden", "hidden_dims", "hidden_sizes", "actor_hidden_dims", "net_arch", "policy_kwargs", "mlp"],
        &["learn.policy.hidden", "learn.value.hidden"],
    ),
    same(&["critic_hidden_dims"], &["learn.value.hidden"]),
    same(&["activation_fn", "nonlinearity"], &["learn.policy.activation", "learn.value.activation"]),
    same(
        &["privileged_obs", "num_privileged_obs", "critic_observations", "asymmetric_critic"],
        &["learn.value.privileged"],
    ),
    same(&["normalize_advantage", "normalize_advantages"], &["learn.advantages"]),
    same(&["reward_scaling", "reward_shaper", "scale_value"], &["learn.reward_scale"]),
    same(&["save_interval", "save_freq", "save_frequency"], &["learn.checkpoint_every"]),
    same(&["random_seed", "rng_seed"], &["learn.seed"]),
    same(&["sim_device", "rl_device", "cuda", "gpu"], &["learn.device"]),
    same(&["behavior_cloning", "imitation", "pretraining", "warm_start"], &["pretrain"]),
    same(&["algorithm", "agent", "train", "runner"], &["learn"]),
    differs(
        &["finetune", "fine_tuning", "finetuning", "load_run", "load_checkpoint"],
        &["fine_tune"],
        "Continues the training of the same spec; the store finds the first policy.",
    ),
];

const CONTROL: &[Synonym] = &[
    same(&["actions", "control", "controller", "actuators"], &["action"]),
    differs(
        &["action_scale", "scale_actions"],
        &["action.scale", "action.std"],
        "Under torque control an action of 1 is the joint's effort limit; position control has `scale`.",
    ),
    same(&["kp", "p_gain", "p_gains", "p_gain_scale"], &["action.stiffness"]),
    same(&["kd", "d_gain", "d_gains", "d_gain_scale"], &["action.damping"]),
    differs(
        &["decimation", "control_decimation", "frame_skip", "n_substeps", "control_freq", "policy_freq"],
        &["action.rate"],
        "The policy's rate in Hz; `physics.rate` must be a multiple of it.",
    ),
    differs(
        &["dt", "sim_dt", "timestep", "time_step", "sim_freq"],
        &["physics.rate"],
        "A rate in Hz instead of a step in s.",
    ),
    same(&["latency", "control_delay", "lag"], &["action.delay"]),
    same(&["simulator", "sim", "backend_sim"], &["physics"]),
    same(&["control_type", "actuator"], &["action"]),
    same(&["t", "effort", "torques_control"], &["action.torque"]),
    same(&["p", "pd", "joint_position", "position_control"], &["action.position"]),
];

const TASK: &[Synonym] = &[
    same(&["env", "environment", "mdp"], &["task"]),
    same(
        &["episode_length", "episode_length_s", "max_episode_length", "max_episode_steps", "time_limit"],
        &["task.episode"],
    ),
    same(&["commands", "command_ranges", "lin_vel_x", "target_velocity"], &["task.command.speed"]),
    same(&["resampling_time", "resampling_time_range"], &["task.command.every"]),
    same(&["reference_motion", "mocap", "clip_file", "motion_file"], &["task.motion"]),
    same(&["init_state", "initial_state", "reset"], &["initial"]),
    same(&["asset", "urdf", "robot_cfg"], &["robot.model"]),
];

const REWARDS: &[Synonym] = &[
    same(&["rewards", "reward_scales", "reward_terms"], &["reward"]),
    same(&["scale", "coef", "coefficient", "reward_scale"], &["reward.*.weight"]),
    differs(
        &["sigma", "tracking_sigma"],
        &["reward.*.k"],
        "Terms are exp(-k x): k is 1 / sigma where the other program divides by sigma.",
    ),
    same(
        &["tracking_lin_vel", "track_lin_vel_xy_exp", "lin_vel", "forward_reward"],
        &["reward.velocity_tracking"],
    ),
    same(&["orientation", "flat_orientation_l2", "upright", "upvector"], &["reward.base_orientation"]),
    same(&["torques", "joint_torques_l2", "dof_torques_l2", "energy"], &["reward.torque"]),
    same(&["action_rate", "action_rate_l2", "smoothness"], &["reward.torque_change"]),
    same(&["dof_vel", "joint_vel_l2"], &["reward.joint_velocity"]),
    same(&["dof_acc", "dof_acc_l2", "joint_acc_l2"], &["reward.joint_velocity_change"]),
    same(&["feet_air_time", "gait", "phase_reward"], &["reward.contact_schedule"]),
    same(&["imitation_reward", "joint_pos", "pose"], &["reward.joint_tracking"]),
    same(&["feet_contact_forces", "contact_forces"], &["reward.contact_force"]),
];

const OBSERVATIONS: &[Synonym] = &[
    same(&["obs", "observation", "observations", "sensors"], &["observe"]),
    differs(
        &["obs_scales", "normalize_observation", "normalize_obs", "vecnormalize"],
        &["observe.*.scale"],
        "Fixed scales per input; there is no running normalization.",
    ),
    same(&["projected_gravity", "base_quat", "imu"], &["observe.base_orientation"]),
    same(&["dof_pos", "joint_pos_rel"], &["observe.joint_position"]),
    same(&["joint_vel", "joint_vel_rel"], &["observe.joint_velocity"]),
    same(&["velocity_commands"], &["observe.command"]),
];

const RANDOMIZATION: &[Synonym] = &[
    same(
        &["domain_rand", "domain_randomization", "randomization", "events", "dynamics_randomization"],
        &["randomize"],
    ),
    differs(
        &["range", "distribution", "min_max"],
        &["randomize.*.scale", "randomize.*.offset", "randomize.*.impulse"],
        "The value itself is a distribution: `scale = { uniform = [0.5, 1.25] }`.",
    ),
    same(
        &["pushes", "push_robots", "push_robot", "push_by_setting_velocity", "perturbations"],
        &["randomize.push"],
    ),
    same(&["push_interval_s", "push_interval", "interval"], &["randomize.push.every"]),
    differs(
        &["max_push_vel_xy", "max_push_vel", "push_force", "push_velocity"],
        &["randomize.push.impulse"],
        "An impulse in N s instead of a velocity: the velocity times the robot's mass.",
    ),
    same(
        &["friction_range", "randomize_friction", "physics_material", "ground_friction_range"],
        &["randomize.ground_friction"],
    ),
    same(
        &["added_mass", "added_mass_range", "randomize_base_mass", "add_base_mass", "base_mass"],
        &["randomize.payload"],
    ),
    same(&["mass_range", "randomize_mass", "link_masses"], &["randomize.link_mass"]),
    same(&["com_displacement", "base_com"], &["randomize.link_com"]),
    same(&["motor_strength", "randomize_motor_strength", "torque_constant"], &["randomize.motor_constant"]),
    same(&["randomize_delay", "action_latency", "lag_timesteps"], &["randomize.action_delay"]),
    same(&["encoder_offset", "motor_offset", "joint_bias"], &["randomize.joint_offset"]),
    differs(
        &["add_noise", "noise_scales", "obs_noise", "observation_noise"],
        &["observe.joint_position.noise"],
        "Noise is a key of the input; evaluations have it with `noise = true`.",
    ),
];

const TERMINATIONS: &[Synonym] = &[
    same(&["terminations", "termination", "done", "dones", "early_termination"], &["terminate"]),
    same(&["root_height_below_minimum", "min_height", "healthy_z_range"], &["terminate.base_height"]),
    same(&["bad_orientation", "tilt", "max_tilt"], &["terminate.base_tilt"]),
    same(&["terminate_after_contacts_on", "illegal_contact", "base_contact"], &["terminate.ground_contact"]),
    same(&["self_collisions", "enable_self_collisions"], &["terminate.self_collision"]),
];

const TERRAIN: &[Synonym] = &[
    differs(
        &["curriculum", "terrain_curriculum", "curriculum_learning", "terrain_levels"],
        &["fine_tune", "terrain"],
        "There is no curriculum of many levels: learn on one ground, then continue on another.",
    ),
    same(&["ground", "terrains", "mesh_type"], &["terrain"]),
    same(&["plane", "ground_plane"], &["terrain.flat"]),
    same(&["rough", "trimesh", "heightfield", "random_rough", "uneven"], &["terrain.height_field"]),
    same(&["incline", "ramp", "pyramid_sloped"], &["terrain.slope"]),
    same(&["obstacle", "step_obstacle", "discrete_obstacles"], &["terrain.box_obstacle"]),
];

const EVALUATION: &[Synonym] = &[
    same(&["eval", "evaluation", "test", "play"], &["evaluate"]),
    same(&["n_eval_episodes", "num_episodes", "eval_episodes"], &["evaluate.episodes.episodes"]),
    same(&["export_policy", "export_jit", "onnx"], &["deploy.export"]),
    same(&["sim2sim", "sim_to_sim"], &["deploy.transfer"]),
    same(&["logger", "wandb", "logging"], &["report"]),
];

/// The row of a name, in any case and with `-`, `_` or blanks.
pub fn find(word: &str) -> Option<&'static Synonym> {
    if word.len() > LONGEST {
        return None;
    }
    let word = word.to_lowercase().replace(['-', ' '], "_");
    PARTS.iter().flat_map(|part| part.rows).find(|row| row.theirs.contains(&word.as_str()))
}

/// Maximum length of a name in bytes.
const LONGEST: usize = 40;

/// The name here of a key written in the table `path`, if known: `environments` for `num_envs` in `learn`.
pub fn here<'a>(word: &str, path: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let row = rows(word).find_map(|row| {
        row.ours.iter().find_map(|ours| {
            let (parent, name) = ours.rsplit_once('.').unwrap_or(("", ours));
            is_at(parent, path).then_some(name)
        })
    })?;
    names.into_iter().find(|name| *name == row)
}

/// What to write instead of a name that belongs elsewhere in the spec.
pub fn elsewhere(word: &str) -> Option<String> {
    let row = find(word)?;
    let paths: Vec<String> = row.ours.iter().map(|path| format!("`{}`", shown(path))).collect();
    let note = if row.note.is_empty() { String::new() } else { format!(". {}", row.note) };
    Some(format!("here it is {}{}", paths.join(" or "), note.trim_end_matches('.')))
}

/// A path as displayed.
pub fn shown(path: &str) -> String {
    path.replace('*', "NAME")
}

/// All rows of a name.
fn rows(word: &str) -> impl Iterator<Item = &'static Synonym> {
    let word =
        if word.len() > LONGEST { String::new() } else { word.to_lowercase().replace(['-', ' '], "_") };
    PARTS.iter().flat_map(|part| part.rows).filter(move |row| row.theirs.contains(&word.as_str()))
}

/// Whether a path fits a pattern in which `*` is any one step.
fn is_at(pattern: &str, path: &str) -> bool {
    let (mut steps, mut wanted) = (path.split('.'), pattern.split('.'));
    loop {
        match (steps.next(), wanted.next()) {
            (None, None) => return true,
            (Some(step), Some(want)) if want == "*" || want == step => {}
            _ => return false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_in_the_table_that_they_belong_to() {
        assert_eq!(here("num_envs", "learn", ["environments", "samples"]), Some("environments"));
        assert_eq!(here("Num-Envs", "learn", ["environments"]), Some("environments"));
        assert_eq!(here("num_envs", "task", ["environments"]), None);
        assert_eq!(here("sigma", "reward.torque", ["k", "weight"]), Some("k"));
        assert_eq!(here("domain_rand", "", ["randomize"]), Some("randomize"));
        assert_eq!(here("friction", "learn", ["clip"]), None);
        assert_eq!(elsewhere("vf_coef").as_deref(), Some("here it is `learn.value.coefficient`"));
        assert_eq!(elsewhere(&"x".repeat(1000)), None);
    }

    #[test]
    fn no_name_stands_twice_and_all_are_in_the_form_that_is_looked_up() {
        let mut names: Vec<&str> =
            PARTS.iter().flat_map(|part| part.rows).flat_map(|row| row.theirs.iter().copied()).collect();
        let form =
            |name: &&str| name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
        assert!(names.iter().all(|name| form(name) && name.len() <= LONGEST), "{names:?}");
        names.sort_unstable();
        let twice: Vec<&[&str]> = names.windows(2).filter(|pair| pair[0] == pair[1]).collect();
        assert!(twice.is_empty(), "{twice:?}");
    }
}
