//! The committed list of MJCF elements and attributes, which the import classifies, is the schema of the
//! linked MuJoCo.

#![cfg(feature = "mujoco")]

/// What `mj_printSchema` prints, an element a line: `body/joint: name class`.
const LIST: &str = include_str!("../src/robot/import/census/mjcf.txt");

/// The list as the linked library prints it.
fn printed() -> String {
    let mut buffer = vec![0u8; 1 << 20];
    let size = i32::try_from(buffer.len()).expect("a megabyte");
    // SAFETY: the library writes at most `size` bytes, among them the zero at the end; without a file name it
    // opens none.
    let length = unsafe {
        mujoco_rs::mujoco_c::mj_printSchema(std::ptr::null(), buffer.as_mut_ptr().cast(), size, 0, 0)
    };
    buffer.truncate(usize::try_from(length).expect("the schema fits"));
    let text = String::from_utf8(buffer).expect("it is ASCII");
    let mut lines: Vec<String> = Vec::new();
    let mut above: Vec<String> = Vec::new();
    for line in text.trim_end_matches('\0').lines() {
        // An element is indented by three columns a level and has its multiplicity in brackets.
        let words: Vec<&str> = line.split_whitespace().collect();
        let begins = words.get(1).is_some_and(|word| matches!(*word, "(!)" | "(*)" | "(?)" | "(R)"));
        let attributes = if begins {
            above.truncate((line.len() - line.trim_start().len()) / 3);
            above.push(words[0].replace("(world)", ""));
            let place = if above.len() == 1 { above[0].clone() } else { above[1..].join("/") };
            lines.push(format!("{place}:"));
            &words[2..]
        } else {
            &words[..]
        };
        let last = lines.last_mut().expect("the first line is an element");
        attributes.iter().for_each(|name| *last += &format!(" {name}"));
    }
    lines.join("\n") + "\n"
}

/// A new MuJoCo with another schema fails here: write the list anew with `SPECFORGE_BLESS=1` and classify
/// what is new.
#[test]
fn the_list_is_the_schema_of_the_mujoco_that_is_linked() {
    let version = mujoco_rs::mujoco_version();
    let found =
        format!("# What mj_printSchema of MuJoCo {version} prints, an element a line.\n{}", printed());
    if std::env::var_os("SPECFORGE_BLESS").is_some() {
        let place = concat!(env!("CARGO_MANIFEST_DIR"), "/src/robot/import/census/mjcf.txt");
        std::fs::write(place, &found).expect("the list is writable");
        return;
    }
    let (mut ours, mut theirs) = (LIST.lines(), found.lines());
    while let (Some(ours), Some(theirs)) = (ours.next(), theirs.next()) {
        assert_eq!(ours, theirs);
    }
    assert_eq!(LIST, found);
}
