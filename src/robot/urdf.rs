//! URDF text of a robot. What URDF cannot express (armature, gains, default pose) is in comments next to the
//! joint.

use std::fmt::Write;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::model::{Body, Collision, Foot, Joint, Robot, Shape};
use crate::escape::xml::attribute;

/// The URDF document: SI units, the floating base as the root link.
pub fn document(robot: &Robot) -> String {
    let mut writer = Writer { text: String::with_capacity(32 * 1024) };
    writer.line(format_args!("<?xml version=\"1.0\"?>"));
    writer.line(format_args!("<robot name=\"{}\">", attribute(&robot.name)));
    writer.link(&robot.base, None);
    for (index, link) in robot.links.iter().enumerate() {
        writer.link(&link.body, robot.feet.iter().find(|foot| foot.link == index));
        let parent = link.parent.map_or(&robot.base, |parent| &robot.links[parent].body);
        writer.joint(&link.joint, &parent.name, &link.body.name);
    }
    writer.line(format_args!("</robot>"));
    writer.text
}

struct Writer {
    text: String,
}

impl Writer {
    fn line(&mut self, line: std::fmt::Arguments) {
        self.text.write_fmt(line).expect("writing to a String cannot fail");
        self.text.push('\n');
    }

    /// A link; a foot has its sole instead of other shapes, as in every engine.
    fn link(&mut self, body: &Body, foot: Option<&Foot>) {
        let i = &body.inertia;
        self.line(format_args!("  <link name=\"{}\">", attribute(&body.name)));
        self.line(format_args!("    <inertial>"));
        self.line(format_args!("      <origin xyz=\"{}\"/>", triple(&body.com.coords)));
        self.line(format_args!("      <mass value=\"{}\"/>", body.mass));
        self.line(format_args!(
            "      <inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/>",
            i.m11, i.m12, i.m13, i.m22, i.m23, i.m33
        ));
        self.line(format_args!("    </inertial>"));
        match foot {
            Some(foot) => {
                let sole = Shape::Box(foot.half_extents);
                self.shape(&Collision {
                    shape: sole,
                    pose: Isometry3::translation(foot.centre.x, foot.centre.y, foot.centre.z),
                });
            }
            None => body.collisions.iter().for_each(|collision| self.shape(collision)),
        }
        self.line(format_args!("  </link>"));
    }

    fn shape(&mut self, collision: &Collision) {
        let geometry = match &collision.shape {
            Shape::Box(half) => format!("<box size=\"{}\"/>", triple(&(2.0 * half))),
            Shape::Capsule(half, radius) => {
                format!("<capsule radius=\"{radius}\" length=\"{}\"/>", 2.0 * half)
            }
            Shape::Cylinder(half, radius) => {
                format!("<cylinder radius=\"{radius}\" length=\"{}\"/>", 2.0 * half)
            }
            Shape::Sphere(radius) => format!("<sphere radius=\"{radius}\"/>"),
        };
        let origin = origin(&collision.pose);
        self.line(format_args!("    <collision>{origin}<geometry>{geometry}</geometry></collision>"));
    }

    fn joint(&mut self, joint: &Joint, parent: &str, child: &str) {
        let Joint { lower, upper, effort_limit, velocity_limit, damping, friction, .. } = joint;
        let Joint { armature, stiffness_gain, damping_gain, default_position, .. } = joint;
        self.line(format_args!("  <joint name=\"{}\" type=\"revolute\">", attribute(&joint.name)));
        self.line(format_args!("    {}", origin(&joint.origin)));
        self.line(format_args!("    <parent link=\"{}\"/>", attribute(parent)));
        self.line(format_args!("    <child link=\"{}\"/>", attribute(child)));
        self.line(format_args!("    <axis xyz=\"{}\"/>", triple(&joint.axis)));
        self.line(format_args!(
            "    <limit \
             lower=\"{lower}\" upper=\"{upper}\" effort=\"{effort_limit}\" velocity=\"{velocity_limit}\"/>"
        ));
        self.line(format_args!("    <dynamics damping=\"{damping}\" friction=\"{friction}\"/>"));
        self.line(format_args!(
            "    <!-- armature {armature} kg*m^2, gains {stiffness_gain} N*m/rad and {damping_gain} \
             N*m*s/rad, \
             default position {default_position} rad -->"
        ));
        self.line(format_args!("  </joint>"));
    }
}

fn origin(pose: &Isometry3<f64>) -> String {
    // Adding zero turns -0 into 0.
    let [roll, pitch, yaw] = fixed_angles(&pose.rotation).map(|angle| angle + 0.0);
    format!("<origin xyz=\"{}\" rpy=\"{roll} {pitch} {yaw}\"/>", triple(&pose.translation.vector))
}

/// Roll, pitch and yaw in rad about the fixed axes x, y, z: the rotation is Rz(yaw) Ry(pitch) Rx(roll).
pub(super) fn fixed_angles(turn: &UnitQuaternion<f64>) -> [f64; 3] {
    let m = turn.to_rotation_matrix().into_inner();
    // The arc tangent is precise even near a pitch of 90 degrees, where the arc sine is not.
    let level = libm::hypot(m.m11, m.m21);
    let pitch = libm::atan2(-m.m31, level);
    if level > 1e-9 {
        [libm::atan2(m.m32, m.m33), pitch, libm::atan2(m.m21, m.m11)]
    } else {
        [libm::atan2(-m.m23, m.m22), pitch, 0.0]
    }
}

fn triple(vector: &Vector3<f64>) -> String {
    format!("{} {} {}", vector.x, vector.y, vector.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::Stream;

    #[test]
    fn fixed_angles_give_back_the_rotation_even_upright() {
        let mut stream = Stream::new("test/angles");
        let quarter = std::f64::consts::FRAC_PI_2;
        for pitch in [quarter, -quarter, quarter - 1e-5, quarter + 4e-6, 0.3] {
            for _ in 0..20 {
                let turn = UnitQuaternion::from_euler_angles(stream.normal(), pitch, stream.normal());
                let [roll, pitch, yaw] = fixed_angles(&turn);
                let back = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
                assert!(turn.angle_to(&back) < 1e-7, "{pitch}");
                let apart = turn.to_rotation_matrix().into_inner() - back.to_rotation_matrix().into_inner();
                assert!(apart.norm() < 1e-9, "{pitch}: {}", apart.norm());
            }
        }
    }
}
