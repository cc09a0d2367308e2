//! E0204: a height field has at least one cell, and fits into memory.

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::terrain::height_field::{self, HeightField};
use crate::spec::typed::Declared;

/// Every field has a valid size.
pub fn fields_have_cells(subject: &Subject, sink: &mut Sink) {
    let fields =
        subject.grounds().into_iter().filter(|path| subject.kind(path) == Some(HeightField::KIND.name));
    fields.for_each(|path| field_has_cells(subject, &path, sink));
}

fn field_has_cells(subject: &Subject, path: &str, sink: &mut Sink) {
    let Some(field) = subject.section(path) else { return };
    let (cell, length) = (field.value(HeightField::cell), field.value(HeightField::length));
    let (Some(cell), Some(length), Some(width)) = (cell, length, field.value(HeightField::width)) else {
        return;
    };
    let Err(error) = height_field::check_size(cell, length, width) else { return };
    let mut diagnostic = Diagnostic::error("E0204", error.to_string());
    if let Some(place) = subject.place(&HeightField::cell.below(path)) {
        diagnostic = diagnostic.at(place, "");
    }
    sink.emit(diagnostic.help(error.help));
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    fn codes(cell: f64, length: f64) -> Vec<String> {
        let text = format!(
            "terrain = {{ kind = \"height_field\", cell = {cell:?}, length = {length:?}, width = 6.0 }}"
        );
        found(fields_have_cells, &text, None).iter().map(|found| found.message.clone()).collect()
    }

    #[test]
    fn a_field_smaller_than_its_cell_is_e0204() {
        assert_eq!(codes(14.0, 24.0), ["a cell of 14 m is larger than the field of 24 m by 6 m"]);
        assert!(codes(5.0, 24.0).is_empty());
    }

    #[test]
    fn the_field_of_an_evaluation_is_looked_at_too() {
        let text = "terrain = { kind = \"flat\" }\n\
                    evaluate.rough.terrain = \
                    { kind = \"height_field\", cell = 14.0, length = 24.0, width = 6.0 }";
        assert_eq!(found(fields_have_cells, text, None).len(), 1);
    }

    #[test]
    fn a_field_of_a_thousand_million_points_is_e0204() {
        let found = codes(0.01, 1000.0);
        assert!(found[0].starts_with("a field of 100001 by 601 points is too large"), "{found:?}");
        assert!(codes(0.1, 1000.0).is_empty());
    }
}
