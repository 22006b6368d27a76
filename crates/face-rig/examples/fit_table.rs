//! scratch
use face_rig::fit::*;
use face_rig::rig::*;
use face_rig::scene::Scene;
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let a: Vec<String> = std::env::args().collect();
    let scene = Scene::load(&a[1])?;
    let mut rp = RigParams::default();
    rp.newton.linear_solver = match std::env::var("LS").as_deref() {
        Ok("s") => fem_solvers::LinearSolver::DirectSingle,
        Ok("a") => fem_solvers::LinearSolver::Auto,
        _ => fem_solvers::LinearSolver::Direct,
    };
    let mut rig = scene.rig(rp)?;
    let map = Parametrization {
        muscles: scene.muscles.len(),
        active: (0..scene.muscles.len()).collect(),
        cranium: CraniumModel::Fixed,
        jaw: scene.hinged_jaw(),
    };
    let params = FitParams {
        activation_weight: a.get(3).map_or(1e-7, |w| w.parse().unwrap()),
        max_iterations: 25,
        ..FitParams::default()
    };
    let rest = rig.solved().clone();
    for target in scene
        .targets
        .iter()
        .filter(|t| a.get(2).is_none_or(|f| t.name.contains(f.as_str())))
    {
        rig.start_from(rest.clone())?;
        let w0 = rig.work();
        let fit = fit_expression(
            &scene,
            &mut rig,
            target,
            Seen::Landmarks,
            &map,
            &params,
            &map.rest(),
            &mut |i| {
                if a.len() > 4 {
                    println!("{i:?}")
                }
            },
        );
        let w = rig.work();
        match fit {
            Ok(f) => println!(
                "{:24} {:6.2} -> {:6.2} mm ({:3.0} %) it {:3} {:6.2} s  jaw {:5.1} newton {} eq {} fact {} eqtime {:.2} jactime {:.2} {:?}",
                f.name,
                f.rms_before_mm,
                f.rms_after_mm,
                100.0 * f.remaining(),
                f.iterations,
                f.seconds,
                f.jaw_degrees.unwrap_or(0.0),
                w.newton_steps - w0.newton_steps,
                w.equilibria - w0.equilibria,
                w.factorizations - w0.factorizations,
                (w.equilibrium_time - w0.equilibrium_time).as_secs_f64(),
                (w.jacobian_time - w0.jacobian_time).as_secs_f64(),
                f.outcome
            ),
            Err(e) => println!("{}: {e}", target.name),
        }
    }
    Ok(())
}
