//! Smooth normals that stop at creases.

/// One unit normal per triangle corner: the angle-weighted mean of the normals of those triangles
/// around the vertex that lie within `crease_degrees` of this corner's triangle.
///
/// Triangles without area (or with a coordinate that is not finite) get `[0, 0, 1]` and count
/// nowhere. Every index must be in range.
///
/// # Panics
/// If a triangle names a point out of range.
pub fn corner_normals(
    points: &[[f64; 3]],
    triangles: &[[u32; 3]],
    crease_degrees: f64,
) -> Vec<[[f32; 3]; 3]> {
    let faces: Vec<Option<[f64; 3]>> = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| points[i as usize]);
            unit(cross(sub(b, a), sub(c, a)))
        })
        .collect();
    let mut start = vec![0usize; points.len() + 1];
    for &v in triangles.iter().flatten() {
        start[v as usize + 1] += 1;
    }
    for i in 0..points.len() {
        start[i + 1] += start[i];
    }
    let mut cursor = start.clone();
    let mut around = vec![(0u32, 0f64); 3 * triangles.len()];
    for (f, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let p = points[t[k] as usize];
            let e = [1, 2].map(|s| unit(sub(points[t[(k + s) % 3] as usize], p)));
            let angle = match e {
                [Some(a), Some(b)] => dot(a, b).clamp(-1.0, 1.0).acos(),
                _ => 0.0,
            };
            around[cursor[t[k] as usize]] = (f as u32, angle);
            cursor[t[k] as usize] += 1;
        }
    }
    let threshold = crease_degrees.to_radians().cos();
    triangles
        .iter()
        .zip(&faces)
        .map(|(t, face)| {
            t.map(|v| {
                let Some(own) = *face else {
                    return [0.0, 0.0, 1.0];
                };
                let mut sum = [0.0; 3];
                for &(g, angle) in &around[start[v as usize]..start[v as usize + 1]] {
                    if let Some(other) = faces[g as usize]
                        && dot(own, other) >= threshold
                    {
                        for k in 0..3 {
                            sum[k] += angle * other[k];
                        }
                    }
                }
                unit(sum).unwrap_or(own).map(|x| x as f32)
            })
        })
        .collect()
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(a, a).sqrt();
    (length.is_finite() && length > 0.0).then(|| a.map(|x| x / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_right_angle_is_a_crease_or_not() {
        let points = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., -1.]];
        // z = 0 facing +z, y = 0 facing -y, sharing the x axis.
        let triangles = [[0, 1, 2], [0, 3, 1]];
        let sharp = corner_normals(&points, &triangles, 60.0);
        assert_eq!(sharp[0][0], [0.0, 0.0, 1.0]);
        assert_eq!(sharp[1][0], [0.0, -1.0, 0.0]);
        let smooth = corner_normals(&points, &triangles, 100.0);
        assert!((smooth[0][0][1] + 0.5f32.sqrt()).abs() < 1e-6);
        assert_eq!(smooth[0][2], [0.0, 0.0, 1.0]);
    }
}
