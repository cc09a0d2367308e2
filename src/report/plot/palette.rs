//! Colours by meaning: a colour-blind-safe set (Okabe and Ito 2008) in versions for light and dark pages.

/// The meaning of a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// Titles and values.
    Text,
    /// Axis labels, ticks, remarks.
    Muted,
    /// Grid lines.
    Grid,
    /// Background areas such as a scheduled contact.
    Shade,
    /// An arm, by its index in the report; the colours repeat after the last one.
    Arm(usize),
    /// The left leg.
    Left,
    /// The right leg.
    Right,
    /// Commands, limits, reference motions.
    Reference,
}

/// Class, colour on light pages, colour on dark pages.
const COLOURS: [(&str, &str, &str); 13] = [
    ("text", "#1f2328", "#e6edf3"),
    ("muted", "#59636e", "#9198a1"),
    ("grid", "#d9dde2", "#30363d"),
    ("shade", "#e9ecef", "#262c33"),
    ("left", "#009e73", "#2fc79a"),
    ("right", "#aa4499", "#e29ac9"),
    ("reference", "#8a7a2f", "#d9c55c"),
    ("arm0", "#0072b2", "#56b4e9"),
    ("arm1", "#d55e00", "#f0a04b"),
    ("arm2", "#009e73", "#2fc79a"),
    ("arm3", "#aa4499", "#e29ac9"),
    ("arm4", "#7a6a00", "#f0e442"),
    ("arm5", "#4d4d4d", "#b8bfc7"),
];

/// Number of colours for arms.
pub const ARMS: usize = 6;

impl Ink {
    /// Its class in the style sheet.
    pub fn class(self) -> &'static str {
        let index = match self {
            Self::Text => 0,
            Self::Muted => 1,
            Self::Grid => 2,
            Self::Shade => 3,
            Self::Left => 4,
            Self::Right => 5,
            Self::Reference => 6,
            Self::Arm(place) => 7 + place % ARMS,
        };
        COLOURS[index].0
    }
}

/// The style sheet: for each class `c` the rules `.c` (fill) and `.c-line` (stroke), then the same for
/// dark pages.
pub fn style_sheet() -> String {
    let rules = |dark: bool| -> String {
        COLOURS
            .iter()
            .map(|(class, light, night)| {
                let colour = if dark { night } else { light };
                format!(".{class}{{fill:{colour}}}.{class}-line{{stroke:{colour}}}")
            })
            .collect()
    };
    format!(
        "text{{font-family:system-ui,-apple-system,\"Segoe UI\",\"DejaVu Sans\",sans-serif}}\n{}\n@media \
         (prefers-color-scheme:dark){{{}}}",
        rules(false),
        rules(true)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance as defined in WCAG 2.1.
    fn luminance(colour: &str) -> f64 {
        let channel = |at: usize| {
            let value =
                f64::from(u8::from_str_radix(&colour[at..at + 2], 16).expect("two hex digits")) / 255.0;
            if value <= 0.03928 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) }
        };
        0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5)
    }

    fn contrast(a: &str, b: &str) -> f64 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn lines_and_texts_stand_out_on_light_and_dark_pages() {
        for (class, light, dark) in COLOURS.iter().filter(|(class, ..)| !["grid", "shade"].contains(class)) {
            assert!(contrast(light, "#ffffff") > 3.0, "{class} on white: {}", contrast(light, "#ffffff"));
            assert!(contrast(dark, "#0d1117") > 4.5, "{class} on black: {}", contrast(dark, "#0d1117"));
        }
    }

    #[test]
    fn the_style_sheet_has_both_schemes() {
        let sheet = style_sheet();
        assert!(sheet.contains(".arm0{fill:#0072b2}"));
        assert!(sheet.contains("prefers-color-scheme:dark){.text{fill:#e6edf3}"));
    }
}
