//! What the flesh is made of, where it is not muscle and fat.
//!
//! Moduli are orders of magnitude, chosen: cartilage 1 MPa, ligaments 5 MPa, both far above flesh. The
//! skin of the lids is thin and loose and unfolds before it is stretched: a third of the usual modulus
//! of flesh. Places after H. Gray, "Anatomy of the Human Body", 20th ed., 1918, on the palpebral
//! ligaments (section X) and the cartilages of the nose (section X).

use super::form::{EYES, Form};

/// What a tet is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Tissue {
    /// Muscle, fat and skin: the material of the scene.
    Flesh = 0,
    /// The thin loose skin of the lids.
    Lid = 1,
    /// The ligaments that hold both corners of the eye to the rim of its socket.
    Ligament = 2,
    /// Septum, tip and wings of the nose.
    Cartilage = 3,
}

impl Tissue {
    /// All of them, by number.
    pub const ALL: [Self; 4] = [Self::Flesh, Self::Lid, Self::Ligament, Self::Cartilage];

    /// Its name as a region of a scene.
    pub fn name(self) -> &'static str {
        match self {
            Self::Flesh => "flesh",
            Self::Lid => "lids",
            Self::Ligament => "canthal_ligaments",
            Self::Cartilage => "nasal_cartilage",
        }
    }

    /// Young's modulus in pascals; none for flesh, which is what a scene says.
    pub fn young(self) -> Option<f64> {
        match self {
            Self::Flesh => None,
            Self::Lid => Some(1.3e4),
            Self::Ligament => Some(5e6),
            Self::Cartilage => Some(1e6),
        }
    }
}

/// The tissue of every tet, by its middle.
pub(super) fn tissues(form: &Form, tets: &[[u32; 4]], material: &[[f64; 3]]) -> Vec<Tissue> {
    let [inner, outer, _] = form.corners;
    let of = |tet: &[u32; 4]| {
        let corners = tet.map(|n| material[n as usize]);
        let [a, b, w] = [0, 1, 2].map(|k| 0.25 * corners.iter().map(|p| p[k]).sum::<f64>());
        tissue([a.abs(), b, w], [inner, outer])
    };
    tets.iter().map(of).collect()
}

/// At a material point with `a >= 0`, for the inner and the outer corner of the eye.
fn tissue([a, b, w]: [f64; 3], [inner, outer]: [f64; 2]) -> Tissue {
    let within = |[x, y]: [f64; 2], [rx, ry]: [f64; 2]| {
        ((a - x) / rx).powi(2) + ((b - y) / ry).powi(2) < 1.0
    };
    // Beside the corners, not over the lids: these turn about the corners.
    let ligament = [5.0, 4.0];
    if within([inner - 4.0, EYES], ligament) || within([outer + 4.0, EYES], ligament) {
        return Tissue::Ligament;
    }
    let lids = [0.5 * (outer - inner) + 1.0, 12.5];
    if within([0.5 * (inner + outer), EYES], lids) {
        return Tissue::Lid;
    }
    let below_skin = w < 0.9;
    let septum = within([0.0, 6.0], [8.0, 21.0]);
    let wing = within([11.0, -4.0], [5.0, 6.0]);
    match below_skin && (septum || wing) {
        true => Tissue::Cartilage,
        false => Tissue::Flesh,
    }
}
