use super::*;

fn joint(path: CondylarPath) -> JawJoint {
    let hinge = JawHinge::new([0.01, -0.02, 0.03], [1.0, 0.2, -0.1]).expect("a hinge");
    JawJoint::new(hinge, path, JointLimits::ADULT).expect("a joint")
}

fn upright() -> JawJoint {
    let hinge = JawHinge::sideways([0.0, -0.01, 0.02]);
    JawJoint::new(hinge, CondylarPath::ADULT, JointLimits::ADULT).expect("a joint")
}

#[test]
fn the_motion_is_rigid_and_leads_the_condyles_down_and_forward() {
    let joint = upright();
    let rest = joint.condyles();
    let mut before = 0.0;
    for degrees in [5.0_f64, 15.0, 25.0, 35.0] {
        let (motion, _) = joint.motion([degrees.to_radians(), 0.0, 0.0, 0.0]);
        assert!(motion.orthogonality().iter().all(|e| e.abs() < 1e-14));
        let moved = motion.apply(rest[0]);
        let way: [f64; 3] = std::array::from_fn(|i| moved[i] - rest[0][i]);
        assert!(way[0].abs() < 1e-15 && way[1] < 0.0 && way[2] > 0.0);
        let angle = (-way[1] / way[2]).atan().to_degrees();
        assert!((angle - 33.0).abs() < 1e-9, "{angle}");
        let length = dot(way, way).sqrt();
        assert!(length > before);
        before = length;
    }
    // The whole way, and no further however wide the jaw opens.
    assert!((before - 0.012).abs() < 1e-15);
    let (wide, _) = joint.motion([0.69, 0.0, 0.0, 0.0]);
    assert!((joint.condyles_apart(&wide, &AffineMap::IDENTITY) - 0.012).abs() < 1e-15);
}

#[test]
fn without_a_path_it_is_the_hinge() {
    let joint = joint(CondylarPath::default());
    let turned = joint.hinge().motion(0.3, [0.0; 3]);
    let (motion, _) = joint.motion([0.3, 0.0, 0.0, 0.0]);
    assert!(joint.condyles_apart(&motion, &turned) < 1e-16);
    let off = motion.to_array().into_iter().zip(turned.to_array());
    assert!(off.into_iter().all(|(m, t)| (m - t).abs() < 1e-15));
}

#[test]
fn yaw_turns_the_chin_to_the_left_and_protrusion_moves_it_forward() {
    let (joint, chin) = (upright(), [0.0, -0.08, 0.1]);
    let moved = |numbers| joint.motion(numbers).0.apply(chin);
    assert!(moved([0.0, 0.0, 0.0, 0.1])[0] > 0.007);
    let forward = moved([0.0, 0.005, 0.0, 0.0]);
    assert!(forward[2] > chin[2] + 0.004 && forward[1] < chin[1]);
    assert!((moved([0.0, 0.0, 0.003, 0.0])[0] - 0.003).abs() < 1e-15);
}

#[test]
fn derivatives_match_differences_through_the_ends_of_the_path() {
    let joint = joint(CondylarPath::ADULT);
    for opening in [-0.03, 0.0, 0.2, 0.55, 0.65] {
        let at = [opening, 0.004, -0.003, 0.07];
        let (_, exact) = joint.motion(at);
        for (k, exact) in exact.iter().enumerate() {
            let h = 1e-6;
            let shifted = |by: f64| {
                let mut numbers = at;
                numbers[k] += by;
                joint.motion(numbers).0.to_array()
            };
            let slopes = shifted(h).into_iter().zip(shifted(-h));
            for ((high, low), exact) in slopes.zip(exact.to_array()) {
                assert!(((high - low) / (2.0 * h) - exact).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn the_numbers_of_a_motion_are_recovered() {
    let joint = joint(CondylarPath::ADULT);
    for numbers in [
        [0.0; 4],
        [0.4, 0.006, -0.004, 0.1],
        [-0.02, -0.001, 0.002, -0.13],
    ] {
        let (mut motion, _) = joint.motion(numbers);
        let (found, beside) = joint.closest(&motion);
        assert!(beside < 1e-15);
        for (found, number) in found.iter().zip(numbers) {
            assert!((found - number).abs() < 1e-14, "{found} for {number}");
        }
        // What no number of the joint can do is what is left.
        let across = cross(joint.way, joint.hinge().axis());
        motion.translation = std::array::from_fn(|i| motion.translation[i] + 0.003 * across[i]);
        assert!((joint.closest(&motion).1 - 0.003).abs() < 1e-15);
    }
}

#[test]
fn joints_that_make_no_sense_are_named() {
    let hinge = JawHinge::sideways([0.0; 3]);
    let with = |path, limits| {
        JawJoint::new(hinge, path, limits)
            .expect_err("no joint")
            .to_string()
    };
    let path = |length, inclination, full_at| CondylarPath {
        length,
        inclination,
        full_at,
    };
    let adult = JointLimits::ADULT;
    for (path, word) in [
        (path(-0.01, 0.0, 0.5), "length"),
        (path(f64::NAN, 0.0, 0.5), "length"),
        (path(0.01, 2.0, 0.5), "inclination"),
        (path(0.01, 0.5, 0.0), "opening at the path's end"),
    ] {
        let message = with(path, adult);
        assert!(message.contains(word), "{message}");
    }
    for bad in [
        [0.1, 0.2],
        [0.0, 0.0],
        [f64::NAN, 0.1],
        [f64::NEG_INFINITY, 1.0],
    ] {
        let limits = JointLimits { yaw: bad, ..adult };
        assert!(with(CondylarPath::default(), limits).contains("limits of the yaw"));
    }
    let up = JawHinge::new([0.0; 3], [0.05, 1.0, 0.0]).expect("a hinge");
    let error = JawJoint::new(up, CondylarPath::default(), adult).expect_err("upright");
    assert!(matches!(error, JointError::Upright(_)));
    let nowhere = [[0.0; 3], [0.0, f64::INFINITY, 0.0]];
    assert!(upright().with_condyles(nowhere).is_err());
}
