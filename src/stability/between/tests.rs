use super::super::testing::{run, with_images};
use super::super::{Analysis, GroupComparison, Options, Run, TestMethod, analyze};
use crate::stats::{Repeats, f_test};

fn analysis(runs: Vec<Run>) -> Analysis {
    analyze(runs, vec![], Options::default()).unwrap()
}

/// Numbers that look random, with a std of about 0.6.
fn noise(index: i32) -> f64 {
    (12.9898 * f64::from(index)).sin() * 43_758.545 % 1.0
}

/// Runs of a camera whose focal length and principal point vary by about so many px.
fn group(group: &str, model: &str, size: f64, count: i32) -> Vec<Run> {
    let params = |i: i32| {
        let seed = 10 * i + i32::try_from(group.len()).unwrap();
        let mut params = vec![
            1000.0 + size * noise(seed),
            640.5 + size * noise(seed + 1),
            480.5 + size * noise(seed + 2),
        ];
        if model == "SIMPLE_RADIAL" {
            params.push(-0.02 + 1e-3 * size * noise(seed + 3));
        }
        params
    };
    (1..=count).map(|i| run(group, &format!("run{i}"), &[(1, model, &params(i))])).collect()
}

fn only(analysis: &Analysis) -> &GroupComparison {
    let [comparison] = &analysis.comparisons[..] else { panic!("one camera") };
    comparison
}

#[test]
fn groups_are_ranked_by_pixels_whatever_their_model() {
    let runs = [
        group("loose", "SIMPLE_PINHOLE", 9.0, 8),
        group("tight", "SIMPLE_RADIAL", 0.5, 8),
        group("lone", "SIMPLE_PINHOLE", 1.0, 1),
        group("middling", "SIMPLE_PINHOLE", 3.0, 8),
    ];
    let analysis = analysis(runs.concat());
    let comparison = only(&analysis);
    let ranked: Vec<&str> = comparison.ranking.iter().map(|one| one.group.as_str()).collect();
    assert_eq!(ranked, ["tight", "middling", "loose", "lone"]);
    assert!(comparison.ranking[3].spread_px.is_none());
    assert_eq!(comparison.spreads.len(), 3, "every pair that has spreads");
    let loose = &comparison.spreads[1];
    assert_eq!(loose.groups, ["loose", "tight"]);
    assert!(loose.p_holm < 1e-3 && loose.ratio > 5.0, "{loose:?}");
    // Parameters compare within a model only.
    let tests: Vec<(&str, &str, &str)> = comparison
        .parameters
        .iter()
        .map(|one| {
            (one.parameter.as_str(), one.test.groups[0].as_str(), one.test.groups[1].as_str())
        })
        .collect();
    assert_eq!(tests, ["f", "cx", "cy"].map(|name| (name, "loose", "middling")));
}

#[test]
fn a_parameters_test_is_that_of_its_numbers() {
    let [a, b] = [group("a", "SIMPLE_PINHOLE", 1.0, 5), group("bb", "SIMPLE_PINHOLE", 2.0, 7)];
    let focal = |runs: &[Run]| {
        let of = |run: &Run| run.scene.cameras.values().next().unwrap().intrinsics.params()[0];
        Repeats::of_numbers(&runs.iter().map(of).collect::<Vec<f64>>()).unwrap()
    };
    let [x, y] = [focal(&a), focal(&b)];
    let [x, y] = if x.std() > y.std() { [x, y] } else { [y, x] };
    let want = f_test([x.std(), x.degrees()], [y.std(), y.degrees()]).unwrap();
    let analysis = analysis([a, b].concat());
    let test = &only(&analysis).parameters[0].test;
    assert_eq!((test.f.to_bits(), test.p.to_bits()), (want.f.to_bits(), want.p.to_bits()));
    assert_eq!(test.n.iter().sum::<usize>(), 12);
    assert!(test.p_holm >= test.p && test.ratio >= 1.0);
}

#[test]
fn ten_runs_in_both_groups_are_enough_for_brown_and_forsythe() {
    for (count, method) in [(9, TestMethod::F), (10, TestMethod::BrownForsythe)] {
        let runs =
            [group("a", "SIMPLE_PINHOLE", 1.0, 12), group("bb", "SIMPLE_PINHOLE", 4.0, count)];
        let analysis = analysis(runs.concat());
        let comparison = only(&analysis);
        assert_eq!(comparison.spreads[0].method, method);
        assert!(comparison.parameters.iter().all(|one| one.test.method == method));
    }
}

#[test]
fn a_model_that_two_cameras_share_is_compared_with_each() {
    let both = |group: &str, shift: f64| {
        let params = |i: i32| [1000.0 + shift * noise(i), 640.5, 480.5 + noise(i + 7)];
        let one = |i: i32| {
            let two = [(1, params(i)), (2, params(i + 100))];
            let cameras: Vec<(u32, &str, &[f64])> =
                two.iter().map(|(id, p)| (*id, "SIMPLE_PINHOLE", &p[..])).collect();
            let taken: [(u32, &[&str]); 2] =
                [(1, &["1_l.jpg", "2_l.jpg"]), (2, &["1_r.jpg", "2_r.jpg"])];
            with_images(run(group, &format!("run{i}"), &cameras), &taken)
        };
        (1..5).map(one).collect::<Vec<Run>>()
    };
    let shared = (1..5).map(|i| {
        let params = [1000.0 + noise(i + 50), 640.5, 480.5 + noise(i + 60)];
        let taken: &[&str] = &["1_l.jpg", "2_l.jpg", "1_r.jpg", "2_r.jpg"];
        with_images(
            run("shared", &format!("run{i}"), &[(1, "SIMPLE_PINHOLE", &params)]),
            &[(1, taken)],
        )
    });
    let analysis = analysis([both("two", 1.0), shared.collect()].concat());
    let compared: Vec<(&str, Vec<&str>)> = analysis
        .comparisons
        .iter()
        .map(|one| (one.camera.as_str(), one.ranking.iter().map(|g| g.camera.as_str()).collect()))
        .collect();
    let sharer = "camera 1 (*_*.jpg)";
    assert_eq!(compared.len(), 2, "{compared:?}");
    for (camera, there) in compared {
        assert!(
            there.contains(&camera) && there.iter().any(|name| *name != camera),
            "{there:?} {sharer}"
        );
    }
}

#[test]
fn too_many_groups_are_ranked_and_not_tested() {
    let runs = |count: usize| {
        let name = |i: usize| "g".repeat(i);
        analysis((1..=count).flat_map(|i| group(&name(i), "SIMPLE_PINHOLE", 1.0, 3)).collect())
    };
    let (few, many) = (runs(24), runs(25));
    assert_eq!(only(&few).spreads.len(), 24 * 23 / 2);
    assert_eq!((only(&many).ranking.len(), only(&many).spreads.len()), (25, 0));
}

#[test]
fn names_and_order_change_no_bit() {
    let named = |names: [&str; 2]| {
        let mut runs: Vec<Run> =
            [group("a", "SIMPLE_RADIAL", 1.0, 5), group("bb", "SIMPLE_RADIAL", 2.0, 5)].concat();
        for (index, run) in runs.iter_mut().enumerate() {
            run.group = names[index / 5].to_owned();
            run.name = format!("{}{}", names[index / 5], (7 * index) % 10);
        }
        let analysis = analysis(runs);
        let comparison = only(&analysis);
        let spreads = comparison.ranking.iter().map(|one| one.spread_px.map(f64::to_bits));
        let tests = comparison.parameters.iter().map(|one| one.test.p_holm.to_bits());
        (spreads.collect::<Vec<_>>(), tests.collect::<Vec<_>>())
    };
    assert_eq!(named(["a", "b"]), named(["z", "m"]));
}
