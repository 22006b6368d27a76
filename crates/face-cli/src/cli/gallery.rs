//! Files and pictures of fits, made on idle threads beside the next fit.

use super::args::{Format, Pictures};
use super::draw::{Cell, Fitted, Shape, Sheets};
use super::error::Failure;
use super::output::Output;
use super::shape_files::{self, Fields};
use super::source::Source;
use face_rig::fit::Goal;
use face_rig::rig::AffineMap;
use face_scenes::Target;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// End of the scale of distances, millimeters: the same for every fit of every face.
const SCALE: f64 = 10.0;

/// A fit that is done.
pub struct Finished {
    /// Its place among the fits.
    pub place: usize,
    pub name: String,
    /// The line above its picture, and the shorter one above its place on a sheet of many.
    pub heading: String,
    pub caption: String,
    pub positions: Vec<[f64; 3]>,
    pub jaw: AffineMap,
    pub fields: Option<Fields>,
}

/// Takes finished fits from any thread.
pub struct Gallery<'s> {
    source: &'s Source,
    folder: PathBuf,
    formats: Vec<Format>,
    pictures: Pictures,
    /// One target fills a sheet of its own.
    alone: bool,
    sheets: Option<Sheets>,
    made: Mutex<BTreeMap<usize, Result<Made, Failure>>>,
}

/// What became of a fit.
struct Made {
    files: Vec<String>,
    cell: Option<Cell>,
}

impl<'s> Gallery<'s> {
    /// A gallery for `count` fits in the folder of `out`.
    pub fn new(source: &'s Source, out: &Output, count: usize) -> Result<Self, Failure> {
        let drawn = out.pictures != Pictures::None;
        Ok(Self {
            source,
            folder: out.folder().to_path_buf(),
            formats: out.formats.clone(),
            pictures: out.pictures,
            alone: count == 1,
            sheets: drawn.then(|| Sheets::new(source, SCALE)).transpose()?,
            made: Mutex::default(),
        })
    }

    /// Writes the files of a fit and draws it.
    pub fn add(&self, target: &Target, finished: &Finished) {
        let made = self.make(target, finished);
        let mut all = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        all.insert(finished.place, made);
    }

    /// Has something gone wrong, so that further fits are for nothing?
    pub fn failed(&self) -> bool {
        let made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        made.values().any(Result::is_err)
    }

    fn make(&self, target: &Target, finished: &Finished) -> Result<Made, Failure> {
        let mut files = shape_files::write(
            &self.folder,
            &self.formats,
            &finished.name,
            &self.source.scene,
            finished.fields.as_ref(),
            &finished.positions,
        )?;
        let mut cell = None;
        if let Some(sheets) = &self.sheets {
            let fitted = Shape::new(self.source, &finished.positions, &finished.jaw);
            let dense = target.dense.clone();
            let dense = dense.map(|points| Shape::of_skin(self.source, points));
            let observed = |goal: &Goal| goal.point.position(&finished.positions);
            let fit = Fitted {
                heading: &finished.heading,
                caption: &finished.caption,
                fitted: &fitted,
                target: dense.as_ref(),
                observed: &target.landmarks.iter().map(observed).collect::<Vec<_>>(),
                wanted: &target
                    .landmarks
                    .iter()
                    .map(|g| g.position)
                    .collect::<Vec<_>>(),
            };
            if !self.alone {
                cell = Some(sheets.cell(&fit)?);
            }
            if self.alone || self.pictures == Pictures::All {
                let file = format!("{}.png", finished.name);
                sheets.rows(&self.folder.join(&file), &self.source.scene.name, &[fit])?;
                files.push(file);
            }
        }
        Ok(Made { files, cell })
    }

    /// Draws the sheet of all fits, and tells `out` of every file.
    pub fn finish(self, out: &mut Output) -> Result<(), Failure> {
        let made = self.made.into_inner();
        let mut cells = Vec::new();
        for made in made.unwrap_or_else(PoisonError::into_inner).into_values() {
            let made = made?;
            out.wrote(made.files);
            cells.extend(made.cell);
        }
        if let (Some(sheets), false) = (&self.sheets, cells.is_empty()) {
            sheets.many(&out.path("fits.png"), &self.source.scene.name, &cells)?;
        }
        Ok(())
    }
}
