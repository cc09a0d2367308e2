//! A small layer over SVG: drawings made of lines, areas and texts, with axes where they are charts.
//!
//! Colours are named by meaning and given in the drawing's own style sheet, once for light and once for
//! dark pages, on a transparent ground. Knows nothing of arms, policies or robots.

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
