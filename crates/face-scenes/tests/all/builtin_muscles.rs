//! Every muscle of the built-in face at 1 does what anatomy says, on its landmarks: millimeters.
//!
//! The directions are those of H. Gray, "Anatomy of the Human Body" (1918), section IV, on the actions
//! of the muscles of the face; `docs/builtin.md` has the table.

use crate::motion::{Motion, Probe, length, parameters, pose};
use crate::promise::Rig;
use face_rig::anatomy::Bone;
use face_rig::rig::{Equilibrium, RigParams};
use face_scenes::Scene;
use face_scenes::builtin::Ornament;

/// The size of `face-rig simulate builtin`.
const TETS: usize = 20_000;
/// Where lips touch, every equilibrium takes ten to thirty steps: a size that tests can afford.
const COARSE: usize = 5_000;
const BOTH: [&str; 2] = ["L", "R"];

struct Stage {
    probe: Probe,
    scene: Scene,
    rig: Rig,
    rest: Equilibrium,
}

impl Stage {
    fn new(tets: usize) -> Self {
        let scene = Scene::builtin(tets).expect("a face");
        let params = RigParams::default();
        let rig = Rig::of(scene.rig(params).expect("a rig"), params);
        Self {
            probe: Probe::new(tets),
            rest: rig.equilibrium().clone(),
            scene,
            rig,
        }
    }

    /// These muscles at 1; nothing may turn inside out.
    fn pull(&mut self, muscles: &[&str], sides: &[&str]) -> Motion {
        let parameters = parameters(&self.scene, muscles, sides, 1.0);
        self.rig.start_from(self.rest.clone()).expect("rest");
        let positions = pose(&mut self.rig, &parameters).expect("an equilibrium");
        self.rig
            .check_afresh(self.scene.assembly().expect("a body"));
        let motion = self.probe.motion(&self.rig, &positions);
        assert_eq!(motion.inverted, 0, "{muscles:?}");
        motion
    }

    fn both(&mut self, muscle: &str) -> Motion {
        self.pull(&[muscle], &BOTH)
    }
}

#[test]
fn lids_close_between_corners_that_stay() {
    let mut stage = Stage::new(COARSE);
    let rest = stage.pull(&[], &BOTH);
    assert!(rest.eye_gap[0] > 7.5, "{rest:?}");
    for sides in [&BOTH[..], &["L"]] {
        let m = stage.pull(&["orbicularis_oculi_palpebral"], sides);
        assert!(m.eye_gap[0] > -1.0 && m.eye_gap[1] < 1.0, "{m:?}");
        assert!(length(m.inner_canthus) < 2.0, "{m:?}");
        assert!(length(m.outer_canthus) < 2.0, "{m:?}");
    }
    // The other eye stays open.
    let m = stage.pull(&["orbicularis_oculi_palpebral"], &["R"]);
    assert!(m.eye_gap[0] > 7.0, "{m:?}");
    let m = stage.both("levator_palpebrae");
    assert!(m.eye_gap[0] > rest.eye_gap[0] + 2.0, "{m:?}");
}

#[test]
fn brows_go_where_their_muscles_pull() {
    let mut stage = Stage::new(TETS);
    let m = stage.both("frontalis_lateral");
    assert!(
        m.outer_brow[1] > 3.0 && m.inner_brow[1].abs() < 1.0,
        "{m:?}"
    );
    let m = stage.both("frontalis_medial");
    assert!(
        m.inner_brow[1] > 3.0 && m.outer_brow[1].abs() < 1.0,
        "{m:?}"
    );
    let m = stage.both("corrugator_supercilii");
    assert!(m.inner_brow[0] < -1.0 && m.inner_brow[1] < -0.5, "{m:?}");
    let m = stage.both("procerus");
    assert!(m.inner_brow[1] < -1.0, "{m:?}");
}

/// Lips that lie on each other at rest feel nothing of each other there.
#[test]
fn a_brow_leaves_the_mouth_alone_on_a_coarse_face_too() {
    for tets in [COARSE, TETS] {
        let m = Stage::new(tets).both("frontalis_medial");
        for way in [m.upper_lip, m.lower_lip, m.mouth_corner] {
            assert!(length(way) < 0.1, "{tets}: {m:?}");
        }
    }
}

#[test]
fn the_tip_of_the_nose_stays_while_wings_and_lips_move() {
    let mut stage = Stage::new(COARSE);
    for muscle in [
        "nasalis",
        "levator_labii_superioris_alaeque_nasi",
        "levator_labii_superioris",
        "levator_anguli_oris",
        "zygomaticus_minor",
    ] {
        let m = stage.both(muscle);
        assert!(length(m.nose_tip) < 1.5, "{muscle}: {m:?}");
        if muscle.starts_with("levator_labii") {
            assert!(m.upper_lip[1] > 1.3, "{muscle}: {m:?}");
        }
    }
}

#[test]
fn a_pucker_brings_the_lips_forward_and_together() {
    let mut stage = Stage::new(COARSE);
    let m = stage.pull(&["orbicularis_oris_upper", "orbicularis_oris_lower"], &BOTH);
    assert!(m.upper_lip[2] > 0.5 && m.lower_lip[2] > 0.5, "{m:?}");
    assert!(m.mouth_corner[0] < -5.0 && m.mouth_corner[2] > 1.0, "{m:?}");
    assert!(m.lip_gap[0] > -1.0 && m.lip_gap[1] < 0.7, "{m:?}");
}

#[test]
fn cheeks_and_corners_of_the_mouth() {
    let mut stage = Stage::new(TETS);
    let m = stage.both("zygomaticus_major");
    assert!(m.mouth_corner[0] > 2.0 && m.mouth_corner[1] > 3.0, "{m:?}");
    assert!(m.lip_gap[0] > -0.5, "lips cross: {m:?}");
    let smile = m.mouth_corner[1];
    let m = stage.both("risorius");
    let [out, up, _] = m.mouth_corner;
    assert!(out > 2.0 && up.abs() < 0.25 * out, "{m:?}");
    assert!(m.lip_gap[0] > -0.5, "lips cross: {m:?}");
    let m = stage.both("buccinator");
    // Towards the teeth, across their arch.
    let [out, _, forward] = m.cheek_inside;
    assert!(
        -0.89 * out - 0.45 * forward > 0.05,
        "it does not press: {m:?}"
    );
    assert!(m.mouth_corner[1].abs() < 0.2 * smile, "it smiles: {m:?}");
}

#[test]
fn the_jaw_opens_to_35_degrees_with_nothing_inside_out() {
    let mut stage = Stage::new(COARSE);
    for degrees in [15.0_f64, 35.0] {
        let mut open = parameters(&stage.scene, &[], &[], 0.0);
        let numbers = [degrees.to_radians(), 0.0, 0.0, 0.0];
        open.jaw = stage.scene.joint.motion(numbers).0;
        stage.rig.start_from(stage.rest.clone()).expect("rest");
        let positions = pose(&mut stage.rig, &open).expect("an equilibrium");
        let fresh = stage.scene.assembly().expect("a body");
        stage.rig.check_afresh(fresh);
        let m = stage.probe.motion(&stage.rig, &positions);
        assert_eq!(m.inverted, 0, "{degrees}");
        assert!(m.lip_gap[1] > 0.7 * degrees, "{degrees}: {m:?}");
        assert!(m.upper_lip[1] > -6.0, "{degrees}: {m:?}");
    }
    let drawn = stage.probe.face().decorations();
    let on_jaw = |o: Ornament| drawn.iter().any(|d| d.ornament == o && d.bone == Bone::Jaw);
    assert!(on_jaw(Ornament::Tongue) && on_jaw(Ornament::Teeth));
}

/// With the tangent of the rest shape: far along it flesh is where it does not balance, and a part of the
/// way is a better start.
#[test]
fn a_guess_goes_along_a_tangent_as_far_as_that_lowers_the_energy() {
    let mut stage = Stage::new(COARSE);
    let mut steps = 0;
    for muscle in [
        "buccinator",
        "orbicularis_oculi_palpebral",
        "risorius",
        "zygomaticus_major",
        "orbicularis_oris_lower",
    ] {
        stage.rig.start_from(stage.rest.clone()).expect("rest");
        let _ = stage.rig.sensitivity().expect("a tangent");
        let before = stage.rig.work().newton_steps;
        let there = parameters(&stage.scene, &[muscle], &BOTH, 1.0);
        let _ = pose(&mut stage.rig, &there).expect("an equilibrium");
        steps += stage.rig.work().newton_steps - before;
    }
    // 43 with the whole way alone, or none of it.
    assert!(steps <= 38, "{steps}");
}
