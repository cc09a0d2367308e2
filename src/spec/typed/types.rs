//! The types used in declarations.

use std::collections::BTreeMap;
use std::marker::PhantomData;

use super::super::value::number;
use super::super::{Kinds, Presence, Quantity, Sampler, Share, Table, Ty, Value};
use super::{InSection, Part, Typed};
use crate::quantity::{Dimension, Measure};

/// Declares a type whose Rust type is the same whether or not the key is present.
macro_rules! typed {
    (for [$($generics:tt)*] $name:ty => $rust:ty, $ty:expr, $read:expr) => {
        impl<$($generics)*> Typed for $name {
            type Value = $rust;
            type Present = Self;
            const TY: Ty = $ty;
            fn read(value: &Value) -> Option<Self::Value> {
                let read: fn(&Value) -> Option<Self::Value> = $read;
                read(value)
            }
        }
    };
    ($name:ty => $rust:ty, $ty:expr, $read:expr) => {
        typed!(for [] $name => $rust, $ty, $read);
    };
}

/// A unit of measurement as a type.
pub trait Unit {
    /// Its dimension.
    const DIMENSION: Dimension;
}

/// What a ratio is a share of, as a type.
pub trait Reference {
    /// As text: `the joint's effort limit`.
    const OF: &'static str;
    /// What a quantity relative to the robot measures in its place; `None` if the key takes only shares.
    const MEASURE: Option<Measure> = None;
}

/// A number without a unit; in Rust with its original text.
pub struct Plain;
/// A number with a unit of this dimension; in Rust in SI units.
pub struct Quantified<U>(PhantomData<U>);
/// A share of a reference; in Rust 1.0 is 100 %.
pub struct Ratio<R>(PhantomData<R>);
/// A distribution over numbers of this dimension.
pub struct Sampled<U>(PhantomData<U>);
/// A table with user-defined keys.
pub struct Named<T>(PhantomData<T>);

typed!(bool => bool, Ty::Flag, |value| match value {
    Value::Flag(flag) => Some(*flag),
    _ => None,
});
typed!(u64 => u64, Ty::Count, |value| match value {
    Value::Count(count) => Some(*count),
    _ => None,
});
typed!(usize => usize, Ty::Count, |value| u64::read(value).and_then(|count| usize::try_from(count).ok()));
typed!(f64 => f64, Ty::Number, number);
typed!(Plain => Quantity, Ty::Number, |value| match value {
    Value::Quantity(quantity) => Some(quantity.clone()),
    _ => None,
});
typed!(String => String, Ty::Text, |value| match value {
    Value::Text(text) => Some(text.clone()),
    _ => None,
});
typed!(for [U: Unit] Quantified<U> => f64, Ty::Quantity(U::DIMENSION), number);
typed!(for [R: Reference] Ratio<R> => f64, Ty::Ratio(Share { of: R::OF, measure: R::MEASURE }), number);
typed!(for [U: Unit] Sampled<U> => Sampler, Ty::Sampler(U::DIMENSION), |value| match value {
    Value::Sampler(sampler) => Some(sampler.clone()),
    other => number(other).map(Sampler::Constant),
});
// A single value where a list is expected is a list of one, as in the decoder.
typed!(for [T: Typed] Vec<T> => Vec<T::Value>, Ty::List(T::TY_REF), |value| match value {
    Value::List(items) => items.iter().map(T::read).collect(),
    other => T::read(other).map(|item| vec![item]),
});
typed!(for [T: Typed] Named<T> => BTreeMap<String, T::Value>, Ty::Named(T::TY_REF), |value| match value {
    Value::Table(table) => table.iter().map(|(name, value)| Some((name.clone(), T::read(value)?))).collect(),
    _ => None,
});

/// Kinds that are also allowed in tables outside their own section.
pub trait HasKinds {
    /// The section, its noun and its kinds.
    const KINDS: Kinds;
}

impl<K: HasKinds> InSection for K {
    const SECTION: &'static str = K::KINDS.section;
}

/// A section with one of its kinds, which are also allowed in other tables.
pub trait SectionKinds: Part + HasKinds {}

/// A table of one of these kinds, as decoded.
pub struct RawKind<K>(PhantomData<K>);
/// Named tables of these kinds, as decoded.
pub struct RawTerms<K>(PhantomData<K>);

typed!(for [K: HasKinds] RawKind<K> => Table, Ty::Kind(K::KINDS), table);
typed!(for [K: HasKinds] RawTerms<K> => Table, Ty::Terms(K::KINDS), table);

fn table(value: &Value) -> Option<Table> {
    match value {
        Value::Table(table) => Some(table.clone()),
        _ => None,
    }
}

impl<T: Typed> Typed for Option<T> {
    type Value = Option<T::Value>;
    type Present = T;
    const TY: Ty = T::TY;
    const PRESENCE: Presence = Presence::Optional;
    fn read(value: &Value) -> Option<Self::Value> {
        T::read(value).map(Some)
    }
    fn absent() -> Option<Self::Value> {
        Some(None)
    }
}

/// Units of measurement as types.
pub mod units {
    use super::{Dimension, Unit};

    macro_rules! units {
        ($($(#[$doc:meta])* $name:ident = $dimension:ident;)*) => {$(
            $(#[$doc])*
            pub struct $name;
            impl Unit for $name {
                const DIMENSION: Dimension = Dimension::$dimension;
            }
        )*};
    }

    units! {
        /// A pure number.
        One = NONE;
        /// m
        Metre = LENGTH;
        /// kg
        Kilogram = MASS;
        /// s
        Second = TIME;
        /// Hz
        Hertz = RATE;
        /// rad
        Radian = ANGLE;
        /// m/s
        MetrePerSecond = VELOCITY;
        /// rad/s
        RadianPerSecond = ANGULAR_VELOCITY;
        /// N
        Newton = FORCE;
        /// N m
        NewtonMetre = TORQUE;
        /// N s
        NewtonSecond = IMPULSE;
        /// kg m^2
        KilogramSquareMetre = INERTIA;
        /// N m/rad
        NewtonMetrePerRadian = STIFFNESS;
        /// N m s/rad
        NewtonMetreSecondPerRadian = DAMPING;
        /// 1/rad
        PerRadian = PER_ANGLE;
        /// 1/rad^2
        PerSquareRadian = PER_ANGLE_SQUARED;
        /// s^2/m^2
        PerSquareVelocity = PER_VELOCITY_SQUARED;
        /// s^2/rad^2
        PerSquareAngularVelocity = PER_ANGULAR_VELOCITY_SQUARED;
        /// 1/N
        PerNewton = PER_FORCE;
        /// 1/(N m)
        PerNewtonMetre = PER_TORQUE;
    }
}
