//! Rotations as the format has them, an axis times an angle, and as quaternions (w, x, y, z).

/// The quaternion of a rotation by |v| radians about v.
pub fn quaternion(v: [f64; 3]) -> [f64; 4] {
    let angle = norm(v);
    let half = angle / 2.0;
    let scale = if angle > 0.0 { half.sin() / angle } else { 0.5 };
    let [x, y, z] = v.map(|part| part * scale);
    [half.cos(), x, y, z]
}

/// The way back, with angles from 0 to 2 pi.
pub fn angle_axis([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    let sine = norm([x, y, z]);
    let scale = if sine > 0.0 { 2.0 * sine.atan2(w) / sine } else { 2.0 };
    [x, y, z].map(|part| part * scale)
}

fn norm([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use nalgebra::{Quaternion, UnitQuaternion, Vector3};

    use super::*;

    #[test]
    fn rotations_come_back_and_are_those_of_nalgebra() {
        let mut checked = 0;
        for axis in [Vector3::x(), -Vector3::y(), Vector3::new(1.0, -2.0, 3.0).normalize()] {
            for angle in [0.0, 1e-300, 1e-17, 1e-9, 0.1, 1.0, 3.0, 3.5, 0.999 * TAU] {
                let v: [f64; 3] = (axis * angle).into();
                let [w, x, y, z] = quaternion(v);
                let back = Vector3::from(angle_axis([w, x, y, z]));
                assert!((back - Vector3::from(v)).norm() <= 4e-15 * angle, "{back} is not {v:?}");
                let ours = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
                assert!(ours.angle_to(&UnitQuaternion::from_scaled_axis(axis * angle)) < 1e-7);
                assert!((ours.norm() - 1.0).abs() < 1e-15);
                checked += 1;
            }
        }
        assert_eq!(checked, 27);
    }
}
