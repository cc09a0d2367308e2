use super::reader::table;
use super::robot;
use crate::robot::{embedded, from_table, symmetry};

#[test]
fn the_robots_have_their_published_masses() {
    for (name, mass) in [("tocabi", 104.48712), ("atlas", 90.72895), ("g1", 32.1069)] {
        assert!((robot(name).total_mass() - mass).abs() < 1e-5, "{name}");
    }
}

#[test]
fn the_base_stands_at_the_published_height() {
    // TOCABI: the squat of the paper starts at 0.92814 m (0.4 mm sunk in). Atlas: 0.05 + 0.374 cos 0.24 + ... by hand.
    assert!((robot("tocabi").standing_height - 0.9285).abs() < 1e-4, "{}", robot("tocabi").standing_height);
    let atlas = robot("atlas").standing_height;
    // Thigh (-0.05, -0.374) turned by -0.24 about y: z = 0.05 sin(-0.24) - 0.374 cos(0.24); shank turned by 0.36.
    let by_hand = 0.05 - (0.05 * (-0.24f64).sin() - 0.374 * 0.24f64.cos()) + 0.422 * 0.36f64.cos() + 0.081119;
    assert!((atlas - by_hand).abs() < 1e-9, "{atlas} {by_hand}");
    assert!((0.6..0.85).contains(&robot("g1").standing_height), "{}", robot("g1").standing_height);
}

#[test]
fn mirroring_flips_yaw_and_roll_and_keeps_pitch() {
    for name in ["tocabi", "atlas"] {
        let robot = robot(name);
        assert!(symmetry::is_involution(&robot.mirror));
        for (joint, (image, sign)) in robot.mirror.iter().enumerate() {
            assert_eq!(*image, (joint + 6) % 12, "{name}");
            assert_eq!(*sign, [-1.0, -1.0, 1.0, 1.0, 1.0, -1.0][joint % 6], "{name} {joint}");
        }
    }
    let g1 = robot("g1");
    let signs: Vec<f64> = g1.mirror[..6].iter().map(|(_, sign)| *sign).collect();
    assert_eq!(signs, [1.0, -1.0, -1.0, 1.0, 1.0, -1.0]);
}

/// The codes and paths of what is wrong with TOCABI after replacing a part of its file once.
fn faults(from: &str, to: &str) -> Vec<(&'static str, String)> {
    let text = embedded("tocabi").unwrap();
    assert!(text.contains(from), "{from}");
    let (robot, issues) = from_table("tocabi", &table(&text.replacen(from, to, 1)));
    assert!(robot.is_none());
    issues.into_iter().map(|issue| (issue.code, issue.path)).collect()
}

#[test]
fn mistakes_are_named_with_their_code_and_place() {
    let knee = "links.3.joint".to_owned();
    assert_eq!(faults("effort_limit = \"289 N*m\"\n", ""), [("E0403", knee)]);
    assert_eq!(
        faults("parent = \"L_Thigh_Link\"", "parent = \"L_Tigh_Link\""),
        [("E0404", "links.3.parent".to_owned())]
    );
    assert_eq!(faults("link = \"R_AnkleRoll_Link\"", "link = \"R_Foot\""), [("E0404", "feet.right.link".to_owned())]);
    assert_eq!(faults("mass = \"2.67 kg\"", "mass = \"2.66 kg\""), [("E0405", "total_mass".to_owned())]);
    assert_eq!(faults("ixx = \"0.0794 kg*m^2\"", "ixx = \"0.794 kg*m^2\""), [("E0405", "links.2.inertia".to_owned())]);
    assert_eq!(faults("ixx = \"0.0794 kg*m^2\"", "ixx = \"-0.01 kg*m^2\""), [("E0405", "links.2.inertia".to_owned())]);
    assert_eq!(faults("lower = \"-0.6 rad\"", "lower = \"0.7 rad\""), [("E0405", "links.0.joint.lower".to_owned())]);
    assert_eq!(
        faults("default_position = \"0.6 rad\"", "default_position = \"4 rad\""),
        [("E0406", "links.3.joint.default_position".to_owned())]
    );
    assert_eq!(faults("origin = [\"0.11 m\", \"0.1025 m\"", "origin = [\"0.11 m\", \"0.2 m\"").len(), 1);
}

#[test]
fn several_mistakes_are_reported_together() {
    let text = embedded("tocabi").unwrap();
    let text = text.replacen("effort_limit = \"289 N*m\"\n", "", 1).replacen("effort_limit = \"222 N*m\"\n", "", 1);
    let (_, issues) = from_table("tocabi", &table(&text));
    assert_eq!(issues.iter().map(|issue| issue.code).collect::<Vec<_>>(), ["E0403", "E0403"]);
}
