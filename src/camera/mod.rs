//! Camera models: the one list of them, their names and parameters.
//!
//! Knows nothing of images, files or scenes. Pixels follow COLMAP: the centre of the first one is (0.5, 0.5).

mod error;
mod grid;
pub mod laws;
mod lens;
mod param;
mod polynomial;

use nalgebra::{Vector2, Vector3};

pub use error::{CameraError, ModelName};
pub use grid::Grid;
pub use lens::Linearized;
pub use param::{Param, ParamClass};

/// What a camera model states about itself.
///
/// A model writes its formula once, with derivatives, in `linearize`; what is not needed costs nothing when inlined.
pub trait CameraModel<const N: usize> {
    /// Its name in a cameras.txt.
    const NAME: &str;
    /// Its number in a cameras.bin; none for the models that calibstab alone has.
    const COLMAP_ID: Option<i32>;
    /// Its parameters, in file order.
    const PARAMS: [Param; N];
    /// Parameters of real and of hard lenses, on which the laws are tested.
    const EXAMPLES: &[[f64; N]];

    /// The pixel of a point in camera coordinates, and its derivatives; none where the lens does not see or its map folds.
    fn linearize(params: &[f64; N], point: &Vector3<f64>) -> Option<Linearized<N>>;

    /// The direction of what a pixel sees, of any length; none when nothing is seen there.
    fn unproject(params: &[f64; N], pixel: &Vector2<f64>) -> Option<Vector3<f64>>;

    /// The largest angle from the optical axis, in radians, that the lens sees without folding, decentring aside.
    fn largest_angle(params: &[f64; N]) -> f64;

    /// The pixel of a point in camera coordinates.
    #[inline(always)]
    fn project(params: &[f64; N], point: &Vector3<f64>) -> Option<Vector2<f64>> {
        Some(Self::linearize(params, point)?.pixel)
    }
}

/// Work to be done with whatever model a camera has: compiled once for each, so that loops inside it never ask.
pub trait Job {
    /// What it gives.
    type Output;

    /// The work.
    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> Self::Output;
}

/// A camera model, as data.
#[derive(Debug)]
pub struct Model {
    /// Its name in a cameras.txt.
    pub name: &'static str,
    /// Its number in a cameras.bin; none for the models that calibstab alone has.
    pub colmap_id: Option<i32>,
    /// Its parameters, in file order.
    pub params: &'static [Param],
    build: fn(&[f64]) -> Option<Intrinsics>,
}

/// Makes the list: the module, the type and the enum variant of every model, from one line each.
macro_rules! models {
    ($($file:ident :: $Model:ident [$n:literal]),+ $(,)?) => {
        $(
            mod $file;
            #[doc = concat!("The model of this name; `camera/", stringify!($file), ".rs` says what it is.")]
            pub struct $Model;

            impl $Model {
                const MODEL: Model = Model {
                    name: $Model::NAME,
                    colmap_id: $Model::COLMAP_ID,
                    params: &$Model::PARAMS,
                    build: |params| Some(Intrinsics::$Model(params.try_into().ok()?)),
                };
            }
        )+

        /// A camera model with its parameters, in file order.
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[allow(missing_docs)] // each variant is the model type of the same name
        pub enum Intrinsics {
            $($Model([f64; $n]),)+
        }

        /// Every example of every model.
        #[cfg(test)]
        fn examples() -> Vec<Intrinsics> {
            let mut all = Vec::new();
            $(all.extend($Model::EXAMPLES.iter().map(|params| Intrinsics::$Model(*params)));)+
            all
        }

        /// Every camera model, COLMAP's first, in the order of their ids.
        pub static MODELS: &[Model] = &[$($Model::MODEL),+];

        impl Intrinsics {
            /// The model these parameters belong to.
            pub fn model(&self) -> &'static Model {
                match self {
                    $(Self::$Model(_) => &$Model::MODEL,)+
                }
            }

            /// Does work with this model and these parameters.
            pub fn visit<J: Job>(&self, job: J) -> J::Output {
                match self {
                    $(Self::$Model(params) => job.run::<$Model, $n>(params),)+
                }
            }

            /// The parameters, in file order.
            pub fn params(&self) -> &[f64] {
                match self {
                    $(Self::$Model(params) => params,)+
                }
            }
        }
    };
}

models! {
    simple_pinhole::SimplePinhole[3],
    pinhole::Pinhole[4],
    simple_radial::SimpleRadial[4],
    radial::Radial[5],
    opencv::OpenCv[8],
    opencv_fisheye::OpenCvFisheye[8],
    full_opencv::FullOpenCv[12],
    fov::Fov[5],
    simple_radial_fisheye::SimpleRadialFisheye[4],
    radial_fisheye::RadialFisheye[5],
    thin_prism_fisheye::ThinPrismFisheye[12],
    rad_tan_thin_prism_fisheye::RadTanThinPrismFisheye[16],
    simple_division::SimpleDivision[4],
    division::Division[5],
    simple_fisheye::SimpleFisheye[3],
    fisheye::Fisheye[4],
    eucm::Eucm[6],
    equirectangular::Equirectangular[2],
    rad_tan::RadTan[9],
    ucm::Ucm[5],
    double_sphere::DoubleSphere[6],
    f_theta::FTheta[6],
    bal_pinhole::BalPinhole[6],
    bal_strict::BalStrict[3],
}

impl Model {
    /// The model of this name.
    pub fn named(name: &str) -> Result<&'static Self, CameraError> {
        MODELS
            .iter()
            .find(|model| model.name == name)
            .ok_or_else(|| CameraError::UnknownModel(ModelName::Text(name.to_owned())))
    }

    /// The model of this number in a cameras.bin.
    pub fn with_colmap_id(id: i32) -> Result<&'static Self, CameraError> {
        MODELS
            .iter()
            .find(|model| model.colmap_id == Some(id))
            .ok_or(CameraError::UnknownModel(ModelName::Id(id)))
    }

    /// This model with these parameters, in file order: as many as it has, each finite.
    pub fn with_params(&self, params: &[f64]) -> Result<Intrinsics, CameraError> {
        let want = self.params.len();
        let count = CameraError::ParamCount { model: self.name, want, got: params.len() };
        let intrinsics = (self.build)(params).ok_or(count)?;
        for (param, &value) in self.params.iter().zip(params) {
            if !value.is_finite() {
                return Err(CameraError::not_finite(param, value));
            }
        }
        Ok(intrinsics)
    }
}

impl Intrinsics {
    /// The pixel of a point in camera coordinates; the first pixel's centre is (0.5, 0.5).
    pub fn project(&self, point: &Vector3<f64>) -> Result<Vector2<f64>, CameraError> {
        self.visit(Project(point)).ok_or_else(|| self.why_unseen(point))
    }

    /// The unit ray, in camera coordinates, of what a pixel sees.
    pub fn unproject(&self, pixel: &Vector2<f64>) -> Result<Vector3<f64>, CameraError> {
        let unseen = || CameraError::PointOutsideImage { x: pixel.x, y: pixel.y };
        let ray = self.visit(Unproject(pixel)).ok_or_else(unseen)?;
        ray.try_normalize(0.0).ok_or_else(unseen)
    }

    /// The largest angle from the optical axis, in radians, that the lens sees without folding, decentring aside.
    pub fn largest_angle(&self) -> f64 {
        self.visit(LargestAngle)
    }

    fn why_unseen(&self, point: &Vector3<f64>) -> CameraError {
        let looks_back = self.visit(Project(&Vector3::z())).is_none();
        let z = if looks_back { -point.z } else { point.z };
        if point.norm_squared() <= 0.0 {
            CameraError::PointAtCameraCenter
        } else if z <= 0.0 && self.largest_angle() <= std::f64::consts::FRAC_PI_2 {
            CameraError::PointBehindCamera { z, min_z: 0.0 }
        } else {
            CameraError::ProjectionOutOfBounds
        }
    }
}

struct Project<'a>(&'a Vector3<f64>);

impl Job for Project<'_> {
    type Output = Option<Vector2<f64>>;

    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> Self::Output {
        M::project(params, self.0)
    }
}

struct Unproject<'a>(&'a Vector2<f64>);

impl Job for Unproject<'_> {
    type Output = Option<Vector3<f64>>;

    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> Self::Output {
        M::unproject(params, self.0)
    }
}

struct LargestAngle;

impl Job for LargestAngle {
    type Output = f64;

    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> f64 {
        M::largest_angle(params)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ids_of_colmap_are_0_to_17_in_order() {
        let ids: Vec<i32> = MODELS.iter().filter_map(|model| model.colmap_id).collect();
        assert_eq!(ids, (0..18).collect::<Vec<i32>>());
    }

    #[test]
    fn names_of_models_and_of_their_parameters_are_unique() {
        for (index, model) in MODELS.iter().enumerate() {
            assert!(MODELS[..index].iter().all(|other| other.name != model.name));
            for (at, param) in model.params.iter().enumerate() {
                assert!(model.params[..at].iter().all(|p| p.name != param.name), "{}", model.name);
            }
        }
    }

    #[test]
    fn every_model_takes_its_own_count_of_parameters_and_no_other() {
        for model in MODELS {
            let params = vec![0.5; model.params.len()];
            let made = model.with_params(&params).unwrap();
            assert_eq!(made.model().name, model.name);
            assert_eq!(made.params(), params);
            for got in [params.len() - 1, params.len() + 1] {
                let error = model.with_params(&vec![0.5; got]).unwrap_err();
                let want = params.len();
                assert_eq!(error, CameraError::ParamCount { model: model.name, want, got });
            }
        }
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
            params[index] = before;
        }
    }

    #[test]
    fn the_thesis_camera_folds_inside_its_own_image() {
        let params = [1011.91, 640.0, 480.0, -0.241569];
        let camera = Model::named("SIMPLE_RADIAL").unwrap().with_params(&params).unwrap();
        // 1 + 3 k r^2 = 0 at r = 1 / sqrt(-3 k), where the image radius f r (1 + k r^2) = f r 2/3 is 792.4 px
        let fold = camera.largest_angle().tan();
        assert!((1011.91 * fold * 2.0 / 3.0 - 792.4).abs() < 0.05, "{fold}");
        assert!(camera.unproject(&Vector2::new(640.0 + 792.3, 480.0)).is_ok());
        let corner = camera.unproject(&Vector2::new(0.0, 0.0)).unwrap_err();
        assert_eq!(corner, CameraError::PointOutsideImage { x: 0.0, y: 0.0 });
    }

    #[test]
    fn what_is_not_seen_is_told_why() {
        let camera =
            |name: &str, params: &[f64]| Model::named(name).unwrap().with_params(params).unwrap();
        let pinhole = camera("SIMPLE_PINHOLE", &[500.0, 320.0, 240.0]);
        let why =
            |camera: &Intrinsics, x, y, z| camera.project(&Vector3::new(x, y, z)).unwrap_err();
        let behind = CameraError::PointBehindCamera { z: -2.0, min_z: 0.0 };
        assert_eq!(why(&pinhole, 0.0, 1.0, -2.0), behind);
        assert_eq!(why(&pinhole, 0.0, 0.0, 0.0), CameraError::PointAtCameraCenter);
        let radial = camera("SIMPLE_RADIAL", &[500.0, 320.0, 240.0, -0.3]);
        assert_eq!(why(&radial, 3.0, 0.0, 1.0), CameraError::ProjectionOutOfBounds);
        let back = camera("BAL_STRICT", &[500.0, 0.0, 0.0]);
        assert_eq!(why(&back, 0.0, 1.0, 2.0), behind);
        assert!(back.project(&Vector3::new(0.0, 1.0, -2.0)).is_ok());
    }

    #[test]
    fn an_unknown_name_suggests_a_near_one() {
        let message = |name| Model::named(name).unwrap_err().to_string();
        assert!(message("OPENCV_FISHEY").ends_with("did you mean OPENCV_FISHEYE?"));
        assert!(message("opencv").ends_with("did you mean OPENCV?"));
        assert!(!message("banana").contains("did you mean"));
    }
}
