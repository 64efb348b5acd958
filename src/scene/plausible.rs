//! Cameras that no real lens has: what a wrong basin of an adjustment looks like.

use super::Camera;
use crate::camera::ParamClass;

/// COLMAP's bounds of a plausible focal length, in units of the larger image side.
const FOCAL_RATIO: std::ops::RangeInclusive<f64> = 0.1..=10.0;
/// COLMAP bounds no fx / fy; but pixels are square and anamorphic lenses squeeze by 2 at most, and repeats on real data that fell into
/// a wrong basin have 0.4 and 2.6.
const ASPECT_RATIO: std::ops::RangeInclusive<f64> = 0.5..=2.0;
/// COLMAP's bound of a plausible distortion coefficient.
const LARGEST_COEFFICIENT: f64 = 1.0;

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
        (!reasons.is_empty()).then(|| reasons.join(", "))
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
