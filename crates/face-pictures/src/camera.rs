//! Where the picture is taken from.

use super::PictureError;

/// Degrees of the vertical field of view of a portrait lens (about 85 mm on full frame).
const PORTRAIT_FIELD_OF_VIEW: f64 = 16.0;

/// A camera that looks at a frame: `+y` is up, and at zero yaw and pitch it looks along `-z`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Center of the frame, in world units.
    pub target: [f64; 3],
    /// Half of the frame's height at the target, in world units.
    pub half_height: f64,
    /// Half of the frame's width at the target, in world units; the wider need wins.
    pub half_width: f64,
    /// The camera goes to this side around the vertical axis, in degrees (positive: towards +x).
    pub yaw: f64,
    /// The camera goes up by this angle, in degrees.
    pub pitch: f64,
    /// Vertical field of view in degrees; 0 is an orthographic camera.
    pub field_of_view: f64,
}

/// A point as seen: pixel coordinates (x right, y down) and distance along the line of sight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OnScreen {
    pub x: f64,
    pub y: f64,
    pub depth: f64,
}

impl Camera {
    /// A mild perspective camera that has all finite `points` in the frame with a small margin.
    ///
    /// # Errors
    /// [`PictureError::NothingToFrame`] where no point is finite.
    pub fn framing(points: &[[f64; 3]], yaw: f64, pitch: f64) -> Result<Self, PictureError> {
        let mut camera = Self {
            target: [0.0; 3],
            half_height: 1.0,
            half_width: 1.0,
            yaw,
            pitch,
            field_of_view: PORTRAIT_FIELD_OF_VIEW,
        };
        let axes = camera.axes();
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for p in points.iter().filter(|p| p.iter().all(|x| x.is_finite())) {
            for k in 0..3 {
                let s = (0..3).map(|i| axes[k][i] * p[i]).sum::<f64>();
                low[k] = low[k].min(s);
                high[k] = high[k].max(s);
            }
        }
        if !(high[0] >= low[0]) {
            return Err(PictureError::NothingToFrame);
        }
        let middle = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
        for i in 0..3 {
            camera.target[i] = (0..3).map(|k| middle[k] * axes[k][i]).sum();
        }
        let size = (0..3)
            .map(|k| high[k] - low[k])
            .fold(0.0, f64::max)
            .max(f64::MIN_POSITIVE);
        let margin = 1.06;
        camera.half_width = (margin * 0.5 * (high[0] - low[0])).max(1e-3 * size);
        camera.half_height = (margin * 0.5 * (high[1] - low[1])).max(1e-3 * size);
        Ok(camera)
    }

    /// The same camera without perspective.
    pub fn orthographic(self) -> Self {
        Self {
            field_of_view: 0.0,
            ..self
        }
    }

    /// The same frame from another side.
    pub fn turned(self, yaw: f64, pitch: f64) -> Self {
        Self { yaw, pitch, ..self }
    }

    /// Closer (`factor > 1`) or farther.
    pub fn zoomed(self, factor: f64) -> Self {
        Self {
            half_height: self.half_height / factor,
            half_width: self.half_width / factor,
            ..self
        }
    }

    /// Unit vectors right, up and towards the camera.
    pub(super) fn axes(&self) -> [[f64; 3]; 3] {
        let (sy, cy) = self.yaw.to_radians().sin_cos();
        let (sp, cp) = self.pitch.to_radians().sin_cos();
        [
            [cy, 0.0, -sy],
            [-sy * sp, cp, -cy * sp],
            [sy * cp, sp, cy * cp],
        ]
    }

    /// World units per pixel at the target.
    pub(super) fn pixel(&self, width: usize, height: usize) -> f64 {
        (2.0 * self.half_height / height as f64).max(2.0 * self.half_width / width as f64)
    }

    /// Distance from the camera to the target.
    pub(super) fn distance(&self, width: usize, height: usize) -> f64 {
        let half = 0.5 * self.pixel(width, height) * height as f64;
        if self.field_of_view > 0.0 {
            half / (0.5 * self.field_of_view.to_radians()).tan()
        } else {
            100.0 * half
        }
    }

    /// Projection into a picture of the given size; the closure is cheap to call.
    pub(super) fn projection(
        &self,
        width: usize,
        height: usize,
    ) -> impl Fn([f64; 3]) -> OnScreen + Sync + use<> {
        let axes = self.axes();
        let target = self.target;
        let distance = self.distance(width, height);
        let scale = 1.0 / self.pixel(width, height);
        let perspective = self.field_of_view > 0.0;
        let center = [0.5 * width as f64, 0.5 * height as f64];
        move |p| {
            let d = [p[0] - target[0], p[1] - target[1], p[2] - target[2]];
            let [r, u, t] = axes.map(|a| a[0] * d[0] + a[1] * d[1] + a[2] * d[2]);
            let depth = distance - t;
            let s = if perspective {
                scale * distance / depth
            } else {
                scale
            };
            OnScreen {
                x: center[0] + s * r,
                y: center[1] - s * u,
                depth,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frame_holds_the_points() {
        let points = [[-1.0, -2.0, 0.0], [3.0, 5.0, 1.0], [f64::NAN, 0.0, 0.0]];
        for (yaw, pitch) in [(0.0, 0.0), (35.0, 10.0), (-80.0, -20.0)] {
            let camera = Camera::framing(&points, yaw, pitch).unwrap().orthographic();
            let see = camera.projection(300, 200);
            for p in &points[..2] {
                let s = see(*p);
                assert!(s.x > 0.0 && s.x < 300.0 && s.y > 0.0 && s.y < 200.0 && s.depth > 0.0);
            }
        }
        assert!(Camera::framing(&[[f64::NAN; 3]], 0.0, 0.0).is_err());
    }

    #[test]
    fn yaw_goes_to_the_left_side_of_the_subject() {
        let camera = Camera::framing(&[[0.0; 3], [1.0; 3]], 90.0, 0.0).unwrap();
        let toward = camera.axes()[2];
        assert!((toward[0] - 1.0).abs() < 1e-12 && toward[2].abs() < 1e-12);
    }
}
