//! `<default>`: the attributes that elements of a class have without writing them.

use std::collections::BTreeMap;

use super::super::intake::{Intake, value};
use super::super::xml::{Attribute, Element};

/// The elements that move joints; MuJoCo keeps one set of defaults for all of them.
const ACTUATORS: &[&str] =
    &["general", "motor", "position", "velocity", "intvelocity", "damper", "cylinder", "muscle", "adhesion", "dcmotor"];

/// Attributes that actuators of different kinds share.
const SHARED: &[&str] =
    &["gear", "ctrlrange", "ctrllimited", "forcerange", "forcelimited", "actrange", "actlimited", "inheritrange"];

/// Attributes by the element that they are meant for.
type Class = BTreeMap<String, Vec<Attribute>>;

/// The classes of a file, each with what it inherits.
#[derive(Clone, Debug, Default)]
pub(super) struct Defaults {
    classes: BTreeMap<String, Class>,
    /// The name of the outermost class.
    main: String,
}

impl Defaults {
    /// The classes of a file.
    pub fn read(root: &Element) -> Self {
        let mut defaults = Self { classes: BTreeMap::new(), main: "main".to_owned() };
        for element in root.all("default") {
            let name = element.text("class").unwrap_or("main").to_owned();
            let own = defaults.classes.get(&defaults.main).cloned().unwrap_or_default();
            defaults.main.clone_from(&name);
            defaults.add(element, &name, own);
        }
        let main = defaults.main.clone();
        defaults.classes.entry(main).or_default();
        defaults
    }

    fn add(&mut self, element: &Element, name: &str, mut class: Class) {
        for child in element.children.iter().filter(|child| child.name != "default") {
            overlay(class.entry(child.name.clone()).or_default(), &child.attributes);
            if ACTUATORS.contains(&child.name.as_str()) {
                let shared: Vec<Attribute> =
                    child.attributes.iter().filter(|one| SHARED.contains(&one.name.as_str())).cloned().collect();
                for other in ACTUATORS.iter().filter(|other| **other != child.name) {
                    overlay(class.entry((*other).to_owned()).or_default(), &shared);
                }
            }
        }
        self.classes.insert(name.to_owned(), class.clone());
        for child in element.all("default") {
            self.add(child, child.text("class").unwrap_or_default(), class.clone());
        }
    }

    /// An element with the attributes of its class: its own `class`, that of the body around it, or the outermost.
    pub fn complete(&self, element: &Element, around: Option<&str>, intake: &mut Intake) -> Element {
        let name = element.text("class").or(around).unwrap_or(&self.main);
        let Some(class) = self.classes.get(name) else {
            let place = if element.text("class").is_some() { element.place("class") } else { element.span };
            let error = value(format!("there is no default class `{name}`"), place);
            let known = self.classes.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
            intake.tell(error.help(format!("the classes are {known}")));
            return element.clone();
        };
        let mut complete = element.clone();
        if let Some(attributes) = class.get(&element.name) {
            let mut merged = attributes.clone();
            overlay(&mut merged, &element.attributes);
            complete.attributes = merged;
        }
        complete
    }
}

/// Puts attributes over others: a name that is there gets the new value.
fn overlay(below: &mut Vec<Attribute>, above: &[Attribute]) {
    let orientation = |name: &str| matches!(name, "axisangle" | "euler" | "xyaxes" | "zaxis");
    for attribute in above {
        // Of the forms of an orientation that are not quaternions, the last one counts.
        if orientation(&attribute.name) {
            below.retain(|known| !orientation(&known.name));
        }
        match below.iter_mut().find(|known| known.name == attribute.name) {
            Some(known) => known.clone_from(attribute),
            None => below.push(attribute.clone()),
        }
    }
}
