//! The dimension of a quantity: integer exponents over the base units.

/// Exponents over metre, kilogram, second, ampere and radian.
///
/// The radian is a base unit here, although it is dimensionless in SI: an angular velocity in rad/s
/// and a rate in Hz are different things, and mixing them up is the mistake users make.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Dimension {
    /// Exponent of the metre.
    pub length: i8,
    /// Exponent of the kilogram.
    pub mass: i8,
    /// Exponent of the second.
    pub time: i8,
    /// Exponent of the ampere.
    pub current: i8,
    /// Exponent of the radian.
    pub angle: i8,
}

impl Dimension {
    /// A dimension from its exponents: length, mass, time, current, angle.
    pub const fn new(length: i8, mass: i8, time: i8, current: i8, angle: i8) -> Self {
        Self { length, mass, time, current, angle }
    }

    /// A pure number.
    pub const NONE: Self = Self::new(0, 0, 0, 0, 0);
    /// m
    pub const LENGTH: Self = Self::new(1, 0, 0, 0, 0);
    /// kg
    pub const MASS: Self = Self::new(0, 1, 0, 0, 0);
    /// s
    pub const TIME: Self = Self::new(0, 0, 1, 0, 0);
    /// Hz
    pub const RATE: Self = Self::new(0, 0, -1, 0, 0);
    /// rad
    pub const ANGLE: Self = Self::new(0, 0, 0, 0, 1);
    /// m/s
    pub const VELOCITY: Self = Self::new(1, 0, -1, 0, 0);
    /// rad/s
    pub const ANGULAR_VELOCITY: Self = Self::new(0, 0, -1, 0, 1);
    /// N
    pub const FORCE: Self = Self::new(1, 1, -2, 0, 0);
    /// N m
    pub const TORQUE: Self = Self::new(2, 1, -2, 0, 0);
    /// N s
    pub const IMPULSE: Self = Self::new(1, 1, -1, 0, 0);
    /// kg m^2
    pub const INERTIA: Self = Self::new(2, 1, 0, 0, 0);
    /// N m/rad
    pub const STIFFNESS: Self = Self::new(2, 1, -2, 0, -1);
    /// N m s/rad
    pub const DAMPING: Self = Self::new(2, 1, -1, 0, -1);
    /// /rad
    pub const PER_ANGLE: Self = Self::new(0, 0, 0, 0, -1);
    /// /rad^2
    pub const PER_ANGLE_SQUARED: Self = Self::new(0, 0, 0, 0, -2);
    /// s^2/m^2
    pub const PER_VELOCITY_SQUARED: Self = Self::new(-2, 0, 2, 0, 0);
    /// s^2/rad^2
    pub const PER_ANGULAR_VELOCITY_SQUARED: Self = Self::new(0, 0, 2, 0, -2);
    /// /N
    pub const PER_FORCE: Self = Self::new(-1, -1, 2, 0, 0);
    /// /N/m
    pub const PER_TORQUE: Self = Self::new(-2, -1, 2, 0, 0);
}
