//! How much of the world an image shows.

use nalgebra::{Vector2, Vector3};

use super::Intrinsics;
use super::lens::largest;

/// Angles in radians between what the ends of three lines see: of the row and the column through the principal point, and of
/// the longer diagonal. Where a line's end has no ray, the last pixel before it counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldOfView {
    /// From the left side to the right.
    pub horizontal: f64,
    /// From the top to the bottom.
    pub vertical: f64,
    /// From corner to corner.
    pub diagonal: f64,
}

impl Intrinsics {
    /// The direction in which the camera looks: Z, or -Z where it does not see along Z.
    pub fn optical_axis(&self) -> Vector3<f64> {
        if self.project(&Vector3::z()).is_ok() { Vector3::z() } else { -Vector3::z() }
    }

    /// The angle in radians between the optical axis and a ray.
    pub fn angle_from_axis(&self, ray: &Vector3<f64>) -> f64 {
        ray.xy().norm().atan2(ray.dot(&self.optical_axis()))
    }

    /// How much an image of this size shows; none where the lens does not see along its axis.
    pub fn field_of_view(&self, width: u64, height: u64) -> Option<FieldOfView> {
        let centre = self.project(&self.optical_axis()).ok()?;
        let (right, bottom) = (width as f64, height as f64);
        let between = |from: Vector2<f64>, to: Vector2<f64>| {
            // Both ends on one side of the axis see the difference of their angles.
            let away = (from - centre).dot(&(to - centre)) > 0.0;
            let [from, to] = [from, to].map(|end| self.last_angle(&centre, &end));
            if away { (to - from).abs() } else { from + to }
        };
        let corner = |x, y| Vector2::new(x, y);
        Some(FieldOfView {
            horizontal: between(corner(0.0, centre.y), corner(right, centre.y)),
            vertical: between(corner(centre.x, 0.0), corner(centre.x, bottom)),
            diagonal: between(corner(0.0, 0.0), corner(right, bottom))
                .max(between(corner(right, 0.0), corner(0.0, bottom))),
        })
    }

    /// The angle from the axis of the last ray on the way from the principal point to a pixel.
    fn last_angle(&self, centre: &Vector2<f64>, end: &Vector2<f64>) -> f64 {
        let ray = |share: f64| self.unproject(&centre.lerp(end, share));
        let share = largest(1.0, |share| ray(share).is_ok());
        ray(share).map_or(0.0, |ray| self.angle_from_axis(&ray))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Model;
    use super::*;

    fn degrees(name: &str, params: &[f64], width: u64, height: u64) -> [f64; 3] {
        let camera = Model::named(name).unwrap().with_params(params).unwrap();
        let FieldOfView { horizontal, vertical, diagonal } =
            camera.field_of_view(width, height).unwrap();
        [horizontal, vertical, diagonal].map(f64::to_degrees)
    }

    #[test]
    fn the_view_is_as_wide_as_trigonometry_says() {
        let atan = |tangent: f64| tangent.atan().to_degrees();
        let corner = 320.0_f64.hypot(240.0);
        for (name, params, size, want) in [
            (
                "PINHOLE",
                vec![400.0, 300.0, 320.0, 240.0],
                (640, 480),
                [2.0 * atan(0.8), 2.0 * atan(0.8), 2.0 * atan(0.8 * 2.0_f64.sqrt())],
            ),
            // The principal point off the centre, then outside the image.
            (
                "SIMPLE_PINHOLE",
                vec![400.0, 100.0, 240.0],
                (640, 480),
                [
                    atan(0.25) + atan(1.35),
                    2.0 * atan(0.6),
                    atan(0.65) + atan(540.0_f64.hypot(240.0) / 400.0),
                ],
            ),
            (
                "SIMPLE_PINHOLE",
                vec![400.0, -400.0, -400.0],
                (400, 400),
                [
                    atan(2.0) - atan(1.0),
                    atan(2.0) - atan(1.0),
                    atan(8.0_f64.sqrt()) - atan(2.0_f64.sqrt()),
                ],
            ),
            // Looks along -Z.
            (
                "BAL_PINHOLE",
                vec![400.0, 300.0, 320.0, 240.0, 0.0, 0.0],
                (640, 480),
                [2.0 * atan(0.8), 2.0 * atan(0.8), 2.0 * atan(0.8 * 2.0_f64.sqrt())],
            ),
            // Beyond 180 degrees.
            (
                "SIMPLE_FISHEYE",
                vec![200.0, 320.0, 240.0],
                (640, 480),
                [3.2, 2.4, corner / 100.0].map(f64::to_degrees),
            ),
            // The corners are dark: 640 px are 3.2 times 180 degrees.
            (
                "SIMPLE_FISHEYE",
                vec![100.0, 320.0, 240.0],
                (640, 480),
                [360.0, 4.8_f64.to_degrees(), 360.0],
            ),
        ] {
            let found = degrees(name, &params, size.0, size.1);
            // The dark corners begin where a double nears pi.
            let off = found.iter().zip(&want).any(|(found, want)| (found - want).abs() > 1e-6);
            assert!(!off, "{name} {params:?}: {found:?}, not {want:?}");
        }
        let [wide, high, _] = degrees("EQUIRECTANGULAR", &[2000.0, 1000.0], 2000, 1000);
        assert!((wide - 360.0).abs() < 1e-6 && (high - 180.0).abs() < 1e-6, "{wide} {high}");
    }
}
