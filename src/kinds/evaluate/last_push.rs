//! When the last scheduled push of an evaluation's episodes comes.

use super::Spread;
use crate::kinds::randomize::Rows;
use crate::kinds::randomize::push::Pushes;
use crate::spec::typed::InSection;
use crate::spec::{Sampler, Section, Value};

/// Time in s from the start of an episode at which the last push with the key `at` begins; of pushes that are
/// repeated it is the first one. `None` if no push has a time. `protocol` is the table of an evaluation or a
/// transfer in the decoded spec `spec`.
pub fn last_push(spec: Section, protocol: Section) -> Option<f64> {
    let rows = match protocol.table().get(Spread::randomize.name)? {
        Value::Flag(true) => spec.section(Rows::SECTION)?,
        Value::Table(rows) => Section::new(rows),
        _ => return None,
    };
    let pushes = rows.sections().map(|(_, row)| row).filter(|row| row.is::<Pushes>());
    pushes.filter_map(|row| row.value(Pushes::at)).map(|at: Sampler| at.bounds()[1]).reduce(f64::max)
}
