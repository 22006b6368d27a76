//! Controls beside activations: the derivative by each against differences of full re-solves, adjoints
//! against columns, and a fit that finds a pressure.

use super::promise::Rig;
use face_rig::anatomy::EmbeddedPoint;
use face_rig::fit::{ControlModel, CraniumModel, FitParams, Fitter, JawModel, Parametrization};
use face_rig::rig::{
    AllNodes, Control, Direction, Effect, EmbeddedPoints, JacobianRoute, Observation, Parameters,
    RigError, RigParams,
};
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{AssemblyBuilder, Cavity, Dofs, Fiber, Gravity, Scaled, VolumePatches};
use fem_materials::curves::PhysBam;
use fem_materials::{FiberLaw, StableNeoHookean, Stretch};

const MUSCLES: usize = 2;
/// Pressure (Pa), weight, strength, stiffness, and two motions.
const VALUES: [f64; 6] = [900.0, 0.8, 0.4, -0.3, 0.7, -0.5];
const UNITS: [f64; 6] = [2000.0, 1.0, 1.0, 1.0, 1.0, 1.0];

fn assembly(
    prescribed: &[usize],
    axes: &[(usize, usize)],
) -> (fem_assembly::Assembly<3>, Vec<usize>) {
    let mesh = kuhn_grid(2, 2, 4, [0.04, 0.04, 0.08]).unwrap();
    let rest = mesh.nodes();
    let at = |z: f64| (0..rest.len()).filter(move |&n| (rest[n][2] - z).abs() < 1e-9);
    let jaw: Vec<usize> = at(0.08).collect();
    let prescribed: Vec<usize> = at(0.0)
        .chain(jaw.clone())
        .chain(prescribed.to_vec())
        .collect();
    let fibers = |control: usize| -> Vec<Fiber> {
        let of = |element| Fiber {
            element,
            control,
            direction: [[0.0, 0.6, 0.8], [0.8, 0.0, 0.6]][control],
            max_isometric_stress: 2e4,
            optimal_stretch: 1.1,
        };
        (0..mesh.num_elements())
            .skip(control)
            .step_by(2)
            .map(of)
            .collect()
    };
    let law = FiberLaw {
        curve: PhysBam::default(),
        stretch: Stretch::Total,
    };
    let side = mesh.boundary_faces(|n| mesh.node(n)[0] == 0.0);
    let cavity = Cavity::capped(Cavity::turned(side), 1.0, |n| n == 0).unwrap();
    let (lower, upper): (Vec<usize>, Vec<usize>) =
        (0..mesh.num_elements()).partition(|e| *e < mesh.num_elements() / 2);
    let flesh = StableNeoHookean {
        mu: 1e4,
        lambda: 1e4,
    };
    let bulk = |chosen: &[usize]| {
        let mut bulk = vec![0.0; mesh.num_elements()];
        chosen.iter().for_each(|&e| bulk[e] = 8e4);
        bulk
    };
    let patches = VolumePatches::around_edges(&mesh);
    let dofs = Dofs::new(rest, &prescribed, axes).unwrap();
    let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let builder = builder
        .region(&lower, flesh)
        .unwrap()
        .mean_volume(&patches, &bulk(&lower))
        .unwrap()
        .fibers(law, MUSCLES, &fibers(0))
        .unwrap()
        .term(Scaled::new(cavity, 2).unwrap())
        .unwrap()
        .term(Scaled::new(Gravity::new(&mesh, 1e3, [0.0, -9.81, 0.0]).unwrap(), 3).unwrap())
        .unwrap()
        .changed_by(4, |b| b.fibers(law, MUSCLES, &fibers(1)))
        .unwrap()
        .changed_by(5, |b| {
            b.region(&upper, flesh)?
                .mean_volume(&patches, &bulk(&upper))
        });
    (builder.unwrap().build().unwrap(), jaw)
}

/// A node in the middle that is moved whole, and one that is moved along y alone.
const HELD: usize = 22;
const SLIDING: (usize, usize) = (20, 1);

fn controls() -> Vec<Control> {
    let effects = [
        Effect::Energy,
        Effect::Motion(vec![
            (HELD, 0, 0.002),
            (HELD, 2, -0.003),
            (SLIDING.0, SLIDING.1, 0.001),
        ]),
        Effect::Energy,
        Effect::Energy,
        Effect::Energy,
        Effect::Motion(vec![(HELD, 0, 0.001), (SLIDING.0, SLIDING.1, -0.004)]),
    ];
    let order = [0, 4, 1, 2, 3, 5];
    let units = order.map(|k| UNITS[k]);
    let control = |(unit, effect)| Control { unit, effect };
    units.into_iter().zip(effects).map(control).collect()
}

fn values() -> Vec<f64> {
    [0, 4, 1, 2, 3, 5].map(|k| VALUES[k]).to_vec()
}

fn rig() -> Rig {
    let (assembly, jaw) = assembly(&[HELD], &[SLIDING]);
    let mut params = RigParams::default();
    params.newton.gradient_tolerance = 1e-13;
    let rig = Rig::new(assembly, &jaw, params).unwrap();
    rig.with_controls(controls()).unwrap()
}

fn pose() -> Parameters {
    let mut pose = Parameters::rest(MUSCLES).with_controls(values());
    pose.activations = vec![0.5, 0.6];
    pose.cranium.matrix = [[1.1, 0.2, 0.0], [-0.1, 0.9, 0.1], [0.05, 0.0, 1.05]];
    pose.jaw.matrix = [[1.0, 0.05, 0.0], [0.0, 0.98, -0.12], [0.0, 0.12, 1.01]];
    pose.jaw.translation = [0.001, 0.004, -0.003];
    pose
}

fn largest(v: impl IntoIterator<Item = f64>) -> f64 {
    v.into_iter().fold(0.0, |m, x| m.max(x.abs()))
}

fn directions() -> Vec<Direction> {
    let controls = (0..VALUES.len()).map(Direction::Control);
    (0..MUSCLES)
        .map(Direction::Activation)
        .chain(controls)
        .collect()
}

#[test]
fn the_column_of_every_control_agrees_with_differences_of_full_solves() {
    let mut rig = rig();
    assert_eq!((rig.muscles(), rig.controls()), (MUSCLES, VALUES.len()));
    rig.solve(&pose()).unwrap();
    let columns = rig.sensitivity().unwrap().columns(&directions()).unwrap();
    for (direction, column) in directions().iter().zip(&columns) {
        let h = match direction {
            Direction::Control(k) => 1e-4 * controls()[*k].unit,
            _ => 1e-4,
        };
        let mut at = |t: f64| {
            let mut moved = pose();
            match direction {
                Direction::Control(k) => moved.controls[*k] += t,
                Direction::Activation(m) => moved.activations[*m] += t,
                _ => {}
            }
            rig.solve(&moved).unwrap();
            rig.equilibrium().positions()
        };
        let shapes = [at(h), at(-h), at(2.0 * h), at(-2.0 * h)].map(|x| x.concat());
        let [one, minus_one, two, minus_two] = shapes;
        let difference = (0..one.len())
            .map(|i| (8.0 * (one[i] - minus_one[i]) - (two[i] - minus_two[i])) / (12.0 * h));
        let exact = column.concat();
        let scale = largest(exact.iter().copied());
        let off = largest(difference.zip(&exact).map(|(d, e)| d - e));
        assert!(
            scale > 0.0 && off <= 1e-6 * scale,
            "{direction:?}: {off} of {scale}"
        );
    }
}

#[test]
fn adjoints_agree_with_columns() {
    let mut rig = rig();
    rig.solve(&pose()).unwrap();
    let nodes = rig.assembly().rest().len();
    let all = AllNodes { nodes };
    let some = EmbeddedPoints(
        [HELD, 20, 30, 40]
            .map(|n| EmbeddedPoint::node(n as u32))
            .to_vec(),
    );
    let sensitivity = rig.sensitivity().unwrap();
    for seen in [&all as &dyn Observation, &some] {
        let by = |route| sensitivity.jacobian(seen, &directions(), route).unwrap();
        let (columns, adjoint) = (by(JacobianRoute::Columns), by(JacobianRoute::Adjoint));
        let rows = seen.dim();
        for (k, (a, b)) in columns.chunks(rows).zip(adjoint.chunks(rows)).enumerate() {
            let scale = largest(a.iter().copied());
            let off = largest(a.iter().zip(b).map(|(a, b)| a - b));
            assert!(
                off <= 1e-10 * scale,
                "{:?}: {off} of {scale}",
                directions()[k]
            );
        }
    }
}

#[test]
fn motions_put_their_nodes_where_they_say() {
    let mut rig = rig();
    rig.solve(&pose()).unwrap();
    let z = &rig.equilibrium().in_cranium_frame;
    let rest = rig.assembly().rest();
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
    near(z[HELD][0], rest[HELD][0] + 0.7 * 0.002 - 0.5 * 0.001);
    near(z[HELD][1], rest[HELD][1]);
    near(z[HELD][2], rest[HELD][2] - 0.7 * 0.003);
    near(z[20][1], rest[20][1] + 0.7 * 0.001 + 0.5 * 0.004);
    assert!((z[20][0] - rest[20][0]).abs() > 1e-5);
}

/// Pressure and weight of a known pose, forgotten and found again beside the activations.
#[test]
fn a_fit_finds_a_pressure_again() {
    let mut rig = rig();
    let mut truth = Parameters::rest(MUSCLES).with_controls(vec![0.0; VALUES.len()]);
    truth.activations = vec![0.4, 0.2];
    truth.controls[0] = 1200.0;
    truth.controls[1] = 0.3;
    truth.controls[2] = -0.5;
    rig.solve(&truth).unwrap();
    let target = rig.equilibrium().positions().concat();
    let observation = AllNodes {
        nodes: target.len() / 3,
    };
    let mut models = vec![
        ControlModel {
            neutral: 0.0,
            bounds: None,
        };
        VALUES.len()
    ];
    models[0].bounds = Some([0.0, 3000.0]);
    models[1].neutral = 0.3;
    models[2].bounds = Some([-1.0, 1.0]);
    let map = Parametrization::of_all(MUSCLES, CraniumModel::Fixed, JawModel::Fixed);
    let map = map.with_controls(models.clone());
    assert_eq!(map.len(), MUSCLES + 2);
    let params = FitParams {
        activation_weight: 0.0,
        rms_tolerance: 1e-12,
        rms_change: 0.0,
        step_tolerance: 1e-9,
        ..FitParams::default()
    };
    let fitter = Fitter {
        observation: &observation,
        target: &target,
        weights: &[],
        parametrization: &map,
        params: &params,
    };
    let rest = Parameters::rest(MUSCLES).with_controls(vec![0.0; VALUES.len()]);
    rig.solve(&rest).unwrap();
    let report = rig.fit(&fitter, &map.rest(), &mut |_| {}).unwrap();
    let found = &report.parameters.controls;
    assert!((found[0] / 1200.0 - 1.0).abs() < 1e-6, "{found:?}");
    assert!(
        (found[1] - 0.3).abs() < 1e-15 && (found[2] + 0.5).abs() < 1e-6,
        "{found:?}"
    );
    assert!(
        largest(
            report
                .parameters
                .activations
                .iter()
                .zip([0.4, 0.2])
                .map(|(a, b)| a - b)
        ) < 1e-6
    );
    let fewer = map.clone().with_controls(models[1..].to_vec());
    let fitter = Fitter {
        parametrization: &fewer,
        ..fitter
    };
    assert!(rig.fit(&fitter, &fewer.rest(), &mut |_| {}).is_err());
}

#[test]
fn controls_that_make_no_sense_are_refused() {
    let made = |controls: Vec<Control>| {
        let (assembly, jaw) = assembly(&[HELD], &[SLIDING]);
        let rig = Rig::new(assembly, &jaw, RigParams::default()).unwrap();
        rig.with_controls(controls).err()
    };
    let energy = |unit| Control {
        unit,
        effect: Effect::Energy,
    };
    let motion = |node, axis, meters| {
        vec![Control {
            unit: 1.0,
            effect: Effect::Motion(vec![(node, axis, meters)]),
        }]
    };
    assert!(made(vec![energy(1.0); 6]).is_none());
    assert!(matches!(
        made(vec![energy(1.0); 7]),
        Some(RigError::WrongLength { .. })
    ));
    assert!(matches!(
        made(vec![energy(0.0)]),
        Some(RigError::ControlUnit { control: 0, .. })
    ));
    assert!(made(motion(HELD, 2, 0.1)).is_none());
    for bad in [
        motion(21, 0, 0.1),
        motion(SLIDING.0, 0, 0.1),
        motion(HELD, 3, 0.1),
        motion(99, 0, 0.1),
        motion(44, 0, 0.1),
        motion(HELD, 0, f64::NAN),
    ] {
        assert!(matches!(
            made(bad),
            Some(RigError::MotionNotPrescribed { .. })
        ));
    }
    let mut rig = rig();
    let short = rig.solve(&Parameters::rest(MUSCLES));
    assert!(matches!(short, Err(RigError::WrongLength { .. })));
}
