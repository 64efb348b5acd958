//! What every contestant is given: a camera, its pose, and points that it sees all over its image.

use calibstab::camera::{CameraModel, Intrinsics, Model};
use nalgebra::{Matrix3, Vector2, Vector3};

/// In cache with all that is made of them.
pub const POINTS: usize = 4096;

/// (x, y, z, w) of a rotation by half a radian about no axis in particular.
const QUATERNION: [f64; 4] = [0.109_971_3, 0.153_959_8, -0.158_358_7, 0.968_912_4];

pub struct Scene {
    pub camera: Intrinsics,
    pub quaternion: [f64; 4],
    pub rotation: Matrix3<f64>,
    pub translation: Vector3<f64>,
    pub in_world: Vec<Vector3<f64>>,
    pub in_camera: Vec<Vector3<f64>>,
    pub observed: Vec<Vector2<f64>>,
}

impl Scene {
    /// An image of twice the principal point, less where the peers see nothing: beyond 75 degrees.
    pub fn of<M: CameraModel<N>, const N: usize>(params: &[f64; N]) -> Self {
        let camera = Model::named(M::NAME).unwrap().with_params(params).unwrap();
        let of_class = |name: &str| M::PARAMS.iter().position(|param| param.name == name).unwrap();
        let size = [2.0 * params[of_class("cx")], 2.0 * params[of_class("cy")]];
        let norm = QUATERNION.iter().map(|part| part * part).sum::<f64>().sqrt();
        let quaternion = QUATERNION.map(|part| part / norm);
        let rotation = rotation(quaternion);
        let translation = Vector3::new(0.3, -0.7, 1.1);
        let (mut in_world, mut in_camera, mut observed) = (vec![], vec![], vec![]);
        // Multiples of the plastic numbers' inverses fill a cube evenly.
        for index in 1.. {
            let [a, b, c] = [0.819_172_513_396_164_5, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3]
                .map(|step: f64| (f64::from(index) * step).fract());
            let pixel = Vector2::new(a * size[0], b * size[1]);
            let Ok(ray) = camera.unproject(&pixel) else { continue };
            if ray.z < 75_f64.to_radians().cos() {
                continue;
            }
            let point = ray * (1.0 + 9.0 * c);
            in_camera.push(point);
            in_world.push(rotation.transpose() * (point - translation));
            observed.push(pixel + Vector2::new(c - 0.5, 0.5 - a));
            if observed.len() == POINTS {
                break;
            }
        }
        Self { camera, quaternion, rotation, translation, in_world, in_camera, observed }
    }
}

fn rotation([x, y, z, w]: [f64; 4]) -> Matrix3<f64> {
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (xy, xz, yz, xw, yw, zw) = (x * y, x * z, y * z, x * w, y * w, z * w);
    let upper = [1.0 - 2.0 * (yy + zz), 2.0 * (xy - zw), 2.0 * (xz + yw)];
    let middle = [2.0 * (xy + zw), 1.0 - 2.0 * (xx + zz), 2.0 * (yz - xw)];
    let lower = [2.0 * (xz - yw), 2.0 * (yz + xw), 1.0 - 2.0 * (xx + yy)];
    Matrix3::from_row_iterator([upper, middle, lower].into_iter().flatten())
}
