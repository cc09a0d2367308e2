//! `<default>`: attributes that elements inherit from their class.

use std::collections::BTreeMap;

use super::super::intake::{Intake, value};
use super::super::xml::{self, Attribute, Element};

/// Actuator elements; MuJoCo has one set of defaults for all of them.
const ACTUATORS: &[&str] = &[
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "pid",
    "orientation",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
    "plugin",
];

/// Attributes common to several kinds of actuators.
const SHARED: &[&str] = &[
    "gear",
    "ctrlrange",
    "ctrllimited",
    "forcerange",
    "forcelimited",
    "actrange",
    "actlimited",
    "inheritrange",
    "armature",
    "damping",
    "delay",
];

/// Mutually exclusive attributes: the last one given counts.
const EITHER: [&[&str]; 2] = [&["axisangle", "euler", "xyaxes", "zaxis"], &["kv", "dampratio"]];

/// Other elements whose defaults are read.
const OTHERS: &[&str] = &["joint", "geom", "mesh"];

/// Maximum number of classes, and maximum length of a value in one: classes are copied into every element.
const MOST_CLASSES: usize = 200;
const LONGEST_VALUE: usize = 400;

/// Attributes that are ignored, and may be long.
const IGNORED: &[&str] = &["user", "name", "class"];

/// Attributes by the element that they apply to.
type Class = BTreeMap<String, Vec<Attribute>>;

/// The classes of a file, each including what it inherits.
#[derive(Clone, Debug, Default)]
pub(super) struct Defaults {
    classes: BTreeMap<String, Class>,
    /// The name of the outermost class.
    main: String,
}

impl Defaults {
    /// The classes of a file.
    pub fn read(root: &Element, intake: &mut Intake) -> Self {
        let mut defaults = Self { classes: BTreeMap::new(), main: "main".to_owned() };
        for element in root.all("default") {
            let name = element.text("class").unwrap_or("main").to_owned();
            let own = defaults.classes.get(&defaults.main).cloned().unwrap_or_default();
            defaults.main.clone_from(&name);
            defaults.add(element, &name, own, intake);
        }
        let main = defaults.main.clone();
        defaults.classes.entry(main).or_default();
        defaults
    }

    fn add(&mut self, element: &Element, name: &str, mut class: Class, intake: &mut Intake) {
        if self.classes.len() >= MOST_CLASSES {
            let message = format!("there are more than {MOST_CLASSES} default classes");
            intake.tell(xml::too_large(message).at(element.span, ""));
            return;
        }
        for child in &element.children {
            let is_actuator = ACTUATORS.contains(&child.name.as_str());
            if !is_actuator && !OTHERS.contains(&child.name.as_str()) {
                continue;
            }
            let own = read(child, intake);
            overlay(class.entry(child.name.clone()).or_default(), &own);
            if is_actuator {
                let shared: Vec<Attribute> =
                    own.iter().filter(|one| SHARED.contains(&one.name.as_str())).cloned().collect();
                for other in ACTUATORS.iter().filter(|other| **other != child.name) {
                    overlay(class.entry((*other).to_owned()).or_default(), &shared);
                }
            }
        }
        self.classes.insert(name.to_owned(), class.clone());
        for child in element.all("default") {
            self.add(child, child.text("class").unwrap_or_default(), class.clone(), intake);
        }
    }

    /// An element with the attributes of its class: its own `class`, that of the enclosing body, or the
    /// outermost. An unknown class is reported.
    pub fn complete(&self, element: &Element, around: Option<&str>, intake: &mut Intake) -> Element {
        let found = self.completed(element, around);
        found.unwrap_or_else(|name| {
            if !intake.has_told_enough("E0411") {
                let place =
                    if element.text("class").is_some() { element.place("class") } else { element.span };
                let error = value(format!("there is no default class `{name}`"), place);
                let known = self.classes.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
                intake.tell(error.help(format!("the classes are {known}")));
            }
            element.clone()
        })
    }

    /// The same, or the name of the unknown class.
    pub fn completed<'a>(
        &'a self,
        element: &'a Element,
        around: Option<&'a str>,
    ) -> Result<Element, &'a str> {
        let name = element.text("class").or(around).unwrap_or(&self.main);
        let class = self.classes.get(name).ok_or(name)?;
        let mut complete = element.clone();
        if let Some(attributes) = class.get(&element.name) {
            let mut merged = attributes.clone();
            overlay(&mut merged, &element.attributes);
            complete.attributes = merged;
        }
        Ok(complete)
    }
}

/// The attributes of a default; overlong ones are reported.
fn read(element: &Element, intake: &mut Intake) -> Vec<Attribute> {
    let named = element.attributes.iter().filter(|attribute| !IGNORED.contains(&attribute.name.as_str()));
    let mut attributes = Vec::new();
    for attribute in named {
        if attribute.value.len() > LONGEST_VALUE {
            let message =
                format!("`{}` of a default class has more than {LONGEST_VALUE} letters", attribute.name);
            intake.tell(xml::too_large(message).at(attribute.span, ""));
        } else {
            attributes.push(attribute.clone());
        }
    }
    attributes
}

/// Overrides attributes with others of the same name.
fn overlay(below: &mut Vec<Attribute>, above: &[Attribute]) {
    for attribute in above {
        for group in EITHER.iter().filter(|group| group.contains(&attribute.name.as_str())) {
            below.retain(|known| !group.contains(&known.name.as_str()));
        }
        match below.iter_mut().find(|known| known.name == attribute.name) {
            Some(known) => known.clone_from(attribute),
            None => below.push(attribute.clone()),
        }
    }
}
