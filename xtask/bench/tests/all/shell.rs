//! The mesh of a thick sphere.

use bench::scenes::shell::octant;
use std::f64::consts::PI;

#[test]
fn its_volume_comes_near_that_of_a_sphere_and_nothing_is_left_open_inside() {
    let exact = 4.0 / 3.0 * PI * 7.0 / 8.0;
    let lack = |n: usize| 1.0 - octant(n, 1.0, 2.0).expect("a mesh").total_volume() / exact;
    let (coarse, fine) = (lack(3), lack(6));
    assert!(
        fine > 0.0 && (coarse / fine - 4.0).abs() < 0.3,
        "{coarse} {fine}"
    );
    let mesh = octant(3, 1.0, 2.0).expect("a mesh");
    // Inner and outer side, and three quarters of a ring.
    assert_eq!(mesh.boundary().faces.len(), 2 * 27 * 2 + 3 * 18 * 2);
    assert_eq!(mesh.components().1, 1);
}
