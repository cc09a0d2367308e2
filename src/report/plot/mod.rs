//! A small layer over SVG: drawings of lines, areas and texts, with axes for charts.
//!
//! Colours are named by meaning and defined in the drawing's own style sheet, for light and for dark pages,
//! on a transparent background. Independent of arms, policies and robots.

pub mod axis;
pub mod drawing;
pub mod outline;
pub mod palette;
pub mod panel;
mod svg;

pub use axis::Axis;
pub use drawing::{Anchor, Drawing, Point, Stroke};
pub use palette::Ink;
pub use panel::{Area, Panel};
