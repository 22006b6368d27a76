//! Which inner points of the flesh hold on to which bone.

use face_rig::anatomy::Bone;

/// What the inside of the flesh touches where it is not attached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Inner {
    Attached(Bone),
    /// Inside of lips and cheeks.
    Mouth,
    /// Inside of the lids.
    Socket,
    /// Gap between the bones at the joint and behind the jaw, and the floor of the mouth.
    Gap,
}

fn ramp(x: f64, low: f64, high: f64) -> f64 {
    ((x - low) / (high - low)).clamp(0.0, 1.0)
}

/// Attachment of the inner surface (`w = 0`) at a material point, in millimeters; `x` and `y` are
/// the frontal coordinates of the smooth head.
pub(super) fn inner(a: f64, b: f64) -> Inner {
    let a = a.abs();
    let eye = ((a - 32.0) / 17.0).powi(2) + ((b - 34.0) / 14.5).powi(2);
    if eye < 1.0 {
        return Inner::Socket;
    }
    // Vestibule: between the folds where lips and cheeks leave the gums.
    let ramus = (80.0, 104.0);
    let upper_fold = -15.0 + 14.0 * ramp(a, 20.0, 60.0) + 5.0 * ramp(a, 60.0, ramus.0);
    let lower_fold = -51.0 + 9.0 * ramp(a, 30.0, ramus.0);
    if a < ramus.0 && b < upper_fold && b > lower_fold {
        return Inner::Mouth;
    }
    // The chin's lower border rises to the angle of the jaw, over which flesh slides.
    let border = -85.0 + 40.0 * ramp(a, 45.0, 95.0);
    if b <= border {
        return if b < -145.0 {
            Inner::Attached(Bone::Cranium)
        } else {
            Inner::Gap
        };
    }
    if a < ramus.0 {
        let bone = if b >= upper_fold {
            Bone::Cranium
        } else {
            Bone::Jaw
        };
        return Inner::Attached(bone);
    }
    if b > 4.0 {
        return Inner::Attached(Bone::Cranium);
    }
    // The ramus moves far back below the joint; skin slides over its edge.
    let back = ramus.1 - 45.0 * ramp(-b, 9.0, 60.0);
    if a <= back && b < -9.0 {
        Inner::Attached(Bone::Jaw)
    } else {
        Inner::Gap
    }
}
