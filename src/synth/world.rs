//! The points of a room, and the places from which it is seen. Metres; x right, y down, z forward.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::random::Random;

/// What is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum World {
    /// A room of 10 x 5 x 10 m: its walls, floor and ceiling, and things all over it.
    #[default]
    Room,
    /// Its floor alone.
    Plane,
}

/// From where it is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Views {
    /// All round, some 3 m from the middle, looking near it across the room, the camera rolled by quarter turns: what
    /// determines the intrinsics.
    #[default]
    Ring,
    /// A straight way of 4 m ahead, looking ahead: focal lengths and depths are hard to tell apart.
    Forward,
    /// One place in the middle, looking all round, the camera rolled: no depth can be told.
    Rotation,
}

/// Half the sides of the room.
const HALF: [f64; 3] = [5.0, 2.5, 5.0];

/// The share of points that lie on walls, floor and ceiling.
const ON_WALLS: f64 = 0.6;

impl World {
    /// So many points.
    pub fn points(self, count: u32, random: &mut Random) -> Vec<Vector3<f64>> {
        (0..count).map(|_| self.point(random)).collect()
    }

    fn point(self, random: &mut Random) -> Vector3<f64> {
        let mut point = random.in_box(HALF);
        match self {
            Self::Room if random.uniform(0.0, 1.0) < ON_WALLS => {
                let axis = if random.uniform(0.0, 1.0) < 0.5 { 0 } else { 2 };
                let axis = if random.uniform(0.0, 1.0) < 0.4 { 1 } else { axis };
                point[axis] = HALF[axis].copysign(point[axis]);
            }
            Self::Room => {}
            Self::Plane => point.y = HALF[1],
        }
        point
    }

    /// Something near the middle to look at.
    fn target(self, random: &mut Random) -> Vector3<f64> {
        let near = random.in_box([1.2, 0.8, 1.2]);
        match self {
            Self::Room => near,
            Self::Plane => Vector3::new(near.x, HALF[1], near.z),
        }
    }
}

impl Views {
    /// From world coordinates to those of a camera that looks along +Z, for each of so many images.
    pub fn poses(self, count: u32, world: World, random: &mut Random) -> Vec<Isometry3<f64>> {
        (0..count)
            .map(|index| self.pose(f64::from(index) / f64::from(count), world, random))
            .collect()
    }

    /// The pose at this share of the way.
    fn pose(self, share: f64, world: World, random: &mut Random) -> Isometry3<f64> {
        let quarter_turns = random.uniform(0.0, 4.0).floor();
        let roll = quarter_turns * FRAC_PI_2 + 0.15 * random.normal();
        let turn = TAU * share;
        let towards = Vector3::new(turn.cos(), 0.0, turn.sin());
        match self {
            Self::Ring => {
                let centre = towards * 3.0 + random.in_box([0.7, 1.2, 0.7]);
                look(centre, world.target(random) - centre, roll)
            }
            Self::Forward => {
                let centre = Vector3::new(0.0, 0.0, -4.0 + 4.0 * share) + 0.02 * random.normals();
                let off = 0.01 * random.normals();
                look(centre, Vector3::new(off.x, off.y, 1.0), off.z)
            }
            Self::Rotation => {
                let up_or_down = Vector3::new(0.0, random.uniform(-0.6, 0.6), 0.0);
                look(Vector3::zeros(), towards + up_or_down, roll)
            }
        }
    }
}

/// At this place, looking in this direction (never straight up or down), rolled about it.
fn look(centre: Vector3<f64>, direction: Vector3<f64>, roll: f64) -> Isometry3<f64> {
    let forward = direction.normalize();
    let right = Vector3::y().cross(&forward).normalize();
    let upright = Matrix3::from_rows(&[
        right.transpose(),
        forward.cross(&right).transpose(),
        forward.transpose(),
    ]);
    let rotation = Rotation3::from_axis_angle(&Vector3::z_axis(), roll)
        * Rotation3::from_matrix_unchecked(upright);
    placed(UnitQuaternion::from_rotation_matrix(&rotation), centre)
}

/// The pose of this rotation from world to camera, whose camera is there.
pub fn placed(rotation: UnitQuaternion<f64>, centre: Vector3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(-(rotation * centre)), rotation)
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::super::random::Purpose;
    use super::*;

    #[test]
    fn a_camera_sees_what_it_looks_at_on_its_axis_and_down_below_it() {
        let (centre, direction) = (Vector3::new(1.0, -2.0, 3.0), Vector3::new(-2.0, 1.0, 0.5));
        let seen =
            |roll, point| look(centre, direction, roll).transform_point(&Point3::from(point));
        let ahead = seen(0.0, centre + direction).coords;
        assert!((ahead - Vector3::new(0.0, 0.0, direction.norm())).norm() < 1e-14, "{ahead}");
        let below = seen(0.0, centre + direction + Vector3::y());
        assert!(below.x.abs() < 1e-14 && below.y > 0.5, "{below}");
        // Rolled by a quarter turn, y has become -x.
        let rolled = seen(FRAC_PI_2, centre + direction + Vector3::y());
        assert!((rolled.x + below.y).abs() < 1e-14 && rolled.y.abs() < 1e-14, "{rolled}");
    }

    #[test]
    fn views_are_what_they_are_called() {
        let random = || Random::new(1, 1, Purpose::Views);
        let centres = |views: Views| -> Vec<Vector3<f64>> {
            let poses = views.poses(40, World::Room, &mut random());
            poses.iter().map(|pose| pose.inverse().translation.vector).collect()
        };
        assert!(centres(Views::Rotation).iter().all(|centre| centre.norm() < 1e-14));
        let forward = centres(Views::Forward);
        assert!(forward.iter().all(|centre| centre.xy().norm() < 0.1));
        assert!((forward[39] - forward[0]).z > 3.5);
        let ring = centres(Views::Ring);
        assert!(ring.iter().all(|centre| (1.5..4.5).contains(&centre.xz().norm())));
        let floor = World::Plane.points(100, &mut random());
        assert!(floor.iter().all(|point| (point.y - 2.5).abs() < 1e-15));
    }
}
