//! Is the task done? Explicit criteria with thresholds, so that standing still never counts as walking.

use serde::{Deserialize, Serialize};

use super::estimate::Estimate;
use super::measurable::is_blind;
use super::metric::{Metric, average};
use super::model::Arm;
use super::wording::number;
use crate::kinds::task::{self, Bound, Judged, Shortest};
use crate::outcome::Evaluation;
use crate::statistics::summary::mean;

/// Share of the episodes that must reach the time limit.
const SURVIVAL: f64 = 0.9;
/// Share of the commanded speed that must be reached.
const SPEED_SHARE: f64 = 0.5;
/// Largest share of time in self-collision: enough for a touch, not for a way of moving.
pub const INSIDE: f64 = 0.01;

/// One condition of a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Criterion {
    /// The requirement, with its threshold.
    pub text: String,
    /// The measured value.
    pub measured: Estimate,
    /// Whether the mean meets the threshold; a criterion that cannot be measured counts as met.
    pub holds: bool,
    /// Why it cannot be measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unmeasured: Option<String>,
}

impl Criterion {
    /// `yes`, `no`, or why it cannot be measured.
    pub fn met(&self) -> String {
        match (&self.unmeasured, self.holds) {
            (Some(reason), _) => format!("not measurable: {reason}"),
            (None, true) => "yes".to_owned(),
            (None, false) => "no".to_owned(),
        }
    }
}

/// Whether one policy does its task in one engine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// `runs`, `walks`, `squats`, `stands`.
    pub verb: String,
    /// Whether all criteria hold; `false` if the task is not judged.
    pub holds: bool,
    /// The criteria.
    pub criteria: Vec<Criterion>,
    /// Why the task is not judged, if it is not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unjudged: Option<String>,
}

/// Why the episodes of an evaluation do not show whether an arm does its task; `None` if they do, and in
/// records without a time limit.
pub fn too_short(arm: &Arm, evaluation: &Evaluation) -> Option<String> {
    let limit = evaluation.time_limit;
    let height = arm.robot.as_ref().map_or(1.0, |robot| robot.standing_height);
    let shortest = Shortest::of(arm.motion.as_ref().map(|motion| motion.period), height);
    let judged = Judged::of(limit, evaluation.push);
    (limit > 0.0 && !shortest.is_reached_by(judged)).then(|| {
        let end = judged.end_in_words(|seconds| format!("{} s", number(seconds)));
        format!("its episodes end {end}, and to judge them takes {}", shortest.in_words())
    })
}

/// Why the survivors of an evaluation's episodes cannot be judged; `None` if they can, or if all fell.
pub fn too_short_for_survivors(arm: &Arm, evaluation: &Evaluation) -> Option<String> {
    let is_survived = evaluation.episodes.iter().any(|episode| episode.survived);
    too_short(arm, evaluation).filter(|_| is_survived)
}

/// The commanded speed of an evaluation in m/s: its command, the mean of its episodes' commands, or the
/// reference motion's own speed.
pub fn asked_speed(arm: &Arm, evaluation: &Evaluation) -> Option<f64> {
    let own: Option<Vec<f64>> = evaluation.episodes.iter().map(|episode| episode.command).collect();
    let own = own.and_then(|own| mean(&own));
    evaluation.command.or(own).or_else(|| arm.motion.as_ref().map(|motion| motion.speed))
}

/// Judges an evaluation of an arm by the criteria of the arm's task.
pub fn judge(arm: &Arm, evaluation: &Evaluation) -> Verdict {
    let task = arm.task();
    let mut criteria =
        vec![at_least(evaluation, "survival", SURVIVAL, "survives at least 90 % of the episodes")];
    let own = task.map_or(&[][..], |task| task.criteria);
    criteria.extend(own.iter().filter_map(|criterion| of_task(criterion, arm, evaluation)));
    if let Some(speed) = asked_speed(arm, evaluation).filter(|speed| arm.travels() && speed.abs() > 0.05) {
        criteria.push(moves(evaluation, speed));
    }
    let inside = estimate(evaluation, "self_collision");
    let text = "is in self-collision at most 1 % of the time".to_owned();
    match inside.value {
        Some(share) if share > INSIDE || !is_blind(arm) => {
            criteria.push(Criterion { text, measured: inside, holds: share <= INSIDE, unmeasured: None });
        }
        _ if is_blind(arm) => {
            let unmeasured = Some("the robot has no collision shapes".to_owned());
            criteria.push(Criterion { text, measured: Estimate::default(), holds: true, unmeasured });
        }
        _ => {}
    }
    let verb = task.map_or("stands", |task| task.verb).to_string();
    // Who falls in a short episode fails. Who does not may still be falling.
    let survives = criteria.first().is_some_and(|survival| survival.holds);
    let unjudged = too_short(arm, evaluation).filter(|_| survives);
    if let Some(reason) = &unjudged {
        for criterion in &mut criteria {
            (criterion.holds, criterion.unmeasured) = (true, Some(reason.clone()));
        }
        return Verdict { verb, holds: false, criteria, unjudged };
    }
    Verdict { verb, holds: criteria.iter().all(|criterion| criterion.holds), criteria, unjudged }
}

/// Whether an evaluation meets all criteria of the arm's task except survival; `None` if its episodes are too
/// short to judge those that survive.
pub fn does_but_for_survival(arm: &Arm, evaluation: &Evaluation) -> Option<bool> {
    if too_short_for_survivors(arm, evaluation).is_some() {
        return None;
    }
    Some(judge(arm, evaluation).criteria.iter().skip(1).all(|criterion| criterion.holds))
}

/// Whether an evaluation meets a criterion of the task; `None` for an unmeasured optional criterion. Any
/// other unmeasured criterion is not met.
fn of_task(criterion: &task::Criterion, arm: &Arm, evaluation: &Evaluation) -> Option<Criterion> {
    let measured = estimate(evaluation, criterion.metric);
    if criterion.optional && measured.value.is_none() {
        return None;
    }
    let height = arm.robot.as_ref().map_or(1.0, |robot| robot.standing_height);
    let (text, holds) = match criterion.bound {
        Bound::AtLeast(least) => return Some(at_least(evaluation, criterion.metric, least, criterion.text)),
        Bound::AtMost(most) => (
            criterion.text.replace("{}", &most.to_string()),
            measured.value.is_some_and(|value| value <= most),
        ),
        Bound::AtMostOfHeight(share) => {
            let most = share * height;
            (
                criterion.text.replace("{}", &format!("{most:.2}")),
                measured.value.is_some_and(|value| value <= most),
            )
        }
    };
    Some(Criterion { text, measured, holds, unmeasured: None })
}

/// Whether it moves at least at half the speed in m/s that is asked for, in its direction.
fn moves(evaluation: &Evaluation, speed: f64) -> Criterion {
    let (least, way) = (SPEED_SHARE * speed.abs(), if speed < 0.0 { " backwards" } else { "" });
    let measured = estimate(evaluation, "speed");
    let holds = measured.value.is_some_and(|value| value * speed.signum() >= least - 1e-12);
    let text = format!("moves{way} at least at half the asked speed of {:.2} m/s", speed.abs());
    Criterion { text, measured, holds, unmeasured: None }
}

fn at_least(evaluation: &Evaluation, metric: &str, threshold: f64, text: &str) -> Criterion {
    let measured = estimate(evaluation, metric);
    let holds = measured.value.is_some_and(|value| value >= threshold - 1e-12);
    Criterion { text: text.to_string(), measured, holds, unmeasured: None }
}

fn estimate(evaluation: &Evaluation, metric: &str) -> Estimate {
    Metric::named(metric).map_or_else(Estimate::default, |metric| metric.estimate(evaluation))
}

impl Verdict {
    /// `runs`, `does not run` or `is not judged`.
    pub fn phrase(&self) -> String {
        if self.unjudged.is_some() {
            return "is not judged".to_owned();
        }
        let stem = self.verb.strip_suffix('s').unwrap_or(&self.verb);
        if self.holds { self.verb.clone() } else { format!("does not {stem}") }
    }
}

/// Whether a robot survives an evaluation by standing still, without significant steps.
pub fn stands_still(evaluation: &Evaluation) -> bool {
    let mean = |name| average(evaluation, name).unwrap_or(0.0);
    mean("survival") >= SURVIVAL && mean("cadence") < 0.2 && mean("speed") < 0.05
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::outcome::Episode;
    use crate::spec::Value;

    fn arm(task: &str) -> Arm {
        let kind = BTreeMap::from([("kind".to_string(), Value::Text(task.to_string()))]);
        Arm { fields: BTreeMap::from([("task".to_string(), Value::Table(kind))]), ..Arm::default() }
    }

    fn evaluation(episode: Episode) -> Evaluation {
        Evaluation { command: Some(0.2), episodes: vec![episode; 10], ..Evaluation::default() }
    }

    #[test]
    fn who_walks_with_crossed_legs_does_not_walk() {
        let walking = |self_collision| {
            let episode = Episode {
                survived: true,
                left_support: 0.3,
                right_support: 0.3,
                speed: 0.2,
                self_collision,
                ..Episode::default()
            };
            judge(&arm("walk"), &evaluation(episode)).holds
        };
        assert!(walking(None) && walking(Some(0.0)) && walking(Some(0.01)) && !walking(Some(0.02)));
    }

    #[test]
    fn who_is_asked_to_walk_backwards_has_to() {
        let walking = |asked, speed| {
            let (left_support, right_support) = (0.3, 0.3);
            let episode =
                Episode { survived: true, left_support, right_support, speed, ..Episode::default() };
            let evaluation = Evaluation { command: Some(asked), ..evaluation(episode) };
            judge(&arm("walk"), &evaluation).holds
        };
        assert!(walking(-0.3, -0.2) && !walking(-0.3, -0.1) && !walking(-0.3, 0.2));
        assert!(walking(0.3, 0.2) && !walking(0.3, -0.2));
    }

    #[test]
    fn a_robot_without_collision_shapes_is_not_said_to_keep_its_links_apart() {
        let mut robot = crate::robot::tests::robot("g1");
        robot.base.collisions.clear();
        robot.links.iter_mut().for_each(|link| link.body.collisions.clear());
        let blind = Arm { robot: Some(robot), ..arm("squat") };
        let sighted = Arm { robot: Some(crate::robot::tests::robot("g1")), ..arm("squat") };
        let met = |arm: &Arm, self_collision| {
            let verdict =
                judge(arm, &evaluation(Episode { survived: true, self_collision, ..Episode::default() }));
            let criterion =
                verdict.criteria.iter().find(|criterion| criterion.text.contains("self-collision"));
            (criterion.map(Criterion::met), verdict.holds)
        };
        assert_eq!(met(&sighted, Some(0.0)), (Some("yes".to_owned()), true));
        let unmeasurable = Some("not measurable: the robot has no collision shapes".to_owned());
        assert_eq!(met(&blind, Some(0.0)), (unmeasurable.clone(), true));
        assert_eq!(met(&blind, None), (unmeasurable, true));
        // The soles are known, so feet that pass through each other are detected.
        assert_eq!(met(&blind, Some(0.02)), (Some("no".to_owned()), false));
    }

    #[test]
    fn a_robot_that_stands_still_survives_and_does_not_walk() {
        let standing = evaluation(Episode { survived: true, duration: 16.0, ..Episode::default() });
        let verdict = judge(&arm("walk"), &standing);
        assert!(!verdict.holds && verdict.criteria[0].holds);
        assert_eq!(verdict.phrase(), "does not walk");
        assert!(stands_still(&standing));
    }

    #[test]
    fn running_needs_a_flight_phase_in_every_step() {
        let gait = |flight_per_step| {
            evaluation(Episode {
                survived: true,
                speed: 0.2,
                flight_per_step,
                steady_flight_per_step: flight_per_step.ceil(),
                duration: 16.0,
                ..Episode::default()
            })
        };
        assert!(judge(&arm("run"), &gait(1.0)).holds);
        assert!(!judge(&arm("run"), &gait(0.5)).holds);
        assert_eq!(judge(&arm("run"), &gait(1.0)).phrase(), "runs");
    }

    #[test]
    fn a_robot_that_slides_does_not_stand() {
        let standing = |drift| {
            judge(&arm("stand"), &evaluation(Episode { survived: true, drift, ..Episode::default() }))
        };
        assert!(standing(Some(0.03)).holds && standing(Some(0.1)).holds);
        let slides = standing(Some(0.3));
        assert_eq!(
            (slides.phrase().as_str(), slides.criteria[1].text.as_str()),
            ("does not stand", "stays within 0.10 m of where it starts")
        );
        // An unmeasured criterion is not met.
        assert!(!standing(None).holds);
        // The limit scales with the robot's size.
        let small =
            crate::robot::Robot { standing_height: 0.2, ..crate::robot::shipped("g1").expect("it ships") };
        let small = Arm { robot: Some(small), ..arm("stand") };
        let judged = |drift| {
            judge(&small, &evaluation(Episode { survived: true, drift: Some(drift), ..Episode::default() }))
        };
        assert!(judged(0.02).holds && !judged(0.05).holds);
        // A squat must also stay in place, if its drift was measured.
        let squats = |drift| {
            judge(&arm("squat"), &evaluation(Episode { survived: true, drift, ..Episode::default() })).holds
        };
        assert!(squats(Some(0.03)) && squats(None) && !squats(Some(0.3)));
    }

    #[test]
    fn an_episode_shorter_than_a_cycle_judges_nothing_unless_the_robot_falls() {
        let robot = crate::robot::tests::robot("tocabi");
        let motion = crate::kinds::motion::shipped("walk", &robot).and_then(Result::ok);
        let walk = Arm { robot: Some(robot.clone()), motion, ..arm("walk") };
        let pushed = |survived: bool, time_limit: f64, push: Option<f64>| {
            let episode =
                Episode { survived, left_support: 0.3, right_support: 0.3, speed: 0.2, ..Episode::default() };
            let evaluation = Evaluation {
                command: Some(0.2),
                time_limit,
                push,
                episodes: vec![episode; 4],
                ..Evaluation::default()
            };
            let Verdict { holds, unjudged, criteria, .. } = judge(&walk, &evaluation);
            assert!(unjudged.is_none() || criteria.iter().all(|criterion| criterion.unmeasured.is_some()));
            let verdict = judge(&walk, &evaluation).phrase();
            (holds, verdict, does_but_for_survival(&walk, &evaluation))
        };
        let walking = |survived: bool, time_limit: f64| pushed(survived, time_limit, None);
        // What remains after the push is judged.
        assert_eq!(pushed(true, 5.8, Some(4.0)), (true, "walks".to_owned(), Some(true)));
        assert_eq!(pushed(true, 5.0, Some(4.0)), (false, "is not judged".to_owned(), None));
        assert_eq!(pushed(false, 5.0, Some(4.0)), (false, "does not walk".to_owned(), Some(true)));
        assert_eq!(walking(true, 16.0), (true, "walks".to_owned(), Some(true)));
        assert_eq!(walking(true, 1.8), (true, "walks".to_owned(), Some(true)));
        assert_eq!(walking(true, 0.2), (false, "is not judged".to_owned(), None));
        assert_eq!(walking(true, 1.796), (false, "is not judged".to_owned(), None));
        assert_eq!(walking(false, 0.2), (false, "does not walk".to_owned(), Some(true)));
        // Records of earlier versions without a time limit are judged as ever.
        assert!(walking(true, 0.0).0);
        let stand = Arm { robot: Some(robot), ..arm("stand") };
        let standing = Episode { survived: true, drift: Some(0.0), ..Episode::default() };
        let standing = Evaluation { time_limit: 0.2, episodes: vec![standing; 4], ..Evaluation::default() };
        let reason = judge(&stand, &standing).unjudged.expect("it is too short");
        assert!(reason.contains("its episodes end after 0.2 s") && reason.contains("falls"), "{reason}");
    }

    #[test]
    fn no_episodes_meet_no_criterion() {
        assert!(!judge(&arm("stand"), &Evaluation::default()).holds);
    }
}
