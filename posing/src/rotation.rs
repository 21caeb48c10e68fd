//! Rotations: axis-angle, quaternions and the continuous six-number form.

use glam::{Mat3, Quat, Vec3};

/// Unit quaternion of an axis-angle vector (radians). The zero vector is the identity.
pub fn quat_from_axis_angle(axis_angle: Vec3) -> Quat {
    let angle = axis_angle.length();
    if angle < 1e-8 {
        return Quat::IDENTITY;
    }
    Quat::from_axis_angle(axis_angle / angle, angle)
}

/// Axis-angle vector (radians, length at most π) of a unit quaternion.
pub fn axis_angle_from_quat(rotation: Quat) -> Vec3 {
    let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
    let sine = rotation.xyz().length();
    if sine < 1e-8 {
        return 2.0 * rotation.xyz();
    }
    rotation.xyz() * (2.0 * sine.atan2(rotation.w) / sine)
}

/// First two columns of the rotation matrix (x column, then y column): a form without jumps, for regression.
pub fn six_numbers_from_quat(rotation: Quat) -> [f32; 6] {
    let matrix = Mat3::from_quat(rotation);
    let (x, y) = (matrix.x_axis, matrix.y_axis);
    [x.x, x.y, x.z, y.x, y.y, y.z]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axis_angle_round_trip_keeps_angles_up_to_pi() {
        for vector in [Vec3::ZERO, Vec3::new(1e-6, 0.0, 0.0), Vec3::new(0.3, -1.2, 0.7), Vec3::new(0.0, 3.1, 0.0)] {
            let back = axis_angle_from_quat(quat_from_axis_angle(vector));
            assert!((back - vector).length() < 1e-5, "{vector} came back as {back}");
        }
    }

    #[test]
    fn angles_beyond_pi_come_back_as_the_same_rotation() {
        let vector = Vec3::new(0.0, 4.0, 0.0);
        let back = axis_angle_from_quat(quat_from_axis_angle(vector));
        assert!((back.y - (4.0 - std::f32::consts::TAU)).abs() < 1e-5);
    }

    #[test]
    fn six_numbers_are_the_first_two_columns() {
        let six = six_numbers_from_quat(Quat::from_rotation_z(std::f32::consts::FRAC_PI_2));
        for (got, expected) in six.iter().zip([0.0, 1.0, 0.0, -1.0, 0.0, 0.0]) {
            assert!((got - expected).abs() < 1e-6);
        }
    }
}
