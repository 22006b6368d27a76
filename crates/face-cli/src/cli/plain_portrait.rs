//! A face from files as a portrait.

use face_pictures::{Patterned, Portrait};
use face_rig::anatomy::Bone;
use face_rig::rig::AffineMap;
use face_scenes::{Outline, Scene};

const SKIN: [f32; 3] = [0.84, 0.69, 0.60];
/// Teeth and gums that are not told apart.
const IVORY: [f32; 3] = [0.88, 0.80, 0.74];

/// A skin of one color with the eyeballs and teeth that a scene names as solids; without those of a
/// jaw whose place is not known.
pub fn plain_portrait(
    scene: &Scene,
    points: &[[f64; 3]],
    triangles: &[[u32; 3]],
    jaw: Option<&AffineMap>,
) -> Portrait {
    let skin = Portrait::new(Patterned {
        points: points.to_vec(),
        triangles: triangles.to_vec(),
        coordinates: vec![[0.0; 3]; points.len()],
        color: Box::new(|_| SKIN),
    });
    scene.contact.solids.iter().fold(skin, |portrait, solid| {
        let Some(outline) = &solid.outline else {
            return portrait;
        };
        let mut outline = Outline::clone(outline);
        if solid.moves_with == Bone::Jaw {
            let Some(jaw) = jaw else {
                return portrait;
            };
            outline.points.iter_mut().for_each(|p| *p = jaw.apply(*p));
        }
        let ornament = outline.ornament;
        portrait.ornament(Patterned {
            points: outline.points,
            triangles: outline.triangles,
            coordinates: outline.coordinates,
            color: Box::new(move |c| ornament.map_or(IVORY, |o| o.color(c))),
        })
    })
}
