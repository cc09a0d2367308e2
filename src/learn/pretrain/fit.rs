//! The regression: draws the samples on all threads, fits the actor with Adam, and measures the held-out
//! error in N m.

use std::path::Path;

use super::{PretrainReport, Teacher};
use crate::crash;
use crate::finite;
use crate::kinds::learn::Ppo;
use crate::kinds::motion::Motion;
use crate::kinds::pretrain::{self, PhaseLabel, Pretraining};
use crate::learn::LearnError;
use crate::learn::adam::Rule;
use crate::learn::backend::native::{NativeMlp, Workspace, check_processor};
use crate::learn::backend::{Beta, TrainableMlp, Workspaces};
use crate::learn::checkpoint::replace;
use crate::learn::clock::{Clock, timed};
use crate::learn::inference::Scratch;
use crate::learn::network::Network;
use crate::robot::Robot;
use crate::spec::{Section, Table};
use crate::stream::Stream;

/// Samples that are drawn from one random stream.
const BLOCK: usize = 512;
/// Number of fitted samples per held-out sample.
const HELD_OUT: usize = 20;

/// Inputs of a pre-training.
#[derive(Clone, Copy)]
pub struct Lesson<'a> {
    /// The decoded fields that the stage declares.
    pub fields: &'a Table,
    /// The robot.
    pub robot: &'a Robot,
    /// The reference motion, if the task has one.
    pub motion: Option<&'a Motion>,
    /// Threads to use; the result does not depend on their number.
    pub threads: usize,
    /// Called with the completed share; returns true to stop.
    pub interrupted: &'a dyn Fn(f64) -> bool,
}

/// Result of a pre-training.
#[derive(Clone, Debug)]
pub struct Pretrained {
    /// The fitted actor.
    pub actor: Network,
    /// Errors of the fit.
    pub report: PretrainReport,
}

impl Pretrained {
    /// Writes `actor.safetensors` and `pretrain.json` into a folder.
    pub fn save(&self, folder: &Path) -> Result<(), LearnError> {
        replace(&folder.join("actor.safetensors"), &self.actor.to_safetensors("actor"))?;
        let report = finite::to_string_pretty(&self.report);
        let report = report.map_err(|found| LearnError::not_finite("pretrain.json", found))?;
        replace(&folder.join("pretrain.json"), report.as_bytes())
    }
}

/// Labelled states, row by row.
struct Samples {
    inputs: Vec<f32>,
    labels: Vec<f32>,
}

/// Fits an actor to the labels of `[pretrain]`.
pub fn pretrain(lesson: &Lesson) -> Result<Pretrained, LearnError> {
    check_processor()?;
    let mut clock = Clock::resumed(0.0, 0.0);
    let sections = Section::new(lesson.fields);
    let pretraining: Pretraining = sections.part().expect("the spec has a pre-training");
    let learn = sections.within::<Ppo>().expect("the spec has a learner");
    let seed = learn.value(Ppo::seed).expect("the descriptor gives `seed` a default");
    let teacher = Teacher::new(lesson.fields, lesson.robot, lesson.motion);
    let count = pretraining.lesson().samples as usize;
    let samples = draw(&teacher, &format!("{seed}/pretrain/samples"), count, lesson.threads, &mut clock);
    let held_out = draw(
        &teacher,
        &format!("{seed}/pretrain/held_out"),
        count.div_ceil(HELD_OUT),
        lesson.threads,
        &mut clock,
    );
    let shape = learn.value(Ppo::policy).expect("the descriptor gives `policy` a default");
    let widths = shape.widths(teacher.inputs(), teacher.outputs());
    let start =
        Network::orthogonal(&widths, shape.activation, &mut Stream::new(&format!("{seed}/pretrain/initial")));
    let (actor, cpu) = timed(|| {
        let fitted = match pretraining.phase_label() {
            PhaseLabel::Masked => teacher.joints(),
            PhaseLabel::Random | PhaseLabel::Zero => teacher.outputs(),
        };
        let regression =
            Regression { lesson: pretraining.lesson(), fitted, seed, interrupted: lesson.interrupted };
        regression.fit(&start, &samples)
    });
    clock.cpu += cpu;
    let actor = actor?;
    let (errors, labels) = errors(&actor, &held_out, &teacher.torque_per_action());
    let names = lesson.robot.links.iter().map(|link| link.joint.name.clone());
    let report = PretrainReport {
        kind: pretraining.kind().to_owned(),
        samples: count as u64,
        held_out: count.div_ceil(HELD_OUT) as u64,
        rmse_nm: root_mean_square(&errors),
        label_rms_nm: root_mean_square(&labels),
        rmse_by_joint_nm: names.zip(errors).collect(),
        wall_s: clock.wall(),
        cpu_s: clock.cpu,
    };
    finite::check(&report).map_err(|found| LearnError::Unfit { what: found.to_string() })?;
    if !actor.is_finite() {
        return Err(LearnError::Unfit { what: "a weight is not a number".into() });
    }
    Ok(Pretrained { actor, report })
}

/// Draws samples in blocks, each from its own stream, on all threads.
fn draw(teacher: &Teacher, stream: &str, count: usize, threads: usize, clock: &mut Clock) -> Samples {
    let (inputs, outputs) = (teacher.inputs(), teacher.outputs());
    let mut samples = Samples { inputs: vec![0.0; count * inputs], labels: vec![0.0; count * outputs] };
    let blocks = count.div_ceil(BLOCK).div_ceil(threads.max(1));
    let shares = samples
        .inputs
        .chunks_mut(blocks * BLOCK * inputs)
        .zip(samples.labels.chunks_mut(blocks * BLOCK * outputs));
    let part = crash::part();
    let cpu: f64 = std::thread::scope(|scope| {
        let draw_share = |share: usize, rows: &mut [f32], labels: &mut [f32]| {
            part.join();
            let mut teacher = teacher.clone();
            let blocks_here = rows.chunks_mut(BLOCK * inputs).zip(labels.chunks_mut(BLOCK * outputs));
            for (block, (rows, labels)) in blocks_here.enumerate() {
                let mut stream = Stream::new(&format!("{stream}/{}", share * blocks + block));
                for (row, label) in rows.chunks_exact_mut(inputs).zip(labels.chunks_exact_mut(outputs)) {
                    teacher.draw(&mut stream, row, label);
                }
            }
        };
        let handles: Vec<_> = shares
            .enumerate()
            .map(|(share, (rows, labels))| scope.spawn(move || timed(|| draw_share(share, rows, labels)).1))
            .collect();
        handles.into_iter().map(|handle| crash::joined(handle.join())).sum()
    });
    clock.cpu += cpu;
    samples
}

/// A fit of the actor to labels.
struct Regression<'a> {
    /// Samples, passes and step sizes.
    lesson: &'a pretrain::Lesson,
    /// Number of outputs that are fitted, from the first; the others have no labels.
    fitted: usize,
    seed: u64,
    /// Called with the completed share; returns true to stop.
    interrupted: &'a dyn Fn(f64) -> bool,
}

impl Regression<'_> {
    /// Minimises the mean squared error of the actions.
    fn fit(&self, start: &Network, samples: &Samples) -> Result<Network, LearnError> {
        let count = samples.inputs.len() / start.inputs();
        let minibatch = self.lesson.minibatch.min(count);
        let epochs = self.lesson.epochs as usize;
        let rates = &self.lesson.learning_rate;
        let (first, last) = (rates.first().copied().unwrap_or(1e-3), rates.last().copied().unwrap_or(1e-3));
        let steps = (epochs * count.div_ceil(minibatch)) as f64;
        let mut network = NativeMlp::new(start);
        let mut spaces = Workspaces::default();
        let mut step: u32 = 0;
        for epoch in 0..epochs {
            let order = Stream::new(&format!("{}/pretrain/shuffle/{epoch}", self.seed)).permutation(count);
            for minibatch in order.chunks(minibatch) {
                let space = spaces.of(&network, minibatch.len());
                gather(minibatch, &samples.inputs, &mut space.inputs);
                network.forward(space);
                write_slopes(minibatch, &samples.labels, self.fitted, space);
                network.backward(space, Beta::Zero);
                let rate = first + (last - first) * f64::from(step) / steps;
                let norm = network.gradient_norm();
                if !norm.is_finite() {
                    return Err(LearnError::Lesson { step: u64::from(step) });
                }
                network.step(norm, Rule { rates: [rate; 2], epsilon: 1e-8, bound: f64::INFINITY });
                step += 1;
            }
            if (self.interrupted)((epoch + 1) as f64 / epochs as f64) {
                return Err(LearnError::Interrupted);
            }
        }
        Ok(network.network())
    }
}

/// Copies the rows of a minibatch.
fn gather(minibatch: &[usize], from: &[f32], rows: &mut [f32]) {
    let width = rows.len() / minibatch.len();
    for (sample, row) in minibatch.iter().zip(rows.chunks_exact_mut(width)) {
        row.copy_from_slice(&from[sample * width..(sample + 1) * width]);
    }
}

/// Writes the derivatives of half the mean squared error of the first `fitted` outputs.
fn write_slopes(minibatch: &[usize], labels: &[f32], fitted: usize, space: &mut Workspace) {
    let (found, slopes) = space.slopes_mut();
    let outputs = found.len() / minibatch.len();
    let share = 1.0 / (minibatch.len() * fitted) as f32;
    let rows = found.chunks_exact(outputs).zip(slopes.chunks_exact_mut(outputs));
    for (sample, (found, slopes)) in minibatch.iter().zip(rows) {
        let labels = &labels[sample * outputs..(sample + 1) * outputs];
        for (place, slope) in slopes.iter_mut().enumerate() {
            *slope = if place < fitted { share * (found[place] - labels[place]) } else { 0.0 };
        }
    }
}

/// Root mean square of each joint's error and label in N m.
fn errors(actor: &Network, samples: &Samples, torque_per_action: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (outputs, joints) = (actor.outputs(), torque_per_action.len());
    let mut found = vec![0.0; samples.labels.len()];
    actor.forward(&samples.inputs, &mut found, &mut Scratch::default());
    let rows = samples.labels.len() / outputs;
    let (mut errors, mut labels) = (vec![0.0; joints], vec![0.0; joints]);
    for (found, label) in found.chunks_exact(outputs).zip(samples.labels.chunks_exact(outputs)) {
        for joint in 0..joints {
            let scale = torque_per_action[joint];
            errors[joint] += (scale * f64::from(found[joint] - label[joint])).powi(2);
            labels[joint] += (scale * f64::from(label[joint])).powi(2);
        }
    }
    let root = |sum: &f64| (sum / rows as f64).sqrt();
    (errors.iter().map(root).collect(), labels.iter().map(root).collect())
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::motion;
    use crate::learn::pretrain::specs;
    use crate::spec::Value;

    fn set(fields: &mut Table, key: &str, value: Value) {
        let Some(Value::Table(pretrain)) = fields.get_mut("pretrain") else {
            panic!("the spec has a pre-training")
        };
        pretrain.insert(key.into(), value);
    }

    fn run(fields: &Table, threads: usize) -> Pretrained {
        let robot = crate::robot::shipped("tocabi").unwrap();
        let walk = motion::shipped("walk", &robot).unwrap().unwrap();
        let lesson = Lesson { fields, robot: &robot, motion: Some(&walk), threads, interrupted: &|_| false };
        pretrain(&lesson).unwrap()
    }

    #[test]
    fn both_kinds_learn_most_of_their_labels_under_both_controls() {
        for fields in
            [specs::torque("tracking"), specs::torque("gravity_compensation"), specs::position("tracking")]
        {
            let report = run(&fields, 2).report;
            assert!(report.rmse_nm < 0.7 * report.label_rms_nm, "{report:?}");
            assert_eq!((report.samples, report.held_out), (4000, 200));
            assert_eq!(report.rmse_by_joint_nm.len(), 12);
        }
    }

    #[test]
    fn the_number_of_threads_does_not_change_a_bit() {
        let fields = specs::torque("tracking");
        assert_eq!(run(&fields, 1).actor, run(&fields, 3).actor);
    }

    #[test]
    fn a_lesson_that_leaves_the_numbers_speaks_of_its_samples_and_labels() {
        let robot = crate::robot::shipped("tocabi").unwrap();
        let mut fields = specs::torque("gravity_compensation");
        set(&mut fields, "learning_rate", specs::list(&[1e30, 1e30]));
        let lesson =
            Lesson { fields: &fields, robot: &robot, motion: None, threads: 1, interrupted: &|_| false };
        let error = pretrain(&lesson).unwrap_err();
        assert_eq!(error.code(), Some("R0001"));
        let said = error.to_string();
        assert!(said.contains("of the pre-training: the samples, their labels"), "{said}");
        assert!(!said.contains("reward") && !said.contains("update"), "{said}");
    }

    #[test]
    fn a_loss_that_overflows_ends_the_pre_training_with_a_code() {
        let mut robot = crate::robot::shipped("tocabi").unwrap();
        robot.links.iter_mut().for_each(|link| link.joint.effort_limit = 1e300);
        let fields = specs::torque("gravity_compensation");
        let lesson =
            Lesson { fields: &fields, robot: &robot, motion: None, threads: 1, interrupted: &|_| false };
        let error = pretrain(&lesson).unwrap_err();
        assert_eq!(error.code(), Some("R0001"));
        assert!(error.to_string().contains("rmse_nm is inf"), "{error}");
    }

    #[test]
    fn a_masked_phase_action_keeps_its_first_weights_and_a_zero_one_does_not() {
        for (label, kept) in [("masked", true), ("zero", false)] {
            let mut fields = specs::torque("gravity_compensation");
            set(&mut fields, "phase_label", specs::text(label));
            let actor = run(&fields, 1).actor;
            let stream = &mut Stream::new("1/pretrain/initial");
            let start = Network::orthogonal(&actor.widths(), actor.activation, stream);
            let phase = |network: &Network| {
                let last = network.layers.last().unwrap().clone();
                let row = 12 * last.inputs..13 * last.inputs;
                (last.outputs, last.weight[row].to_vec(), last.bias[12])
            };
            assert_eq!(phase(&actor).0, 13);
            assert_eq!(phase(&actor) == phase(&start), kept, "{label}");
            assert_ne!(actor.layers[2].weight[..12], start.layers[2].weight[..12], "the torques are learned");
        }
    }

    #[test]
    fn an_interrupted_lesson_says_so() {
        let robot = crate::robot::shipped("tocabi").unwrap();
        let fields = specs::torque("gravity_compensation");
        let lesson =
            Lesson { fields: &fields, robot: &robot, motion: None, threads: 1, interrupted: &|_| true };
        assert!(matches!(pretrain(&lesson), Err(LearnError::Interrupted)));
    }
}
