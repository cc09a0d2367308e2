//! The randomization `push`.

use super::{Draft, Push, Randomization};
use crate::spec::typed::prelude::*;
use crate::stream::Stream;

kind! {
    pub struct Pushes = "push" {
        /// Force times duration of a push.
        #[range(0.0, 1e5)]
        impulse: Sampled<NewtonSecond>,
        /// Duration of a push.
        #[range(1e-3, 1e3)]
        duration: Sampled<Second>,
        /// Interval with one push; by default the whole episode.
        #[range(0.01, 1e6)]
        every: Option<Quantified<Second>>,
        /// Time of a push from the beginning of its interval; by default random.
        #[range(0.0, 1e6)]
        at: Option<Sampled<Second>>,
        /// Direction of a push, as an angle about the vertical from the world's x axis, the robot's initial
        /// heading: "90 deg" is to its left; by default random.
        #[range(-6.3, 6.3)]
        direction: Option<Sampled<Radian>>,
    }
}

impl Randomization for Pushes {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        let every = self.every.unwrap_or(draft.episode);
        let mut interval = 0.0;
        while interval < draft.episode {
            let start = match &self.at {
                Some(at) => stream.draw(at),
                None => every * stream.uniform(),
            };
            let direction = match &self.direction {
                Some(direction) => stream.draw(direction),
                None => std::f64::consts::TAU * stream.uniform(),
            };
            let (sine, cosine) = libm::sincos(direction);
            let (impulse, duration) = (stream.draw(&self.impulse), stream.draw(&self.duration));
            let force = impulse / duration;
            let start = interval + start;
            draft.pushes.push(Push {
                start,
                end: start + duration,
                force: [force * cosine, force * sine, 0.0],
            });
            interval += every;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;
    use crate::spec::Sampler;

    fn term() -> Pushes {
        let (impulse, duration) = (Sampler::Constant(50.0), Sampler::Constant(0.1));
        Pushes { impulse, duration, every: None, at: None, direction: None }
    }

    fn pushes(term: &Pushes) -> Vec<Push> {
        let mut draft = draft();
        term.apply(&mut draft, &mut Stream::new("test"));
        draft.pushes
    }

    #[test]
    fn every_interval_holds_one_push_of_the_impulse() {
        let pushes = pushes(&Pushes { every: Some(4.0), ..term() });
        assert_eq!(pushes.len(), 4);
        for (index, push) in pushes.iter().enumerate() {
            assert_eq!((push.start / 4.0).floor() as usize, index);
            assert!((push.force[0].hypot(push.force[1]) * (push.end - push.start) - 50.0).abs() < 1e-9);
        }
    }

    #[test]
    fn a_push_at_a_time_in_a_direction_is_there_and_goes_there() {
        let left = Some(Sampler::Constant(std::f64::consts::FRAC_PI_2));
        let once = pushes(&Pushes { at: Some(Sampler::Constant(4.0)), direction: left.clone(), ..term() });
        assert_eq!(once.len(), 1);
        assert_eq!((once[0].start, once[0].end), (4.0, 4.1));
        assert!(
            once[0].force[0].abs() < 1e-9 && (once[0].force[1] - 500.0).abs() < 1e-6,
            "{:?}",
            once[0].force
        );
        let again =
            pushes(&Pushes { at: Some(Sampler::Constant(1.0)), every: Some(5.0), direction: left, ..term() });
        assert_eq!(again.iter().map(|push| push.start).collect::<Vec<_>>(), [1.0, 6.0, 11.0, 16.0]);
    }

    #[test]
    fn without_an_interval_one_push_comes_at_any_time_of_the_episode() {
        let once = pushes(&term());
        assert_eq!(once.len(), 1);
        assert!((0.0..16.0).contains(&once[0].start) && once[0].start != 0.0);
    }
}
