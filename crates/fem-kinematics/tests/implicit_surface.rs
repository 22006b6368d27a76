//! Signed distances against a search for the nearest point of the surface and central differences.
#![allow(non_snake_case)]
use fem_kinematics::{ImplicitSurface, Mat};

fn solids() -> Vec<ImplicitSurface<3>> {
    vec![
        ImplicitSurface::Sphere {
            center: [0.1, -0.2, 0.3],
            radius: 0.7,
        },
        ImplicitSurface::HalfSpace {
            point: [0.2, 0.1, -0.1],
            normal: [0.6, 0.0, 0.8],
        },
        ImplicitSurface::Box {
            min: [-0.5, -0.3, -0.4],
            max: [0.6, 0.4, 0.2],
        },
        ImplicitSurface::Capsule {
            ends: [[-0.4, 0.1, 0.0], [0.5, -0.2, 0.3]],
            radius: 0.25,
        },
    ]
}

/// Points of a coarse lattice that misses the places where φ has no derivative.
fn places() -> Vec<[f64; 3]> {
    let at = |k: usize| -1.13 + 0.37 * k as f64;
    (0..343)
        .map(|i| [at(i % 7), at(i / 7 % 7) + 0.011, at(i / 49) - 0.017])
        .collect()
}

#[test]
fn normals_and_curvatures_are_the_derivatives_of_the_distance() {
    const H: f64 = 1e-6;
    for solid in solids() {
        for x in places() {
            let (n, K) = (solid.normal(&x), solid.curvature(&x));
            for k in 0..3 {
                let moved = |h: f64| {
                    let mut y = x;
                    y[k] += h;
                    y
                };
                let slope = (solid.distance(&moved(H)) - solid.distance(&moved(-H))) / (2.0 * H);
                assert!((slope - n[k]).abs() < 1e-8, "{solid:?} {x:?}");
                let (a, b) = (solid.normal(&moved(H)), solid.normal(&moved(-H)));
                for i in 0..3 {
                    let turn = (a[i] - b[i]) / (2.0 * H);
                    assert!((turn - K.0[i][k]).abs() < 1e-7, "{solid:?} {x:?} {K:?}");
                }
            }
        }
    }
}

/// x − φ n lies on the surface, and no point of a fine lattice of the solid is nearer to an x
/// outside (or of its complement, to one inside).
#[test]
fn the_distance_is_that_of_the_nearest_point() {
    let lattice: Vec<[f64; 3]> = (0..41 * 41 * 41)
        .map(|i| {
            let at = |k: usize| -2.0 + 0.1 * k as f64;
            [at(i % 41), at(i / 41 % 41), at(i / 1681)]
        })
        .collect();
    let apart =
        |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    for solid in solids() {
        for x in places() {
            let (phi, n) = (solid.distance(&x), solid.normal(&x));
            let foot = std::array::from_fn(|k| x[k] - phi * n[k]);
            assert!(solid.distance(&foot).abs() < 1e-15 * 8.0, "{solid:?} {x:?}");
            let nearest = lattice
                .iter()
                .filter(|y| solid.distance(y) * phi < 0.0)
                .map(|y| apart(&x, y))
                .fold(f64::INFINITY, f64::min);
            assert!(nearest > phi.abs() - 1e-12, "{solid:?} {x:?}");
        }
    }
}

/// By hand: one place for each kind of nearest point, and membership that is no distance.
#[test]
fn distances_by_hand() {
    let [ball, plane, cuboid, capsule] = solids()[..] else {
        panic!("four solids")
    };
    // n·x − n·p = 0.6 · 1.2 + 0.8 · 0.4 − 0.04, and 0.8 from the center less the radius.
    assert!((plane.distance(&[1.2, 7.0, 0.4]) - 1.0).abs() < 1e-15);
    assert!((ball.distance(&[0.1, 0.6, 0.3]) - 0.1).abs() < 1e-15);
    // Beyond either end of the capsule, and beside its middle.
    for (x, expected) in [
        ([-0.4, 1.1, 0.0], 0.75),
        ([0.5, -1.2, 0.3], 0.75),
        ([0.05 + 0.3, -0.05 + 0.9, 0.15], 0.9_f64.hypot(0.3) - 0.25),
    ] {
        let found = capsule.distance(&x);
        assert!((found - expected).abs() < 1e-15, "{x:?}: {found}");
    }
    // Beyond a corner by (0.3, 0.4, 1.2), an edge by (0.3, 0.4), a face by 0.5; 0.1 inside one.
    let corner = cuboid.distance(&[0.9, 0.8, 1.4]);
    let edge = cuboid.distance(&[0.9, 0.8, 0.0]);
    let face = cuboid.distance(&[0.0, 0.0, 0.7]);
    let inside = cuboid.distance(&[0.0, 0.0, 0.1]);
    for (found, expected) in [(corner, 1.3), (edge, 0.5), (face, 0.5), (inside, -0.1)] {
        assert!((found - expected).abs() < 1e-15, "{found} {expected}");
    }
    assert_eq!(cuboid.normal(&[0.0, 0.0, 0.1]), [0.0, 0.0, 1.0]);
    assert!((capsule.distance(&[-0.4, 0.1, 0.0]) + 0.25).abs() < 1e-16);
    assert!(
        solids()
            .iter()
            .all(|s| s.distance(&[0.0, f64::NAN, 0.0]).is_nan())
    );
}

/// On a center or an axis every direction leads out: the normal is one of them.
#[test]
fn a_normal_has_length_one_everywhere() {
    let flat = ImplicitSurface::Capsule {
        ends: [[0.3, 0.1], [0.3, 0.1]],
        radius: 1.0,
    };
    assert_eq!(flat.normal(&[0.3, 0.1]), [0.0, 1.0]);
    let [ball, _, _, capsule] = solids()[..] else {
        panic!("four solids")
    };
    let middle = [0.05, -0.05, 0.15];
    for (solid, x) in [(ball, [0.1, -0.2, 0.3]), (capsule, middle)] {
        let n = solid.normal(&x);
        assert!(
            (n.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-14,
            "{n:?}"
        );
    }
    assert_eq!(ball.curvature(&[0.1, -0.2, 0.3]), Mat::zeros());
    // At right angles to an axis, wherever that points.
    for along in [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, -2.0, 0.0],
        [0.0, 0.0, -1.0],
        [-0.3, -0.2, 0.5],
    ] {
        let capsule = ImplicitSurface::Capsule {
            ends: [[0.0; 3], along],
            radius: 0.1,
        };
        let n = capsule.normal(&along.map(|c| 0.5 * c));
        let dot = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
        assert!((dot(&n, &n) - 1.0).abs() < 1e-14, "{along:?}: {n:?}");
        assert!(dot(&n, &along).abs() < 1e-14, "{along:?}: {n:?}");
    }
}

#[test]
fn numbers_that_no_distance_can_be_computed_with_are_named() {
    let nan = f64::NAN;
    let sphere = |center, radius| ImplicitSurface::Sphere { center, radius };
    let plane = |point, normal| ImplicitSurface::HalfSpace { point, normal };
    let cuboid = |min, max| ImplicitSurface::Box { min, max };
    let capsule = |end, radius| ImplicitSurface::Capsule {
        ends: [[0.0; 2], end],
        radius,
    };
    for (bad, what) in [
        (sphere([0.0, nan], 1.0), "a coordinate of the center"),
        (sphere([0.0; 2], 0.0), "the radius"),
        (
            plane([f64::INFINITY, 0.0], [0.0, 1.0]),
            "a coordinate of the point",
        ),
        (plane([0.0; 2], [0.0, 1.01]), "the length of the normal"),
        (plane([0.0; 2], [nan, 1.0]), "the length of the normal"),
        (
            cuboid([0.0; 2], [1.0, nan]),
            "a coordinate of the highest corner",
        ),
        (cuboid([0.0; 2], [1.0, 0.0]), "a side of the box"),
        (capsule([nan, 0.0], 1.0), "a coordinate of an end"),
        (capsule([1.0, 0.0], nan), "the radius"),
    ] {
        assert_eq!(bad.check(1e-3).map_err(|e| e.what), Err(what), "{bad:?}");
    }
    assert!(solids().iter().all(|s| s.check(1e-6).is_ok()));
}
