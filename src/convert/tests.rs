#![cfg(test)]
use super::*;
use crate::camera::{MODELS, examples};

pub(super) fn size_of(camera: &Intrinsics) -> [u32; 2] {
    let named = |name| {
        let mut params = camera.model().params.iter().zip(camera.params());
        params.find(|(param, _)| param.name == name).map(|(_, value)| *value)
    };
    match (named("cx").or(named("w").map(|w| w / 2.0)), named("cy").or(named("h").map(|h| h / 2.0)))
    {
        (Some(cx), Some(cy)) if cx > 100.0 && cy > 100.0 => [(2.0 * cx) as u32, (2.0 * cy) as u32],
        _ => [640, 480],
    }
}

#[test]
fn explore() {
    let want: Option<String> = std::env::var("PAIR").ok();
    for camera in examples() {
        for target in MODELS {
            let name = format!("{} {}", camera.model().name, target.name);
            if want.as_ref().is_some_and(|want| !name.contains(want)) {
                continue;
            }
            let start = std::time::Instant::now();
            let done = convert(&camera, size_of(&camera), target, Folds::Refused);
            let ms = start.elapsed().as_millis();
            match done {
                Ok(Converted { how: How::Exact, intrinsics }) => {
                    println!("{name}: exact {ms} {:?} {:?}", camera.params(), intrinsics.params())
                }
                Ok(Converted { how: How::Fitted(fit), intrinsics }) => println!(
                    "{name}: rms {:.3e} max {:.3e} {ms} ms {:?} {:?}",
                    fit.rms_px,
                    fit.max_px,
                    camera.params(),
                    intrinsics.params()
                ),
                Err(error) => println!("{name}: REFUSED {error} {ms}ms {:?}", camera.params()),
            }
        }
    }
}
