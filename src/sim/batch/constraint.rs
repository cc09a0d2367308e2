//! A contact as a constraint, with the solver's values for it.

use super::lane::{Lane, Mask};
use super::math::V3;

/// A contact in some lanes, with the solver's values for it.
#[derive(Clone, Copy)]
pub struct Contact<L: Lane> {
    pub body: usize,
    pub foot: Option<usize>,
    /// The lanes in which the contact exists.
    pub active: L::Mask,
    /// Its position relative to the base's origin.
    pub p: V3<L>,
    /// Normal out of the ground.
    pub n: V3<L>,
    pub friction: L,
    /// 1 / (1 + friction^2).
    pub share: L,
    /// 1/R, zero in other lanes.
    pub d: L,
    /// Reference acceleration.
    pub reference: V3<L>,
    /// Acceleration of the point minus the reference, and its change along the search direction.
    pub gap: V3<L>,
    pub change: V3<L>,
    /// Normal part of the gap, tangential part, square of its length.
    pub normal: L,
    pub tangent: V3<L>,
    pub square: L,
    /// Normal part of the change; tangential gap times change; square of the tangential change.
    pub normal_change: L,
    pub product: L,
    pub square_change: L,
    /// In the middle of the cone: unit vector along the tangential gap, stiffness along the cone's generator,
    /// and across it as a share of that.
    pub along: V3<L>,
    pub stiffness: L,
    pub across: L,
    /// Whether it sticks: the bottom of the cone.
    pub sticks: L::Mask,
    pub force: V3<L>,
}

impl<L: Lane> Contact<L> {
    fn none() -> Self {
        let (z, zero3, none) = (L::zero(), [L::zero(); 3], L::Mask::splat(false));
        Self {
            body: 0,
            foot: None,
            active: none,
            p: zero3,
            n: zero3,
            friction: z,
            share: z,
            d: z,
            reference: zero3,
            gap: zero3,
            change: zero3,
            normal: z,
            tangent: zero3,
            square: z,
            normal_change: z,
            product: z,
            square_change: z,
            along: zero3,
            stiffness: z,
            across: z,
            sticks: none,
            force: zero3,
        }
    }
}

/// The contacts of a step; storage of former steps is reused.
pub struct Contacts<L: Lane> {
    places: Vec<Contact<L>>,
    used: usize,
}

impl<L: Lane> Default for Contacts<L> {
    fn default() -> Self {
        Self { places: Vec::with_capacity(32), used: 0 }
    }
}

impl<L: Lane> Contacts<L> {
    #[inline(always)]
    pub fn all_mut(&mut self) -> &mut [Contact<L>] {
        &mut self.places[..self.used]
    }
    /// Discards the contacts of the last step.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.used = 0;
    }
    /// Storage for one more contact.
    #[inline(always)]
    pub(super) fn next(&mut self) -> &mut Contact<L> {
        if self.used == self.places.len() {
            self.places.push(Contact::none());
        }
        self.used += 1;
        &mut self.places[self.used - 1]
    }
}
