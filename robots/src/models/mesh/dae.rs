//! COLLADA files (1.4 and 1.5): the triangles and polygons that the scene shows, where its nodes put them.
//!
//! Lengths become metres by `<unit meter="..">`. `<up_axis>` is not followed: a URDF's frames are what the numbers say, as RViz,
//! MoveIt and Pinocchio take them.

use mrroc::console::quoted;
use nalgebra::{Matrix4, Point3, Rotation3, Unit, Vector3};
use roxmltree::{Document, Node, ParsingOptions};

use super::error::MeshError;
use super::triangles::Read;
use crate::models::xml::check_xml;

/// Most elements, comments and texts that are read.
const MOST_NODES: u32 = 400_000;

/// How deep elements may be nested.
const DEEPEST: usize = 64;

/// Vertices \[m\], and triangles by their indices.
pub(super) fn read(bytes: &[u8]) -> Result<Read, MeshError> {
    let text = core::str::from_utf8(bytes).map_err(|_| MeshError::NoText)?;
    check_xml(text, DEEPEST)?;
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|why| {
        let message = why.to_string();
        let what = quoted(message.split(" at ").next().unwrap_or(&message), 120);
        MeshError::Xml { line: why.pos().row as usize, what }
    })?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(refused(root, format!("the root element is <{}>, not <COLLADA>", named(root))));
    }
    let unit = child(root, "asset").and_then(|asset| child(asset, "unit"));
    let metres = match unit.and_then(|unit| Some((unit, unit.attribute("meter")?))) {
        None => 1.0,
        Some((unit, text)) => {
            let metres = text.trim().parse().ok().filter(|metres: &f64| metres.is_finite() && *metres > 0.0);
            metres.ok_or_else(|| refused(unit, "meter is not a finite number above 0".to_owned()))?
        }
    };
    let shown = child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene"));
    let shown =
        shown.ok_or_else(|| refused(root, "it has no <scene> with an <instance_visual_scene>".to_owned()))?;
    let mut scene = Scene { root, read: (Vec::new(), Vec::new()), most: bytes.len() };
    for node in children(scene.named_by(shown, "visual_scene")?, "node") {
        scene.add_node(node, &Matrix4::new_scaling(metres))?;
    }
    Ok(scene.read)
}

/// A scene being read.
struct Scene<'a, 'i> {
    root: Node<'a, 'i>,
    read: Read,
    /// Most vertices and triangles: as many as the file has bytes.
    most: usize,
}

impl<'a, 'i> Scene<'a, 'i> {
    /// The element that `url="#.."` of an element names.
    fn named_by(&self, element: Node<'a, 'i>, kind: &str) -> Result<Node<'a, 'i>, MeshError> {
        let id =
            element.attribute("url").or(element.attribute("source")).and_then(|url| url.strip_prefix('#'));
        let is_it = |node: &Node<'_, '_>| node.tag_name().name() == kind && node.attribute("id") == id;
        let found = id.and_then(|_| self.root.descendants().find(is_it));
        found.ok_or_else(|| refused(element, format!("it names no <{kind}> of this file")))
    }

    /// Adds what a node shows. Elements are nested at most [`DEEPEST`] deep, so this ends.
    fn add_node(&mut self, node: Node<'a, 'i>, above: &Matrix4<f64>) -> Result<(), MeshError> {
        let mut place = *above;
        for element in node.children().filter(Node::is_element) {
            match element.tag_name().name() {
                "matrix" => place *= Matrix4::from_row_slice(&numbers::<16>(element)?),
                "translate" => place *= Matrix4::new_translation(&Vector3::from(numbers::<3>(element)?)),
                "scale" => place *= Matrix4::new_nonuniform_scaling(&Vector3::from(numbers::<3>(element)?)),
                "rotate" => {
                    let [x, y, z, degrees] = numbers::<4>(element)?;
                    let axis = Unit::try_new(Vector3::new(x, y, z), 1e-9);
                    let axis =
                        axis.ok_or_else(|| refused(element, "its axis has no direction".to_owned()))?;
                    place *= Rotation3::from_axis_angle(&axis, degrees.to_radians()).to_homogeneous();
                }
                "instance_geometry" => self.add_geometry(self.named_by(element, "geometry")?, &place)?,
                "node" => self.add_node(element, &place)?,
                other @ ("lookat" | "skew" | "instance_node" | "instance_controller") => {
                    return Err(refused(element, format!("<{other}> is not read")));
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn add_geometry(&mut self, geometry: Node<'a, 'i>, place: &Matrix4<f64>) -> Result<(), MeshError> {
        let mesh = child(geometry, "mesh").ok_or_else(|| refused(geometry, "it has no <mesh>".to_owned()))?;
        let first = self.read.0.len();
        for part in mesh.children().filter(Node::is_element) {
            match part.tag_name().name() {
                "triangles" | "polylist" => self.add_polygons(part, first, place)?,
                other @ ("polygons" | "trifans" | "tristrips") => {
                    return Err(refused(part, format!("<{other}> is not read")));
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn add_polygons(
        &mut self,
        part: Node<'a, 'i>,
        first: usize,
        place: &Matrix4<f64>,
    ) -> Result<(), MeshError> {
        let offset =
            |input: Node<'_, '_>| input.attribute("offset").unwrap_or("0").trim().parse::<usize>().ok();
        let mut stride = 0;
        let mut vertex = None;
        for input in children(part, "input") {
            let offset = offset(input).filter(|offset| *offset < 64);
            let offset = offset.ok_or_else(|| refused(input, "its offset is not 0 to 63".to_owned()))?;
            stride = stride.max(offset + 1);
            if input.attribute("semantic") == Some("VERTEX") {
                vertex = Some((input, offset));
            }
        }
        let (input, offset) =
            vertex.ok_or_else(|| refused(part, "it has no <input semantic=\"VERTEX\">".to_owned()))?;
        // Every part of a mesh has the same vertices, which are added once.
        if self.read.0.len() == first {
            self.add_vertices(self.named_by(input, "vertices")?, place)?;
        }
        let count = self.read.0.len() - first;
        let indices: Vec<usize> = match child(part, "p") {
            Some(list) => listed(list)?,
            None => Vec::new(),
        };
        let corners: Vec<usize> = indices.chunks(stride).filter_map(|all| all.get(offset).copied()).collect();
        let sides: Vec<usize> = match child(part, "vcount") {
            Some(list) => listed(list)?,
            None => vec![3; corners.len() / 3],
        };
        let needed = sides.iter().try_fold(0_usize, |sum, sides| sum.checked_add(*sides));
        if needed != Some(corners.len()) || !indices.len().is_multiple_of(stride) {
            let what = format!("its polygons do not use its {} indices exactly", indices.len());
            return Err(refused(part, what));
        }
        let mut rest = corners.as_slice();
        for sides in sides {
            let (polygon, behind) = rest.split_at(sides);
            rest = behind;
            if let Some(index) = polygon.iter().find(|index| **index >= count) {
                return Err(refused(part, format!("it names vertex {index}, and there are {count}")));
            }
            if sides < 3 {
                return Err(refused(part, format!("a polygon of {sides} corners")));
            }
            let corner = |index: usize| (first + index) as u32;
            let fan = polygon[1..].windows(2);
            self.read.1.extend(fan.map(|pair| [polygon[0], pair[0], pair[1]].map(corner)));
        }
        self.bounded(part)
    }

    fn add_vertices(&mut self, vertices: Node<'a, 'i>, place: &Matrix4<f64>) -> Result<(), MeshError> {
        let mut inputs = children(vertices, "input");
        let positions = inputs.find(|input| input.attribute("semantic") == Some("POSITION"));
        let positions = positions
            .ok_or_else(|| refused(vertices, "it has no <input semantic=\"POSITION\">".to_owned()))?;
        let source = self.named_by(positions, "source")?;
        let array = child(source, "float_array");
        let array = array.ok_or_else(|| refused(source, "it has no <float_array>".to_owned()))?;
        let accessor = child(source, "technique_common").and_then(|common| child(common, "accessor"));
        let plain = |name: &str| accessor.and_then(|accessor| accessor.attribute(name)?.trim().parse().ok());
        let (stride, offset): (usize, usize) = (plain("stride").unwrap_or(3), plain("offset").unwrap_or(0));
        if !(3..=64).contains(&stride) {
            return Err(refused(source, format!("positions of {stride} numbers")));
        }
        let floats: Vec<f64> = listed(array)?;
        let floats = floats.get(offset..).unwrap_or_default();
        if let Some(count) =
            plain("count").filter(|count: &usize| count.saturating_mul(stride) > floats.len())
        {
            let what = format!("it states {count} positions and has {}", floats.len() / stride);
            return Err(refused(source, what));
        }
        let points = floats.chunks_exact(stride).map(|p| Point3::new(p[0], p[1], p[2]));
        self.read.0.extend(points.map(|point| place.transform_point(&point).coords));
        self.bounded(vertices)
    }

    /// A geometry may be shown again and again: what a file becomes stays in proportion to it.
    fn bounded(&self, at: Node<'_, '_>) -> Result<(), MeshError> {
        let count = self.read.0.len().max(self.read.1.len());
        if count > self.most {
            return Err(refused(at, "its geometries are shown too often".to_owned()));
        }
        Ok(())
    }
}

fn named(node: Node<'_, '_>) -> String {
    quoted(node.tag_name().name(), 40)
}

fn refused(node: Node<'_, '_>, what: String) -> MeshError {
    let line = node.document().text_pos_at(node.range().start).row as usize;
    MeshError::Collada { line, what: format!("<{}>: {what}", named(node)) }
}

/// The elements called `name` directly inside `parent`, in whatever namespace.
fn children<'a, 'i>(parent: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    parent.children().filter(move |node| node.tag_name().name() == name)
}

fn child<'a, 'i>(parent: Node<'a, 'i>, name: &'static str) -> Option<Node<'a, 'i>> {
    children(parent, name).next()
}

/// All numbers in an element.
fn listed<T: core::str::FromStr>(list: Node<'_, '_>) -> Result<Vec<T>, MeshError> {
    let number = |word: &str| {
        word.parse()
            .map_err(|_| refused(list, format!("\"{}\" is not a number of its kind", quoted(word, 40))))
    };
    list.text().unwrap_or_default().split_ascii_whitespace().map(number).collect()
}

/// The `C` finite numbers in an element.
fn numbers<const C: usize>(list: Node<'_, '_>) -> Result<[f64; C], MeshError> {
    let all: Vec<f64> = listed(list)?;
    let finite = all.iter().all(|number| number.is_finite());
    let all = <[f64; C]>::try_from(all).ok().filter(|_| finite);
    all.ok_or_else(|| refused(list, format!("it does not hold {C} finite numbers")))
}
