//! The dimension of a quantity: integer exponents over the base units.

/// Exponents over metre, kilogram, second, ampere and radian.
///
/// The radian is a base unit here, although it is dimensionless in SI: an angular velocity in rad/s and a
/// rate in Hz are different quantities that users often confuse.
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

/// Dimensions with a name: the user's term and the unit to write.
const NAMED: &[(Dimension, &str, &str)] = &[
    (Dimension::NONE, "a pure number", ""),
    (Dimension::LENGTH, "a length", "m"),
    (Dimension::MASS, "a mass", "kg"),
    (Dimension::TIME, "a duration", "s"),
    (Dimension::RATE, "a rate", "Hz"),
    (Dimension::ANGLE, "an angle", "rad"),
    (Dimension::VELOCITY, "a velocity", "m/s"),
    (Dimension::new(1, 0, -2, 0, 0), "an acceleration", "m/s^2"),
    (Dimension::ANGULAR_VELOCITY, "an angular velocity", "rad/s"),
    (Dimension::new(0, 0, -2, 0, 1), "an angular acceleration", "rad/s^2"),
    (Dimension::FORCE, "a force", "N"),
    (Dimension::TORQUE, "a torque", "N*m"),
    (Dimension::IMPULSE, "an impulse", "N*s"),
    (Dimension::INERTIA, "a moment of inertia", "kg*m^2"),
    (Dimension::STIFFNESS, "a joint stiffness", "N*m/rad"),
    (Dimension::DAMPING, "a joint damping", "N*m*s/rad"),
    (Dimension::new(0, 1, -2, 0, 0), "a linear stiffness", "N/m"),
    (Dimension::new(0, 1, -1, 0, 0), "a linear damping", "N*s/m"),
    (Dimension::new(-1, 1, -2, 0, 0), "a pressure", "Pa"),
    (Dimension::new(2, 1, -3, 0, 0), "a power", "W"),
    (Dimension::new(2, 1, -3, -1, 0), "a voltage", "V"),
    (Dimension::new(0, 0, 0, 1, 0), "a current", "A"),
    (Dimension::new(2, 0, 0, 0, 0), "an area", "m^2"),
    (Dimension::PER_ANGLE, "an inverse angle", "/rad"),
    (Dimension::PER_ANGLE_SQUARED, "an inverse squared angle", "/rad^2"),
    (Dimension::new(-1, 0, 0, 0, 0), "an inverse length", "/m"),
    (Dimension::new(-2, 0, 0, 0, 0), "an inverse squared length", "/m^2"),
    (Dimension::PER_VELOCITY_SQUARED, "an inverse squared velocity", "s^2/m^2"),
    (Dimension::PER_ANGULAR_VELOCITY_SQUARED, "an inverse squared angular velocity", "s^2/rad^2"),
    (Dimension::PER_FORCE, "an inverse force", "/N"),
    (Dimension::PER_TORQUE, "an inverse torque", "/N/m"),
];

impl Dimension {
    /// The user's term for it, with an article: `an angle`, `an angular velocity`. Dimensions without a name
    /// are described by their unit: `a quantity in kg*m`.
    pub fn name(self) -> String {
        match NAMED.iter().find(|(dimension, ..)| *dimension == self) {
            Some((_, name, _)) => (*name).to_owned(),
            None => format!("a quantity in {}", self.unit()),
        }
    }

    /// The SI unit of the dimension as the spec language writes it: `N*m`, `/rad^2`, empty for a number.
    pub fn unit(self) -> String {
        if let Some((.., unit)) = NAMED.iter().find(|(dimension, ..)| *dimension == self) {
            return (*unit).to_owned();
        }
        let mut above = String::new();
        let mut below = String::new();
        for (symbol, power) in [
            ("kg", self.mass),
            ("m", self.length),
            ("A", self.current),
            ("rad", self.angle),
            ("s", self.time),
        ] {
            let factor = match power.unsigned_abs() {
                0 => continue,
                1 => symbol.to_owned(),
                size => format!("{symbol}^{size}"),
            };
            if power > 0 {
                above = if above.is_empty() { factor } else { format!("{above}*{factor}") };
            } else {
                below = format!("{below}/{factor}");
            }
        }
        above + &below
    }

    /// The product with `other` to an integer power; `None` if an exponent overflows.
    pub fn times(self, other: Self, power: i8) -> Option<Self> {
        let sum = |a: i8, b: i8| a.checked_add(b.checked_mul(power)?);
        Some(Self {
            length: sum(self.length, other.length)?,
            mass: sum(self.mass, other.mass)?,
            time: sum(self.time, other.time)?,
            current: sum(self.current, other.current)?,
            angle: sum(self.angle, other.angle)?,
        })
    }
}
