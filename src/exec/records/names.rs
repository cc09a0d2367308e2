//! File names of records. A record belongs to one name, so a renamed record or a copy is found.

use std::collections::BTreeSet;
use std::path::Path;

use super::RunRecord;

/// A unique start of a file name for a run: `NAME.RUN`, and a digest if two runs have the same words.
pub fn stem(name: &str, run: &str, known: &mut BTreeSet<String>) -> String {
    let stem = format!("{name}.{}", words(run));
    let stem = if known.contains(&stem) { format!("{stem}.{}", digest(run)) } else { stem };
    known.insert(stem.clone());
    stem
}

/// What is wrong with the name of a record's file.
pub fn flaw(record: &RunRecord, path: &Path) -> Option<String> {
    let found = path.file_stem().unwrap_or_default().to_string_lossy();
    (found != record.file).then(|| {
        format!(
            "it is the record of the run `{}`, which belongs in `{}.json`: it was renamed or copied",
            record.run, record.file
        )
    })
}

/// A run's name in the characters of file names.
fn words(run: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '.' | '-') { c } else { '_' };
    let mut words: String = run.chars().map(plain).collect();
    while words.contains("__") {
        words = words.replace("__", "_");
    }
    words.trim_matches('_').to_owned()
}

fn digest(run: &str) -> String {
    blake3::hash(run.as_bytes()).to_hex().as_str()[..8].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_belongs_to_one_file_name() {
        let mut known = BTreeSet::new();
        assert_eq!(stem("suite", "case=a b,seed=1", &mut known), "suite.case_a_b_seed_1");
        let second = stem("suite", "case=a_b,seed=1", &mut known);
        assert!(second.starts_with("suite.case_a_b_seed_1.") && second.len() == 30, "{second}");
        let record = |file: &str| RunRecord {
            format: 3,
            run: "case=a_b,seed=1".into(),
            file: file.into(),
            stages: Vec::new(),
            seal: String::new(),
        };
        let fits = |record: &RunRecord, path: &str| flaw(record, Path::new(path)).is_none();
        let own = record("suite.case_a_b_seed_1");
        assert!(fits(&own, "runs/suite.case_a_b_seed_1.json"));
        assert!(!fits(&own, "runs/other.case_a_b_seed_1.json") && !fits(&own, "suite.case_a_b_seed_2.json"));
        assert!(!fits(&own, "copy.json") && !fits(&own, "suite.case_a_b_seed_1 (copy).json"));
    }
}
