//! Against lengths, areas and angles in closed form.
#![allow(non_snake_case)]

use super::line::{cross, dot, norm, sub, unit};
use super::*;
use crate::anatomy::TetLocator;
use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_kinematics::ImplicitSurface;
use std::f64::consts::PI;

fn block(cells: usize) -> SimplexMesh<3> {
    kuhn_grid(cells, cells, cells, [0.04; 3]).expect("a grid")
}

fn filled(course: &Course, mesh: &SimplexMesh<3>) -> Filling {
    course
        .fill(mesh, &TetLocator::new(mesh))
        .expect("a course in the mesh")
}

/// Σ weight × volume.
fn flesh(filling: &Filling, mesh: &SimplexMesh<3>) -> f64 {
    let shares = filling.shares.iter();
    shares.map(|s| s.weight * mesh.volume(s.tet as usize)).sum()
}

fn course(lines: &[&[[f64; 3]]], closed: bool, section: Section) -> Course {
    Course {
        lines: lines.iter().map(|line| line.to_vec()).collect(),
        closed,
        section,
    }
}

fn close(found: f64, expected: f64, tolerance: f64) {
    let error = (found - expected).abs();
    assert!(
        error <= tolerance * expected.abs(),
        "{found} instead of {expected}"
    );
}

/// On every mesh, also where an element is far larger than the muscle; elements that hold less than a
/// thousandth of muscle are left out.
#[test]
fn a_straight_muscle_fills_its_length_times_its_section_and_runs_along_it() {
    let (a, b) = ([0.005, 0.011, 0.013], [0.033, 0.017, 0.026]);
    let (length, along) = (norm(sub(b, a)), unit(sub(b, a)));
    let up = [0.0, 1.0, 0.0];
    let across = unit(cross(along, up)).map(|v| 0.006 * v);
    let beside = |p: [f64; 3]| std::array::from_fn(|i| p[i] + across[i]);
    let (c, d): ([f64; 3], [f64; 3]) = (beside(a), beside(b));
    let sheet = |rounded| Section::Sheet {
        thickness: 0.002,
        rounded,
    };
    let strap = Section::Strap {
        width: 0.006,
        thickness: 0.0015,
        normal: up,
    };
    let round = Section::Round { radius: 0.002 };
    let cases = [
        (course(&[&[a, b]], false, round), PI * 4e-6),
        (course(&[&[a, b]], false, strap), 9e-6),
        (course(&[&[a, b], &[c, d]], false, sheet(false)), 12e-6),
        (
            course(&[&[a, b], &[c, d]], false, sheet(true)),
            12e-6 + PI * 1e-6,
        ),
    ];
    for (course, section) in cases {
        for cells in [2, 5, 12] {
            let mesh = block(cells);
            let filling = filled(&course, &mesh);
            close(filling.volume, length * section, 1e-12);
            close(filling.inside, length * section, 1e-12);
            close(flesh(&filling, &mesh), length * section, 6e-3);
            for share in &filling.shares {
                assert!(norm(cross(share.direction, along)) < 1e-12);
            }
        }
    }
}

/// Around a corner a strap keeps its width on both sides, and a sheet may have lines of any points.
#[test]
fn a_bent_strap_and_a_sheet_of_uneven_lines_have_the_areas_of_their_drawings() {
    let mesh = block(4);
    let corner = [[0.005, 0.02, 0.02], [0.02, 0.02, 0.02], [0.02, 0.035, 0.02]];
    let strap = Section::Strap {
        width: 0.006,
        thickness: 0.001,
        normal: [0.0, 0.0, 1.0],
    };
    // The mitred corner is shorter inside by what it is longer outside.
    let filling = filled(&course(&[&corner], false, strap), &mesh);
    close(filling.volume, 0.03 * 6e-6, 1e-12);
    let sheet = Section::Sheet {
        thickness: 0.001,
        rounded: false,
    };
    let (low, high) = (
        [[0.005, 0.01, 0.02], [0.035, 0.01, 0.02]],
        [[0.005, 0.03, 0.02], [0.01, 0.03, 0.02], [0.035, 0.03, 0.02]],
    );
    let filling = filled(&course(&[&low, &high], false, sheet), &mesh);
    close(filling.volume, 0.03 * 0.02 * 1e-3, 1e-12);
}

/// Lines that lie on each other: there is no more muscle in an element than the element.
#[test]
fn an_element_holds_no_more_than_itself() {
    let mesh = block(8);
    let line = [[0.005, 0.0152, 0.0126], [0.035, 0.0151, 0.0127]];
    let round = Section::Round { radius: 0.008 };
    let once = filled(&course(&[&line], false, round), &mesh);
    let twice = filled(&course(&[&line, &line], false, round), &mesh);
    close(twice.volume, 2.0 * once.volume, 1e-10);
    let full = twice.shares.iter().filter(|share| share.weight == 1.0);
    assert!(full.count() > 20);
    assert!(twice.shares.iter().all(|s| s.weight <= 1.0));
}

/// A tilted torus: ∫ (ρ − R) dV = π² r⁴/2, for there is more flesh outside of a bend than inside, and
/// ∫ s² dV = π² R r⁴ about the circle, for the disc does not shrink where its frame is carried along.
#[test]
fn a_bundle_that_bends_keeps_its_disc_and_has_more_flesh_outside() {
    let (R, r, sides) = (0.012, 0.003, 240);
    let (sin, cos) = 0.7_f64.sin_cos();
    let axes = [
        [cos, sin * sin, sin * cos],
        [0.0, cos, -sin],
        [-sin, cos * sin, cos * cos],
    ];
    let point = |k: usize| {
        let (s, c) = (2.0 * PI * k as f64 / sides as f64).sin_cos();
        std::array::from_fn(|i| R * (c * axes[0][i] + s * axes[1][i]))
    };
    let line: Vec<[f64; 3]> = (0..sides).map(point).collect();
    let ring = course(&[&line], true, Section::Round { radius: r });
    let (mut outside, mut about) = (0.0, 0.0);
    ring.sweep(2e-4, &mut |sample| {
        let [x, y, z] = axes.map(|axis| dot(axis, sample.position));
        let beyond = x.hypot(y) - R;
        outside += sample.volume * beyond;
        about += sample.volume * (beyond * beyond + z * z);
    });
    close(outside, PI * PI * r.powi(4) / 2.0, 2e-2);
    close(about, PI * PI * R * r.powi(4), 1e-2);
}

/// A strap of whole cells: their elements are full, all others empty.
#[test]
fn a_weight_is_the_share_of_an_element_that_is_muscle() {
    let mesh = block(8);
    let strap = Section::Strap {
        width: 0.01,
        thickness: 0.005,
        normal: [0.0, 0.0, 1.0],
    };
    let line = [[0.005, 0.015, 0.0125], [0.035, 0.015, 0.0125]];
    let filling = filled(&course(&[&line], false, strap), &mesh);
    assert_eq!(filling.shares.len(), 6 * 2 * 6);
    for share in &filling.shares {
        let tet = mesh.tet(share.tet as usize).map(|n| mesh.node(n));
        for x in tet {
            let inside = x[0] > 0.0049 && x[0] < 0.0351 && x[1] > 0.0099 && x[1] < 0.0201;
            assert!(inside && x[2] > 0.0099 && x[2] < 0.0151, "{x:?}");
        }
        assert!(share.weight > 0.88, "{}", share.weight);
    }
}

/// A block with a hole along its middle, and a ring drawn through the hole that is laid around it.
fn ring(cells: usize, sides: usize) -> (SimplexMesh<3>, Course) {
    let whole = block(cells);
    let beside = |tet: &[u32]| {
        tet.iter().all(|&n| {
            let [x, y, _] = whole.node(n);
            (x - 0.02).hypot(y - 0.02) > 0.004
        })
    };
    let tets: Vec<u32> = whole
        .elements()
        .filter(|t| beside(t))
        .flatten()
        .copied()
        .collect();
    let mesh = without_orphans(whole.nodes(), &tets);
    let point = |k: usize| {
        let angle = 2.0 * PI * k as f64 / sides as f64;
        [0.02 + 0.009 * angle.cos(), 0.02 + 0.009 * angle.sin(), 0.02]
    };
    let line: Vec<[f64; 3]> = (0..sides).map(point).collect();
    let hole = ImplicitSurface::Capsule {
        ends: [[0.02, 0.02, -1.0], [0.02, 0.02, 1.0]],
        radius: 0.01,
    };
    let fine = resampled(&line, true, 1e-4).expect("a step");
    let laid = wrapped(&fine, 0.002, |x| (hole.distance(x), hole.normal(x)));
    let round = Section::Round { radius: 0.0015 };
    (mesh, course(&[&laid], true, round))
}

#[test]
fn a_ring_laid_around_a_hole_goes_around_it_and_refines_with_the_mesh() {
    let mut errors = Vec::new();
    for cells in [8, 16, 32] {
        let (mesh, course) = ring(cells, 7);
        for p in &course.lines[0] {
            close((p[0] - 0.02).hypot(p[1] - 0.02), 0.012, 1e-12);
        }
        let filling = filled(&course, &mesh);
        close(filling.volume, 2.0 * PI * 0.012 * PI * 2.25e-6, 1e-3);
        close(flesh(&filling, &mesh), filling.volume, 6e-3);
        // Off the tangent of the circle at the middle of the element, weighed by muscle.
        let off = |share: &Share| {
            let tet = mesh.tet(share.tet as usize).map(|n| mesh.node(n));
            let middle: [f64; 3] =
                std::array::from_fn(|i| 0.25 * tet.iter().map(|x| x[i]).sum::<f64>() - 0.02);
            let tangent = unit([-middle[1], middle[0], 0.0]);
            let angle = dot(share.direction, tangent).abs().min(1.0).acos();
            angle * share.weight * mesh.volume(share.tet as usize)
        };
        errors.push(filling.shares.iter().map(off).sum::<f64>() / filling.volume);
    }
    assert!(errors[0] < 0.1, "{errors:?}");
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.7 * pair[0], "{errors:?}");
    }
}

#[test]
fn what_is_turned_as_a_whole_is_filled_as_before() {
    let (mesh, ring) = ring(10, 9);
    let (sin, cos) = 0.7_f64.sin_cos();
    let turn = |x: [f64; 3]| {
        let [x, y, z] = [x[0] * cos - x[1] * sin, x[0] * sin + x[1] * cos, x[2]];
        [x * cos - z * sin + 0.3, y - 0.1, x * sin + z * cos]
    };
    let nodes = mesh.nodes().iter().map(|&x| turn(x)).collect();
    let turned = SimplexMesh::new(nodes, mesh.connectivity().to_vec()).expect("a mesh");
    let lines = ring
        .lines
        .iter()
        .map(|line| line.iter().map(|&x| turn(x)).collect());
    let turned_ring = Course {
        lines: lines.collect(),
        ..ring.clone()
    };
    let (before, after) = (filled(&ring, &mesh), filled(&turned_ring, &turned));
    assert_eq!(before.shares.len(), after.shares.len());
    let zero = turn([0.0; 3]);
    for (a, b) in before.shares.iter().zip(&after.shares) {
        assert_eq!(a.tet, b.tet);
        close(b.weight, a.weight, 1e-2);
        let direction = sub(turn(a.direction), zero);
        assert!(norm(cross(direction, b.direction)) < 1e-3);
    }
}

#[test]
fn smooth_lines_pass_through_their_points_and_follow_a_circle() {
    let point = |k: usize| {
        let angle = 2.0 * PI * k as f64 / 8.0;
        [angle.cos(), angle.sin(), 0.5]
    };
    let line: Vec<[f64; 3]> = (0..8).map(point).collect();
    let smooth = smoothed(&line, true, 10);
    assert_eq!(smooth.len(), 80);
    // Between equal chords a Catmull-Rom spline passes the middle at (9 (p₁ + p₂) − p₀ − p₃)/16.
    let middle = (18.0 * (PI / 8.0).cos() - 2.0 * (3.0 * PI / 8.0).cos()) / 16.0;
    for k in 0..8 {
        assert!(norm(sub(smooth[10 * k], line[k])) < 1e-12);
        let [x, y, _] = smooth[10 * k + 5];
        close(x.hypot(y), middle, 1e-12);
    }
    // Chords of 1, 4 and 9: knots 1, 2 and 3 apart. By Hermite's form, half the ends and an eighth of
    // the difference of their tangents, times the way between knots; beyond the ends points mirrored.
    let uneven = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 4.0, 0.0], [10.0, 4.0, 0.0]];
    let middles = [
        [0.5 + 1.0 / 24.0, -1.0 / 12.0, 0.0],
        [13.0 / 15.0, 28.0 / 15.0, 0.0],
        [4.825, 4.45, 0.0],
    ];
    let halved = smoothed(&uneven, false, 2);
    for (k, middle) in middles.into_iter().enumerate() {
        let found = halved[2 * k + 1];
        assert!(norm(sub(found, middle)) < 1e-14, "{found:?} {middle:?}");
    }
    let open = smoothed(&line[..3], false, 4);
    assert_eq!((open.len(), open[0], open[8]), (9, line[0], line[2]));
}

#[test]
fn each_defect_has_its_own_error() {
    let mesh = block(2);
    let round = Section::Round { radius: 0.001 };
    let line = [[0.01, 0.01, 0.01], [0.02, 0.02, 0.02]];
    let error = |course: Course| {
        course
            .fill(&mesh, &TetLocator::new(&mesh))
            .expect_err("must be refused")
    };
    assert_eq!(error(course(&[], false, round)), CourseError::NoLine);
    let few = error(course(&[&line, &line[..1]], false, round));
    assert!(
        few.to_string()
            .contains("line 1 has 1 point(s), at least 2"),
        "{few}"
    );
    let open = error(course(&[&line], true, round));
    assert!(
        matches!(open, CourseError::FewPoints { wanted: 3, .. }),
        "{open}"
    );
    let nan = error(course(&[&[line[0], [0.01, f64::NAN, 0.0]]], false, round));
    assert_eq!(nan, CourseError::NotFinite { line: 0, point: 1 });
    let twice = error(course(&[&[line[0], line[0], line[1]]], false, round));
    assert_eq!(twice, CourseError::Repeated { line: 0, point: 0 });
    for radius in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        let size = error(course(&[&line], false, Section::Round { radius }));
        assert!(
            matches!(size, CourseError::Size { what: "radius", .. }),
            "{size}"
        );
    }
    let sheet = Section::Sheet {
        thickness: 0.001,
        rounded: false,
    };
    assert_eq!(error(course(&[&line], false, sheet)), CourseError::OneLine);
    let strap = Section::Strap {
        width: 0.002,
        thickness: 0.001,
        normal: [1.0; 3],
    };
    let along = error(course(&[&line], false, strap));
    assert_eq!(along, CourseError::Normal { line: 0, point: 0 });
    let far = error(course(&[&[[1.0; 3], [1.1; 3]]], false, round));
    assert!(far.to_string().contains("meets no tetrahedron"), "{far}");
    // So thin that its square and its half are 0.
    for radius in [1e-120, 1e-200, 5e-324] {
        let thin = error(course(&[&line], false, Section::Round { radius }));
        assert!(matches!(thin, CourseError::TooFine { .. }), "{thin}");
    }
    // Micrometers taken for meters, and a strap as wide as a country: not swept for hours.
    let wide = Section::Strap {
        width: 1e6,
        thickness: 1e-3,
        normal: [0.0, 0.0, 1.0],
    };
    for (far, section) in [(1e4, round), (1e300, round), (0.02, wide)] {
        let fine = error(course(&[&[line[0], [far, 0.01, 0.01]]], false, section));
        assert!(matches!(fine, CourseError::TooFine { .. }), "{fine}");
    }
}

fn without_orphans(nodes: &[[f64; 3]], tets: &[u32]) -> SimplexMesh<3> {
    let mut used = tets.to_vec();
    used.sort_unstable();
    used.dedup();
    let place = |n: &u32| used.partition_point(|m| m < n) as u32;
    let kept = used.iter().map(|&n| nodes[n as usize]).collect();
    SimplexMesh::new(kept, tets.iter().map(place).collect()).expect("a mesh")
}
