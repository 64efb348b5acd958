//! A first estimate of distortion from rays and the pixels that they lead to, by linear least squares.
//!
//! A start for a search, not its end: what is least is the error of each model's equation, which is not quite one in pixels.

use nalgebra::{DMatrix, DVector, SVector, Vector2, Vector3};

use super::{CameraError, CameraModel, Intrinsics, Job, ParamClass};

/// A ray in camera coordinates, and the pixel to which it leads.
pub type Pair = (Vector3<f64>, Vector2<f64>);

impl Intrinsics {
    /// This camera with the distortion that ray-pixel pairs show, its focal lengths and principal point kept: a start for a
    /// search. F-Theta's focal length, which is part of its polynomial, is found too. Rays may have any length.
    ///
    /// From exact pairs it is exact, except for the models that are not linear at all: for `RAD_TAN_THIN_PRISM_FISHEYE` it is
    /// right to first order in the distortion, and for `FULL_OPENCV`, whose numerator and denominator are one to first
    /// order, there is none.
    ///
    /// It is a [`NumericalError`](CameraError::NumericalError) where the pairs do not determine the distortion, and
    /// [`ParameterOutOfRange`](CameraError::ParameterOutOfRange) where they fit no lens of this model.
    pub fn estimate_distortion(&self, pairs: &[Pair]) -> Result<Self, CameraError> {
        let unit = |(index, (ray, pixel)): (usize, &Pair)| {
            let is_finite = ray.iter().chain(pixel).all(|value| value.is_finite());
            let ray = ray.try_normalize(0.0).filter(|_| is_finite);
            let no_direction = || undetermined(format!("pair {index} has no ray or no pixel"));
            ray.map(|ray| (ray, *pixel)).ok_or_else(no_direction)
        };
        let pairs: Vec<Pair> = pairs.iter().enumerate().map(unit).collect::<Result<_, _>>()?;
        let estimated = self.model().with_params(&self.visit(Estimate(&pairs))?)?;
        estimated.validate()?;
        Ok(estimated)
    }
}

struct Estimate<'a>(&'a [Pair]);

impl Job for Estimate<'_> {
    type Output = Result<Vec<f64>, CameraError>;

    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> Self::Output {
        Ok(M::estimate_distortion(params, self.0)?.to_vec())
    }
}

/// The extra parameters of a model that is linear in them: one step from zero.
pub(super) fn linear<M: CameraModel<N>, const N: usize>(
    params: &[f64; N],
    pairs: &[Pair],
) -> Result<[f64; N], CameraError> {
    let mut start = *params;
    let is_extra = |index: &usize| M::PARAMS[*index].class == ParamClass::Extra;
    let unknown: Vec<usize> = (0..N).filter(is_extra).collect();
    unknown.iter().for_each(|&index| start[index] = 0.0);
    let mut equations = DMatrix::zeros(2 * pairs.len(), unknown.len());
    let mut rest = DVector::zeros(2 * pairs.len());
    for (index, (ray, pixel)) in pairs.iter().enumerate() {
        let at = M::linearize(&start, ray).ok_or_else(|| {
            undetermined(format!("the ray of pair {index} is not seen without distortion"))
        })?;
        for (column, &param) in unknown.iter().enumerate() {
            equations
                .fixed_view_mut::<2, 1>(2 * index, column)
                .copy_from(&at.wrt_params.column(param));
        }
        rest.fixed_rows_mut::<2>(2 * index).copy_from(&(pixel - at.pixel));
    }
    for (index, value) in unknown.into_iter().zip(&solve(equations, rest)?) {
        start[index] = *value;
    }
    Ok(start)
}

/// The K unknowns of R equations a pair: their factors in each equation, and its right side.
pub(super) fn fit<const K: usize, const R: usize>(
    pairs: &[Pair],
    equations: impl Fn(&Vector3<f64>, &Vector2<f64>) -> ([SVector<f64, R>; K], SVector<f64, R>),
) -> Result<[f64; K], CameraError> {
    let mut factors = DMatrix::zeros(R * pairs.len(), K);
    let mut right = DVector::zeros(R * pairs.len());
    for (index, (ray, pixel)) in pairs.iter().enumerate() {
        let (columns, value) = equations(ray, pixel);
        for (column, factor) in columns.iter().enumerate() {
            factors.fixed_view_mut::<R, 1>(R * index, column).copy_from(factor);
        }
        right.fixed_rows_mut::<R>(R * index).copy_from(&value);
    }
    let found = solve(factors, right)?;
    Ok(std::array::from_fn(|index| found[index]))
}

/// How far out a place is in the direction of the ray, and how far the ray is from the axis.
pub(super) fn radius(ray: &Vector3<f64>, at: &Vector2<f64>) -> (f64, f64) {
    let rho = ray.xy().norm();
    if rho > 0.0 { (at.dot(&ray.xy()) / rho, rho) } else { (at.norm(), 0.0) }
}

/// The parameters with the least squares of pixel errors among those that one number between two makes.
pub(super) fn search<M: CameraModel<N>, const N: usize>(
    [low, high]: [f64; 2],
    pairs: &[Pair],
    with: impl Fn(f64) -> Result<[f64; N], CameraError>,
) -> Result<[f64; N], CameraError> {
    /// Between two of so many places the error of no model has more than one valley.
    const PLACES: u32 = 64;
    /// Each round leaves 0.62 of the interval: a hundred leave less than a double's width.
    const ROUNDS: usize = 100;
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let cost = |at: f64| {
        let Ok(params) = with(at) else { return f64::INFINITY };
        let error = |(ray, pixel): &Pair| Some((M::project(&params, ray)? - pixel).norm_squared());
        pairs.iter().map(error).sum::<Option<f64>>().unwrap_or(f64::INFINITY)
    };
    let place = |index: u32| low + (high - low) * f64::from(index) / f64::from(PLACES);
    let costs: Vec<f64> = (0..=PLACES).map(|index| cost(place(index))).collect();
    let [least, most] = [f64::min as fn(f64, f64) -> f64, f64::max].map(|better| {
        costs.iter().copied().filter(|cost| cost.is_finite()).reduce(better).unwrap_or(0.0)
    });
    if most <= least * (1.0 + 1e-9) {
        return Err(undetermined("the distortion does not move these pixels".to_owned()));
    }
    let best = (0..=PLACES).zip(&costs).min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |best| best.0);
    let [mut left, mut right] = [place(best.saturating_sub(1)), place((best + 1).min(PLACES))];
    for _ in 0..ROUNDS {
        let width = GOLDEN * (right - left);
        if cost(right - width) <= cost(left + width) {
            right = left + width
        } else {
            left = right - width
        }
    }
    with(0.5 * (left + right))
}

/// Linear least squares.
fn solve(mut factors: DMatrix<f64>, right: DVector<f64>) -> Result<DVector<f64>, CameraError> {
    /// Below this share of the largest singular value a direction is made of rounding errors.
    const RANK: f64 = 1e-10;
    let unknowns = factors.ncols();
    if unknowns == 0 {
        return Ok(DVector::zeros(0));
    }
    if factors.nrows() < unknowns {
        let (rows, pairs) = (factors.nrows(), "equations from the pairs");
        return Err(undetermined(format!("{rows} {pairs} for {unknowns} unknowns")));
    }
    let scales: Vec<f64> = factors.column_iter().map(|column| column.norm()).collect();
    for (mut column, scale) in factors.column_iter_mut().zip(&scales) {
        column /= scale.max(f64::MIN_POSITIVE);
    }
    let qr = factors.qr();
    let mut rotated = right;
    qr.q_tr_mul(&mut rotated);
    let svd = qr.unpack_r().svd(true, true);
    let rank = svd.rank(RANK * svd.singular_values.max());
    let solution = svd.solve(&rotated.rows(0, unknowns).into_owned(), 0.0);
    match solution {
        Ok(solution) if rank == unknowns => {
            let scales = DVector::from_vec(scales);
            Ok(solution.component_div(&scales))
        }
        _ => Err(undetermined(format!("the pairs determine {rank} of {unknowns} unknowns"))),
    }
}

fn undetermined(details: String) -> CameraError {
    CameraError::NumericalError { operation: "estimate of distortion", details }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Random, hold};
    use super::super::{Model, examples};
    use super::*;

    /// What the camera sees at 15 x 11 pixels, within 80 degrees, with noise of a standard deviation in px.
    fn pairs(camera: &Intrinsics, noise_px: f64) -> Vec<Pair> {
        let mut random = Random(0x2545_f491_4f6c_dd1d);
        let mut pairs = Vec::new();
        for (column, row) in (0..15).flat_map(|column| (0..11).map(move |row| (column, row))) {
            let pixel = Vector2::new(20.0 + 70.0 * f64::from(column), 20.0 + 70.0 * f64::from(row));
            let Ok(ray) = camera.unproject(&pixel) else { continue };
            // The sum of twelve uniform numbers is as good as normal.
            let mut normal = || (0..12).map(|_| 0.5 * random.next()).sum::<f64>() * noise_px;
            let pixel = pixel + Vector2::new(normal(), normal());
            if ray.z.abs() > 80_f64.to_radians().cos() {
                pairs.push((ray * 3.0, pixel));
            }
        }
        pairs
    }

    /// The camera with its distortion forgotten.
    fn forgotten(camera: &Intrinsics) -> Intrinsics {
        let params: Vec<f64> = camera
            .model()
            .params
            .iter()
            .zip(camera.params())
            .map(|(param, value)| if param.class == ParamClass::Extra { 0.123 } else { *value })
            .collect();
        camera.model().with_params(&params).unwrap()
    }

    const NOT_LINEAR: [&str; 2] = ["FULL_OPENCV", "RAD_TAN_THIN_PRISM_FISHEYE"];

    #[test]
    fn exact_pairs_give_the_distortion_back() {
        let law = |camera: &Intrinsics| {
            let name = camera.model().name;
            if NOT_LINEAR.contains(&name) {
                return 1;
            }
            let found = forgotten(camera).estimate_distortion(&pairs(camera, 0.0)).unwrap();
            for (found, want) in found.params().iter().zip(camera.params()) {
                // omega and -omega are one lens; near 0 its square is what the pixels tell.
                let (found, want) =
                    if name == "FOV" { (found.abs(), want.abs()) } else { (*found, *want) };
                let allowed = if want.abs() < 0.01 && name == "FOV" {
                    1e-6
                } else {
                    1e-8 * want.abs().max(1.0)
                };
                assert!(
                    (found - want).abs() <= allowed,
                    "{name}: {found} for {want} of {camera:?}"
                );
            }
            1
        };
        hold(law, 2);
    }

    #[test]
    fn noisy_pairs_give_a_start_as_good_as_their_noise() {
        const NOISE_PX: f64 = 0.3;
        let law = |camera: &Intrinsics| {
            let name = camera.model().name;
            if name == "FULL_OPENCV" {
                return 1;
            }
            let found = forgotten(camera).estimate_distortion(&pairs(camera, NOISE_PX)).unwrap();
            let exact = pairs(camera, 0.0);
            let error = |(ray, pixel): &Pair| (found.project(ray).unwrap() - pixel).norm_squared();
            let rms_px = (exact.iter().map(error).sum::<f64>() / exact.len() as f64).sqrt();
            // Least squares would leave sqrt(unknowns / pairs) of the noise; of another error than that in px, a little more.
            let allowed = if name == "RAD_TAN_THIN_PRISM_FISHEYE" { 1.0 } else { NOISE_PX };
            assert!(rms_px <= allowed, "{camera:?}: {rms_px} px");
            1
        };
        hold(law, 2);
    }

    #[test]
    fn pairs_that_do_not_tell_are_refused() {
        let on_axis = |camera: &Intrinsics| {
            let axis = Vector3::z();
            let pixel = camera.project(&axis).unwrap();
            vec![(axis, pixel); 20]
        };
        let mut refused = 0;
        for camera in examples().iter().filter(|c| c.project(&Vector3::z()).is_ok()) {
            let unknowns = camera.model().params.iter().filter(|p| p.class == ParamClass::Extra);
            if unknowns.count() == 0 {
                assert_eq!(camera.estimate_distortion(&[]).unwrap(), *camera);
                continue;
            }
            for pairs in [vec![], on_axis(camera)] {
                let error = forgotten(camera).estimate_distortion(&pairs).unwrap_err();
                assert!(matches!(error, CameraError::NumericalError { .. }), "{camera:?}: {error}");
                assert!(error.to_string().starts_with("estimate of distortion: "), "{error}");
                refused += 1;
            }
        }
        assert!(refused > 60, "{refused}");
    }

    #[test]
    fn what_is_wrong_with_the_pairs_is_told() {
        let camera = Model::named("RADTAN").unwrap().with_params(&[1.0; 9]).unwrap();
        let message = |pairs: &[Pair]| camera.estimate_distortion(pairs).unwrap_err().to_string();
        let good = (Vector3::new(0.1, 0.2, 1.0), Vector2::new(1.0, 2.0));
        let behind = (Vector3::new(0.1, 0.2, -1.0), Vector2::new(1.0, 2.0));
        let nowhere = (Vector3::zeros(), Vector2::new(1.0, 2.0));
        for (pairs, want) in [
            (vec![good; 2], "4 equations from the pairs for 5 unknowns"),
            (vec![good; 9], "the pairs determine 2 of 5 unknowns"),
            (vec![good, behind], "the ray of pair 1 is not seen without distortion"),
            (vec![good, nowhere], "pair 1 has no ray or no pixel"),
        ] {
            assert_eq!(message(&pairs), format!("estimate of distortion: {want}"));
        }
        let ucm = Model::named("UCM").unwrap().with_params(&[1.0, 1.0, 0.0, 0.0, 0.5]).unwrap();
        // 0.3 / (alpha d + (1 - alpha) z) = 1 needs an alpha below zero
        let bent = [(Vector3::new(0.3, 0.0, 1.0), Vector2::new(1.0, 0.0))];
        let error = ucm.estimate_distortion(&bent).unwrap_err();
        assert!(
            matches!(error, CameraError::ParameterOutOfRange { param: "alpha", .. }),
            "{error}"
        );
    }
}
