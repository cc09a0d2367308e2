//! What the import of an MJCF file drops.

use std::collections::BTreeSet;

use super::super::census::mjcf::{FREE, TABLE, path};
use super::super::census::{Census, Group};
use super::super::naming::some;
use super::super::xml::Element;
use super::defaults::Defaults;
use super::geoms::{Geoms, masked};

/// The lines for a file whose robot is this body of the world.
pub(super) fn lines(root: &Element, base: &Element, defaults: &Defaults, geoms: &Geoms) -> Vec<String> {
    let mut count = Count { census: Census::new(TABLE), base, defaults, geoms, paired: Vec::new() };
    count.census.take("mujoco", root, "", &[]);
    for section in &root.children {
        match section.name.as_str() {
            "worldbody" => count.world(section, Around::default()),
            "default" => count.class(section, "default"),
            name => count.element(section, &path("mujoco", name), Around::default()),
        }
    }
    let mut lines = count.census.lines();
    if !count.paired.is_empty() {
        let names: Vec<&str> = count.paired.iter().map(String::as_str).collect();
        lines.push(format!(
            "the geoms {} touch in contact pairs alone: they are taken over as shapes that touch everything",
            some(&names)
        ));
    }
    lines
}

/// Names of geoms that collide through a contact pair, regardless of their masks.
pub(super) fn paired(root: &Element) -> BTreeSet<String> {
    let pairs = root.all("contact").flat_map(|contact| contact.all("pair"));
    pairs
        .flat_map(|pair| ["geom1", "geom2"].map(|end| pair.text(end).unwrap_or_default().to_owned()))
        .collect()
}

/// The context of an element: the class of its body, and the nearest name.
#[derive(Clone, Copy, Debug, Default)]
struct Around<'a> {
    class: Option<&'a str>,
    owner: &'a str,
}

struct Count<'a> {
    census: Census,
    base: &'a Element,
    defaults: &'a Defaults,
    geoms: &'a Geoms<'a>,
    /// Geoms that collide only in contact pairs.
    paired: Vec<String>,
}

impl Count<'_> {
    /// The world's contents; of its bodies only the robot's base is searched.
    fn world(&mut self, world: &Element, around: Around) {
        for element in &world.children {
            let name = element.text("name").unwrap_or_default();
            match element.name.as_str() {
                "body" if std::ptr::eq(element, self.base) => self.element(element, "body", around),
                "frame" => {
                    let class = element.text("childclass").or(around.class);
                    self.world(element, Around { class, ..around });
                }
                // The floor that most robot files include is a plane.
                "geom" if element.text("type") == Some("plane") => {}
                "body" | "geom" => self.census.count(Group::World, format!("<{}>", element.name), name),
                other => self.element(element, &path("body", other), around),
            }
        }
    }

    /// A default class: its attributes count where they are used, except those unknown to MuJoCo.
    fn class(&mut self, class: &Element, above: &str) {
        self.census.unknown(above, class, "");
        let name = class.text("class").unwrap_or("main");
        for element in &class.children {
            if element.name == "default" {
                self.class(element, above);
            } else if self.census.knows(&path(above, &element.name)) {
                self.census.unknown(&path(above, &element.name), element, name);
            } else {
                self.census.count(Group::Unknown, format!("<{}>", element.name), name);
            }
        }
    }

    /// An element with the attributes of its class, and its contents.
    fn element(&mut self, element: &Element, place: &str, around: Around) {
        let owner = element.text("name").unwrap_or(around.owner);
        let complete = self.defaults.completed(element, around.class).unwrap_or_else(|_| element.clone());
        let is_free = place == "body/joint" && complete.text("type") == Some("free");
        let is_idle = place == "body/geom" && !self.geoms.collides(&complete);
        if place == "body/geom" && !is_idle && !masked(&complete) {
            self.paired.push(owner.to_owned());
        }
        // An attribute of a class for several kinds of elements is not unknown in one without it.
        let ignored =
            if is_idle { &[Group::Unknown, Group::Masks, Group::Solver][..] } else { &[Group::Unknown] };
        if is_free {
            self.census.attributes(&FREE, &complete, owner, &[]);
            return;
        }
        if !self.census.take(place, &complete, owner, ignored) {
            return;
        }
        self.census.unknown(place, element, owner);
        let class = element.text("childclass").or(around.class);
        for child in &element.children {
            self.element(child, &path(place, &child.name), Around { class, owner });
        }
    }
}
