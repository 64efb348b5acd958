//! Camera models: the one list of them, their names and parameters.
//!
//! Knows nothing of images, files or scenes. Pixels follow COLMAP: the centre of the first one is (0.5, 0.5).

mod batch;
mod error;
mod estimate;
mod field_of_view;
mod grid;
pub mod laws;
mod lens;
pub mod param;
mod polynomial;
mod pose;
#[cfg(test)]
mod testing;
mod valid_set;
mod validity;

use std::f64::consts::PI;

use nalgebra::{SMatrix, Vector2, Vector3};

pub use batch::LinearizedSlices;
pub use error::{CameraError, ModelName};
pub use estimate::Pair;
pub use field_of_view::FieldOfView;
pub use grid::Grid;
pub use lens::Linearized;
pub use param::{Param, ParamClass};

/// What a camera model states about itself.
///
/// A model writes its formula once, with derivatives, in `linearize`; what is not needed costs nothing when inlined.
pub trait CameraModel<const N: usize>: Sized {
    /// Its name in a cameras.txt.
    const NAME: &str;
    /// Its number in a cameras.bin; none for the models that calibstab alone has.
    const COLMAP_ID: Option<i32>;
    /// Its parameters, in file order.
    const PARAMS: [Param; N];
    /// No parameters let it see as far as this from the optical axis, in radians.
    const WIDEST_ANGLE: f64 = PI;
    /// Whether it has `linearize_at_once` and `unproject_at_once`.
    const AT_ONCE: bool = false;
    /// Parameters of real and of hard lenses, on which the laws are tested.
    const EXAMPLES: &[[f64; N]];

    /// The pixel of a point in camera coordinates, and its derivatives; none where the lens does not see or its map folds.
    fn linearize(params: &[f64; N], point: &Vector3<f64>) -> Option<Linearized<N>>;

    /// The direction of what a pixel sees, of any length; none when nothing is seen there.
    fn unproject(params: &[f64; N], pixel: &Vector2<f64>) -> Option<Vector3<f64>>;

    /// `linearize` without a branch, and whether it is surely right: for models worth it, as a loop over it becomes SIMD.
    #[inline(always)]
    fn linearize_at_once(_params: &[f64; N], _point: &Vector3<f64>) -> (Linearized<N>, bool) {
        (Linearized::NONE, false)
    }

    /// `unproject` in the same way; `unproject` gives the same bits where this is sure.
    #[inline(always)]
    fn unproject_at_once(_params: &[f64; N], _pixel: &Vector2<f64>) -> (Vector3<f64>, bool) {
        (Vector3::new(f64::NAN, f64::NAN, f64::NAN), false)
    }

    /// The largest angle from the optical axis, in radians, that the lens sees without folding, decentring aside.
    fn largest_angle(params: &[f64; N]) -> f64;

    /// The extra parameters from the rays that some pixels see, with the focal lengths and the principal point of `params`: by
    /// linear least squares where that can be exact. The rays are unit vectors; F-Theta's focal length is found too.
    ///
    /// What stands here is exact for a model that is linear in its extra parameters, and to first order for another.
    fn estimate_distortion(params: &[f64; N], pairs: &[Pair]) -> Result<[f64; N], CameraError> {
        estimate::linear::<Self, N>(params, pairs)
    }

    /// What the formula divides by for this point, where that can vanish within the angles that the model is made for.
    fn denominator(_params: &[f64; N], _point: &Vector3<f64>) -> Option<f64> {
        None
    }

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
    /// No parameters let it see as far as this from the optical axis, in radians.
    pub widest_angle: f64,
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
                    widest_angle: $Model::WIDEST_ANGLE,
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
        pub(crate) fn examples() -> Vec<Intrinsics> {
            let mut all = Vec::new();
            $(all.extend($Model::EXAMPLES.iter().map(|params| Intrinsics::$Model(*params)));)+
            all
        }

        /// The parameters of the model that has most.
        pub const MOST_PARAMS: usize = {
            let (counts, mut most, mut index) = ([$($n),+], 0, 0);
            while index < counts.len() {
                if counts[index] > most {
                    most = counts[index];
                }
                index += 1;
            }
            most
        };

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
        self.visit(Unproject(pixel)).ok_or_else(unseen)
    }

    /// The pixel of a point in camera coordinates, and its derivatives; none where `project` is an error. Columns of parameters that
    /// the model does not have are zero.
    ///
    /// For what need not be compiled anew for every model, and is not asked millions of times: a [`Job`] asks only once.
    pub fn linearize(&self, point: &Vector3<f64>) -> Option<Linearized<MOST_PARAMS>> {
        self.visit(Linearize(point))
    }

    /// The largest angle from the optical axis, in radians, that the lens sees without folding, decentring aside.
    pub fn largest_angle(&self) -> f64 {
        self.visit(LargestAngle)
    }
}

struct Project<'a>(&'a Vector3<f64>);

impl Job for Project<'_> {
    type Output = Option<Vector2<f64>>;

    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> Self::Output {
        M::project(params, self.0)
    }
}

struct Linearize<'a>(&'a Vector3<f64>);

impl Job for Linearize<'_> {
    type Output = Option<Linearized<MOST_PARAMS>>;

    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> Self::Output {
        let Linearized { pixel, wrt_point, wrt_params } = M::linearize(params, self.0)?;
        let mut padded = SMatrix::<f64, 2, MOST_PARAMS>::zeros();
        padded.columns_mut(0, N).copy_from(&wrt_params);
        Some(Linearized { pixel, wrt_point, wrt_params: padded })
    }
}

struct Unproject<'a>(&'a Vector2<f64>);

impl Job for Unproject<'_> {
    type Output = Option<Vector3<f64>>;

    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> Self::Output {
        unit_ray::<M, N>(params, self.0)
    }
}

/// The unit ray of what a pixel sees.
#[inline(always)]
fn unit_ray<M: CameraModel<N>, const N: usize>(
    params: &[f64; N],
    pixel: &Vector2<f64>,
) -> Option<Vector3<f64>> {
    let ray = M::unproject(params, pixel)?;
    let length = ray.norm();
    (length > 0.0 && length.is_finite()).then(|| ray / length)
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
    fn an_unknown_name_suggests_a_near_one() {
        let message = |name| Model::named(name).unwrap_err().to_string();
        assert!(message("OPENCV_FISHEY").ends_with("did you mean OPENCV_FISHEYE?"));
        assert!(message("opencv").ends_with("did you mean OPENCV?"));
        assert!(!message("banana").contains("did you mean"));
    }
}
