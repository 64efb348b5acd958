//! What one figure is about: a camera with one model and image size, in every group that has it.

use crate::stability::{Analysis, Parameter, ParameterClass, Population, Sample, SampleState};

use super::font::clean;
use super::marker::Style;

/// A camera with one model and image size.
pub struct Subject<'a> {
    pub camera: String,
    pub model: String,
    pub width: u64,
    pub height: u64,
    pub members: Vec<Member<'a>>,
    /// The analysis that it is part of.
    pub analysis: &'a Analysis,
}

/// That camera in one group.
pub struct Member<'a> {
    pub group: String,
    pub style: Style,
    pub population: &'a Population,
}

/// One parameter of the subject, in those of its groups that have it, each with its index among the members.
pub struct Row<'a> {
    pub name: &'a str,
    pub unit: &'a str,
    pub cells: Vec<(usize, &'a Parameter)>,
}

/// The subjects of an analysis, in the order in which it has them.
pub fn subjects(analysis: &Analysis) -> Vec<Subject<'_>> {
    let mut groups: Vec<&str> = Vec::new();
    let mut subjects: Vec<Subject> = Vec::new();
    for population in &analysis.populations {
        let index =
            groups.iter().position(|&group| group == population.group).unwrap_or_else(|| {
                groups.push(&population.group);
                groups.len() - 1
            });
        let member =
            Member { group: clean(&population.group), style: Style::of_group(index), population };
        match subjects.iter_mut().find(|subject| subject.is_of(population)) {
            Some(subject) => subject.members.push(member),
            None => subjects.push(Subject::with(member, analysis)),
        }
    }
    subjects
}

impl<'a> Subject<'a> {
    fn with(member: Member<'a>, analysis: &'a Analysis) -> Self {
        let Population { camera, model, width, height, .. } = member.population;
        Self {
            camera: clean(camera),
            model: clean(model),
            width: *width,
            height: *height,
            members: vec![member],
            analysis,
        }
    }

    fn is_of(&self, other: &Population) -> bool {
        let Population { camera, model, width, height, .. } = self.members[0].population;
        (camera, model, width, height) == (&other.camera, &other.model, &other.width, &other.height)
    }

    /// The subject in words, such as `camera 1, OPENCV, 752 × 480 px`.
    pub fn words(&self) -> String {
        format!("{}, {}, {} × {} px", self.camera, self.model, self.width, self.height)
    }

    /// Its parameters, in file order, less the metadata of its model.
    pub fn rows(&self) -> Vec<Row<'a>> {
        let mut rows: Vec<Row> = Vec::new();
        for (index, member) in self.members.iter().enumerate() {
            let can_vary = |parameter: &&Parameter| parameter.class != ParameterClass::Metadata;
            for parameter in member.population.parameters.iter().filter(can_vary) {
                match rows.iter_mut().find(|row| row.name == parameter.name) {
                    Some(row) => row.cells.push((index, parameter)),
                    None => rows.push(Row {
                        name: &parameter.name,
                        unit: &parameter.unit,
                        cells: vec![(index, parameter)],
                    }),
                }
            }
        }
        rows
    }
}

impl Row<'_> {
    /// Whether there is anything to draw.
    pub fn varies(&self) -> bool {
        self.cells
            .iter()
            .any(|(_, parameter)| parameter.samples.iter().any(|sample| drawn(sample).is_some()))
    }

    /// Every value that is drawn.
    pub fn values(&self) -> Vec<f64> {
        self.cells
            .iter()
            .flat_map(|(_, parameter)| parameter.samples.iter().filter_map(drawn))
            .collect()
    }
}

/// The value of a sample that may differ between runs; none of a held or failed one.
pub fn drawn(sample: &Sample) -> Option<f64> {
    match sample.state {
        SampleState::Estimated | SampleState::Unknown => {
            sample.value.filter(|value| value.is_finite())
        }
        SampleState::Held | SampleState::PresumedHeld | SampleState::Failed => None,
    }
}

/// The value of a sample that was held, for certain or presumably.
pub fn held(sample: &Sample) -> Option<f64> {
    let is_held = matches!(sample.state, SampleState::Held | SampleState::PresumedHeld);
    sample.value.filter(|_| is_held)
}
