//! Which heuristic is better, and is that certain.

use std::collections::{BTreeMap, BTreeSet};

use super::super::RANDOM;
use super::result::{Agreement, Cell, RankRow, Ranking, Ratio, ScoredSample, Target};
use crate::stats::{Contrast, Pair, concordance};

/// How often a ranking may say that one is better than another that is not.
const LEVEL: f64 = 0.05;
/// A heuristic that gives no calibration in more than this share of the repeats, and more than once, is not compared by those that it
/// gives. Repeats whose pool has not so many that hang together count for none: there no heuristic can choose.
const MOST_FAILURES: f64 = 0.1;

/// The squared errors of each heuristic at each size of each model.
pub(super) struct Errors {
    squares: BTreeMap<(usize, usize, String), BTreeMap<usize, f64>>,
    heuristics: Vec<String>,
    /// All models and sizes, and in how many repeats there was something to choose.
    strata: BTreeMap<(usize, usize), usize>,
    /// Whether repeats have noise of their own.
    is_independent: bool,
}

impl Errors {
    pub(super) fn new(
        samples: &[ScoredSample],
        heuristics: Vec<String>,
        is_independent: bool,
    ) -> Self {
        let mut squares: BTreeMap<_, BTreeMap<usize, f64>> = BTreeMap::new();
        let mut chosen: BTreeMap<(usize, usize), BTreeSet<usize>> = BTreeMap::new();
        for ScoredSample { sample, error_px, .. } in samples {
            let draw = sample.draw;
            if !sample.images.is_empty() {
                chosen.entry((draw.model, draw.size)).or_default().insert(draw.repeat);
            }
            let own = squares.entry((draw.model, draw.size, sample.heuristic.clone())).or_default();
            own.extend(error_px.map(|error| (draw.repeat, error * error)));
        }
        let strata =
            chosen.into_iter().map(|(stratum, repeats)| (stratum, repeats.len())).collect();
        Self { squares, heuristics, strata, is_independent }
    }

    /// Over all models and sizes first, then at each size, then of each model where there are several.
    pub(super) fn rankings(&self) -> Vec<Ranking> {
        let distinct = |of: fn(&(usize, usize)) -> usize| {
            let mut all: Vec<usize> = self.strata.keys().map(of).collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        let (models, sizes) = (distinct(|it| it.0), distinct(|it| it.1));
        let mut rankings = vec![self.ranking(None, None)];
        if sizes.len() > 1 {
            rankings.extend(sizes.iter().map(|&size| self.ranking(None, Some(size))));
        }
        if models.len() > 1 {
            rankings.extend(models.iter().map(|&model| self.ranking(Some(model), None)));
        }
        rankings
    }

    fn ranking(&self, model: Option<usize>, size: Option<usize>) -> Ranking {
        let is_in = |it: &&(usize, usize)| {
            model.is_none_or(|model| it.0 == model) && size.is_none_or(|size| it.1 == size)
        };
        let strata: Vec<(usize, usize)> = self.strata.keys().filter(is_in).copied().collect();
        let (mut ranked, mut unranked): (Vec<(f64, &str)>, Vec<String>) = (Vec::new(), Vec::new());
        for heuristic in &self.heuristics {
            match self.log_rms(heuristic, &strata) {
                Some(log_rms) => ranked.push((log_rms, heuristic)),
                None => unranked.push(heuristic.clone()),
            }
        }
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        let names: Vec<&str> = ranked.iter().map(|(_, name)| *name).collect();
        let is_better = self.better(&names, &strata);
        let rank = |of: usize| 1 + (0..names.len()).filter(|&other| is_better[other][of]).count();
        let row = |(at, &(log_rms, name)): (usize, &(f64, &str))| RankRow {
            heuristic: name.to_owned(),
            rank: rank(at),
            rms_px: log_rms.exp(),
            to_first: names
                .first()
                .filter(|_| at > 0)
                .and_then(|first| self.ratio([name, first], &strata, level_of_pair(names.len()))),
            to_random: (name != RANDOM.name && names.contains(&RANDOM.name))
                .then(|| self.ratio([name, RANDOM.name], &strata, LEVEL))
                .flatten(),
        };
        let beats_all = |at: &usize| {
            names.len() > 1 && (0..names.len()).all(|other| other == *at || is_better[*at][other])
        };
        Ranking {
            model,
            size,
            winner: (0..names.len()).find(beats_all).map(|at| names[at].to_owned()),
            first: (0..names.len())
                .filter(|&at| rank(at) == 1)
                .map(|at| names[at].to_owned())
                .collect(),
            rows: ranked.iter().enumerate().map(row).collect(),
            unranked,
        }
    }

    fn own(&self, heuristic: &str, stratum: (usize, usize)) -> Option<&BTreeMap<usize, f64>> {
        self.squares.get(&(stratum.0, stratum.1, heuristic.to_owned()))
    }

    /// Mean over the strata; none where it failed too often somewhere.
    fn log_rms(&self, heuristic: &str, strata: &[(usize, usize)]) -> Option<f64> {
        let of_stratum = |&stratum: &(usize, usize)| {
            let own = self.own(heuristic, stratum)?;
            let (count, all) = (own.len() as f64, self.strata[&stratum] as f64);
            let mean = own.values().sum::<f64>() / count;
            let is_often = all - count <= (MOST_FAILURES * all).max(1.0);
            (count > 1.0 && is_often && mean > 0.0).then(|| 0.5 * mean.ln())
        };
        let logs: Option<f64> = strata.iter().map(of_stratum).sum();
        Some(logs? / strata.len() as f64).filter(|mean| mean.is_finite())
    }

    /// Of each heuristic, whether it is shown to be better than each other one.
    fn better(&self, names: &[&str], strata: &[(usize, usize)]) -> Vec<Vec<bool>> {
        let is_better = |one: usize, other: usize| {
            let contrast = self.contrast([names[one], names[other]], strata);
            let contrast = contrast.filter(|it| self.can_tell(strata) && it.log_ratio < 0.0);
            let p = contrast.and_then(|contrast| contrast.p());
            p.is_some_and(|p| p < level_of_pair(names.len()))
        };
        let all = || 0..names.len();
        all()
            .map(|one| all().map(|other| one != other && is_better(one, other)).collect())
            .collect()
    }

    /// Whether there are independent replicates: repeats with noise of their own, or else three models or more.
    fn can_tell(&self, strata: &[(usize, usize)]) -> bool {
        const LEAST_MODELS: usize = 3;
        self.is_independent || blocks(strata).len() >= LEAST_MODELS
    }

    fn contrast(&self, [one, other]: [&str; 2], strata: &[(usize, usize)]) -> Option<Contrast> {
        let pairs = |&stratum: &(usize, usize)| -> Option<Vec<Pair>> {
            let others = self.own(other, stratum)?;
            let both = self.own(one, stratum)?.iter();
            let both =
                both.filter_map(|(repeat, square)| Some((repeat, *square, *others.get(repeat)?)));
            Some(
                both.map(|(&repeat, square, other)| Pair {
                    replicate: (stratum.0, repeat),
                    squares: [square, other],
                })
                .collect(),
            )
        };
        if self.is_independent {
            return Contrast::new(&strata.iter().map(pairs).collect::<Option<Vec<_>>>()?);
        }
        // Repeats share their noise: a model is one replicate.
        let of_block = |block: &usize| {
            let own = strata.iter().filter(|it| it.0 == *block);
            let pairs: Option<Vec<_>> = own.map(pairs).collect();
            Some(Contrast::new(&pairs?)?.log_ratio)
        };
        let ratios: Vec<f64> = blocks(strata).iter().map(of_block).collect::<Option<_>>()?;
        match ratios.as_slice() {
            [alone] => Some(Contrast { log_ratio: *alone, std: 0.0, degrees: 0.0 }),
            several => Contrast::of_blocks(several),
        }
    }

    fn ratio(&self, names: [&str; 2], strata: &[(usize, usize)], level: f64) -> Option<Ratio> {
        let contrast = self.contrast(names, strata)?;
        let interval = self.can_tell(strata).then(|| contrast.interval(1.0 - level)).flatten();
        Some(Ratio { ratio: contrast.ratio(), interval_95: interval })
    }

    /// How far the models agree; none for one.
    pub(super) fn agreement(&self, rankings: &[Ranking]) -> Option<Agreement> {
        let of_models: Vec<&Ranking> =
            rankings.iter().filter(|ranking| ranking.model.is_some()).collect();
        let best = of_models.iter().map(|ranking| Some(ranking.rows.first()?.heuristic.clone()));
        let best: Vec<String> = best.collect::<Option<_>>()?;
        let score = |ranking: &Ranking, name: &String| {
            Some(ranking.rows.iter().find(|row| row.heuristic == *name)?.rms_px)
        };
        let everywhere = self
            .heuristics
            .iter()
            .filter(|name| of_models.iter().all(|ranking| score(ranking, name).is_some()));
        let everywhere: Vec<&String> = everywhere.collect();
        let scores = of_models.iter().map(|ranking| {
            everywhere.iter().filter_map(|name| score(ranking, name)).collect::<Vec<f64>>()
        });
        let concordance = concordance(&scores.collect::<Vec<_>>());
        (!of_models.is_empty()).then_some(Agreement { concordance, best })
    }
}

/// The level of each of all pairs of so many, so that all together keep to theirs (Bonferroni): the intervals that are told then
/// agree with the ranks.
fn level_of_pair(count: usize) -> f64 {
    let pairs = count * count.saturating_sub(1) / 2;
    LEVEL / pairs.max(1) as f64
}

fn blocks(strata: &[(usize, usize)]) -> Vec<usize> {
    let mut blocks: Vec<usize> = strata.iter().map(|it| it.0).collect();
    blocks.dedup();
    blocks
}

/// How many images each heuristic needs for this error.
pub(super) fn targets(cells: &[Cell], heuristics: &[String], target_px: f64) -> Vec<Target> {
    let target = |heuristic: &String| {
        let own: Vec<&Cell> = cells.iter().filter(|cell| cell.heuristic == *heuristic).collect();
        let mut sizes: Vec<usize> = own.iter().map(|cell| cell.size).collect();
        sizes.sort_unstable();
        sizes.dedup();
        let smallest = |reaches: &dyn Fn(&Cell) -> Option<f64>| {
            sizes.iter().copied().find(|&size| {
                let mut at_size = own.iter().filter(|cell| cell.size == size);
                at_size.all(|cell| reaches(cell).is_some_and(|px| px <= target_px))
            })
        };
        Target {
            heuristic: heuristic.clone(),
            size: smallest(&|cell| Some(cell.error?.rms_px)),
            certain_size: smallest(&|cell| Some(cell.interval_95?[1])),
        }
    };
    heuristics.iter().map(target).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Draw, Sample};
    use super::*;

    const REPEATS: usize = 12;

    /// Some repeats and two heuristics, of which one errs half as much; what each makes of a repeat.
    fn ranking(fate: impl Fn(&str, usize) -> Fate) -> Ranking {
        let mut samples = Vec::new();
        for (heuristic, scale) in [("good", 1.0), ("bad", 2.0)] {
            for repeat in 0..REPEATS {
                let fate = fate(heuristic, repeat);
                let error_px = matches!(fate, Fate::Calibrates)
                    .then_some(scale * (1.0 + 0.1 * (scale * repeat as f64).sin()));
                let images = if matches!(fate, Fate::ChoosesNothing) { vec![] } else { vec![1, 2] };
                let sample = Sample {
                    draw: Draw { model: 0, size: 2, repeat },
                    heuristic: heuristic.to_owned(),
                    images,
                    failure: None,
                    cameras: vec![],
                    held_out_px: None,
                };
                samples.push(ScoredSample { sample, error_px, raw_error_px: None });
            }
        }
        let names = ["good", "bad"].map(str::to_owned).to_vec();
        Errors::new(&samples, names, true).rankings().remove(0)
    }

    enum Fate {
        ChoosesNothing,
        Fails,
        Calibrates,
    }

    #[test]
    fn a_pool_that_no_heuristic_can_choose_from_is_held_against_none() {
        let ranking =
            ranking(
                |_, repeat| {
                    if repeat % 3 == 0 { Fate::ChoosesNothing } else { Fate::Calibrates }
                },
            );
        assert_eq!((ranking.unranked.len(), ranking.winner.as_deref()), (0, Some("good")));
    }

    #[test]
    fn a_heuristic_that_fails_where_another_does_not_is_not_compared() {
        for fate in [|| Fate::Fails, || Fate::ChoosesNothing] {
            let ranking = ranking(|heuristic, repeat| {
                if heuristic == "good" && repeat % 3 == 0 { fate() } else { Fate::Calibrates }
            });
            assert_eq!((ranking.unranked, ranking.winner), (vec!["good".to_owned()], None));
        }
        // A choice that gives no calibration is held against those that made it, though all did.
        let ranking =
            ranking(|_, repeat| if repeat % 3 == 0 { Fate::Fails } else { Fate::Calibrates });
        assert_eq!(ranking.unranked.len(), 2);
    }
}
