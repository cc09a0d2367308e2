//! The randomization `push`.

use super::{Draft, Push, Randomization, RandomizationKind};
use crate::kinds::Entry;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Sampler, Section, Ty};
use crate::stream::Stream;

/// The registry entry.
pub static KIND: RandomizationKind = Entry {
    kind: Kind {
        name: "push",
        since: Edition::ONE,
        doc: include_str!("push.md"),
        params: &[
            Param::required("impulse", Ty::Sampler(Dimension::IMPULSE))
                .range(0.0, 1e5)
                .doc("Force times duration of a push."),
            Param::required("duration", Ty::Sampler(Dimension::TIME)).range(1e-3, 1e3).doc("Duration of a push."),
            Param::required("every", Ty::Quantity(Dimension::TIME))
                .range(0.01, 1e6)
                .doc("Interval that holds one push."),
        ],
        needs: &[],
    },
    build: |section| Box::new(Term::new(section)),
};

struct Term {
    impulse: Sampler,
    duration: Sampler,
    every: f64,
}

impl Term {
    fn new(section: Section) -> Self {
        Self { impulse: section.sampler("impulse"), duration: section.sampler("duration"), every: section.si("every") }
    }
}

impl Randomization for Term {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        let mut interval = 0.0;
        while interval < draft.episode {
            let start = interval + self.every * stream.uniform();
            let (sine, cosine) = libm::sincos(std::f64::consts::TAU * stream.uniform());
            let (impulse, duration) = (stream.draw(&self.impulse), stream.draw(&self.duration));
            let force = impulse / duration;
            draft.pushes.push(Push { start, end: start + duration, force: [force * cosine, force * sine, 0.0] });
            interval += self.every;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;

    #[test]
    fn every_interval_holds_one_push_of_the_impulse() {
        let mut draft = draft();
        let term = Term { impulse: Sampler::Constant(50.0), duration: Sampler::Constant(0.1), every: 4.0 };
        term.apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.pushes.len(), 4);
        for (index, push) in draft.pushes.iter().enumerate() {
            assert_eq!((push.start / 4.0).floor() as usize, index);
            assert!((push.force[0].hypot(push.force[1]) * (push.end - push.start) - 50.0).abs() < 1e-9);
        }
    }
}
