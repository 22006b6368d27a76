//! The built-in face as a portrait.

use face_pictures::{Patterned, Portrait};
use face_rig::anatomy::Bone;
use face_scenes::builtin::{BuiltinFace, Ornament, flesh_color};

/// The face with its nodes at `positions` (one per node of the mesh, meters) and its lower teeth
/// moved by `jaw`, which maps a rest position to a position.
pub fn portrait(
    face: &BuiltinFace,
    positions: &[[f64; 3]],
    jaw: impl Fn([f64; 3]) -> [f64; 3],
) -> Portrait {
    let flesh = Portrait::new(Patterned {
        points: positions.to_vec(),
        triangles: face.triangles(|_| true),
        coordinates: face.material.clone(),
        color: Box::new(flesh_color),
    });
    face.decorations()
        .into_iter()
        .fold(flesh, |portrait, mut d| {
            if d.bone == Bone::Jaw {
                d.points.iter_mut().for_each(|p| *p = jaw(*p));
            }
            let drawn = Patterned {
                points: d.points,
                triangles: d.triangles,
                coordinates: d.coordinates,
                color: Box::new(move |c| d.ornament.color(c)),
            };
            match d.ornament {
                Ornament::MouthCavity => portrait.depth(drawn),
                _ => portrait.ornament(drawn),
            }
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use face_pictures::{Camera, Sheet};

    #[test]
    fn the_portrait_shows_a_face() {
        let face = BuiltinFace::with_tets(5_000).unwrap();
        let camera = Camera::framing(&face.nodes, 0.0, 0.0).unwrap();
        let draw = || {
            let face_drawn = portrait(&face, &face.nodes, |p| p);
            Sheet::new("")
                .row(vec![face_drawn.panel("rest", camera)])
                .draw(150, 190)
                .unwrap()
        };
        let canvas = draw();
        assert_eq!(canvas, draw());
        let skin = canvas
            .pixels()
            .iter()
            .filter(|p| p[0] > p[2].saturating_add(25))
            .count();
        assert!(skin > canvas.pixels().len() / 4, "{skin} pixels of skin");
        // Mirror symmetry of the eyes: dark pupils left and right of the middle, in the upper half.
        let dark = |columns: std::ops::Range<usize>| {
            let rows = canvas.height() / 4..canvas.height() / 2;
            rows.flat_map(|y| columns.clone().map(move |x| (x, y)))
                .filter(|&(x, y)| {
                    canvas.pixels()[y * canvas.width() + x]
                        .iter()
                        .all(|&c| c < 70)
                })
                .count()
        };
        let middle = canvas.width() / 2;
        assert!(dark(0..middle) >= 3 && dark(middle..canvas.width()) >= 3);
        // Positions of another mesh are refused, not drawn.
        let face_drawn = portrait(&face, &face.nodes[1..], |p| p);
        assert!(
            Sheet::new("")
                .row(vec![face_drawn.panel("", camera)])
                .draw(60, 60)
                .is_err()
        );
    }
}
