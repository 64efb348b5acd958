//! Whether parameters are those of a lens, and why a point is not seen.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use super::{CameraError, CameraModel, Intrinsics, Job, ParamClass, Project};

impl Intrinsics {
    /// Whether these are the parameters of a lens: focal lengths above zero, and the others within the range that their model
    /// states ([`Param::range`](super::Param::range)). Files hold other ones, and are read: this is how to flag them.
    pub fn validate(&self) -> Result<(), CameraError> {
        let params = || self.model().params.iter().zip(self.params().iter().copied());
        if let Some((param, value)) = params().find(|(_, value)| !value.is_finite()) {
            return Err(CameraError::not_finite(param, value));
        }
        let mut focals = params().filter(|(param, _)| param.class == ParamClass::Focal);
        if let Some((_, fx)) = focals.next() {
            let fy = focals.next().map_or(fx, |(_, fy)| fy);
            if fx <= 0.0 || fy <= 0.0 {
                return Err(CameraError::FocalLengthNotPositive { fx, fy });
            }
        }
        for (param, value) in params() {
            let [min, max] = param.range;
            if value < min || value > max {
                return Err(CameraError::ParameterOutOfRange {
                    param: param.name,
                    value,
                    min,
                    max,
                });
            }
        }
        Ok(())
    }

    /// Why this camera does not see a point.
    pub(super) fn why_unseen(&self, point: &Vector3<f64>) -> CameraError {
        let looks_back = self.visit(Project(&Vector3::z())).is_none();
        let z = if looks_back { -point.z } else { point.z };
        let Some(direction) = point.try_normalize(0.0) else {
            return CameraError::PointAtCameraCenter;
        };
        match self.visit(Denominator(&direction)) {
            Some(value) if value <= 0.0 => CameraError::DenominatorTooSmall { value },
            _ if z <= 0.0 && self.largest_angle() <= FRAC_PI_2 => {
                CameraError::PointBehindCamera { z, min_z: 0.0 }
            }
            _ => CameraError::ProjectionOutOfBounds,
        }
    }
}

struct Denominator<'a>(&'a Vector3<f64>);

impl Job for Denominator<'_> {
    type Output = Option<f64>;

    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> Self::Output {
        M::denominator(params, self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::hold;
    use super::super::{MODELS, Model};
    use super::*;

    fn camera(name: &str, params: &[f64]) -> Intrinsics {
        Model::named(name).unwrap().with_params(params).unwrap()
    }

    #[test]
    fn a_parameter_that_is_no_number_is_refused_by_its_class() {
        let model = Model::named("OPENCV").unwrap();
        let mut params = [500.0, 500.0, 320.0, 240.0, 0.1, 0.1, 0.0, 0.0];
        for (index, want) in [
            (1, CameraError::FocalLengthNotFinite),
            (2, CameraError::PrincipalPointNotFinite),
            (5, CameraError::DistortionNotFinite { name: "k2", value: f64::INFINITY }),
        ] {
            let before = std::mem::replace(&mut params[index], f64::INFINITY);
            assert_eq!(model.with_params(&params).unwrap_err(), want);
            assert_eq!(Intrinsics::OpenCv(params).validate().unwrap_err(), want);
            params[index] = before;
        }
    }

    #[test]
    fn every_example_is_a_lens() {
        hold(|example| usize::from(example.validate() == Ok(())), 2);
        let [examples, lenses] = [|_: &Intrinsics| true, |e: &Intrinsics| e.validate().is_ok()]
            .map(|law| super::super::examples().iter().filter(|example| law(example)).count());
        assert_eq!(examples, lenses);
    }

    #[test]
    fn every_focal_length_must_be_positive_and_is_read_when_it_is_not() {
        let mut count = 0;
        for example in super::super::examples() {
            let model = example.model();
            for index in
                (0..model.params.len()).filter(|&i| model.params[i].class == ParamClass::Focal)
            {
                for value in [0.0, -500.0] {
                    let mut params = example.params().to_vec();
                    params[index] = value;
                    let error = model.with_params(&params).unwrap().validate().unwrap_err();
                    let CameraError::FocalLengthNotPositive { fx, fy } = error else {
                        panic!("{}: {error}", model.name)
                    };
                    assert!(fx.min(fy) <= 0.0);
                    assert!(error.to_string().contains(&value.to_string()), "{error}");
                    count += 1;
                }
            }
        }
        assert!(count >= 2 * MODELS.len(), "{count}");
    }

    #[test]
    fn a_parameter_outside_its_range_is_told_with_the_range() {
        let message =
            |name, params: &[f64]| camera(name, params).validate().unwrap_err().to_string();
        let pinhole = [500.0, 490.0, 320.0, 240.0];
        for (name, extra, want) in [
            ("UCM", vec![1.2], "alpha is 1.2, and must be from 0 to 1"),
            ("UCM", vec![-0.1], "alpha is -0.1, and must be from 0 to 1"),
            ("EUCM", vec![1.5, 1.0], "alpha is 1.5, and must be from 0 to 1"),
            ("EUCM", vec![0.5, 0.0], "beta is 0, and must be above 0"),
            ("EUCM", vec![0.5, -2.0], "beta is -2, and must be above 0"),
            ("DOUBLE_SPHERE", vec![-1.5, 0.5], "xi is -1.5, and must be from -1 to 1"),
            ("DOUBLE_SPHERE", vec![0.1, 2.0], "alpha is 2, and must be from 0 to 1"),
            (
                "FOV",
                vec![4.0],
                "omega is 4, and must be from -3.141592653589793 to 3.141592653589793",
            ),
        ] {
            assert_eq!(message(name, &[&pinhole[..], &extra].concat()), want);
        }
        assert_eq!(message("EQUIRECTANGULAR", &[0.0, 5.0]), "w is 0, and must be above 0");
        assert_eq!(message("EQUIRECTANGULAR", &[5.0, -1.0]), "h is -1, and must be above 0");
        let error = camera("UCM", &[500.0, 490.0, 320.0, 240.0, 1.2]).validate().unwrap_err();
        let want =
            CameraError::ParameterOutOfRange { param: "alpha", value: 1.2, min: 0.0, max: 1.0 };
        assert_eq!(error, want);
    }

    #[test]
    fn what_is_not_seen_is_told_why() {
        let pinhole = camera("SIMPLE_PINHOLE", &[500.0, 320.0, 240.0]);
        let why =
            |camera: &Intrinsics, x, y, z| camera.project(&Vector3::new(x, y, z)).unwrap_err();
        let behind = CameraError::PointBehindCamera { z: -2.0, min_z: 0.0 };
        assert_eq!(why(&pinhole, 0.0, 1.0, -2.0), behind);
        let text = "the point is behind the camera: its z is -2, and must be above 0";
        assert_eq!(behind.to_string(), text);
        assert_eq!(why(&pinhole, 0.0, 0.0, 0.0), CameraError::PointAtCameraCenter);
        let radial = camera("SIMPLE_RADIAL", &[500.0, 320.0, 240.0, -0.3]);
        assert_eq!(why(&radial, 3.0, 0.0, 1.0), CameraError::ProjectionOutOfBounds);
        let back = camera("BAL_STRICT", &[500.0, 0.0, 0.0]);
        assert_eq!(why(&back, 0.0, 1.0, 2.0), behind);
        assert!(back.project(&Vector3::new(0.0, 1.0, -2.0)).is_ok());
    }

    #[test]
    fn a_denominator_that_vanishes_is_told_with_its_value() {
        let mut rational = [500.0, 490.0, 320.0, 240.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.5, 0.0, 0.0];
        for (camera, point, value) in [
            // alpha + (1 - alpha) z of a unit vector
            (camera("UCM", &[500.0, 490.0, 320.0, 240.0, 0.3]), [0.0, 0.6, -0.8], 0.3 - 0.7 * 0.8),
            // alpha sqrt(beta rho^2 + z^2) + (1 - alpha) z
            (
                camera("EUCM", &[500.0, 490.0, 320.0, 240.0, 0.25, 4.0]),
                [0.6, 0.0, -0.8],
                0.25 * (4.0_f64 * 0.36 + 0.64).sqrt() - 0.75 * 0.8,
            ),
            // xi = 0: the same with beta = 1
            (
                camera("DOUBLE_SPHERE", &[500.0, 490.0, 320.0, 240.0, 0.0, 0.25]),
                [0.6, 0.0, -0.8],
                0.25 - 0.75 * 0.8,
            ),
            // 1 - r^2 / 2 at r^2 = 3^2
            (camera("FULL_OPENCV", &rational), [3.0, 0.0, 1.0], 1.0 - 4.5),
        ] {
            let error = camera.project(&(Vector3::from(point) * 2.0)).unwrap_err();
            let CameraError::DenominatorTooSmall { value: found } = error else {
                panic!("{camera:?}: {error}")
            };
            assert!((found - value).abs() < 1e-12, "{camera:?}: {found}, not {value}");
            let text = format!("projecting divides by {found}, which must be above 0");
            assert_eq!(error.to_string(), text);
        }
        // r / (1 + r^2 / 2) folds at sqrt(2) over a denominator that is never zero.
        rational[9] = 0.5;
        let error = camera("FULL_OPENCV", &rational).project(&Vector3::new(3.0, 0.0, 1.0));
        assert_eq!(error.unwrap_err(), CameraError::ProjectionOutOfBounds);
    }
}
