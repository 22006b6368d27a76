//! Wavefront OBJ text.

use std::fmt::Write as _;

use super::{ExportError, check, point_normals};

/// A surface as the text of an OBJ file: `v`, `vn` and `f` lines, in the unit of the points.
///
/// Coordinates are written with the digits that give the same `f64` back.
///
/// # Errors
/// [`ExportError`] for an index out of range, a coordinate that is not finite, or no triangles.
///
/// ```
/// let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let text = face_pictures::export::obj("skin", &points, &[[0, 1, 2]])?;
/// assert!(text.contains("f 1//1 2//2 3//3"));
/// # Ok::<(), face_pictures::export::ExportError>(())
/// ```
pub fn obj(name: &str, points: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<String, ExportError> {
    check(points, triangles)?;
    let mut text = String::with_capacity(90 * points.len() + 40 * triangles.len());
    let name: String = name
        .chars()
        .map(|c| if c.is_whitespace() { '_' } else { c })
        .collect();
    let _ = writeln!(text, "o {name}");
    for [x, y, z] in points {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for [x, y, z] in point_normals(points, triangles) {
        let _ = writeln!(text, "vn {x} {y} {z}");
    }
    for t in triangles {
        let [a, b, c] = t.map(|i| i + 1);
        let _ = writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}");
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_back_bit_for_bit() {
        let points = [
            [0.1, 1.0 / 3.0, -2e-9],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 7.0],
            [3.0, 1.0, 1.0],
        ];
        let triangles = [[0, 1, 2], [2, 1, 3]];
        let text = obj("left ear", &points, &triangles).unwrap();
        let rows = |tag: &str| -> Vec<Vec<String>> {
            text.lines()
                .filter_map(|l| l.strip_prefix(tag))
                .map(|l| l.split_whitespace().map(str::to_string).collect())
                .collect()
        };
        let read: Vec<Vec<f64>> = rows("v ")
            .iter()
            .map(|r| r.iter().map(|x| x.parse().unwrap()).collect())
            .collect();
        assert_eq!(read, points.map(|p| p.to_vec()));
        assert_eq!(rows("f ")[1], ["3//3", "2//2", "4//4"]);
        assert_eq!(rows("vn ").len(), 4);
        assert_eq!(rows("o ")[0], ["left_ear"]);
    }

    #[test]
    fn bad_surfaces_are_refused() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, f64::NAN, 0.0]];
        assert!(matches!(
            obj("", &points, &[[0, 1, 2]]),
            Err(ExportError::NotFinite { point: 2, .. })
        ));
        assert!(matches!(
            obj("", &points[..2], &[[0, 1, 2]]),
            Err(ExportError::IndexOutOfRange { point: 2, .. })
        ));
        assert!(matches!(obj("", &points, &[]), Err(ExportError::Empty)));
    }
}
