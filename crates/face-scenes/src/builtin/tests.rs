//! The built-in face as a whole: a valid mesh, in its place, with muscles that pull the right way.

use std::collections::HashMap;

use super::*;
use face_rig::anatomy::{Bone, EmbeddedPoint};
use fem_assembly::mesh::{Quality, SimplexMesh};

const SIZES: [usize; 3] = [5_000, 20_000, 100_000];

fn mesh(face: &BuiltinFace) -> SimplexMesh<3> {
    let tets = face.tets.as_flattened().to_vec();
    SimplexMesh::new(face.nodes.clone(), tets).unwrap()
}

fn center(face: &BuiltinFace, tet: u32) -> [f64; 3] {
    let nodes = face.tets[tet as usize];
    let weights = [0.25; 4];
    EmbeddedPoint { nodes, weights }.position(&face.nodes)
}

/// Tets that share a face, and whether any face is shared by more than two.
fn neighbors(face: &BuiltinFace) -> Vec<[usize; 2]> {
    let mut faces: HashMap<[u32; 3], Vec<usize>> = HashMap::new();
    for (t, tet) in face.tets.iter().enumerate() {
        for k in 0..4 {
            let mut key = [tet[(k + 1) % 4], tet[(k + 2) % 4], tet[(k + 3) % 4]];
            key.sort_unstable();
            faces.entry(key).or_default().push(t);
        }
    }
    assert!(
        faces.values().all(|t| t.len() <= 2),
        "a face has three tets"
    );
    faces
        .values()
        .filter(|t| t.len() == 2)
        .map(|t| [t[0], t[1]])
        .collect()
}

#[test]
fn the_mesh_is_valid_at_every_size() {
    let mut volumes = Vec::new();
    for size in SIZES {
        let face = BuiltinFace::with_tets(size).unwrap();
        let q = Quality::measure(&mesh(&face));
        assert!(q.element_volume.min > 0.0, "{size}: {q:?}");
        assert!(
            q.smallest_dihedral.min > 4.0 && q.radius_ratio.min > 0.02,
            "{size}: {q:?}"
        );
        assert!(q.smallest_dihedral.median > 22.0, "{size}: {q:?}");
        volumes.push(q.volume);
        // One piece through shared faces, no unused node.
        let mut parent: Vec<usize> = (0..face.tets.len()).collect();
        fn root(parent: &mut [usize], mut i: usize) -> usize {
            while parent[i] != i {
                parent[i] = parent[parent[i]];
                i = parent[i];
            }
            i
        }
        for [a, b] in neighbors(&face) {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            parent[a] = b;
        }
        let first = root(&mut parent, 0);
        assert!((0..face.tets.len()).all(|t| root(&mut parent, t) == first));
        let mut used = vec![false; face.nodes.len()];
        face.tets
            .iter()
            .flatten()
            .for_each(|&n| used[n as usize] = true);
        assert!(used.iter().all(|&u| u));
        // The boundary is closed and manifold: every edge has two triangles, once each way.
        let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
        for t in &face.boundary {
            for k in 0..3 {
                *edges.entry([t.nodes[k], t.nodes[(k + 1) % 3]]).or_default() += 1;
            }
        }
        for (&[a, b], &n) in &edges {
            assert_eq!((n, edges.get(&[b, a])), (1, Some(&1)), "edge {a} {b}");
        }
    }
    // The form is the same at every resolution.
    assert!((volumes[1] / volumes[2] - 1.0).abs() < 0.02, "{volumes:?}");
    assert!((volumes[0] / volumes[2] - 1.0).abs() < 0.06, "{volumes:?}");
}

#[test]
fn the_face_is_its_own_mirror_image() {
    let face = BuiltinFace::with_tets(20_000).unwrap();
    let key = |p: [f64; 3]| p.map(f64::to_bits);
    let mirrored = |p: [f64; 3]| [if p[0] == 0.0 { 0.0 } else { -p[0] }, p[1], p[2]];
    // Upper and lower lip may share a place, so compare as multisets with the labels.
    let mut count: HashMap<([u64; 3], Bone), i32> = HashMap::new();
    for (p, b) in face.nodes.iter().zip(&face.bone) {
        *count.entry((key(*p), *b)).or_default() += 1;
        *count.entry((key(mirrored(*p)), *b)).or_default() -= 1;
    }
    assert!(count.values().all(|&c| c == 0));
    let half = face.muscles.len() as u32 / 2;
    let of = |m: u32| face.fibers.iter().filter(move |e| e.muscle == m);
    for m in 0..half {
        assert_eq!(of(m).count(), of(m + half).count());
        let sum = |m: u32| of(m).map(|e| e.weight).sum::<f64>();
        assert!((sum(m) - sum(m + half)).abs() < 1e-9);
        let base =
            |i: u32| face.muscles[i as usize][..face.muscles[i as usize].len() - 2].to_string();
        assert_eq!(base(m), base(m + half));
        assert!(of(m).all(|e| center(&face, e.tet)[0] > 0.0));
        assert!(of(m + half).all(|e| center(&face, e.tet)[0] < 0.0));
    }
}

#[test]
fn the_lips_and_lids_are_apart() {
    for size in SIZES {
        let face = BuiltinFace::with_tets(size).unwrap();
        let at = |x: f64, b: f64, side| face.embed([x, b, 1.0], side);
        for (a, b) in [
            (0.0, -33.0),
            (12.0, -33.0),
            (-12.0, -33.0),
            (31.0, 34.0),
            (-34.0, 34.0),
        ] {
            let (upper, lower) = (at(a, b, Side::Upper), at(a, b, Side::Lower));
            assert!(
                upper.nodes.iter().all(|n| !lower.nodes.contains(n)),
                "{size}: lips share a node at {a}, {b}"
            );
            let gap = upper.position(&face.nodes)[1] - lower.position(&face.nodes)[1];
            let range = if b < 0.0 { 1e-4..2e-3 } else { 3e-3..1.3e-2 };
            assert!(range.contains(&gap), "{size}: gap {gap} at {a}, {b}");
        }
        // Beyond the corner the two sides are one.
        let (upper, lower) = (at(35.0, -33.0, Side::Upper), at(35.0, -33.0, Side::Lower));
        let d = upper.position(&face.nodes)[1] - lower.position(&face.nodes)[1];
        assert!(d.abs() < 1e-12, "{size}: {d}");
    }
}

#[test]
fn bones_hold_what_they_should() {
    for size in SIZES {
        let face = BuiltinFace::with_tets(size).unwrap();
        let count = |b: Bone| face.bone.iter().filter(|&&x| x == b).count();
        // Flesh slides over the lower rear edge of the jaw.
        assert!(
            count(Bone::Jaw) >= 30 && count(Bone::Cranium) >= 100,
            "{size}"
        );
        assert!(
            count(Bone::Free) as f64 > 0.4 * face.nodes.len() as f64,
            "{size}"
        );
        for (p, bone) in face.nodes.iter().zip(&face.bone) {
            if *bone == Bone::Jaw {
                assert!(p[1] < 0.006 && p[1] > -0.085, "{size}: jaw at {p:?}");
            }
        }
        // No tet joins the two bones directly where the jaw moves: that would tear.
        let torn = face.tets.iter().filter(|t| {
            let has = |b: Bone| t.iter().any(|&n| face.bone[n as usize] == b);
            let jaw_front = t
                .iter()
                .any(|&n| face.bone[n as usize] == Bone::Jaw && face.nodes[n as usize][2] > 0.05);
            has(Bone::Cranium) && has(Bone::Jaw) && jaw_front
        });
        assert_eq!(torn.count(), 0, "{size}");
        // Opening moves the chin down and back.
        let chin = face.landmark_positions(&face.nodes)[8];
        let open = face.hinge.motion(0.1, [0.0; 3]).apply(chin);
        assert!(open[1] < chin[1] - 5e-3 && open[2] < chin[2] - 5e-3 && open[0] == chin[0]);
    }
}

#[test]
fn landmarks_are_where_anatomy_says() {
    let fine = BuiltinFace::with_tets(100_000).unwrap();
    let truth = fine.landmark_positions(&fine.nodes);
    for size in SIZES {
        let face = BuiltinFace::with_tets(size).unwrap();
        assert_eq!(face.landmarks.len(), 68);
        let skin: std::collections::HashSet<u32> = face.skin().into_iter().flatten().collect();
        for e in &face.landmarks {
            let on_skin: f64 = (0..4)
                .filter(|&k| skin.contains(&e.nodes[k]))
                .map(|k| e.weights[k])
                .sum();
            assert!((on_skin - 1.0).abs() < 1e-12, "landmark not on the skin");
            assert!(e.weights.iter().all(|w| (0.0..=1.0).contains(w)));
        }
        let p = face.landmark_positions(&face.nodes);
        for (a, b) in p.iter().zip(&truth) {
            let d = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
            assert!(d < if size < 10_000 { 6e-3 } else { 3e-3 }, "{size}: {d}");
        }
        // The mark-up is symmetric under this exchange.
        let mirror = |i: usize| match i {
            0..=16 => 16 - i,
            17..=26 => 43 - i,
            31..=35 => 66 - i,
            36..=39 => 81 - i,
            40 | 41 => 87 - i,
            42..=45 => 81 - i,
            46 | 47 => 87 - i,
            48..=54 => 102 - i,
            55..=59 => 114 - i,
            60..=64 => 124 - i,
            65..=67 => 132 - i,
            _ => i,
        };
        for i in 0..68 {
            let (a, b) = (p[i], p[mirror(i)]);
            assert!(
                (a[0] + b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9,
                "{i}: {a:?} {b:?}"
            );
        }
        assert!(
            p[0][0] < -0.05 && p[16][0] > 0.05,
            "0 is on the subject's right"
        );
        assert!(
            p[30][2] > p.iter().map(|q| q[2]).fold(0.0, f64::max) - 1e-12,
            "tip of the nose"
        );
        assert!(p[8][1] < p[57][1] && p[57][1] < p[51][1] && p[51][1] < p[33][1]);
        assert!(p[33][1] < p[36][1] && p[37][1] > p[41][1] && p[19][1] > p[37][1]);
        assert!(p[48][0] < -0.02 && p[54][0] > 0.02 && p[62][1] > p[66][1]);
        let pupils = 0.25 * (p[43][0] + p[44][0] + p[46][0] + p[47][0]);
        assert!((pupils - 0.031).abs() < 2e-3, "{pupils}");
    }
}

#[test]
fn muscles_pull_the_right_way_at_every_size() {
    let mut volumes: Vec<Vec<f64>> = Vec::new();
    for size in SIZES {
        let face = BuiltinFace::with_tets(size).unwrap();
        assert!(face.muscles.len() >= 46);
        let mut sums = vec![0.0; face.tets.len()];
        for e in &face.fibers {
            assert!(e.weight > 0.0 && e.weight <= 1.0);
            let length = e.direction.iter().map(|x| x * x).sum::<f64>();
            assert!((length - 1.0).abs() < 1e-12);
            sums[e.tet as usize] += e.weight;
        }
        assert!(sums.iter().all(|&s| s <= 1.0));
        assert!(
            face.fibers
                .windows(2)
                .all(|w| (w[0].tet, w[0].muscle) < (w[1].tet, w[1].muscle))
        );
        let mesh = mesh(&face);
        let mut volume = vec![0.0; face.muscles.len()];
        for e in &face.fibers {
            volume[e.muscle as usize] += e.weight * mesh.volume(e.tet as usize);
        }
        volumes.push(volume);
        let pull = |name: &str| {
            let m = face.muscles.iter().position(|n| n == name).unwrap() as u32;
            let entries: Vec<_> = face.fibers.iter().filter(|e| e.muscle == m).collect();
            assert!(
                entries.len() >= 6,
                "{size}: {name} has {} tets",
                entries.len()
            );
            let mut sum = [0.0; 3];
            for e in &entries {
                (0..3).for_each(|k| sum[k] += e.weight * e.direction[k]);
            }
            sum
        };
        for name in &face.muscles {
            pull(name);
        }
        let p = pull("zygomaticus_major_L");
        assert!(
            p[0] > 0.0 && p[1] > 0.0 && p[2] < 0.0,
            "up, out and back: {p:?}"
        );
        let p = pull("zygomaticus_major_R");
        assert!(p[0] < 0.0 && p[1] > 0.0 && p[2] < 0.0);
        for name in [
            "frontalis_medial_L",
            "frontalis_lateral_L",
            "levator_labii_superioris_L",
        ] {
            let p = pull(name);
            assert!(p[1] > p[0].abs() && p[1] > 0.0, "{name}: {p:?}");
        }
        for name in [
            "depressor_anguli_oris_L",
            "depressor_labii_inferioris_L",
            "procerus_L",
        ] {
            let p = pull(name);
            assert!(p[1] < 0.0 && p[1].abs() > p[0].abs(), "{name}: {p:?}");
        }
        let p = pull("corrugator_supercilii_L");
        assert!(
            p[0] < 0.0 && p[0].abs() > p[1].abs(),
            "towards the nose: {p:?}"
        );
        let p = pull("risorius_L");
        assert!(
            p[0] > 0.0 && p[2] < 0.0 && p[1].abs() < 0.5 * p[0].hypot(p[2]),
            "{p:?}"
        );
        assert!(pull("mentalis_L")[1] > 0.0 && pull("masseter_L")[1] > 0.0);
    }
    for m in 0..volumes[0].len() {
        let (coarse, middle, fine) = (volumes[0][m], volumes[1][m], volumes[2][m]);
        assert!(
            (middle / fine - 1.0).abs() < 0.25,
            "muscle {m}: {middle} {fine}"
        );
        assert!(
            (coarse / fine - 1.0).abs() < 0.5,
            "muscle {m}: {coarse} {fine}"
        );
    }
}

#[test]
fn the_same_face_every_time_and_no_absurd_size() {
    let face = || BuiltinFace::with_tets(5_000).unwrap();
    let alone = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let (a, b) = (face(), alone.install(face));
    assert_eq!(a.nodes, b.nodes);
    assert_eq!(a.fibers, b.fibers);
    assert_eq!(a.boundary, b.boundary);
    assert!(matches!(
        BuiltinFace::with_tets(7),
        Err(BuiltinError::Resolution { target: 7 })
    ));
}

#[test]
fn decorations_stay_behind_the_skin() {
    let face = BuiltinFace::with_tets(20_000).unwrap();
    let front = face.landmark_positions(&face.nodes)[30][2];
    for d in face.decorations() {
        assert_eq!(d.points.len(), d.coordinates.len());
        assert!(
            d.triangles
                .iter()
                .flatten()
                .all(|&i| (i as usize) < d.points.len())
        );
        assert!(d.points.iter().all(|p| p[2] < front && p[0].abs() < 0.05));
    }
}
