//! What runs do to the pixels of a grid: each camera's deviation from what it and its peers agree on, as rows of numbers.

use nalgebra::{Vector2, Vector3};
use rayon::prelude::*;

use super::Population;
use super::spread::aligned_deviations;
use crate::camera::{Grid, Intrinsics, Model};

/// Deviations in px of the cameras of some groups, over the cells that all of them see.
#[derive(Debug)]
pub(super) struct Deviations {
    /// By group and camera, in the order given: x and y of each cell. Divided by the root of the number of cells, so that the
    /// sum of squares of a row is its mean square over the image.
    pub raw: Vec<Vec<Vec<f64>>>,
    /// The same after the cameras of each consensus were rotated onto each other, as poses absorb a rotation. None where the
    /// search for the rotations lost sight of a cell.
    pub aligned: Option<Vec<Vec<Vec<f64>>>>,
    /// Share of the image that these cells are.
    pub image_share: f64,
}

/// The cameras of a population, one for each sample that has all parameters.
pub(super) fn cameras(population: &Population) -> Vec<Intrinsics> {
    let Ok(model) = Model::named(&population.model) else { return Vec::new() };
    let count = population.parameters.first().map_or(0, |parameter| parameter.samples.len());
    let camera = |index: usize| {
        let values = population.parameters.iter().map(|parameter| parameter.samples[index].value);
        model.with_params(&values.collect::<Option<Vec<f64>>>()?).ok()
    };
    (0..count).filter_map(camera).collect()
}

/// The deviations of each group from its own consensus. None when no cell is seen by all.
pub(super) fn apart(groups: &[Vec<Intrinsics>], size: [u64; 2]) -> Option<Deviations> {
    deviations(groups, size, |group| group)
}

/// The deviations of all groups from one consensus.
pub(super) fn together(groups: &[Vec<Intrinsics>], size: [u64; 2]) -> Option<Deviations> {
    deviations(groups, size, |_| 0)
}

/// A camera among those of its consensus.
struct Member<'a> {
    consensus: usize,
    place: [usize; 2],
    camera: &'a Intrinsics,
}

fn deviations(
    groups: &[Vec<Intrinsics>],
    [width, height]: [u64; 2],
    consensus_of: impl Fn(usize) -> usize,
) -> Option<Deviations> {
    let grid = Grid::new(width, height);
    let pixels: Vec<Vector2<f64>> = grid.pixels().collect();
    let mut members: Vec<Member> = Vec::new();
    for (group, cameras) in groups.iter().enumerate() {
        let consensus = consensus_of(group);
        members.extend(cameras.iter().enumerate().map(|(index, camera)| Member {
            consensus,
            place: [group, index],
            camera,
        }));
    }
    // By content, so that sums run in one order whatever runs and groups are called.
    members.sort_by(|a, b| {
        let of = |member: &Member| (member.consensus, member.camera.model().name);
        let params = a.camera.params().iter().zip(b.camera.params());
        of(a).cmp(&of(b)).then_with(|| {
            params.fold(std::cmp::Ordering::Equal, |order, (a, b)| order.then(a.total_cmp(b)))
        })
    });
    let fields: Vec<Vec<Field>> = members
        .chunk_by(|a, b| a.consensus == b.consensus)
        .map(|peers| fields(peers, &pixels))
        .collect();
    let fields = fields.concat();
    let seen: Vec<usize> = (0..pixels.len())
        .filter(|&cell| fields.iter().all(|field| field[cell].is_some()))
        .collect();
    if seen.is_empty() {
        return None;
    }
    let seen_pixels: Vec<Vector2<f64>> = seen.iter().map(|&cell| pixels[cell]).collect();
    let aligned: Option<Vec<Vec<Vec<Vector2<f64>>>>> = members
        .chunk_by(|a, b| a.consensus == b.consensus)
        .map(|peers| {
            let cameras: Vec<&Intrinsics> = peers.iter().map(|peer| peer.camera).collect();
            aligned_deviations(&cameras, &seen_pixels)
        })
        .collect();
    let raw: Vec<Vec<Vector2<f64>>> =
        fields.iter().map(|field| seen.iter().filter_map(|&cell| field[cell]).collect()).collect();
    let rows = |fields: &[Vec<Vector2<f64>>]| rows(groups, &members, fields);
    Some(Deviations {
        raw: rows(&raw),
        aligned: aligned.map(|fields| rows(&fields.concat())),
        image_share: seen.len() as f64 / pixels.len() as f64,
    })
}

/// The members' deviations as rows, by group and camera.
fn rows(
    groups: &[Vec<Intrinsics>],
    members: &[Member],
    fields: &[Vec<Vector2<f64>>],
) -> Vec<Vec<Vec<f64>>> {
    let mut rows: Vec<Vec<Vec<f64>>> =
        groups.iter().map(|cameras| vec![Vec::new(); cameras.len()]).collect();
    for (member, field) in members.iter().zip(fields) {
        let weight = (field.len() as f64).sqrt().recip();
        let [group, index] = member.place;
        rows[group][index] = field.iter().flat_map(|d| [weight * d.x, weight * d.y]).collect();
    }
    rows
}

/// A deviation at each cell; none where there is no ray, or the camera does not see that of the consensus.
type Field = Vec<Option<Vector2<f64>>>;

/// The deviations of peers from their consensus, the mean of their rays at each cell.
fn fields(peers: &[Member], pixels: &[Vector2<f64>]) -> Vec<Field> {
    let rays: Vec<Vec<Option<Vector3<f64>>>> = peers
        .par_iter()
        .map(|peer| pixels.iter().map(|at| peer.camera.unproject(at).ok()).collect())
        .collect();
    let consensus: Vec<Option<Vector3<f64>>> = (0..pixels.len())
        .map(|cell| rays.iter().map(|rays| rays[cell]).sum::<Option<Vector3<f64>>>())
        .collect();
    let deviation = |camera: &Intrinsics, at: usize| {
        Some(camera.project(consensus[at].as_ref()?).ok()? - pixels[at])
    };
    let field = |peer: &Member| (0..pixels.len()).map(|at| deviation(peer.camera, at)).collect();
    peers.par_iter().map(field).collect()
}
