//! One step of the host against the sums of the textbook: every node visited by its weight and
//! gradient, every stress taken alone, no sorting, no blocks, no registers.
use aniso_mpm::kernels::for_each_node;
use aniso_mpm::{
    Apic, Body, Cubic, Float, Linear, MlsMpm, Particle, Particles, Quadratic, Scheme, Settings,
    Simulation, Spline, Stencil,
};
use fem_kinematics::Mat;
use fem_materials::field::{Local1, MaterialField};
use fem_materials::{DegradableQr, QrAnisotropic};
use std::collections::BTreeMap;

const H: f64 = 0.1;
const DT: f64 = 1e-3;
const GRAVITY: f64 = -9.81;

fn bodies<const D: usize>() -> Vec<Body<DegradableQr, D>> {
    [2e3, 5e3, 1e3]
        .map(|mu| {
            Body::elastic(
                QrAnisotropic {
                    mu,
                    lambda: 5e3,
                    kx: 3e3,
                    ky: 1e3,
                }
                .degradable(0.0),
            )
        })
        .to_vec()
}

/// Particles of three bodies in turn, all different in everything.
fn particles<T: Float, const D: usize>(count: usize) -> Particles<T, D> {
    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
        (state >> 33) as f64 / (1u64 << 31) as f64
    };
    let mut particles = Particles::new();
    for p in 0..count {
        let particle = Particle {
            x: std::array::from_fn(|_| -0.3 + 0.7 * random()),
            v: std::array::from_fn(|_| random() - 0.5),
            F: Mat::from_fn(|i, j| f64::from(i == j) + 0.3 * (random() - 0.5)),
            mass: 0.5 + random(),
            volume: 1e-3 * (0.5 + random()),
            damage: 0.9 * random(),
            body: (p % 3) as u16,
        };
        particles.push(&particle).unwrap();
        particles.C[p] = Mat::from_fn(|_, _| T::from_f64(random() - 0.5));
    }
    particles
}

/// x, v, C and F of a particle after the step.
type State<const D: usize> = ([f64; D], [f64; D], Mat<f64, D>, Mat<f64, D>);

fn wide<T: Float, const D: usize>(m: &Mat<T, D>) -> Mat<f64, D> {
    Mat::from_fn(|i, j| m.0[i][j].to_f64())
}

/// What is done with a node, its weight, its distance from the particle and its gradient.
type Visit<'a, const D: usize> = Box<dyn FnMut([i32; D], f64, [f64; D], [f64; D]) + 'a>;

fn textbook<T: Float, S: Scheme, const D: usize>(particles: &Particles<T, D>) -> Vec<State<D>> {
    let bodies = bodies::<D>();
    let inertia = S::Kernel::INERTIA.map(|inertia| inertia * H * H);
    let x = |p: usize| -> [f64; D] { particles.x[p].map(|x| x.to_f64()) };
    let nodes = |p: usize, mut visit: Visit<'_, D>| {
        let stencil = Stencil::new::<S::Kernel>(&x(p), H);
        for_each_node::<D>(S::Kernel::WIDTH, |n| {
            let node: [i32; D] = std::array::from_fn(|a| stencil.base[a] + n[a] as i32);
            let away = std::array::from_fn(|a| f64::from(node[a]) * H - x(p)[a]);
            let w = stencil.weight(n);
            let gradient = match inertia {
                Some(inertia) if !S::KERNEL_GRADIENT => away.map(|r| w * r / inertia),
                _ => stencil.gradient(n),
            };
            visit(node, w, away, gradient);
        });
    };
    let mut grid: BTreeMap<[i32; D], (f64, [f64; D])> = BTreeMap::new();
    for p in 0..particles.len() {
        let (F, C) = (wide(&particles.F[p]), wide(&particles.C[p]));
        let (m, volume) = (particles.mass[p].to_f64(), particles.volume[p].to_f64());
        let material = bodies[usize::from(particles.body[p])].material;
        let tau = material
            .stress(&Local1(particles.damage[p].to_f64()), &F)
            .mul_tr(&F);
        let add = |node, w: f64, away: [f64; D], gradient: [f64; D]| {
            let (mass, momentum) = grid.entry(node).or_insert((0.0, [0.0; D]));
            *mass += w * m;
            let (affine, force) = (C.mul_vec(away), tau.mul_vec(gradient));
            for a in 0..D {
                let v = particles.v[p][a].to_f64() + affine[a];
                momentum[a] += w * m * v - DT * volume * force[a];
            }
        };
        nodes(p, Box::new(add));
    }
    (0..particles.len())
        .map(|p| {
            let mut v = [0.0; D];
            let (mut moment, mut gradient) = (Mat::zeros(), Mat::zeros());
            let read = |node, w: f64, away: [f64; D], grad: [f64; D]| {
                let (mass, momentum) = &grid[&node];
                for a in 0..D {
                    let down = if a == D - 1 { DT * GRAVITY } else { 0.0 };
                    let of_node = momentum[a] / mass + down;
                    v[a] += w * of_node;
                    for b in 0..D {
                        moment.0[a][b] += w * of_node * away[b];
                        gradient.0[a][b] += of_node * grad[b];
                    }
                }
            };
            nodes(p, Box::new(read));
            let C = inertia.map_or(gradient, |inertia| moment.scale(1.0 / inertia));
            let F = wide(&particles.F[p]);
            let new_x = std::array::from_fn(|a| x(p)[a] + DT * v[a]);
            (new_x, v, C, F + gradient.scale(DT) * F)
        })
        .collect()
}

fn host_takes_the_step_of_the_textbook<T: Float, S: Scheme, const D: usize>(
    count: usize,
    tolerance: f64,
) {
    let start = particles::<T, D>(count);
    let expected = textbook::<T, S, D>(&start);
    let settings = Settings::new(H);
    let mut host = Simulation::<T, S, _, D>::new(settings, bodies(), vec![], start).unwrap();
    host.step(DT).unwrap();
    let p = host.particles();
    let mut seen = vec![false; count];
    for i in 0..count {
        let id = p.id[i] as usize;
        seen[id] = true;
        let (x, v, C, F) = &expected[id];
        let near = |found: f64, right: f64, scale: f64| {
            let off = (found - right).abs();
            assert!(
                off <= tolerance * scale,
                "particle {id} of {count}: {found} {right}"
            );
        };
        for a in 0..D {
            near(p.x[i][a].to_f64(), x[a], 1.0);
            near(p.v[i][a].to_f64(), v[a], 1.0);
            for b in 0..D {
                near(p.C[i].0[a][b].to_f64(), C.0[a][b], 1.0 / H);
                near(p.F[i].0[a][b].to_f64(), F.0[a][b], 1.0);
            }
        }
    }
    assert!(seen.into_iter().all(|seen| seen));
}

#[test]
fn every_transfer_in_both_dimensions() {
    host_takes_the_step_of_the_textbook::<f64, MlsMpm<Quadratic>, 3>(300, 1e-12);
    host_takes_the_step_of_the_textbook::<f64, MlsMpm<Cubic>, 3>(300, 1e-12);
    host_takes_the_step_of_the_textbook::<f64, Apic<Quadratic>, 2>(300, 1e-12);
    host_takes_the_step_of_the_textbook::<f64, Apic<Quadratic>, 3>(300, 1e-12);
    host_takes_the_step_of_the_textbook::<f64, Apic<Cubic>, 2>(300, 1e-12);
    host_takes_the_step_of_the_textbook::<f64, Apic<Linear>, 3>(300, 1e-12);
}

#[test]
fn every_number_of_particles_that_eight_lanes_may_meet() {
    for count in [1, 7, 8, 9, 1025] {
        host_takes_the_step_of_the_textbook::<f64, MlsMpm<Quadratic>, 2>(count, 1e-12);
        host_takes_the_step_of_the_textbook::<f32, MlsMpm<Quadratic>, 2>(count, 3e-5);
    }
}
