//! A choice that grows by one at a time and hangs together at every step.

use super::field::{Field, LEAST_SHARED};
use super::{Choice, SelectionError};

/// What is chosen so far.
#[derive(Debug, Clone)]
pub(super) struct Growth<'a> {
    pub field: &'a Field<'a>,
    pub chosen: Vec<usize>,
    is_chosen: Vec<bool>,
    is_seen: Vec<bool>,
    /// How many points each group shares with those chosen.
    shared: Vec<usize>,
    shows: Vec<bool>,
}

impl<'a> Growth<'a> {
    pub(super) fn new(field: &'a Field<'a>) -> Self {
        Self {
            field,
            chosen: Vec::new(),
            is_chosen: vec![false; field.groups.len()],
            is_seen: vec![false; field.candidates.rows.points.len()],
            shared: vec![0; field.groups.len()],
            shows: vec![false; field.wanted.len()],
        }
    }

    pub(super) fn add(&mut self, group: usize) {
        self.chosen.push(group);
        self.is_chosen[group] = true;
        for &point in &self.field.groups[group].points {
            if !std::mem::replace(&mut self.is_seen[point], true) {
                self.field.seen_by(point).iter().for_each(|&other| self.shared[other] += 1);
            }
        }
        self.field.groups[group].cameras.iter().for_each(|&camera| self.shows[camera] = true);
    }

    /// How many of a group's points those chosen see too.
    pub(super) fn shared(&self, group: usize) -> usize {
        self.shared[group]
    }

    pub(super) fn holds(&self, group: usize) -> bool {
        self.chosen.is_empty() || self.shared[group] >= LEAST_SHARED
    }

    /// What may come next: what hangs together with those chosen, and leaves room for every wanted camera.
    pub(super) fn allowed(&self) -> Result<Vec<usize>, SelectionError> {
        let missing = self.shows.iter().filter(|&&shown| !shown).count();
        let is_new = |group: &usize| {
            self.field.groups[*group].cameras.iter().any(|&camera| !self.shows[camera])
        };
        let free = (0..self.is_chosen.len()).filter(|&at| !self.is_chosen[at] && self.holds(at));
        if missing == 0 || self.field.size - self.chosen.len() > missing {
            return Ok(free.collect());
        }
        let needed: Vec<usize> = free.filter(is_new).collect();
        match self.shows.iter().position(|&shown| !shown) {
            Some(camera) if needed.is_empty() => {
                Err(SelectionError::Unreached(self.field.wanted[camera]))
            }
            _ => Ok(needed),
        }
    }

    /// Grows to the size asked for by what scores most, the first of those that score the same.
    pub(super) fn by_score(
        field: &'a Field<'a>,
        mut score: impl FnMut(&Self, usize) -> f64,
        reason: impl Fn(&Self, usize, f64) -> String,
    ) -> Result<Vec<Choice>, SelectionError> {
        let mut growth = Self::new(field);
        let mut choices = Vec::with_capacity(field.size);
        while choices.len() < field.size {
            let mut best: Option<(f64, usize)> = None;
            for group in growth.allowed()? {
                let gain = score(&growth, group);
                if best.is_none_or(|(most, _)| gain > most) {
                    best = Some((gain, group));
                }
            }
            let Some((gain, group)) = best else { break };
            let reason = reason(&growth, group, gain);
            choices.push(Choice { images: field.groups[group].images.clone(), gain, reason });
            growth.add(group);
        }
        Ok(choices)
    }
}

impl Field<'_> {
    /// Whether these groups hang together and show every wanted camera.
    pub(super) fn is_sound(&self, groups: &[usize]) -> bool {
        let shows = |camera| groups.iter().any(|&at| self.groups[at].cameras.contains(&camera));
        let reaches_all = |&first: &usize| {
            let mut growth = Growth::new(self);
            growth.add(first);
            let mut left: Vec<usize> = groups.iter().copied().filter(|&at| at != first).collect();
            while let Some(at) = left.iter().position(|&group| growth.holds(group)) {
                growth.add(left.swap_remove(at));
            }
            left.is_empty()
        };
        let hangs = || self.hangs_by_pairs(groups) || groups.iter().any(reaches_all);
        (0..self.wanted.len()).all(shows) && hangs()
    }
}
