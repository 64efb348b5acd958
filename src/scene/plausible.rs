//! Cameras that no real lens has: what a wrong basin of an adjustment looks like.

use nalgebra::Vector2;

use super::Camera;
use crate::camera::ParamClass;

/// COLMAP's bounds of a plausible focal length, in units of the larger image side.
const FOCAL_RATIO: std::ops::RangeInclusive<f64> = 0.1..=10.0;
/// COLMAP bounds no fx / fy; but pixels are square and anamorphic lenses squeeze by 2 at most, and repeats on real data that fell into
/// a wrong basin have 0.4 and 2.6.
const ASPECT_RATIO: std::ops::RangeInclusive<f64> = 0.5..=2.0;
/// COLMAP's bound of a plausible distortion coefficient.
const LARGEST_COEFFICIENT: f64 = 1.0;

/// Between these diagonal fields of view, in degrees, are lenses: COLMAP's focal ratios in angles, up to the widest fisheye made.
const DIAGONAL_DEGREES: std::ops::RangeInclusive<f64> = 5.0..=300.0;
/// A lens that folds nearer to its axis than this, in units of the shorter image side, shows less than any fisheye's circle.
const FOLD_RATIO: f64 = 0.25;

impl Camera {
    /// Why no real lens has these intrinsics; none when one could.
    pub fn implausible(&self) -> Option<String> {
        let size = [self.width as f64, self.height as f64];
        let larger = size[0].max(size[1]);
        let params = self.intrinsics.model().params.iter().zip(self.intrinsics.params());
        // A model's principal point is its two coordinates, x before y.
        let mut sides = size.iter();
        let mut reasons: Vec<String> = Vec::new();
        let mut focals = Vec::new();
        for (param, &value) in params {
            let name = param.name;
            match param.class {
                ParamClass::Focal => {
                    focals.push(value);
                    let ratio = value / larger;
                    if !FOCAL_RATIO.contains(&ratio) {
                        reasons.push(format!("{name} is {ratio:.3} times the larger image side"));
                    }
                }
                ParamClass::PrincipalPoint => {
                    if sides.next().is_some_and(|&side| !(0.0..=side).contains(&value)) {
                        reasons.push(format!("{name} = {value:.3} px is outside the image"));
                    }
                }
                ParamClass::Extra if param.is_small && value.abs() > LARGEST_COEFFICIENT => {
                    reasons.push(format!("{name} = {value:.3} is beyond {LARGEST_COEFFICIENT}"));
                }
                ParamClass::Extra | ParamClass::Metadata => {}
            }
        }
        if let [fx, fy] = focals[..]
            && !ASPECT_RATIO.contains(&(fx / fy))
        {
            reasons.push(format!("fx / fy is {:.3}", fx / fy));
        }
        let model = self.intrinsics.model();
        if model.params.iter().any(|param| param.class == ParamClass::Extra && !param.is_small) {
            reasons.extend(self.misshapen());
        }
        (!reasons.is_empty()).then(|| reasons.join(", "))
    }

    /// What is wrong with the shape of a lens whose coefficients have no bounds of their own.
    fn misshapen(&self) -> Option<String> {
        let Some(view) = self.intrinsics.field_of_view(self.width, self.height) else {
            return Some("it sees nothing along its axis".to_owned());
        };
        let degrees = view.diagonal.to_degrees();
        if !DIAGONAL_DEGREES.contains(&degrees) {
            return Some(format!("its image shows {degrees:.1} degrees from corner to corner"));
        }
        let shorter = self.width.min(self.height) as f64;
        let ways = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]].map(Vector2::from);
        let folds = ways.iter().filter_map(|way| self.intrinsics.fold_radius_px(way));
        let nearest = folds.fold(f64::INFINITY, f64::min);
        let is_near = nearest < FOLD_RATIO * shorter;
        is_near.then(|| format!("it folds {nearest:.0} px from its principal point"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Model;

    fn camera(model: &str, params: &[f64]) -> Camera {
        let intrinsics = Model::named(model).unwrap().with_params(params).unwrap();
        Camera { intrinsics, width: 752, height: 480 }
    }

    #[test]
    fn a_plausible_camera_is_not_bogus() {
        let params = [465.7, 465.0, 376.0, 240.0, -0.27, 0.067, 0.0014, -0.0004];
        assert_eq!(camera("OPENCV", &params).implausible(), None);
        // Rational coefficients trade with each other: 12 is no fault.
        let params = [465.7, 465.0, 376.0, 240.0, 12.0, 3.0, 0.0, 0.0, 0.1, 12.3, 5.0, 0.5];
        assert_eq!(camera("FULL_OPENCV", &params).implausible(), None);
    }

    #[test]
    fn a_lens_without_small_coefficients_is_judged_by_its_view_and_its_fold() {
        let lens = |k| [465.7, 465.0, 376.0, 240.0, k];
        let mut judged = 0;
        // r / (1 + k r^2) turns back at r = 1 / sqrt(k), 85 px; r + k r^3 at 1 / sqrt(-3 k), where the pixel is at 28 px.
        for (name, params, word) in [
            ("DIVISION", lens(-0.2).to_vec(), None),
            ("DIVISION", lens(30.0).to_vec(), Some("it folds 85 px")),
            ("EUCM", [&lens(0.6)[..], &[1.1]].concat(), None),
            ("FULL_OPENCV", [&lens(-40.0)[..], &[0.0; 7]].concat(), Some("it folds 28 px")),
        ] {
            let why = camera(name, &params).implausible();
            match word {
                None => assert_eq!(why, None, "{name}"),
                Some(word) => assert!(why.as_ref().unwrap().starts_with(word), "{name}: {why:?}"),
            }
            judged += 1;
        }
        assert_eq!(judged, 4);
    }

    #[test]
    fn each_bound_of_colmap_is_checked_and_named() {
        let good = [465.7, 465.0, 376.0, 240.0, -0.27, 0.067, 0.0014, -0.0004];
        for (index, value, word) in [
            (0, 75.1, "fx is"),
            (1, 7521.0, "fy is"),
            (1, -465.0, "fy is"),
            (1, 150.0, "fx / fy"),
            (2, 752.5, "cx"),
            (3, -0.5, "cy"),
            (3, 500.0, "cy"),
            (4, -1.01, "k1"),
            (7, 1.5, "p2"),
        ] {
            let mut params = good;
            params[index] = value;
            let why = camera("OPENCV", &params).implausible().unwrap();
            assert!(why.starts_with(word), "{why}");
        }
    }
}
