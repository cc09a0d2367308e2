//! Locates a mistake: the primary label is the conflicting value that was set last, and the values that a
//! profile or a `--set` replaced are shown.

use std::cmp::Reverse;

use crate::diag::{Diagnostic, SourceId, Span};
use crate::spec::{Experiment, Mark, Marks};
use crate::syntax::Layer;

/// Makes the label of the value set last the primary one: a child wins over its parent, a profile over files,
/// a `--set` over all. Ties go to the first label.
pub fn blame_the_last_writer(diagnostic: &mut Diagnostic, marks: &Marks, files: &[SourceId]) {
    // Parents come before children in `files`; of other files, the first one read counts as the child.
    let age = |source: SourceId| (files.iter().position(|file| *file == source), Reverse(source));
    let rank = |span: Span| owner(span, marks).map(|(_, mark)| (mark.layer, age(mark.value.source)));
    let ranks: Vec<_> = diagnostic.labels.iter().map(|label| rank(label.span)).collect();
    let Some(last) =
        (0..ranks.len()).reduce(|best, other| if ranks[other] > ranks[best] { other } else { best })
    else {
        return;
    };
    let blamed = diagnostic.labels.remove(last);
    diagnostic.labels.insert(0, blamed);
    diagnostic.labels.iter_mut().enumerate().for_each(|(index, label)| label.primary = index == 0);
}

/// Adds labels for the values that a profile or a `--set` replaced.
pub fn show_what_was_replaced(diagnostic: &mut Diagnostic, experiment: &Experiment) {
    let Some(place) = diagnostic.labels.first().map(|label| label.span) else { return };
    let Some((path, _)) = owner(place, &experiment.marks) else { return };
    for (span, layer) in experiment.replaced.get(path).into_iter().flatten() {
        let words = match layer {
            Layer::Profile => format!("the value of profile `{}`", experiment.profile_of(*span)),
            _ => "the spec's own value".to_owned(),
        };
        *diagnostic = diagnostic.clone().note(*span, words);
    }
}

/// An edit belongs into the spec that is checked: the files of its parents are shared.
pub fn edit_own_file(diagnostic: &mut Diagnostic, marks: &Marks, own: SourceId) {
    let Some(fix) = diagnostic.fix.as_ref().filter(|fix| fix.span.source != own) else { return };
    let inherited =
        |mark: &Mark| mark.value == fix.span && matches!(mark.layer, Layer::File | Layer::Profile);
    let Some((path, _)) = marks.by_path.iter().find(|(_, mark)| inherited(mark)) else { return };
    let line = format!("`{path} = {}`", fix.replacement);
    diagnostic.fix = None;
    if !diagnostic.help.iter().any(|help| help.contains(&line)) {
        diagnostic
            .help
            .push(format!("write {line} in this spec: the value is that of a parent, which others share"));
    }
}

/// The innermost value that contains a place.
fn owner(place: Span, marks: &Marks) -> Option<(&String, &Mark)> {
    let around =
        |span: Span| span.source == place.source && span.start <= place.start && place.end <= span.end;
    let written = marks.by_path.iter().filter(|(_, mark)| mark.layer != Layer::Default);
    written.filter(|(_, mark)| around(mark.value)).min_by_key(|(_, mark)| mark.value.end - mark.value.start)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(source: usize, start: usize) -> Span {
        Span { source: SourceId(source), start, end: start + 5 }
    }

    fn marks(values: &[(&str, Span, Layer)]) -> Marks {
        let mark = |value: Span, layer| Mark { key: value, value, layer, text: String::new() };
        Marks {
            by_path: values
                .iter()
                .map(|(path, value, layer)| ((*path).to_owned(), mark(*value, *layer)))
                .collect(),
        }
    }

    fn blamed(values: &[(&str, Span, Layer)]) -> Vec<Span> {
        let mut diagnostic = Diagnostic::error("E0501", "").at(values[0].1, "");
        for (_, span, _) in &values[1..] {
            diagnostic = diagnostic.note(*span, "");
        }
        blame_the_last_writer(&mut diagnostic, &marks(values), &[]);
        assert!(
            diagnostic.labels[0].primary
                && diagnostic.labels.iter().filter(|label| label.primary).count() == 1
        );
        diagnostic.labels.iter().map(|label| label.span).collect()
    }

    #[test]
    fn an_edit_of_a_parents_value_becomes_a_line_for_the_spec_itself() {
        let (parent, own) = (span(1, 0), span(0, 40));
        let marks = marks(&[("action.damping", parent, Layer::File), ("action.std", own, Layer::File)]);
        let edited = |place: Span| {
            let mut diagnostic = Diagnostic::warning("W0512", "").at(place, "").fix(place, "\"30 %\"");
            edit_own_file(&mut diagnostic, &marks, SourceId(0));
            diagnostic
        };
        assert!(edited(own).fix.is_some() && edited(own).help.is_empty());
        let line = "write `action.damping = \"30 %\"` in this spec: the value is that of a parent, which others share";
        assert_eq!((edited(parent).fix, edited(parent).help), (None, vec![line.to_owned()]));
    }

    #[test]
    fn the_child_is_blamed_before_its_parent_and_an_assignment_before_both() {
        let (parent, child, set) = (span(1, 0), span(0, 40), span(2, 7));
        assert_eq!(blamed(&[("a", parent, Layer::File), ("b", child, Layer::File)]), [child, parent]);
        assert_eq!(blamed(&[("a", child, Layer::File), ("b", set, Layer::Set)]), [set, child]);
    }

    #[test]
    fn of_two_values_of_one_file_the_first_keeps_the_blame() {
        assert_eq!(
            blamed(&[("a", span(0, 50), Layer::File), ("b", span(0, 9), Layer::File)])[0],
            span(0, 50)
        );
    }
}
