//! Names in remarks.

use crate::spec::suggest::listed;

/// Maximum number of names listed; of the rest only the count is shown.
const NAMED: usize = 3;

/// Names for a remark; of very many the first and the number of others.
pub(super) fn some(names: &[&str]) -> String {
    match names.len() {
        count if count > NAMED + 1 => {
            let first: Vec<String> = names.iter().take(NAMED).map(|name| format!("`{name}`")).collect();
            format!("{} and {} others", first.join(", "), count - NAMED)
        }
        _ => listed(names.iter().copied()),
    }
}
