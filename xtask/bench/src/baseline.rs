//! Runs that are kept, and what has changed since: ratios on one machine.

use crate::curve::Curve;
use crate::failure::Failure;
use crate::machine::Machine;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// A run that was kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Baseline {
    /// Where it ran.
    pub machine: Machine,
    /// Seconds of every point, by scene, curve and setting.
    pub seconds: BTreeMap<String, f64>,
    /// Errors of every point, by the same names.
    pub errors: BTreeMap<String, f64>,
    /// Instructions of the scenes that were counted.
    #[serde(default)]
    pub instructions: BTreeMap<String, u64>,
}

/// What has changed in one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// The scene.
    pub scene: String,
    /// Points in both runs.
    pub points: usize,
    /// The geometric mean of seconds now over seconds then.
    pub ratio: f64,
    /// The point that became slower most, and by which ratio.
    pub worst: (String, f64),
    /// Points whose error has more than doubled, whatever its sign.
    pub less_exact: Vec<String>,
    /// Instructions now over instructions then, where both were counted.
    pub instructions: Option<f64>,
}

/// Errors below this are rounding, and not compared.
const ROUNDING: f64 = 1e-9;

impl Baseline {
    /// This run.
    pub fn of(runs: &[(String, Vec<Curve>)], instructions: BTreeMap<String, u64>) -> Self {
        let mut kept = Self {
            machine: Machine::here(),
            seconds: BTreeMap::new(),
            errors: BTreeMap::new(),
            instructions,
        };
        for (scene, curves) in runs {
            for curve in curves {
                for p in &curve.points {
                    let key = format!("{scene} / {} / {}", curve.name, p.setting);
                    kept.seconds.insert(key.clone(), p.seconds);
                    kept.errors.insert(key, p.error);
                }
            }
        }
        kept
    }

    /// Reads one.
    ///
    /// # Errors
    /// If there is no such file, or it holds something else.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let named = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        let text = std::fs::read_to_string(path).map_err(|e| Failure::Failed(named(&e).into()))?;
        serde_json::from_str(&text).map_err(|e| Failure::Failed(named(&e).into()))
    }

    /// Writes it.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Failure> {
        let named = |e: std::io::Error| format!("{}: {e}", path.display());
        let text = serde_json::to_string_pretty(self)?;
        std::fs::write(path, text).map_err(|e| Failure::Failed(named(e).into()))
    }

    /// What has changed since then, scene by scene, in what both have.
    ///
    /// # Errors
    /// If they ran on different machines, whose seconds cannot be compared, or have no point in common.
    pub fn changes_since(&self, then: &Self) -> Result<Vec<Change>, Failure> {
        if self.machine != then.machine {
            let told = format!(
                "the baseline was made on another machine ({}; this is {}): seconds of two machines \
                 are not compared",
                then.machine, self.machine
            );
            return Err(Failure::Failed(told.into()));
        }
        let scene_of = |key: &str| key.split(" / ").next().unwrap_or_default().to_owned();
        let mut scenes: BTreeMap<String, Vec<(&String, f64)>> = BTreeMap::new();
        for (key, now) in &self.seconds {
            if let Some(before) = then.seconds.get(key) {
                let ratio = now / before;
                scenes.entry(scene_of(key)).or_default().push((key, ratio));
            }
        }
        if scenes.is_empty() {
            let told = "the baseline has no point of this run: nothing is compared";
            return Err(Failure::Failed(told.into()));
        }
        let all = scenes.into_iter();
        Ok(all.map(|(scene, r)| self.change(then, scene, &r)).collect())
    }

    fn change(&self, then: &Self, scene: String, ratios: &[(&String, f64)]) -> Change {
        let logs: f64 = ratios.iter().map(|(_, r)| r.ln()).sum();
        let worst = ratios.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        // Some errors are angles with a sign.
        let error = |of: &Self, key: &String| of.errors.get(key).map_or(f64::NAN, |e| e.abs());
        let less_exact = |key: &&String| {
            let now = error(self, key);
            !(now <= ROUNDING) && !(now <= 2.0 * error(then, key))
        };
        let keys = ratios.iter().map(|(key, _)| *key);
        let counted = |of: &Self| of.instructions.get(&scene).map(|&n| n as f64);
        Change {
            points: ratios.len(),
            ratio: (logs / ratios.len() as f64).exp(),
            worst: worst.map_or_else(Default::default, |(key, r)| ((*key).clone(), *r)),
            less_exact: keys.filter(less_exact).cloned().collect(),
            instructions: counted(self).zip(counted(then)).map(|(now, old)| now / old),
            scene,
        }
    }
}
