//! `show --signals`: every input and output of the policy, and the controller behind the outputs.

use serde_json::{Value as Json, json};

use crate::check::Checked;
use crate::control::words;
use crate::deploy::law;
use crate::env::Observation;
use crate::escape::terminal::one_line;
use crate::kinds::action::Action;
use crate::kinds::learn::Learner;
use crate::kinds::observe::Input;
use crate::kinds::observe::Observations;
use crate::kinds::task::Task;
use crate::robot::Robot;
use crate::spec::Experiment;
use crate::spec::typed::InSection;

/// The tables; `None` for an abstract spec, which does not have a robot and an action yet.
pub fn show(checked: &Checked, as_json: bool) -> Option<String> {
    let experiment = checked.experiment.as_ref()?;
    let robot = checked.robot.as_ref().filter(|_| !experiment.is_abstract)?;
    let needed = [Observations::SECTION, Action::SECTION, Learner::SECTION, Task::SECTION];
    if needed.iter().any(|section| experiment.section(section).is_none()) {
        return None;
    }
    let observation = Observation::new(&experiment.table, robot);
    let rate = experiment.part::<Action>()?.rate();
    let law = words::law(&experiment.table)?;
    let outputs = outputs(experiment, robot)?;
    if as_json {
        return Some(super::pretty(&json!({
            "inputs": observation.inputs().iter().enumerate().map(|(index, input)| input_json(index, input,
                    rate)).collect::<Vec<_>>(),
            "outputs": outputs.iter().enumerate().map(|(index, output)| output_json(index, output,
                    rate)).collect::<Vec<_>>(),
            "law": law,
            "exploration": words::exploration(&experiment.table),
            "mirrored": observation.is_mirrored(),
        })));
    }
    let mut text =
        one_line(&format!("inputs at {rate} Hz; the policy sees clamp((value - offset) / scale, +-clip)"));
    text += &one_line(&format!(
        "{:>5}  {:<18} {:<20} {:<6} {:>10} {:>10} {:>6}",
        "index", "signal", "joint", "unit", "offset", "scale", "clip"
    ));
    for (index, input) in observation.inputs().iter().enumerate() {
        let joint = input.joint.as_deref().unwrap_or("-");
        let (offset, scale) = (number(input.offset), number(input.scale));
        text += &one_line(&format!(
            "{index:>5}  {:<18} {joint:<20} {:<6} {offset:>10} {scale:>10} {:>6}",
            input.name,
            input.unit,
            number(input.clip)
        ));
    }
    if observation.is_mirrored() {
        text += "In the second half of the cycle inputs and outputs are mirrored (left and right change \
            places).\n";
    }
    text += &format!(
        "\noutputs at {rate} Hz\n{:>5}  {:<18} {:<20} {:<6} {:>22}\n",
        "index", "command", "joint", "unit", "range"
    );
    for (index, output) in outputs.iter().enumerate() {
        let range = format!("{} .. {}", number(output.range[0]), number(output.range[1]));
        let joint = output.joint.as_deref().unwrap_or("-");
        text += &one_line(&format!(
            "{index:>5}  {:<18} {joint:<20} {:<6} {range:>22}",
            output.command, output.unit
        ));
    }
    text += &one_line(&format!("\nlaw: {law}"));
    if let Some(exploration) = words::exploration(&experiment.table) {
        text += &one_line(&format!("exploration: {exploration}"));
    }
    Some(text)
}

/// What an output commands.
struct Output {
    command: &'static str,
    joint: Option<String>,
    unit: &'static str,
    /// Limits of the command, in its unit.
    range: [f64; 2],
}

fn outputs(experiment: &Experiment, robot: &Robot) -> Option<Vec<Output>> {
    let action: Action = experiment.part()?;
    let (command, unit) =
        if action.servo().is_some() { ("joint_position", "rad") } else { ("joint_torque", "N*m") };
    let outputs = law::outputs(&action, robot).into_iter().map(|output| match output.joint {
        None => Output { command: "phase_advance", joint: None, unit: "", range: output.limits },
        joint => Output { command, joint, unit, range: output.limits },
    });
    Some(outputs.collect())
}

fn input_json(index: usize, input: &Input, rate: f64) -> Json {
    json!({
        "index": index, "signal": input.name, "joint": input.joint, "unit": input.unit, "rate": rate,
        "offset": input.offset, "scale": input.scale, "clip": input.clip,
    })
}

fn output_json(index: usize, output: &Output, rate: f64) -> Json {
    json!({
        "index": index, "command": output.command, "joint": output.joint, "unit": output.unit, "rate": rate,
        "range": output.range,
    })
}

/// A number to four decimals without trailing zeros.
fn number(value: f64) -> String {
    ((value * 1e4).round() / 1e4).to_string()
}
