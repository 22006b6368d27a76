//! The skin of dense targets, and vertices of it on the wrong flesh.

use super::*;

#[test]
fn dense_targets() {
    let files = Files::new();
    let dense = r#""landmarks": "landmarks.csv", "dense": { "file": "skin.vtu" }, "skip""#;
    files.edit(
        "scene.json",
        "\"landmarks\": \"landmarks.csv\", \"skip\"",
        dense,
    );
    let write = |ids: [i64; 3], names: [&str; 2]| {
        let points = vec![[0.0; 3], [0.01, 0.0, 0.0], [0.0, 0.01, 0.0]];
        let mut skin = MeshFile::from_triangles(points, &[[0, 1, 2]])
            .with_point_data(DataArray::integers("ict_vertex", ids));
        for name in names {
            let up = [[0.0, 0.5, 0.0]; 3];
            skin = skin.with_point_data(DataArray::vectors(name, &up));
        }
        skin.write(files.path("skin.vtu")).expect("writable");
    };
    write([7, 9, 7], ["disp_smile", "disp_identity_a"]);
    let scene = files.load().expect("sound");
    let goals = scene.targets[0].dense.as_deref().expect("dense");
    assert_eq!(goals[1], [0.01, 0.5, 0.0]);
    assert_eq!(scene.skin.expect("a skin").triangles, [[0, 1, 2]]);
    write([7, 9, 8], ["disp_smile", "disp_identity_a"]);
    expect(&files.error("skin.vtu"), &["point 2", "vertex 8"]);
    write([7, 9, 7], ["disp_smile", "disp_other"]);
    expect(
        &files.error("skin.vtu"),
        &["\"disp_identity_a\"; the file has", "disp_other"],
    );
}

/// Five points of the skin on one tet; the embedding lays the middle one on a tet that shares no node
/// with it.
#[test]
fn strays_are_kept_or_repaired_as_the_scene_says() {
    let files = Files::new();
    let repair = r#""strays": "repair", "embedding": "embedding.csv""#;
    files.edit("scene.json", r#""embedding": "embedding.csv""#, repair);
    let error = files.error("scene.json");
    expect(
        &error,
        &["face.files.strays", "needs the skin", "\"dense\""],
    );

    let mesh = kuhn_grid(2, 3, 2, [0.1, 0.2, 0.1]).expect("a grid");
    let (own, nodes) = (0, mesh.tet(0));
    let middle = EmbeddedPoint {
        nodes,
        weights: [0.25; 4],
    }
    .position(mesh.nodes());
    let apart = |t: &usize| mesh.tet(*t).iter().all(|n| !nodes.contains(n));
    let on = |t: usize| EmbeddedPoint::at(mesh.tet(t), mesh.nodes(), middle).expect("a tet");
    let least = |t: usize| on(t).weights.into_iter().fold(f64::INFINITY, f64::min);
    let others = (0..mesh.num_elements()).filter(apart);
    let other = others
        .max_by(|a, b| least(*a).total_cmp(&least(*b)))
        .expect("another tet");
    let mut table = String::from("vertex,tet,w0,w1,w2,w3\n");
    let mut places = vec![middle];
    let mut row = |vertex, tet, w: [f64; 4]| {
        table += &format!(
            "{vertex},{tet},{:?},{:?},{:?},{:?}\n",
            w[0], w[1], w[2], w[3]
        );
    };
    row(7, other, on(other).weights);
    for k in 0..4 {
        let mut weights = [0.24; 4];
        weights[k] += 0.04;
        row(8 + k, own, weights);
        places.push(EmbeddedPoint { nodes, weights }.position(mesh.nodes()));
    }
    files.text("embedding.csv", &table);
    let [x, y, z] = middle;
    let rows = format!("rest,0,7,{x:?},{y:?},{z:?}\nsmile,0,7,0.01,0,0\n");
    files.text(
        "landmarks.csv",
        &format!("target,landmark,vertex,x,y,z\n{rows}"),
    );
    let triangles = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];
    MeshFile::from_triangles(places, &triangles)
        .with_point_data(DataArray::integers("ict_vertex", [7, 8, 9, 10, 11]))
        .with_point_data(DataArray::vectors("disp_smile", &[[0.0; 3]; 5]))
        .write(files.path("skin.vtu"))
        .expect("writable");
    let dense = r#""landmarks": "landmarks.csv", "dense": { "file": "skin.vtu" }, "skip""#;
    files.edit(
        "scene.json",
        "\"landmarks\": \"landmarks.csv\", \"skip\"",
        dense,
    );
    let told = |scene: &Scene| {
        let warnings = check(scene).warnings;
        warnings.iter().any(|w| matches!(w, Warning::Strays { .. }))
    };
    let repaired = files.load().expect("sound");
    assert_eq!(repaired.repaired_strays, [7]);
    assert!(!told(&repaired));
    assert!(
        check(&repaired)
            .to_string()
            .contains("given the flesh of their neighbors: [7]")
    );
    let skin = repaired.skin.as_ref().expect("a skin");
    assert_eq!(skin.points[0].nodes, nodes);
    assert_eq!(repaired.embedding[&7], skin.points[0]);
    assert_eq!(repaired.landmarks[0].point, skin.points[0]);
    // What is fitted is the repaired place.
    assert_eq!(repaired.targets[0].landmarks[0].point, skin.points[0]);
    files.edit(
        "scene.json",
        "\"strays\": \"repair\"",
        "\"strays\": \"keep\"",
    );
    let kept = files.load().expect("sound");
    assert_eq!(kept.repaired_strays, [0_u32; 0]);
    assert_eq!(kept.embedding[&7].nodes, mesh.tet(other));
    assert!(told(&kept));
}
