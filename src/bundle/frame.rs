//! The frame in which a scene is adjusted: its centre at the origin, its size one.

use nalgebra::{Isometry3, Point3, Vector3};

use super::linearize::Placed;

/// From the scene's world to that of the adjustment: x -> scale (x - centre).
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    centre: Vector3<f64>,
    pub(super) scale: f64,
}

impl Frame {
    /// The frame for these points: medians, which far points do not move.
    pub(super) fn of(points: &[[f64; 3]]) -> Self {
        /// A median distance this much smaller than the outer points' is that of a collapsed cluster.
        const COLLAPSED: f64 = 1e-6;
        let mut sorted: Vec<f64> = Vec::new();
        let mut quantile = |values: &mut dyn Iterator<Item = f64>, share: f64| {
            sorted.clear();
            sorted.extend(values.filter(|value| value.is_finite()));
            let last = sorted.len().saturating_sub(1);
            // Of two values the lower: any of them serves.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            // a share of a length
            let at = (share * last as f64) as usize;
            if sorted.is_empty() {
                0.0
            } else {
                *sorted.select_nth_unstable_by(at, f64::total_cmp).1
            }
        };
        let axis = |axis: usize| points.iter().map(move |point| point[axis]);
        let centre = Vector3::from([0, 1, 2].map(|at| quantile(&mut axis(at), 0.5)));
        let distance = |point: &[f64; 3]| (Vector3::from(*point) - centre).norm();
        let [middle, outer] =
            [0.5, 0.9].map(|share| quantile(&mut points.iter().map(distance), share));
        let size = if middle > COLLAPSED * outer { middle } else { outer };
        let scale = if size > 0.0 && (1.0 / size).is_finite() { 1.0 / size } else { 1.0 };
        Self { centre, scale }
    }

    pub(super) fn point_in(&self, point: [f64; 3]) -> Vector3<f64> {
        (Vector3::from(point) - self.centre) * self.scale
    }

    pub(super) fn point_out(&self, point: &Vector3<f64>) -> [f64; 3] {
        (point / self.scale + self.centre).into()
    }

    pub(super) fn pose_in(&self, pose: &Isometry3<f64>) -> Placed {
        let centre_seen = pose.transform_point(&Point3::from(self.centre)).coords;
        Placed::new(pose.rotation, centre_seen * self.scale)
    }

    pub(super) fn pose_out(&self, pose: &Placed) -> Isometry3<f64> {
        let translation = pose.translation / self.scale - pose.turn * self.centre;
        Isometry3::from_parts(translation.into(), pose.turn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    #[test]
    fn what_goes_in_comes_out_where_it_was() {
        let points =
            [[1e3, -2e3, 5.0], [1e3 + 1.0, -2e3, 7.0], [1e3, -2e3 + 4.0, 5.0], [1e9, 0.0, 0.0]];
        let frame = Frame::of(&points);
        assert!(frame.scale > 0.1 && frame.scale < 10.0, "{frame:?}");
        let turn = UnitQuaternion::from_euler_angles(0.3, -1.0, 2.0);
        let pose = Isometry3::from_parts(Vector3::new(4.0, 5.0, 6.0).into(), turn);
        let back = frame.pose_out(&frame.pose_in(&pose));
        assert!((back.translation.vector - pose.translation.vector).norm() < 1e-11);
        for point in points {
            let inside = frame.point_in(point);
            let out = Vector3::from(frame.point_out(&inside));
            assert!((out - Vector3::from(point)).norm() <= 1e-15 * out.norm(), "{point:?}");
            // Seen from the camera it is where it was, but for the scale.
            let seen = pose.transform_point(&Point3::from(point)).coords * frame.scale;
            assert!(
                (frame.pose_in(&pose).see(&inside) - seen).norm() < 1e-12 * (1.0 + seen.norm())
            );
        }
    }

    #[test]
    fn a_collapsed_cluster_does_not_set_the_scale() {
        let mut points = vec![[0.0, 0.0, 1e-12]; 60];
        points.extend((0..40).map(|at| [5.0 * f64::from(at % 3), f64::from(at % 5), 1.0]));
        let scale = Frame::of(&points).scale;
        assert!(scale > 0.01 && scale < 10.0, "{scale}");
        assert!(Frame::of(&[]).scale > 0.0);
    }
}
