//! Box plots of the parameters that the choices of each heuristic gave, in the manner of those of runs.

use super::boxes::Boxes;
use super::choices::Choices;
use super::drawing::Drawing;
use super::font::Font;
use super::marker::Style;
use super::number::short;
use super::subject::Row;
use crate::selection::experiment::CameraRecord;
use crate::stability::{Parameter, ParameterClass, Sample, SampleState};

/// The figure of a camera; none where nothing varies.
pub fn draw(choices: &Choices<'_>, camera: &CameraRecord, font: &Font) -> Option<Drawing> {
    let heuristics = &choices.selection.options.heuristics;
    let names: Vec<String> = heuristics.iter().map(|(name, _)| name.clone()).collect();
    let parameters: Vec<Vec<Parameter>> = camera
        .free
        .iter()
        .map(|&place| {
            heuristics.iter().map(|(name, _)| parameter(choices, camera, (name, place))).collect()
        })
        .collect();
    let rows: Vec<Row> = parameters
        .iter()
        .zip(&camera.free)
        .map(|(own, &place)| Row {
            name: &camera.parameters[place],
            unit: "",
            cells: own.iter().enumerate().collect(),
        })
        .collect();
    let full = camera
        .free
        .iter()
        .map(|&place| format!("{} {}", camera.parameters[place], short(camera.refined[place])));
    let full: Vec<String> = full.collect();
    let CameraRecord { camera_id, model, width, height, .. } = camera;
    let figure = Boxes {
        title: format!(
            "{}camera {camera_id}, {model}, {width} \u{d7} {height} px",
            choices.of_model()
        ),
        subtitle: format!("Each parameter over the choices of {} of each heuristic", choices.size),
        styles: (0..names.len()).map(Style::of_group).collect(),
        labels: names,
        notes: vec![format!("The full reconstruction has {}.", full.join(", "))],
        dot: "choice",
    };
    figure.draw(&rows, font)
}

fn parameter(
    choices: &Choices<'_>,
    camera: &CameraRecord,
    (heuristic, place): (&str, usize),
) -> Parameter {
    let name = &camera.parameters[place];
    let cell = choices.cells().find(|cell| cell.heuristic == heuristic);
    let of_camera =
        cell.and_then(|cell| cell.cameras.iter().find(|it| it.camera_id == camera.camera_id));
    let statistics = of_camera.and_then(|it| it.parameters.iter().find(|(other, _)| other == name));
    let statistics = statistics.map(|(_, statistics)| statistics.clone());
    let sample = |it: &crate::selection::experiment::Sample| {
        let own = it.cameras.iter().find(|own| own.camera_id == camera.camera_id);
        let value = own.and_then(|own| own.params.get(place).copied());
        let beyond = |value: f64| {
            statistics.as_ref().is_some_and(|it| value < it.whiskers[0] || value > it.whiskers[1])
        };
        Sample {
            run: it.draw.repeat.to_string(),
            camera_id: own.map(|own| own.camera_id),
            state: if value.is_some() { SampleState::Estimated } else { SampleState::Failed },
            value,
            predicted_std: None,
            is_outlier: value.is_some_and(beyond),
        }
    };
    Parameter {
        name: name.clone(),
        class: ParameterClass::Extra,
        unit: String::new(),
        samples: choices.samples(heuristic).map(sample).collect(),
        statistics,
        predicted_std: None,
    }
}
