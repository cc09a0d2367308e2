//! COLLADA: the boxes around the geometries of a file, placed by its scene. Ignores materials and the use of
//! the mesh.
//!
//! A box only needs the positions, the transforms of the nodes and the unit. The up axis of the file is
//! ignored: robot descriptions use the file's own axes.

use std::collections::BTreeMap;

use nalgebra::{Matrix4, Point3, Rotation3, Unit, Vector3};
use roxmltree::{Document, Node, ParsingOptions};

use super::xml;

/// Maximum nesting of nodes and node instances.
const DEEPEST: usize = 100;
/// Maximum number of nodes of a scene, counting each instance.
const MOST_NODES: usize = 100_000;
/// Maximum number of XML nodes, attribute values and comments of a file.
const MOST_XML_NODES: u32 = 1_000_000;

/// The minimum and maximum corners of all placed geometries, in m.
pub(super) fn corners(text: &str) -> Result<Vec<[f32; 3]>, String> {
    if xml::crowded(text).is_some() {
        return Err("an element has too many attributes".to_owned());
    }
    let options = ParsingOptions { nodes_limit: MOST_XML_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| error.to_string())?;
    let root = document.root_element();
    let mut named: BTreeMap<(&str, &str), Vec<Node>> = BTreeMap::new();
    for node in root.descendants() {
        if let Some(id) = node.attribute("id") {
            named.entry((id, node.tag_name().name())).or_default().push(node);
        }
    }
    let mut scene = Scene { named, points: BTreeMap::new(), nodes: 0, corners: Vec::new() };
    let metre = match child(root, "asset")
        .and_then(|asset| child(asset, "unit"))
        .and_then(|unit| unit.attribute("meter"))
    {
        Some(metre) => number(metre)?,
        None => 1.0,
    };
    let frame = Matrix4::new_scaling(metre);
    match child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene")) {
        Some(instance) => {
            let nodes = scene.target(instance, "url", "visual_scene")?;
            scene.node(nodes, frame, 0)?;
        }
        None => {
            let geometries = root.descendants().filter(|node| is(node, "geometry"));
            geometries.into_iter().try_for_each(|geometry| scene.geometry(geometry, frame))?;
        }
    }
    Ok(scene.corners)
}

/// State of the traversal of a scene.
struct Scene<'a, 'input> {
    /// The elements by `id` and kind, in the order of the file; some programs use an `id` several times.
    named: BTreeMap<(&'a str, &'a str), Vec<Node<'a, 'input>>>,
    /// The points of the geometries visited, by the position of their element.
    points: BTreeMap<usize, Vec<Point3<f64>>>,
    nodes: usize,
    corners: Vec<[f32; 3]>,
}

impl<'a, 'input> Scene<'a, 'input> {
    /// A node, or a container of nodes, in this frame.
    fn node(&mut self, node: Node<'a, 'input>, mut frame: Matrix4<f64>, depth: usize) -> Result<(), String> {
        self.nodes += 1;
        if depth > DEEPEST || self.nodes > MOST_NODES {
            return Err(format!(
                "its nodes nest more than {DEEPEST} deep, or there are more than {MOST_NODES}"
            ));
        }
        for part in node.children().filter(Node::is_element) {
            match part.tag_name().name() {
                "node" => self.node(part, frame, depth + 1)?,
                "instance_node" => {
                    let node = self.target(part, "url", "node")?;
                    self.node(node, frame, depth + 1)?;
                }
                "instance_geometry" => {
                    let geometry = self.target(part, "url", "geometry")?;
                    self.geometry(geometry, frame)?;
                }
                "instance_controller" => return Err("a skin bends its mesh".to_owned()),
                _ => frame *= transform(part)?,
            }
        }
        Ok(())
    }

    /// A geometry in this frame.
    fn geometry(&mut self, geometry: Node<'a, 'input>, frame: Matrix4<f64>) -> Result<(), String> {
        let key = geometry.range().start;
        if !self.points.contains_key(&key) {
            let points = self.positions(geometry)?;
            self.points.insert(key, points);
        }
        let mut placed = self.points[&key].iter().map(|point| frame.transform_point(point).coords);
        if let Some(first) = placed.next() {
            let (low, high) =
                placed.fold((first, first), |(low, high), point| (low.inf(&point), high.sup(&point)));
            // The caller reports values that are not finite.
            let cast = |corner: Vector3<f64>| <[f32; 3]>::from(corner.map(|x| x as f32));
            self.corners.extend([cast(low), cast(high)]);
        }
        Ok(())
    }

    /// The positions of a geometry's mesh in its own frame.
    fn positions(&self, geometry: Node<'a, 'input>) -> Result<Vec<Point3<f64>>, String> {
        let mut points = Vec::new();
        let vertices = geometry.descendants().filter(|node| is(node, "vertices"));
        for input in vertices.flat_map(|vertices| vertices.children()) {
            if input.attribute("semantic") != Some("POSITION") {
                continue;
            }
            let source = self.target(input, "source", "source")?;
            let accessor = source.descendants().find(|node| is(node, "accessor"));
            let accessor = accessor.ok_or("positions without an accessor")?;
            let count = |key: &str, absent: usize| match accessor.attribute(key) {
                Some(text) => {
                    text.trim().parse::<usize>().map_err(|_| format!("`{key}` is not a number: {text}"))
                }
                None => Ok(absent),
            };
            let (offset, stride) = (count("offset", 0)?, count("stride", 1)?);
            if stride < 3 {
                return Err(format!("positions of {stride} numbers"));
            }
            let numbers = numbers(self.target(accessor, "source", "float_array")?)?;
            let rows =
                numbers.get(offset..).unwrap_or_default().chunks_exact(stride).take(count("count", 0)?);
            points.extend(rows.map(|row| Point3::new(row[0], row[1], row[2])));
        }
        match points.iter().all(|point: &Point3<f64>| point.iter().all(|x| x.is_finite())) {
            true => Ok(points),
            false => Err("a point of it is not finite".to_owned()),
        }
    }

    /// The element of a kind that an attribute refers to: the one in the smallest common ancestor, because
    /// exporters repeat the same ids in every geometry.
    fn target(&self, node: Node<'a, 'input>, key: &str, kind: &str) -> Result<Node<'a, 'input>, String> {
        let name = node.attribute(key).unwrap_or_default();
        let id = name.strip_prefix('#').unwrap_or_default();
        let Some(fit) = self.named.get(&(id, kind)) else {
            let others =
                self.named.range((id, "")..).next().filter(|((other, _), _)| *other == id && !id.is_empty());
            return Err(match others {
                Some(((_, other), _)) => format!("`{name}` names a <{other}>, not a <{kind}>"),
                None => format!("nothing in the file has the name `{name}`"),
            });
        };
        for outer in node.ancestors() {
            let outer = outer.range();
            let first = fit.partition_point(|found| found.range().start < outer.start);
            let end = fit.partition_point(|found| found.range().start < outer.end);
            match &fit[first..end] {
                [] => {}
                [one] => return Ok(*one),
                several => return Err(format!("{} <{kind}> elements have the id `{name}`", several.len())),
            }
        }
        Err(format!("nothing in the file has the name `{name}`"))
    }
}

/// The effect of a transform element of a node on the frame of the following ones.
fn transform(part: Node) -> Result<Matrix4<f64>, String> {
    let exact = |numbers: Vec<f64>, count: usize| match numbers.len() == count {
        true => Ok(numbers),
        false => Err(format!("<{}> has {} numbers, not {count}", part.tag_name().name(), numbers.len())),
    };
    let vector = |numbers: &[f64]| Vector3::new(numbers[0], numbers[1], numbers[2]);
    match part.tag_name().name() {
        "matrix" => exact(numbers(part)?, 16).map(|rows| Matrix4::from_row_slice(&rows)),
        "translate" => exact(numbers(part)?, 3).map(|by| Matrix4::new_translation(&vector(&by))),
        "scale" => exact(numbers(part)?, 3).map(|by| Matrix4::new_nonuniform_scaling(&vector(&by))),
        "rotate" => {
            let turn = exact(numbers(part)?, 4)?;
            let axis = Unit::try_new(vector(&turn), 1e-12);
            Ok(axis.map_or(Matrix4::identity(), |axis| {
                Rotation3::from_axis_angle(&axis, turn[3].to_radians()).into()
            }))
        }
        unread @ ("lookat" | "skew") => Err(format!("<{unread}> is not read")),
        _ => Ok(Matrix4::identity()),
    }
}

/// The numbers in an element.
fn numbers(node: Node) -> Result<Vec<f64>, String> {
    node.text().unwrap_or_default().split_whitespace().map(number).collect()
}

fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| format!("`{text}` is not a number"))
}

fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    node.children().find(|child| is(child, name))
}

/// Whether an element has this name, in any namespace: COLLADA's differs by version.
fn is(node: &Node, name: &str) -> bool {
    node.is_element() && node.tag_name().name() == name
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A file with a brick of 2 by 4 by 6 units, one corner at the origin, and the given unit and scene.
    fn file(asset: &str, nodes: &str, more: &str) -> String {
        format!(
            r##"<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{asset}<up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="brick"><mesh>
<source id="p"><float_array id="a" count="9">7 0 0 0 9 2 4 6 9</float_array>
<technique_common><accessor source="#a" count="2" offset="1" stride="4"/></technique_common></source>
<vertices id="v"><input semantic="NORMAL" source="#n"/><input semantic="POSITION" source="#p"/></vertices>
</mesh></geometry></library_geometries>
<library_nodes>{more}</library_nodes>
<library_visual_scenes><visual_scene id="s">{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"##
        )
    }

    /// The bounding box of everything: minimum and maximum corner.
    fn around(text: &str) -> Result<[Vec<f32>; 2], String> {
        let corners = corners(text)?;
        let side = |pick: fn(f32, f32) -> f32| {
            (0..3)
                .map(|axis| corners.iter().map(|corner| corner[axis]).reduce(pick).unwrap_or(f32::NAN))
                .collect()
        };
        Ok([side(f32::min), side(f32::max)])
    }

    const BRICK: &str = r##"<instance_geometry url="#brick"/>"##;

    #[test]
    fn a_geometry_is_placed_by_its_nodes_in_order_and_scaled_by_the_unit() {
        let millimetres = r#"<unit name="millimetre" meter="0.001"/>"#;
        let plain = format!("<node>{BRICK}</node>");
        assert_eq!(around(&file("", &plain, "")).unwrap(), [vec![0.0; 3], vec![2.0, 4.0, 6.0]]);
        assert_eq!(around(&file(millimetres, &plain, "")).unwrap()[1], [0.002, 0.004, 0.006]);
        // Scaled by half, turned by 90 degrees about z, then moved, in a parent that moves by 10 along y.
        let placed = format!(
            "<node><matrix>1 0 0 0 0 1 0 10 0 0 1 0 0 0 0 1</matrix><node><translate>1 0 0</translate>\
             <rotate>0 0 1 90</rotate><scale>0.5 0.5 0.5</scale>{BRICK}</node></node>"
        );
        let [low, high] = around(&file("", &placed, "")).unwrap();
        let near =
            |found: &[f32], expected: [f32; 3]| found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5);
        assert!(near(&low, [-1.0, 10.0, 0.0]) && near(&high, [1.0, 11.0, 3.0]), "{low:?} {high:?}");
    }

    #[test]
    fn an_instance_counts_wherever_it_is_placed() {
        let shared = format!(r#"<node id="pair">{BRICK}</node>"#);
        let nodes = r##"<node><instance_node url="#pair"/></node>
            <node><translate>0 0 -5</translate><instance_node url="#pair"/></node>"##;
        assert_eq!(around(&file("", nodes, &shared)).unwrap(), [vec![0.0, 0.0, -5.0], vec![2.0, 4.0, 6.0]]);
    }

    /// A file of two bricks, 2 by 4 by 6 and 2 by 4 by 1 units, the second 10 units above; its sources have
    /// these ids.
    fn pair(first: [&str; 3], second: [&str; 3]) -> String {
        let brick = |[geometry, source, array]: [&str; 3], high: u32| {
            format!(
                r##"<geometry id="{geometry}"><mesh><source id="{source}">
                  <float_array id="{array}" count="6">0 0 0 2 4 {high}</float_array>
<technique_common><accessor source="#{array}" count="2" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#{source}"/></vertices></mesh></geometry>"##
            )
        };
        format!(
            r##"<COLLADA><library_geometries>{}{}</library_geometries><library_visual_scenes>
              <visual_scene id="s">
<node id="{}"><instance_geometry url="#{}"/></node><node><translate>0 0 10</translate>
  <instance_geometry url="#{}"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"##,
            brick(first, 6),
            brick(second, 1),
            first[0],
            first[0],
            second[0]
        )
    }

    #[test]
    fn an_id_is_looked_up_in_its_own_geometry_first_and_by_its_kind() {
        let unique = around(&pair(["a", "ap", "aa"], ["b", "bp", "ba"])).unwrap();
        assert_eq!(unique, [vec![0.0; 3], vec![2.0, 4.0, 11.0]]);
        assert_eq!(around(&pair(["a", "p", "x"], ["b", "p", "x"])).unwrap(), unique);
        assert_eq!(around(&pair(["a", "p", "x"], ["b", "p", "y"])).unwrap(), unique);
        // A node, a geometry and a source with the same id.
        assert_eq!(around(&pair(["a", "a", "a2"], ["b", "b", "b2"])).unwrap(), unique);
    }

    #[test]
    fn an_id_of_two_elements_that_may_be_meant_is_an_error() {
        let error = around(&pair(["a", "p", "x"], ["a", "p", "x"])).unwrap_err();
        assert_eq!(error, "2 <geometry> elements have the id `#a`");
        let double =
            pair(["a", "p", "x"], ["b", "q", "y"]).replace("<vertices", "<source id=\"p\"/><vertices");
        assert_eq!(around(&double).unwrap_err(), "2 <source> elements have the id `#p`");
        let wrong = pair(["a", "p", "x"], ["b", "q", "y"]).replace("url=\"#a\"", "url=\"#p\"");
        assert_eq!(around(&wrong).unwrap_err(), "`#p` names a <source>, not a <geometry>");
    }

    #[test]
    fn what_cannot_be_placed_is_said() {
        let said = |nodes: &str, more: &str| corners(&file("", nodes, more)).unwrap_err();
        let deep = "<node>".repeat(200) + &"</node>".repeat(200);
        let circle = r##"<node id="c"><instance_node url="#c"/></node>"##;
        let doubled: String = (0..60)
            .map(|n| {
                format!(
                    r##"<node id="n{n}">{0}{0}</node>"##,
                    format!(r##"<instance_node url="#n{}"/>"##, n + 1)
                )
            })
            .collect();
        for (nodes, more, part) in [
            (deep.as_str(), "", "nest more than 100 deep"),
            (r##"<node><instance_node url="#c"/></node>"##, circle, "nest more than 100 deep"),
            (r##"<instance_node url="#n0"/>"##, &(doubled + r#"<node id="n60"/>"#), "more than 100000"),
            (
                r##"<node><instance_geometry url="#gone"/></node>"##,
                "",
                "nothing in the file has the name `#gone`",
            ),
            ("<node><skew>1 2 3 4 5 6 7</skew></node>", "", "<skew> is not read"),
            ("<node><matrix>1 2 3</matrix></node>", "", "<matrix> has 3 numbers, not 16"),
            ("<node><translate>1 two 3</translate></node>", "", "`two` is not a number"),
        ] {
            let said = said(nodes, more);
            assert!(said.contains(part), "{said}");
        }
        let entity = file("", "", "").replace("<COLLADA", "<!DOCTYPE x [<!ENTITY a \"b\">]><COLLADA");
        assert!(corners(&entity).is_err());
        let crowd: String = (0..2000).map(|n| format!(" a{n}=\"\"")).collect();
        assert!(corners(&format!("<COLLADA{crowd}/>")).unwrap_err().contains("too many attributes"));
    }

    proptest! {
        #[test]
        fn damaged_files_are_read_or_refused(at in 0usize..1100, cut in 0usize..40, put in "[ -~]{0,8}") {
            let text = file("<unit meter=\"1\"/>", &format!("<node><scale>1 1 1</scale>{BRICK}</node>"), "");
            let at = at.min(text.len());
            let rest = &text[(at + cut).min(text.len())..];
            let _ = corners(&format!("{}{put}{rest}", &text[..at]));
        }
    }
}
