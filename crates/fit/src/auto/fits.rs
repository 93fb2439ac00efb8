//! The fits of one model: of everything, and of everything but what is held out.

use crate::folds::{FOLDS, Fold};
use crate::model_fit::ModelFit;
use crate::series::Series;

/// A model fitted to everything, and anew without each part that is held out; `None` where the rest does not settle it.
pub(super) struct Fits {
    pub whole: ModelFit,
    /// Without each fold; nothing of a fold in which no group is used.
    pub folds: Vec<Option<ModelFit>>,
    /// Without the cold and without the hot end.
    pub ends: Vec<Option<ModelFit>>,
}

impl Fits {
    /// By `make`, which fits the groups that are kept. `None` where all of them do not settle the model.
    pub fn of(series: &Series<'_>, make: impl Fn(&dyn Fn(usize) -> bool) -> Option<ModelFit>) -> Option<Self> {
        let fold = |fold: &Fold| {
            fold.rows().any(|group| series.is_used(group)).then(|| make(&|group| !fold.has(group))).flatten()
        };
        Some(Self {
            whole: make(&|_| true)?,
            folds: series.folds().iter().map(fold).collect(),
            ends: ends(series).iter().map(|end| make(&|group| !end.contains(&group))).collect(),
        })
    }

    /// Each fit with the other model's of the same groups. `None` where the two of everything make none.
    pub fn with(&self, other: &Self, join: impl Fn(&ModelFit, &ModelFit) -> Option<ModelFit>) -> Option<Self> {
        let all = |own: &[Option<ModelFit>], others: &[Option<ModelFit>]| {
            own.iter().zip(others).map(|(own, other)| join(own.as_ref()?, other.as_ref()?)).collect()
        };
        Some(Self {
            whole: join(&self.whole, &other.whole)?,
            folds: all(&self.folds, &other.folds),
            ends: all(&self.ends, &other.ends),
        })
    }
}

/// The used groups at the cold and at the hot end, as many each as a fold.
pub(super) fn ends(series: &Series<'_>) -> [Vec<usize>; 2] {
    let mut used: Vec<usize> = (0..series.rate.len()).filter(|&group| series.is_used(group)).collect();
    used.sort_by(|&a, &b| series.temperature[a].total_cmp(&series.temperature[b]));
    let end = used.len() / FOLDS;
    [used[..end].to_vec(), used[used.len() - end..].to_vec()].map(|mut end| {
        end.sort_unstable();
        end
    })
}
