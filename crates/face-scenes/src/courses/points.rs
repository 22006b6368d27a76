//! Where the points of a drawing are.

use super::spec::{CourseSpec, OverSpec, PlaceOnFace, PointSpec};
use crate::defect::CourseDefect;
use crate::load::Place;
use crate::shape::shapes;
use crate::{Landmark, SceneError};
use face_rig::anatomy::{Course, EmbeddedPoint, Section, TetLocator, resampled, smoothed, wrapped};
use fem_assembly::RigidSurface;
use fem_assembly::mesh::SimplexMesh;
use std::collections::BTreeMap;

/// Straight pieces between two points of a smooth line.
const PIECES: usize = 8;
/// Pieces of a line that is laid over a solid, meters.
const LAID_STEP: f64 = 5e-4;

/// What drawings are made on.
pub(crate) struct Paper<'a> {
    pub place: &'a Place<'a>,
    pub mesh: &'a SimplexMesh<3>,
    pub locator: TetLocator<'a>,
    pub landmarks: &'a [Landmark],
    pub embedding: &'a BTreeMap<u32, EmbeddedPoint>,
}

/// A drawing as it stands in the scene, or its mirror image.
#[derive(Clone, Copy)]
pub(super) struct Drawing<'a> {
    /// Where it stands in the scene file.
    pub field: &'a str,
    pub name: &'a str,
    pub spec: &'a CourseSpec,
    pub mirrored: bool,
}

impl Paper<'_> {
    pub(super) fn refuse(&self, field: &str, defect: CourseDefect) -> SceneError {
        self.place.field(field, defect)
    }

    /// The drawing in meters, smoothed and laid over its solids.
    pub(super) fn course(&self, drawing: Drawing) -> Result<Course, SceneError> {
        let spec = drawing.spec;
        let refused = |defect| self.refuse(drawing.field, defect);
        let section = self.section(drawing).map_err(refused)?;
        let mut lines = Vec::new();
        for (l, points) in spec.lines.iter().enumerate() {
            let at = |(p, point)| self.point(drawing, (l, p), point);
            let line = points.iter().enumerate().map(at);
            lines.push(line.collect::<Result<Vec<_>, _>>().map_err(refused)?);
        }
        let closed = spec.closed;
        let mut course = Course {
            lines,
            closed,
            section,
        };
        // Before splines turn one bad number into many.
        course.check().map_err(|error| {
            let name = drawing.name.to_owned();
            refused(CourseDefect::Course { name, error })
        })?;
        if spec.smooth {
            let smooth = |line: &mut Vec<[f64; 3]>| *line = smoothed(line, closed, PIECES);
            course.lines.iter_mut().for_each(smooth);
        }
        for over in &spec.over {
            self.lay(drawing, over, &mut course)?;
        }
        Ok(course)
    }

    fn section(&self, drawing: Drawing) -> Result<Section, CourseDefect> {
        let scale = self.place.scale;
        let CourseSpec {
            radius,
            thickness,
            width,
            normal,
            ..
        } = *drawing.spec;
        match (radius, thickness, width, normal) {
            (Some(radius), None, None, None) => Ok(Section::Round {
                radius: radius * scale,
            }),
            (None, Some(thickness), None, None) => Ok(Section::Sheet {
                thickness: thickness * scale,
                rounded: false,
            }),
            (None, Some(thickness), Some(width), Some(normal)) => {
                let [x, y, z] = normal;
                let x = if drawing.mirrored { -x } else { x };
                Ok(Section::Strap {
                    width: width * scale,
                    thickness: thickness * scale,
                    normal: [x, y, z],
                })
            }
            _ => Err(CourseDefect::Section {
                name: drawing.name.to_owned(),
            }),
        }
    }

    fn point(
        &self,
        drawing: Drawing,
        at: (usize, usize),
        point: &PointSpec,
    ) -> Result<[f64; 3], CourseDefect> {
        let scale = self.place.scale;
        let turned = |[x, y, z]: [f64; 3]| match drawing.mirrored {
            true => [-x * scale, y * scale, z * scale],
            false => [x, y, z].map(|v| v * scale),
        };
        match point {
            PointSpec::At(x) => Ok(turned(*x)),
            PointSpec::On(on) => {
                let base = self.base(drawing, at, on)?;
                let offset = turned(on.offset);
                Ok(std::array::from_fn(|i| base[i] + offset[i]))
            }
        }
    }

    fn base(
        &self,
        drawing: Drawing,
        at: (usize, usize),
        on: &PlaceOnFace,
    ) -> Result<[f64; 3], CourseDefect> {
        let name = || drawing.name.to_owned();
        let position = |p: &EmbeddedPoint| p.position(self.mesh.nodes());
        match (on.landmark, on.vertex, &on.between, on.at) {
            (Some(landmark), None, None, None) => {
                let wanted = match drawing.mirrored {
                    true => mirror_image(landmark)
                        .ok_or_else(|| CourseDefect::NoMirrorImage { name: name() })?,
                    false => landmark,
                };
                let found = self.landmarks.iter().find(|l| l.index == wanted);
                let found = found.map(|l| position(&l.point));
                found.ok_or_else(|| CourseDefect::NoLandmark {
                    name: name(),
                    landmark: wanted,
                })
            }
            (None, Some(_), None, None) if drawing.mirrored => {
                Err(CourseDefect::NoMirrorImage { name: name() })
            }
            (None, Some(vertex), None, None) => {
                let found = self.embedding.get(&vertex).map(position);
                found.ok_or_else(|| CourseDefect::NoVertex {
                    name: name(),
                    vertex,
                })
            }
            (None, None, Some([from, to]), share) => {
                let from = self.point(drawing, at, from)?;
                let to = self.point(drawing, at, to)?;
                let share = share.unwrap_or(0.5);
                Ok(std::array::from_fn(|i| from[i] + share * (to[i] - from[i])))
            }
            _ => Err(CourseDefect::Point {
                name: name(),
                line: at.0,
                point: at.1,
            }),
        }
    }

    fn lay(
        &self,
        drawing: Drawing,
        over: &OverSpec,
        course: &mut Course,
    ) -> Result<(), SceneError> {
        let clearance = over.clearance * self.place.scale;
        if !(clearance >= 0.0 && clearance.is_finite()) {
            let defect = CourseDefect::NotPositive {
                name: drawing.name.to_owned(),
                what: "clearance",
                value: over.clearance,
            };
            return Err(self.refuse(drawing.field, defect));
        }
        let field = format!("{}.along.over", drawing.field);
        let spacing = 1e-3;
        let solids = shapes(
            self.place,
            &field,
            &over.shape,
            spacing,
            clearance.max(spacing),
        )?;
        for line in &mut course.lines {
            if let Some(fine) = resampled(line, course.closed, LAID_STEP) {
                *line = fine;
            }
            for solid in &solids {
                *line = wrapped(line, clearance, |x| distance_and_normal(&solid.surface, x));
            }
            // A corner of a solid may draw neighbors to one point.
            line.dedup();
        }
        Ok(())
    }
}

/// Far away from what is unknown, so that it moves nothing.
fn distance_and_normal(surface: &RigidSurface, x: &[f64; 3]) -> (f64, [f64; 3]) {
    let jet = match surface {
        RigidSurface::Implicit(solid) => return (solid.distance(x), solid.normal(x)),
        RigidSurface::Sampled(sampled) => sampled.jet(*x),
        _ => None,
    };
    jet.map_or((f64::INFINITY, [0.0; 3]), |jet| (jet.value, jet.gradient))
}

/// The landmark of the 68-point scheme (Multi-PIE) on the other side of the face.
fn mirror_image(landmark: u32) -> Option<u32> {
    let sum = match landmark {
        0..=16 => 16,
        17..=26 => 43,
        27..=30 => return Some(landmark),
        31..=35 => 66,
        36..=39 | 42..=45 => 81,
        40 | 41 | 46 | 47 => 87,
        48..=54 => 102,
        55..=59 => 114,
        60..=64 => 124,
        65..=67 => 132,
        _ => return None,
    };
    Some(sum - landmark)
}
