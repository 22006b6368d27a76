//! A shaded surface of 20,000 triangles: `cargo bench -p face-pictures`.

use criterion::{Criterion, criterion_group, criterion_main};
use face_pictures::{Camera, Layer, Paint, Panel};

/// A wavy sheet of n × n points.
fn sheet(n: usize) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let at = |k: usize| k as f64 / (n - 1) as f64 - 0.5;
    let point = |i: usize| {
        let (x, y) = (at(i % n), at(i / n));
        [x, y, 0.05 * (20.0 * x).sin() * (15.0 * y).cos()]
    };
    let corners = |i: usize| {
        let a = (i / (n - 1) * n + i % (n - 1)) as u32;
        let [b, c, d] = [a + 1, a + n as u32, a + n as u32 + 1];
        [[a, b, c], [b, d, c]]
    };
    let triangles = (0..(n - 1) * (n - 1)).flat_map(corners).collect();
    ((0..n * n).map(point).collect(), triangles)
}

fn shading(criterion: &mut Criterion) {
    let (points, triangles) = sheet(101);
    let camera = Camera::framing(&points, 25.0, 10.0).expect("points");
    let panel = Panel::new("sheet", camera).layer(Layer::new(
        &points,
        &triangles,
        Paint::Uniform([0.7, 0.6, 0.5]),
    ));
    let mut group = criterion.benchmark_group("20000 triangles");
    group.sample_size(10);
    group.bench_function("400 x 400", |b| b.iter(|| panel.draw(400, 400)));
    group.finish();
}

criterion_group!(benches, shading);
criterion_main!(benches);
