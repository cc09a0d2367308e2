use super::{faults, robot};
use crate::diag::{Sink, Sources};
use crate::robot::{embedded, load, symmetry};

#[test]
fn the_robots_have_their_published_masses() {
    for (name, mass) in [("tocabi", 104.48712), ("atlas", 90.72895), ("g1", 32.1069)] {
        assert!((robot(name).total_mass() - mass).abs() < 1e-5, "{name}");
    }
}

#[test]
fn the_base_stands_at_the_published_height() {
    // TOCABI: the squat of the paper starts at 0.92814 m (0.4 mm sunk in). Atlas: 0.05 + 0.374 cos 0.24 + ...
    // by hand.
    assert!((robot("tocabi").standing_height - 0.9285).abs() < 1e-4, "{}", robot("tocabi").standing_height);
    let atlas = robot("atlas").standing_height;
    // Thigh (-0.05, -0.374) turned by -0.24 about y: z = 0.05 sin(-0.24) - 0.374 cos(0.24); shank turned by
    // 0.36.
    let by_hand =
        0.05 - (0.05 * libm::sin(-0.24) - 0.374 * libm::cos(0.24)) + 0.422 * libm::cos(0.36) + 0.081119;
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

#[test]
fn mistakes_are_named_with_their_code_and_place() {
    for (from, to, code, place) in [
        ("parent = \"L_Thigh_Link\"", "parent = \"L_Tigh_Link\"", "E0404", "\"L_Tigh_Link\""),
        ("link = \"R_AnkleRoll_Link\"", "link = \"R_Foot\"", "E0404", "\"R_Foot\""),
        ("mass = \"2.67 kg\"", "mass = \"2.66 kg\"", "E0405", "\"104.48712 kg\""),
        ("lower = \"-0.6 rad\"", "lower = \"0.7 rad\"", "E0405", "\"0.7 rad\""),
        ("damping = \"2 N*m*s/rad\"", "damping = \"-2 N*m*s/rad\"", "E0405", "\"-2 N*m*s/rad\""),
        ("default_position = \"0.6 rad\"", "default_position = \"4 rad\"", "E0406", "\"4 rad\""),
        ("velocity_limit = \"4.03 rad/s\"", "velocity_limit = \"4.03 rad\"", "E0203", "rad"),
    ] {
        assert_eq!(faults(from, to), [(code, place.to_owned())], "{to}");
    }
}

#[test]
fn a_joint_without_effort_limit_and_an_impossible_inertia_are_refused() {
    let codes = |from: &str, to: &str| faults(from, to).into_iter().map(|(code, _)| code).collect::<Vec<_>>();
    assert_eq!(codes("effort_limit = \"289 N*m\"\n", ""), ["E0403"]);
    // The thigh's moments are 0.0794, 0.08 and 0.009967 kg m^2.
    assert_eq!(codes("ixx = \"0.0794 kg*m^2\"", "ixx = \"0.794 kg*m^2\""), ["E0405"]);
    assert_eq!(codes("ixx = \"0.0794 kg*m^2\"", "ixx = \"-0.01 kg*m^2\""), ["E0405"]);
    // A left hip moved 20 cm to the side has no mirror image; neither have the joints below it.
    assert_eq!(codes("origin = [\"0.11 m\", \"0.1025 m\"", "origin = [\"0.11 m\", \"0.2 m\""), ["E0405"]);
}

#[test]
fn several_mistakes_are_reported_together() {
    let knee = "effort_limit = \"289 N*m\"\nvelocity_limit = \"4.03 rad/s\"\n";
    let text = embedded("tocabi").unwrap().replace(knee, "velocity_limit = \"4.03 rad/s\"\n");
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add("tocabi.toml", text.as_str());
    assert_eq!(load("tocabi", &sources, source, &mut sink), None);
    assert_eq!(sink.diagnostics.iter().map(|found| found.code).collect::<Vec<_>>(), ["E0403", "E0403"]);
}

#[test]
fn a_load_moves_the_centre_of_mass_and_adds_its_own_moment() {
    let mut base = robot("tocabi").base;
    (base.mass, base.com, base.inertia) = (3.0, nalgebra::Point3::origin(), nalgebra::Matrix3::identity());
    base.load(1.0, nalgebra::Point3::new(0.0, 0.0, 4.0));
    assert_eq!((base.mass, base.com.z), (4.0, 1.0));
    // 3 kg at 1 m and 1 kg at 3 m from the new centre: 12 kg m^2 about x and y, nothing about z.
    assert_eq!((base.inertia[(0, 0)], base.inertia[(1, 1)], base.inertia[(2, 2)]), (13.0, 13.0, 1.0));
    base.load(0.0, nalgebra::Point3::new(9.0, 0.0, 0.0));
    assert_eq!(base.com.x, 0.0);
}
