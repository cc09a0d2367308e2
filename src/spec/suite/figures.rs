//! The figures of a suite's report and their syntax in `report.figures`: `"survival_grid"`, or with an
//! argument after a colon, `"metric_grid:evaluate.nominal.speed_error"`. Independent of drawing and metrics.

use crate::diag::{Diagnostic, Sink, Span};
use crate::spec::suggest::{listed, nearest};
use crate::syntax::Node;

/// The argument allowed after a figure's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// Nothing.
    Nothing,
    /// A training, `learn` or `fine_tune`; the first if omitted.
    Training,
    /// A metric of an evaluation; required.
    Metric,
    /// A metric of an evaluation; chosen by the report if omitted.
    MetricOrNothing,
    /// An evaluation; chosen by the report if omitted.
    Stage,
    /// Two evaluations separated by a comma; chosen by the report if omitted.
    TwoStages,
}

/// Every figure with its argument, sorted by name.
pub const FIGURES: &[(&str, About)] = &[
    ("ankle_torque", About::TwoStages),
    ("claims", About::Nothing),
    ("contact_forces", About::TwoStages),
    ("failure_deciles", About::Stage),
    ("failure_loadings", About::Stage),
    ("learning_curves", About::Training),
    ("metric_grid", About::Metric),
    ("return_histogram", About::Stage),
    ("speeds", About::MetricOrNothing),
    ("survival_grid", About::Stage),
    ("time_lapse", About::Nothing),
];

/// A figure requested by a suite.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// Its name.
    pub name: String,
    /// Its argument: stages, the last one followed by the metric; empty if the report chooses.
    pub about: Vec<String>,
}

impl Wanted {
    /// Splits a figure's name from its argument.
    pub fn parse(text: &str) -> Self {
        let (name, about) = text.split_once(':').unwrap_or((text, ""));
        let about =
            about.split(',').map(str::trim).filter(|part| !part.is_empty()).map(str::to_owned).collect();
        Self { name: name.trim().to_owned(), about }
    }

    /// The argument it takes; `None` for an unknown figure.
    pub fn takes(&self) -> Option<About> {
        FIGURES.iter().find(|(name, _)| *name == self.name).map(|(_, about)| *about)
    }
}

/// E0301 for an unknown figure, E0103 for a missing or superfluous argument.
pub(super) fn known(node: &Node, sink: &mut Sink) -> Option<(Wanted, Span)> {
    let wanted = Wanted::parse(node.text()?);
    let Some(takes) = wanted.takes() else {
        sink.emit(unknown(&wanted, node));
        return None;
    };
    let (name, count) = (&wanted.name, wanted.about.len());
    let cure = match takes {
        About::Nothing if count > 0 => format!("write `{name}` alone"),
        About::Metric if count != 1 => format!("write for example `{name}:evaluate.nominal.speed_error`"),
        About::MetricOrNothing if count > 1 => {
            format!("write `{name}`, or for example `{name}:evaluate.grid.survival`")
        }
        About::Training if count > 1 => format!("write `{name}`, or for example `{name}:fine_tune`"),
        About::Stage if count > 1 => format!("write `{name}`, or for example `{name}:evaluate.nominal`"),
        About::TwoStages if count != 0 && count != 2 => {
            format!("write `{name}`, or for example `{name}:evaluate.flat,evaluate.box`")
        }
        _ => return Some((wanted, node.span)),
    };
    let what = match takes {
        About::Nothing => "takes no argument",
        About::Training => "takes at most one training",
        About::Metric => "needs one metric",
        About::MetricOrNothing => "takes at most one metric",
        About::Stage => "takes at most one evaluation",
        About::TwoStages => "takes two evaluations",
    };
    sink.emit(Diagnostic::error("E0103", format!("the figure `{name}` {what}")).at(node.span, "").help(cure));
    None
}

fn unknown(wanted: &Wanted, node: &Node) -> Diagnostic {
    let names = || FIGURES.iter().map(|(name, _)| *name);
    let error = Diagnostic::error("E0301", format!("unknown figure `{}`", wanted.name)).at(node.span, "");
    match nearest(&wanted.name, names()) {
        Some(near) => {
            let about = node
                .text()
                .and_then(|text| text.split_once(':'))
                .map_or(String::new(), |(_, about)| format!(":{about}"));
            error.help(format!("did you mean `{near}`?")).fix(node.span, format!("\"{near}{about}\""))
        }
        None => error.help(format!("the figures of a suite are {}", listed(names()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_is_taken_apart_at_its_colon_and_commas() {
        let wanted = Wanted::parse("ankle_torque: evaluate.flat, evaluate.box");
        assert_eq!((wanted.name.as_str(), wanted.about.len()), ("ankle_torque", 2));
        assert_eq!(wanted.about, ["evaluate.flat", "evaluate.box"]);
        assert_eq!(wanted.takes(), Some(About::TwoStages));
        assert_eq!(Wanted::parse("claims").about, Vec::<String>::new());
        assert_eq!(Wanted::parse("clams").takes(), None);
    }

    #[test]
    fn the_figures_are_sorted() {
        assert!(FIGURES.is_sorted_by_key(|(name, _)| *name));
    }
}
