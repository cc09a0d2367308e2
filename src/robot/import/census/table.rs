//! Classifies the contents of a description: imported, harmless, or not imported and why. Independent of the
//! format.

use Class::{Harmless, Left};

/// How the import treats an element or an attribute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    /// It is in the robot file, or the code that reads it reports what it does with it.
    Imported,
    /// Irrelevant for a robot file: names, appearance, sensors, settings of a spec.
    Harmless,
    /// It affects how the robot moves but is not in the robot file.
    Left(Group),
}

/// Things that are not imported, grouped by effect: one line of remarks each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Group {
    Springs,
    GravityCompensation,
    DriveDynamics,
    Transmissions,
    Drives,
    Constraints,
    Tendons,
    FreeJoint,
    Limits,
    Masks,
    Solver,
    Medium,
    Switches,
    Deformables,
    Plugins,
    World,
    Simulators,
    Extensions,
    Second,
    Unknown,
}

impl Group {
    /// A description, and why a robot file does not need it.
    pub fn text(self) -> (&'static str, &'static str) {
        match self {
            Self::Springs => ("springs", "the joints of a robot file have none"),
            Self::GravityCompensation => {
                ("gravity compensation of bodies", "the motors carry the whole weight")
            }
            Self::DriveDynamics => ("dynamics of drives", "a drive of a robot file gives its torque at once"),
            Self::Transmissions => {
                ("drives of tendons, sites and bodies", "a drive of a robot file moves one joint")
            }
            Self::Drives => (
                "drives that are neither motors nor servos",
                "their effort limits and gains are to be filled in",
            ),
            Self::Constraints => ("constraints", "a robot is a tree of joints that move independently"),
            Self::Tendons => ("tendons", "a robot is a tree of joints that move independently"),
            Self::FreeJoint => ("damping, friction and armature of the free joint", "the base floats freely"),
            Self::Limits => (
                "safety controllers and limits of acceleration",
                "a joint has limits of position, speed and torque",
            ),
            Self::Masks => (
                "contact masks, pairs and exclusions",
                "links that are apart in the default pose must not meet",
            ),
            Self::Solver => ("parameters of contacts and limits", "the engines of a spec have their own"),
            Self::Medium => {
                ("gravity, magnetic field, wind and fluids", "a spec has the earth's gravity and no air")
            }
            Self::Switches => ("physics that is switched off", "the engines of a spec compute all of it"),
            Self::Deformables => ("deformable bodies", "the links of a robot are rigid"),
            Self::Plugins => ("plugins", "the engines of a spec have none"),
            Self::World => ("what stands beside the robot", "a spec has its own terrain"),
            Self::Simulators => (
                "settings of simulators and controllers",
                "a joint's figures are those of <limit> and <dynamics>",
            ),
            Self::Extensions => ("elements of other programs", "they are in another XML name space"),
            Self::Second => ("second elements where one counts", "the first one is taken"),
            Self::Unknown => ("unknown elements and attributes", "check their spelling"),
        }
    }
}

/// An element of a format.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    /// The names of its ancestors and its own: `body/joint`.
    pub path: &'static str,
    /// Its class, if its whole content has the same.
    pub whole: Option<Class>,
    /// Its attributes by class, comma-separated. `stiffness=0` is harmless if its value is 0.
    attributes: &'static [(Class, &'static str)],
}

/// An element whose attributes and children are classified individually.
pub(super) const fn row(path: &'static str, attributes: &'static [(Class, &'static str)]) -> Row {
    Row { path, whole: None, attributes }
}

/// An element with one class for its whole content.
pub(super) const fn whole(path: &'static str, class: Class) -> Row {
    Row { path, whole: Some(class), attributes: &[] }
}

impl Row {
    /// The element with this path.
    pub fn find(table: &'static [Self], path: &str) -> Option<&'static Self> {
        table.iter().find(|row| row.path == path)
    }

    /// The class of an attribute with this value; `None` if the element has no such attribute.
    pub fn class(&self, attribute: &str, value: &str) -> Option<Class> {
        self.entries().find(|(_, name, _)| *name == attribute).map(|(class, _, neutral)| {
            match (class, neutral) {
                (Left(_), Some(neutral)) if is(value, neutral) => Harmless,
                (class, _) => class,
            }
        })
    }

    /// The names of its attributes.
    #[cfg(test)]
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.entries().map(|(_, name, _)| name)
    }

    /// Class, name and harmless value of every attribute.
    fn entries(&self) -> impl Iterator<Item = (Class, &'static str, Option<&'static str>)> {
        self.attributes.iter().flat_map(|(class, names)| {
            names.split(", ").map(|entry| match entry.split_once('=') {
                Some((name, neutral)) => (*class, name, Some(neutral)),
                None => (*class, entry, None),
            })
        })
    }
}

/// Whether a value is the harmless one, compared as text or numbers; one number matches any count of it.
fn is(value: &str, neutral: &str) -> bool {
    let numbers = |text: &str| text.split_whitespace().map(str::parse).collect::<Result<Vec<f64>, _>>().ok();
    match (numbers(value), numbers(neutral)) {
        (Some(found), Some(neutral)) => match neutral.as_slice() {
            [one] => found.iter().all(|number| number == one),
            all => found == all,
        },
        _ => value.trim() == neutral,
    }
}

/// For tests: whether an element, or an attribute of it, is classified.
#[cfg(test)]
pub(super) fn knows(table: &'static [Row], path: &str, attribute: Option<&str>) -> bool {
    let above = std::iter::successors(Some(path), |path| path.rsplit_once('/').map(|(above, _)| above));
    let mut rows = above.filter_map(|path| Row::find(table, path).map(|row| (path, row)));
    rows.find_map(|(place, row)| match (row.whole, attribute) {
        (Some(_), _) => Some(true),
        (None, None) => (place == path).then_some(true),
        (None, Some(name)) => (place == path).then(|| row.class(name, "").is_some()),
    })
    .unwrap_or(false)
}

#[cfg(test)]
mod tests {
    use super::Class::Imported;
    use super::*;

    #[test]
    fn a_harmless_value_is_one_by_number_and_not_by_spelling() {
        let joint = row("joint", &[(Imported, "name"), (Left(Group::Springs), "stiffness=0, springref")]);
        assert_eq!(joint.class("stiffness", "0.0 0"), Some(Harmless));
        assert_eq!(joint.class("stiffness", "1e-3"), Some(Left(Group::Springs)));
        assert_eq!(joint.class("springref", "0"), Some(Left(Group::Springs)));
        assert_eq!(joint.class("stifness", "0"), None);
        let option = row("option", &[(Left(Group::Medium), "gravity=0 0 -9.81")]);
        assert_eq!(option.class("gravity", "0 0  -9.810"), Some(Harmless));
        assert_eq!(option.class("gravity", "0 0 -1.62"), Some(Left(Group::Medium)));
    }
}
