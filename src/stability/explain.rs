//! What findings mean, how they are found and what to do about them, in plain words.

use super::FindingId;
use super::clusters::{FEWEST, LEAST_GAP_PX, least_ratio};
use super::inside::{LEAST_EFFECT_PX, LEAST_PATTERN_PX, MOST_P, MOST_SIGMA_RATIO, TAIL};
use super::overlap::MOST_SHARED;
use super::prediction::remarks::MOST_BIRGE;
use super::screen::FEW_IMAGES;
use super::spread::MOST_WITHOUT_RAY;
use super::verdict::basis::{FEW_RUNS, LEAST_REGION, OPEN_IN_SHARE};

/// A kind of finding, explained.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Explanation {
    /// The finding in a few words.
    pub short: &'static str,
    /// What it means for the calibration.
    pub meaning: &'static str,
    /// How it is found, with its thresholds.
    pub found: String,
    /// What to do about it.
    pub advice: &'static str,
}

impl FindingId {
    /// All kinds, in their order.
    pub fn all() -> impl Iterator<Item = Self> {
        TEXTS.iter().map(|texts| texts.id)
    }

    /// What it means, how it is found and what to do.
    pub fn explanation(self) -> Explanation {
        let Texts { short, meaning, found, advice, .. } = TEXTS[self as usize];
        Explanation { short, meaning, found: with_thresholds(found), advice }
    }
}

/// The thresholds are the code's own, by the names that they have there.
fn with_thresholds(text: &str) -> String {
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let thresholds = [
        ("{FEW_RUNS}", FEW_RUNS.to_string()),
        ("{LEAST_REGION}", percent(LEAST_REGION)),
        ("{OPEN_IN_SHARE}", percent(OPEN_IN_SHARE)),
        ("{MOST_SHARED}", percent(MOST_SHARED)),
        ("{MOST_BIRGE}", MOST_BIRGE.to_string()),
        ("{MOST_P}", MOST_P.to_string()),
        ("{LEAST_EFFECT_PX}", LEAST_EFFECT_PX.to_string()),
        ("{LEAST_PATTERN_PX}", LEAST_PATTERN_PX.to_string()),
        ("{MOST_SIGMA_RATIO}", MOST_SIGMA_RATIO.to_string()),
        ("{TAIL}", TAIL.to_string()),
        ("{FEW_IMAGES}", percent(FEW_IMAGES)),
        ("{MOST_WITHOUT_RAY}", percent(MOST_WITHOUT_RAY)),
        ("{FEWEST}", FEWEST.to_string()),
        ("{LEAST_GAP_PX}", LEAST_GAP_PX.to_string()),
        ("{least_ratio(6)}", least_ratio(6).to_string()),
        ("{least_ratio(20)}", least_ratio(20).to_string()),
    ];
    thresholds.iter().fold(text.to_owned(), |text, (name, value)| text.replace(name, value))
}

/// One entry of the list below; `found` has thresholds by name.
struct Texts {
    id: FindingId,
    short: &'static str,
    meaning: &'static str,
    found: &'static str,
    advice: &'static str,
}

// An explanation is found by its place: the list has the order of the kinds, and none is left out.
const _: () = {
    let mut at = 0;
    while at < TEXTS.len() {
        assert!(TEXTS[at].id as usize == at);
        at += 1;
    }
    assert!(at == FindingId::Reading as usize + 1);
};

const TEXTS: [Texts; 31] = [
    Texts {
        id: FindingId::OpenDirection,
        short: "the observations leave a combination of parameters open",
        meaning: "Parameters can be changed together, as the finding says, without moving any observation: their values are an \
            accident of where the adjustment began, and so is every number about them.",
        found: "The information that a run's observations hold on the intrinsics, with poses and points free, is scaled and \
            decomposed. A direction below 1e-10 of the largest is open. The camera has this finding when {OPEN_IN_SHARE} or \
            more of its runs leave one open; a run that does is no sample in any case.",
        advice: "Take images that tell the parameters apart: turn the camera about its axis, change the distance, fill the image. \
            Or estimate less (--refine), take a model with fewer parameters, or say what is known (--prior).",
    },
    Texts {
        id: FindingId::NoEstimate,
        short: "no parameter of the camera was estimated",
        meaning: "All of its values were held, or refining it failed in every run. Values that were held repeat to the last bit and \
            say nothing.",
        found: "No run has a parameter of the camera whose state is `estimated`. As COLMAP left the runs, a value is presumed \
            held when runs that differ have it to the last bit, or a principal point is exactly the image's centre.",
        advice: "Let COLMAP or calibstab refine the intrinsics (--refine), and look at why refining failed.",
    },
    Texts {
        id: FindingId::NotRepeated,
        short: "there is one calibration, and no covariance of it",
        meaning: "One calibration cannot disagree with itself. With images and points the run's own adjustment would at least say \
            how well it determines the camera; a lone cameras file does not.",
        found: "Fewer than two runs count, and none has a covariance.",
        advice: "Repeat the reconstruction, with other seeds or, better, other images, and give all runs together. Copies of one \
            run are no repeats. With images and points, `calibstab resample` makes samples out of one reconstruction.",
    },
    Texts {
        id: FindingId::SkippedRun,
        short: "a run could not be read and was left out",
        meaning: "The numbers are about the other runs. If those that cannot be read are those that went wrong, the rest looks \
            better than the experiment is.",
        found: "Its files are missing, damaged, or no COLMAP model; --skip-bad was given, and so it is no error.",
        advice: "Repair or repeat the run; the finding has the file and the line.",
    },
    Texts {
        id: FindingId::DuplicateRuns,
        short: "runs are the same to the last bit",
        meaning: "A copied folder, or a repeat with the same seed on the same images. Copies agree for that reason alone; they \
            count once.",
        found: "Cameras are compared bit by bit, and where there are images, those and the points too. It bears on the verdict \
            when fewer than two runs are left without the copies.",
        advice: "Repeat with another seed, or better with other images.",
    },
    Texts {
        id: FindingId::BogusCamera,
        short: "a run has a camera that no real lens could be",
        meaning: "The adjustment ended in a wrong place, as COLMAP's does when too few images hang together. The run stays in the \
            statistics unless --exclude-flagged is given.",
        found: "COLMAP's own bounds: focal length beyond 0.1 to 10 times the larger image side, principal point outside the \
            image, a small coefficient beyond 1. Besides, fx and fy that differ by more than a factor of 2, and of models \
            without small coefficients an impossible field of view or a fold close to the axis.",
        advice: "Look at the reconstruction; repeat it with better start values or more images.",
    },
    Texts {
        id: FindingId::FewImages,
        short: "a run registered far fewer images than its group",
        meaning: "The reconstruction broke off or split. Its calibration rests on less than the others', and its spread from them \
            is not that of a repeat. It stays in the statistics unless --exclude-flagged is given.",
        found: "It has less than {FEW_IMAGES} of the median number of images of its group.",
        advice: "Repeat the run, or leave it out with --exclude-flagged and say so.",
    },
    Texts {
        id: FindingId::MissingCamera,
        short: "a run lacks a camera that others of its group have",
        meaning: "None of the camera's images was registered there, or they were given to another camera. The camera has fewer \
            samples than there are runs.",
        found: "By the matching of cameras: see camera-match.",
        advice: "If the camera should be there, look at how cameras were matched (--match), then at the reconstruction.",
    },
    Texts {
        id: FindingId::LostRuns,
        short: "some runs gave no calibration of a camera that they have",
        meaning: "Refining failed there, or left the camera open. The numbers are about the other runs, and those are the ones that \
            went well: a repeat may fail as these did.",
        found: "The camera took images in the run, and its samples are `failed`. The finding refinement-failed has the reason.",
        advice: "See refinement-failed. The verdict stays doubtful until every run that is given counts.",
    },
    Texts {
        id: FindingId::RefinementFailed,
        short: "refining a run or one of its cameras came to nothing",
        meaning: "The adjustment did not converge, could not begin, or does not determine the camera. What stands in its files is \
            no optimum, and so it is no sample.",
        found: "The adjustment must end by its stopping rule or at the limits of rounding, and no direction of the camera's \
            parameters may be open.",
        advice: "The finding has the reason. Check the run's images; estimate fewer parameters; try --loss cauchy:1 against \
            outliers.",
    },
    Texts {
        id: FindingId::NotRefined,
        short: "a group was not refined, as some of its runs cannot be",
        meaning: "COLMAP stops short of the optimum, so values that it left and refined ones are never mixed: all runs of the group \
            are as COLMAP left them, and there is no covariance.",
        found: "Some runs of the group have images and points, others do not.",
        advice: "Give the images and points of all runs, or the cameras of all alone.",
    },
    Texts {
        id: FindingId::UnusedCamera,
        short: "a camera stands in a model and took no image",
        meaning: "What stands there is what COLMAP started from. It does not count.",
        found: "No image of the run names the camera.",
        advice: "Nothing, unless images of it should be there.",
    },
    Texts {
        id: FindingId::MixedCameras,
        short: "a camera has several models or image sizes in one group",
        meaning: "Their parameters do not compare, so each model and size is a population, with a verdict of its own.",
        found: "Cameras matched as the same have different model names or image sizes.",
        advice: "Give runs of one model and size; calibstab compare sets different models against each other in pixels.",
    },
    Texts {
        id: FindingId::OutlierRun,
        short: "a run lies far from all others",
        meaning: "One calibration disagrees with the rest by more than chance, so mean, std and spread describe neither it nor \
            them. Such a run is mostly one that converged to a wrong place; and what happened once may happen again.",
        found: "From {FEWEST} runs on, by the distances in px between any two calibrations, turned onto each other: the run is at \
            least {LEAST_GAP_PX} px from every other one, and as many median distances as chance gives in one case of a \
            hundred ({least_ratio(6)} with 6 runs, {least_ratio(20)} with 20). Or its lens has no ray in more than \
            {MOST_WITHOUT_RAY} of what the others see.",
        advice: "Look at the run: its images, its points, its residuals. Leave it out only for a reason that you can name.",
    },
    Texts {
        id: FindingId::Clusters,
        short: "the runs settled in several places",
        meaning: "The runs fall into parts that agree within and disagree between: two minima, two settings of a lens, two sets of \
            images. One mean describes none of them.",
        found: "As for outlier-run, with two runs or more on both sides of the gap; from {FEWEST} runs on. Statistics of each \
            part are in the report.",
        advice: "Find out what the runs of one part have in common; group them by it (--group-by).",
    },
    Texts {
        id: FindingId::Birge,
        short: "the runs differ by more than their adjustments predict",
        meaning: "Each adjustment says how well its observations determine the camera, if keypoints err by chance alone. The runs \
            differ by more than that: something else changes between them, such as wrong matches, a lens model that is wrong in \
            another way for every scene, or a camera that was touched. A small ratio clears nothing: what is wrong in all runs \
            alike does not show in it.",
        found: "The Birge ratio, the root of the squared differences from the weighted mean in units of what the covariances \
            allow, corrected for the observations that runs share, is above {MOST_BIRGE}.",
        advice: "Rely on the spread and not on the stds of an adjustment. Look for the run that is furthest off, filter matches \
            more strictly, or try a lens model with another term.",
    },
    Texts {
        id: FindingId::ClusteredErrors,
        short: "errors of one image depend on each other",
        meaning: "The std by BA takes the errors of all keypoints for independent. Those of one image are not: motion blur, a rolling \
            shutter, a wrong pose that its own matches agree with, or a lens model that is wrong in the same way in every image \
            move many of them together. The clustered covariance in analysis.json allows for that; the std by BA, the predicted \
            spread and the Birge ratio do not, and promise too much where the ratio is above 1. Below 1 errors of one image cancel.",
        found: "The sandwich covariance with images as clusters (Liang and Zeger 1986): scores of the intrinsics, poses and points \
            projected out, summed by image. Its mean ratio to the plain one is chi-square over its degrees if errors are independent, \
            the degrees from each image's share in the information and the tails of the residuals. The finding needs a ratio outside \
            of 99.9 % of that in half of the runs that tell, from 30 images on.",
        advice: "Take the clustered std where it is the larger one, and trust the spread of the runs before either. Look at the \
            residual patterns, and try a lens model with another term or --loss cauchy:1.",
    },
    Texts {
        id: FindingId::HeldParameter,
        short: "what was held wants to move, and moves the lens",
        meaning: "A parameter that the adjustment holds, or that the lens model lacks, is away from where the observations want it. \
            All runs hold it at the same place and agree on what that does to the others: no spread can show it, and on real \
            photographs it is often the largest error. A principal point held at the image's centre moves the focal length by \
            percents.",
        found: "Of the principal point, one focal length for both directions, and the next radial term each that is held: the \
            score test for freeing it in all cameras of a run, at the run's optimum. The finding needs twice the median p of the \
            runs below {MOST_P}, and that freeing it moves the lens by more than {LEAST_EFFECT_PX} px, the median of the runs, \
            RMS over the region with rotation removed. Where it is near that, the run is adjusted again with the class free.",
        advice: "Free it (--refine principal-point, or a model with another term) where the std of what is freed stays small, \
            or hold it at a value that is known. What all runs share is settled by a reference alone.",
    },
    Texts {
        id: FindingId::ResidualPattern,
        short: "the residuals have a pattern over the image",
        meaning: "In parts of the image all projections miss their keypoints the same way, in all runs alike: a lens that this model \
            cannot be, such as a missing radial term, or keypoints that are off by where they lie. No spread shows it, and the \
            lens is off by more than the pattern, as poses, points and parameters have taken what they could of it.",
        found: "Mean residuals over cells of the image (twelve in a row, fewer where too little was observed) and, outward and along \
            the tangent, over rings about the principal point are tested together against independent noise: F, with the part \
            that the adjustment itself takes away. The camera has this finding when twice the median of its runs' p-values is \
            below {MOST_P} and the RMS of the means, less that of noise, is above {LEAST_PATTERN_PX} px in half of the runs: lens models \
            that are right leave half as much in real keypoints.",
        advice: "Look at the plots of the residuals and at residuals.csv: arrows that point outward or inward by rings ask for a radial \
            term, that is a model with more of them; others for tangential terms or a free principal point (--refine).",
    },
    Texts {
        id: FindingId::HeavyTails,
        short: "some points fit far worse than most",
        meaning: "Wrong matches, moving things, or blurred keypoints. With a squared loss they weigh most of all: sigma is a mean \
            of good and bad, and the calibration varies more than the good points alone would let it. No ratio of observed to \
            predicted spread shows it, since sigma has grown too.",
        found: "The squares of a point's residuals are summed and held against chi-square. Sigma is more than {MOST_SIGMA_RATIO} times \
            what the median point says, and more points than {TAIL} of all lie beyond what {TAIL} of normal ones would (p below \
            {MOST_P}).",
        advice: "Refine with a loss that lets them count less (--loss huber, or cauchy), or filter points by their error in COLMAP.",
    },
    Texts {
        id: FindingId::SharedObservations,
        short: "the runs share nearly all of their observations",
        meaning: "They repeat the solver and not the measurement: the same matched points, adjusted again, must agree. How far \
            another set of images would move the calibration, they cannot show.",
        found: "More than {MOST_SHARED} of the observations are shared by pairs of runs: the same image name, the same keypoint. \
            Below, the spread is corrected by 1 / sqrt(1 - share); above, nothing corrects it.",
        advice: "Repeat with other images, or with other subsets of them.",
    },
    Texts {
        id: FindingId::NoSpread,
        short: "calibrations could not be compared in the image",
        meaning: "There are two calibrations or more, but no part of the image where their rays can be compared.",
        found: "Their lenses have no ray in common, all but one are set aside for lack of rays, or their images differ in size.",
        advice: "calibstab inspect shows what each sees; mostly one or all of them are no real lens.",
    },
    Texts {
        id: FindingId::MixedStates,
        short: "a parameter was held in some runs and estimated in others",
        meaning: "Its statistics are of the runs that estimated it. The spread in px is of all, and so mixes two experiments.",
        found: "By our own refinement; as COLMAP left the runs, by values that repeat to the last bit.",
        advice: "Make groups of the runs that held it and of those that did not.",
    },
    Texts {
        id: FindingId::CameraPerImage,
        short: "every image has a camera of its own",
        meaning: "COLMAP's default, which is seldom meant: each camera is determined by one image alone, and weakly.",
        found: "Each camera of each run took one image, and some run has several.",
        advice: "Reconstruct with ImageReader.single_camera, or take them for samples of one camera with --pool.",
    },
    Texts {
        id: FindingId::CameraMatch,
        short: "how the cameras of different runs were matched",
        meaning: "COLMAP numbers cameras anew in every run. If they are matched wrongly, everything else is wrong.",
        found: "By the images that they share, else by the folder of their images, else by the pattern of names, else by \
            CAMERA_ID; --match says which.",
        advice: "Check that it is what you mean.",
    },
    Texts {
        id: FindingId::Refinement,
        short: "how the runs were refined, and what did not take part",
        meaning: "Poses, points and intrinsics were adjusted to the optimum before parameters were compared. What was left out of \
            that is listed.",
        found: "From the adjustments of the group's runs.",
        advice: "Nothing, as long as little is left out.",
    },
    Texts {
        id: FindingId::SmallRegion,
        short: "the spread is over a small part of the image",
        meaning: "Calibrations differ most where nothing was observed, at the borders and in the corners. A spread over the middle \
            says nothing of them.",
        found: "Less than {LEAST_REGION} of the image's cells were compared: those that at least half of the runs observed \
            (--region observed), or the part that --region asked for, and where every lens has a ray.",
        advice: "Take images in which the scene fills the frame, corners included; or ask for a region because nothing else is \
            used.",
    },
    Texts {
        id: FindingId::Fold,
        short: "the lens folds inside its own image",
        meaning: "From some radius on, the polynomial of the lens model turns back, and no ray leads to the pixels beyond. No real \
            lens does so: the distortion was not determined out there, and is wrong somewhat before the fold, too.",
        found: "Of the mean of the runs, from the middle of the image to its corners. calibstab inspect says at which radius.",
        advice: "Take images with points in the corners, or a lens model with fewer terms.",
    },
    Texts {
        id: FindingId::NoRay,
        short: "a part of the image has no ray, as the lens ends before it",
        meaning: "The model sees no further than some angle, and the image is larger, as with the circle of a fisheye. The std in \
            px leaves those pixels out.",
        found: "Cells of a grid of 60 columns are unprojected by the mean of the runs.",
        advice: "Nothing, if the corners are black.",
    },
    Texts {
        id: FindingId::FewRuns,
        short: "there are too few runs to tell",
        meaning: "A std from n samples is itself uncertain: from three it may be half or six times the true one.",
        found: "Fewer than {FEW_RUNS} calibrations count; the interval is that of chi-square with n - 1 degrees.",
        advice: "Give more runs; ten are a good number. `calibstab resample` makes samples out of one reconstruction.",
    },
    Texts {
        id: FindingId::Reading,
        short: "something about how the files were read",
        meaning: "A remark and no error: two forms of a model side by side, frames that overrule poses, and the like.",
        found: "While reading.",
        advice: "Check that the file that was read is the one you mean.",
    },
];

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_finding_is_listed_once_and_explained_in_words_of_its_own() {
        let schema = serde_json::to_value(schemars::schema_for!(FindingId)).unwrap();
        let kinds = schema["oneOf"].as_array().unwrap().len();
        let names: BTreeSet<&str> = FindingId::all().map(FindingId::name).collect();
        assert_eq!((kinds, names.len()), (TEXTS.len(), TEXTS.len()));
        let mut said = BTreeSet::new();
        for id in FindingId::all() {
            let Explanation { short, meaning, found, advice } = id.explanation();
            for text in [short, meaning, &found, advice] {
                assert!(
                    text.len() > 12 && !text.contains("  ") && !text.contains('{'),
                    "{id:?}: {text}"
                );
                assert!(!text.contains("accura"), "{id:?}: only a reference tells that");
            }
            said.extend([short.to_owned(), meaning.to_owned(), found]);
        }
        assert_eq!(said.len(), 3 * TEXTS.len());
    }
}
