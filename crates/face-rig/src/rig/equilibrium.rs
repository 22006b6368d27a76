//! x(θ): the equilibrium shape of a pose.

mod prediction;
mod tangent;

use self::prediction::Change;
pub(super) use self::tangent::Stiffness;
use self::tangent::Tangent;
use super::control::{Control, Controls};
use super::error::{PartError, RigError};
use super::parameters::Parameters;
use super::work::Work;
use crate::stopwatch::Stopwatch;
use fem_assembly::{
    Assembly, AssemblyError, Positions, Quasistatic, RenewingError, solve_renewing,
};
use fem_solvers::{
    BlockSymmetric, ContinuationError, ContinuationParams, LinearSolver, MultigridDirection,
    MultigridParams, Newton, NewtonParams, Path, ProjectionPolicy, Watch, follow_path,
};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A face that can be posed: flesh with muscles, attached to a cranium and a jaw.
///
/// The equilibrium z is found in the frame of the cranium, with the cranium's nodes at rest and the
/// jaw's nodes X at M_j X + t_j; the face is then x = M_c z + t_c at *every* node, so that a
/// non-orthogonal M_c changes no force (document 000, 3.2, with the position before the map).
pub struct Rig {
    assembly: Assembly<3>,
    jaw: Vec<u32>,
    controls: Controls,
    newton: Newton<'static, 3>,
    params: RigParams,
    equilibrium: Equilibrium,
    tangent: Option<Tangent>,
    work: Work,
    /// Right-hand sides of derivatives.
    right_hand_sides: AtomicUsize,
    /// Conjugate gradient iterations of derivatives.
    derivative_iterations: AtomicUsize,
    /// Are equilibria found by [`Multilevel`]?
    multigrid: bool,
}

/// Three axes, six rigid motions.
type Multilevel = MultigridDirection<3, 6>;

/// How a rig is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigParams {
    /// How each equilibrium is solved.
    pub newton: NewtonParams,
    /// The smallest part of the way to a new pose that is tried before giving up, in (0, 1].
    pub smallest_step: f64,
    /// An equilibrium with an element inside out that has a free node is none.
    pub refuses_inverted: bool,
    /// Whether equilibria are found with conjugate gradients on a multigrid hierarchy in place of
    /// [`NewtonParams::linear_solver`] (which may come to one by itself:
    /// [`LinearSolver::Auto`]), and derivatives in place of a factor.
    pub multigrid: MultigridUse,
    /// How exact derivatives by conjugate gradients are: the error of each solution dz or λ of K dz = f, in
    /// the norm of the stiffness K, over its own norm; not used with a factor. A number that is observed
    /// has a derivative by adjoints that is off by at most this times |λ| |dz|, both in that norm.
    pub derivative_tolerance: f64,
    /// Flops of a factorization above which [`LinearSolver::DirectSingle`] stands in for
    /// [`LinearSolver::Direct`]: its factor serves later steps and neighboring poses as long as a few
    /// conjugate gradient iterations on it suffice. ∞ for never.
    pub keeps_factor_above: f64,
}

/// When a rig uses [`MultigridDirection`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MultigridUse {
    /// Where it takes fewer operations than a factorization, by the counts of the analysis: those of a
    /// usual step for equilibria, those of all right-hand sides for a derivative. A derivative whose
    /// hierarchy cannot be made is taken by a factor.
    WhereCheaper,
    /// Where four steps of it do: for poses that follow each other, which share one factor in `f32` over
    /// steps and poses and need another one for the derivative in any case.
    WhereFarCheaper,
    /// Always, for want of memory: never a factor.
    Always,
    /// Never, but where the linear solver of the settings comes to one.
    Never,
}

impl RigParams {
    /// For fits, which stop at thousandths of a millimeter: forces are balanced to 1e-7 of what the
    /// flesh is strained by, 1e-9 otherwise. Newton's method converges quadratically, so that this
    /// spares about one step of each equilibrium and leaves positions and derivatives good to seven
    /// digits. Multigrid is used [where it is far cheaper](MultigridUse::WhereFarCheaper).
    #[must_use]
    pub fn for_fits() -> Self {
        let mut params = Self::default();
        params.newton.relative_gradient_tolerance = 1e-7;
        params.derivative_tolerance = 1e-8;
        params.multigrid = MultigridUse::WhereFarCheaper;
        params
    }
}

impl Default for RigParams {
    fn default() -> Self {
        let newton = NewtonParams {
            // Of the forces in the flesh: newtons would mean another accuracy in every unit.
            relative_gradient_tolerance: 1e-9,
            // Nearly incompressible flesh held by thin layers on bone needs hundreds of conjugate
            // gradient iterations; on the head of 13,000 free nodes a factor costs less.
            linear_solver: LinearSolver::Direct,
            // Posed flesh buckles on the way; a projection would be stiff everywhere for that.
            projection: ProjectionPolicy::ExactThenBlended,
            ..NewtonParams::default()
        };
        Self {
            newton,
            smallest_step: 1.0 / 256.0,
            refuses_inverted: false,
            // A fit factors every pose for its derivatives, which also predicts the next.
            multigrid: MultigridUse::Never,
            derivative_tolerance: 1e-10,
            // A factor of less is made in the time of three iterations on an old one.
            keeps_factor_above: 2e9,
        }
    }
}

/// A pose with its equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub struct Equilibrium {
    /// θ.
    pub parameters: Parameters,
    /// z: positions of all nodes in the frame of the cranium, meters.
    pub in_cranium_frame: Vec<[f64; 3]>,
}

impl Equilibrium {
    /// x = M_c z + t_c, meters.
    pub fn positions(&self) -> Vec<[f64; 3]> {
        self.in_cranium_frame
            .iter()
            .map(|&z| self.parameters.cranium.apply(z))
            .collect()
    }
}

impl std::fmt::Debug for Rig {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Rig")
            .field("assembly", &self.assembly)
            .field("jaw_nodes", &self.jaw.len())
            .field("params", &self.params)
            .field("work", &self.work)
            .finish_non_exhaustive()
    }
}

impl Rig {
    /// Takes an assembly whose prescribed nodes are those of cranium and jaw; `jaw` lists the latter.
    ///
    /// # Errors
    /// When a jaw node is not among the prescribed ones; [`RigError::Free`] when nothing holds a part of
    /// the flesh.
    pub fn new(
        assembly: Assembly<3>,
        jaw: &[usize],
        mut params: RigParams,
    ) -> Result<Self, RigError> {
        let expected = assembly.rest().len();
        for &node in jaw {
            if node >= expected || assembly.dofs().row(node).is_some() {
                return Err(RigError::JawNodeNotPrescribed { node });
            }
        }
        let parameters = Parameters::rest(assembly.controls());
        let rest = assembly.rest().to_vec();
        let relaxed = assembly.configuration(&rest, &parameters.activations)?;
        let free = assembly.free_motions(relaxed);
        // Springs that a control scales hold nothing at 0.
        let set = vec![1.0; assembly.controls()];
        let set = assembly.configuration(&rest, &set)?;
        if let Some(part) = free.into_iter().next()
            && !assembly.free_motions(set).is_empty()
        {
            return Err(RigError::Free(part));
        }
        let problem = Quasistatic::new(&assembly, rest.clone(), parameters.activations.clone())?;
        let mut newton = Newton::new(&problem);
        if params.newton.linear_solver == LinearSolver::Direct
            && (newton.symbolic()).is_some_and(|s| s.flops() > params.keeps_factor_above)
        {
            params.newton.linear_solver = LinearSolver::DirectSingle;
        }
        let mut worth = |steps| {
            let symbolic = newton.symbolic();
            symbolic.is_some_and(|symbolic| Multilevel::is_cheaper_than(symbolic, steps))
        };
        let multigrid = match params.multigrid {
            MultigridUse::Always => true,
            MultigridUse::Never => false,
            MultigridUse::WhereCheaper => worth(1.0),
            MultigridUse::WhereFarCheaper => worth(4.0),
        };
        if multigrid {
            newton = newton.directed_by(Multilevel::new(MultigridParams::default()));
        }
        let equilibrium = Equilibrium {
            parameters,
            in_cranium_frame: rest,
        };
        let jaw = jaw.iter().map(|&n| n as u32).collect();
        let controls = Controls::none(&assembly);
        let (tangent, work) = (None, Work::default());
        Ok(Self {
            assembly,
            jaw,
            controls,
            newton,
            params,
            equilibrium,
            tangent,
            work,
            right_hand_sides: AtomicUsize::new(0),
            derivative_iterations: AtomicUsize::new(0),
            multigrid,
        })
    }

    /// The same rig with controls beside the activations: those with an [`Effect::Energy`] are, in
    /// their order, the last controls of the assembly. All are 0 at rest.
    ///
    /// # Errors
    /// When there are more of them than controls of the assembly, a unit is not positive, or a motion
    /// moves what is not prescribed or hangs on the jaw.
    ///
    /// [`Effect::Energy`]: super::Effect::Energy
    pub fn with_controls(mut self, controls: Vec<Control>) -> Result<Self, RigError> {
        self.controls = Controls::new(controls, &self.assembly, &self.jaw)?;
        let rest = Parameters::rest(self.controls.muscles());
        self.equilibrium.parameters = rest.with_controls(vec![0.0; self.controls.len()]);
        self.equilibrium.in_cranium_frame = self.assembly.rest().to_vec();
        self.tangent = None;
        Ok(self)
    }

    /// The same rig, whose solves ask `watch` after every Newton step: a program shows progress, or
    /// cancels a solve or a fit ([`RigError::is_cancelled`]).
    #[must_use]
    pub fn watched_by(mut self, watch: Watch) -> Self {
        self.newton = self.newton.watched_by(watch);
        self
    }

    /// How it is solved: what it was made with, the linear solver by size.
    pub fn params(&self) -> &RigParams {
        &self.params
    }
    /// Number of muscles.
    pub fn muscles(&self) -> usize {
        self.controls.muscles()
    }
    /// Number of controls beside the activations.
    pub fn controls(&self) -> usize {
        self.controls.len()
    }
    /// The controls that the assembly's energy is given in a pose: activations, then controls of energy.
    pub fn energy_controls(&self, pose: &Parameters) -> Vec<f64> {
        self.controls.of_energy(pose)
    }
    /// The mesh with its materials.
    pub fn assembly(&self) -> &Assembly<3> {
        &self.assembly
    }
    /// The nodes attached to the jaw.
    pub fn jaw(&self) -> &[u32] {
        &self.jaw
    }
    /// The last pose that was solved; at first the rest shape.
    pub fn equilibrium(&self) -> &Equilibrium {
        &self.equilibrium
    }
    /// What has been done so far.
    pub fn work(&self) -> Work {
        Work {
            right_hand_sides: self.right_hand_sides.load(Ordering::Relaxed),
            linear_iterations: self.work.linear_iterations
                + self.derivative_iterations.load(Ordering::Relaxed),
            evaluations: self.assembly.evaluations(),
            ..self.work
        }
    }
    /// Makes an earlier pose the starting point of the next solve, which then depends on nothing that the rig
    /// has done since or before, its factors and derivatives included.
    ///
    /// # Errors
    /// When it is of another rig's lengths, or θ is not finite.
    pub fn start_from(&mut self, equilibrium: Equilibrium) -> Result<(), RigError> {
        self.check(&equilibrium.parameters)?;
        let (found, expected) = (
            equilibrium.in_cranium_frame.len(),
            self.assembly.rest().len(),
        );
        if found != expected {
            return Err(RigError::WrongLength {
                what: "nodes",
                found,
                expected,
            });
        }
        self.tangent = None;
        self.assembly.forget();
        self.newton.forget();
        self.equilibrium = equilibrium;
        Ok(())
    }

    /// Finds the equilibrium of a pose.
    ///
    /// The start is the nearer of the last solved pose and the last one whose derivative was taken,
    /// moved along its tangent dz/dθ; without the tangent, bones that move a few millimeters would
    /// turn the elements beside them inside out. The whole way is tried first; where that fails it
    /// is walked in parts. After an error the rig still holds its last solved pose.
    ///
    /// # Errors
    /// [`RigError::MovedOutOfDomain`] where the bones alone make the energy infinite;
    /// [`RigError::NoEquilibrium`] says how far the walk came; [`RigError::Walk`] when
    /// [`RigParams::smallest_step`] is no part of a way.
    pub fn solve(&mut self, parameters: &Parameters) -> Result<&Equilibrium, RigError> {
        self.solve_in_parts(parameters, self.params.smallest_step)
    }

    /// As [`solve`](Self::solve), the whole way or not at all: for a search that has a nearer pose to try
    /// where this one is far. Walked in parts a pose that flesh cannot come to whole may take thousands of
    /// Newton steps, only to be turned down.
    ///
    /// # Errors
    /// As [`solve`](Self::solve), but for what only parts can run into: [`RigError::NoEquilibrium`] came
    /// 0 % of the way.
    pub fn solve_whole(&mut self, parameters: &Parameters) -> Result<&Equilibrium, RigError> {
        self.solve_in_parts(parameters, 1.0)
    }

    fn solve_in_parts(
        &mut self,
        parameters: &Parameters,
        smallest_step: f64,
    ) -> Result<&Equilibrium, RigError> {
        self.check(parameters)?;
        self.check_bones(parameters)?;
        let begin = Stopwatch::start();
        let walked = self.walk(parameters, smallest_step);
        self.work.equilibrium_time += begin.elapsed();
        self.equilibrium = walked?;
        Ok(&self.equilibrium)
    }

    fn walk(&mut self, target: &Parameters, smallest_step: f64) -> Result<Equilibrium, RigError> {
        let near = |at: &Equilibrium| self.distance(&at.parameters, target);
        let start = match &self.tangent {
            Some(tangent) if near(&tangent.at) <= near(&self.equilibrium) => tangent.at.clone(),
            _ => self.equilibrium.clone(),
        };
        let params = ContinuationParams {
            smallest_step,
            ..ContinuationParams::default()
        };
        let mut state = start.clone();
        let mut walk = Walk {
            rig: self,
            start: &start.parameters,
            target,
        };
        match follow_path(&mut walk, &mut state, &params) {
            Ok(_) => Ok(state),
            Err(ContinuationError::Stuck {
                reached,
                step,
                info,
                source,
            }) => {
                let pose = walk.pose(reached + step);
                Err(RigError::NoEquilibrium {
                    percent: 100.0 * reached,
                    steps: info.steps,
                    element: self.inverted_element(&state, &pose),
                    last: Box::new(state),
                    source: Box::new(source),
                })
            }
            Err(error) => Err(RigError::Walk(Box::new(error))),
        }
    }

    /// How deep flesh lies in flesh or solids at the last solved pose, beyond rest, meters; `None` where
    /// nothing touches anything. Stencils are renewed there.
    ///
    /// # Errors
    /// As the terms' renewal.
    pub fn deepest_contact(&mut self) -> Result<Option<f64>, RigError> {
        let at = self.equilibrium.clone();
        self.renew(&at)?;
        let shape = self.assembly.positions(&at.in_cranium_frame)?;
        Ok(self.assembly.deepest_contact(shape)?)
    }

    /// Stencils that hold everything that has an energy at a pose, and a solver for them.
    fn renew(&mut self, at: &Equilibrium) -> Result<(), RigError> {
        if !self.assembly.changes() {
            return Ok(());
        }
        let energy = self.controls.of_energy(&at.parameters);
        let here = self.assembly.configuration(&at.in_cranium_frame, &energy)?;
        self.assembly.renew(here)?;
        let analyzed = self.newton.matrix().map(BlockSymmetric::pattern);
        if !analyzed.is_some_and(|own| Arc::ptr_eq(own, self.assembly.pattern())) {
            let z = at.in_cranium_frame.clone();
            let problem = Quasistatic::new(&self.assembly, z, energy)?;
            self.newton.renew(&problem);
        }
        Ok(())
    }

    /// Prescribed nodes at their pose.
    fn place_bones(&self, z: &mut [[f64; 3]], pose: &Parameters) {
        let rest = self.assembly.rest();
        for &n in &self.jaw {
            z[n as usize] = pose.jaw.apply(rest[n as usize]);
        }
        self.controls.place_moved(rest, &pose.controls, z);
    }

    /// |θ_a − θ_b| in what needs an equilibrium: activations, jaw, and controls in their units.
    fn distance(&self, a: &Parameters, b: &Parameters) -> f64 {
        let change = Change::between(a, b);
        let numbers = change.activations.iter().copied();
        let numbers = numbers.chain(change.jaw.to_array());
        let numbers = numbers.chain(self.controls.in_units(&change.controls));
        numbers.map(|d| d * d).sum::<f64>().sqrt()
    }

    fn solve_part(
        &mut self,
        guess: Vec<[f64; 3]>,
        pose: &Parameters,
    ) -> Result<Vec<[f64; 3]>, PartError> {
        let energy = self.controls.of_energy(pose);
        let Self {
            assembly,
            newton,
            params,
            work,
            ..
        } = self;
        work.equilibria += 1;
        let z = if assembly.changes() {
            match solve_renewing(assembly, newton, guess, &energy, &params.newton) {
                Ok(done) => {
                    work.add(done.iterations, done.factorizations, done.linear_iterations);
                    done.positions
                }
                Err(error) => {
                    if let RenewingError::Newton { source: e, .. } = &error {
                        work.add(e.iteration, e.factorizations, e.linear_iterations);
                    }
                    return Err(error.into());
                }
            }
        } else {
            let problem = Quasistatic::new(assembly, guess, energy)?;
            let mut x = problem.unknowns();
            let end = newton.solve(&problem, &mut x, &params.newton);
            match &end {
                Ok(done) => work.add(done.iterations, done.factorizations, done.linear_iterations),
                Err(e) => work.add(e.iteration, e.factorizations, e.linear_iterations),
            }
            end?;
            problem.positions(&x)?
        };
        if self.params.refuses_inverted
            && let Some((element, ratio)) = self.most_inverted(self.assembly.positions(&z)?)?
        {
            return Err(PartError::Inverted { element, ratio });
        }
        Ok(z)
    }

    /// The element with a free node that is furthest inside out, with its det F.
    fn most_inverted(&self, z: Positions<3>) -> Result<Option<(usize, f64)>, AssemblyError> {
        let dofs = self.assembly.dofs();
        let free = |element: usize| {
            let mut nodes = self.assembly.nodes_of(element).iter();
            nodes.any(|&n| dofs.row(n as usize).is_some())
        };
        let ratios = self.assembly.volume_ratios(z)?.into_iter().enumerate();
        let inverted = ratios.filter(|(element, ratio)| !(*ratio > 0.0) && free(*element));
        Ok(inverted.min_by(|a, b| a.1.total_cmp(&b.1)))
    }

    fn inverted_element(&self, from: &Equilibrium, pose: &Parameters) -> Option<usize> {
        let mut z = from.in_cranium_frame.clone();
        self.place_bones(&mut z, pose);
        let energy = self.controls.of_energy(pose);
        let at = self.assembly.configuration(&z, &energy);
        self.assembly.element_outside_domain(at.ok()?)
    }

    /// Newton's energy has no element without a free node; an infinite one is found here.
    fn check_bones(&self, pose: &Parameters) -> Result<(), RigError> {
        let mut z = self.assembly.rest().to_vec();
        self.place_bones(&mut z, pose);
        let energy = self.controls.of_energy(pose);
        let at = self.assembly.configuration(&z, &energy)?;
        let Some(element) = self.assembly.prescribed_element_outside_domain(at) else {
            return Ok(());
        };
        let nodes = self.assembly.nodes_of(element).iter().copied();
        let (jaw, cranium) = nodes.partition(|n| self.jaw.contains(n));
        let gradients = self.assembly.deformation_gradients(element, at)?;
        let ratios = gradients.map(|gradient| gradient.determinant());
        Err(RigError::MovedOutOfDomain {
            element,
            ratio: ratios.fold(f64::INFINITY, f64::min),
            jaw,
            cranium,
        })
    }

    fn check(&self, parameters: &Parameters) -> Result<(), RigError> {
        let (activations, controls) = (parameters.activations.len(), parameters.controls.len());
        for (what, found, expected) in [
            ("activations", activations, self.muscles()),
            ("controls", controls, self.controls.len()),
        ] {
            if found != expected {
                return Err(RigError::WrongLength {
                    what,
                    found,
                    expected,
                });
            }
        }
        match parameters.to_vec().iter().position(|v| !v.is_finite()) {
            Some(index) => Err(RigError::NotFinite { index }),
            None => Ok(()),
        }
    }
}

/// The way between two poses.
struct Walk<'a> {
    rig: &'a mut Rig,
    start: &'a Parameters,
    target: &'a Parameters,
}

impl Walk<'_> {
    fn pose(&self, s: f64) -> Parameters {
        match s {
            1.0 => self.target.clone(),
            _ => self.start.toward(self.target, s),
        }
    }
}

impl Path for Walk<'_> {
    type State = Equilibrium;
    type Error = PartError;

    fn predict(&mut self, state: &mut Equilibrium, _: f64, to: f64) {
        let pose = self.pose(to);
        state.in_cranium_frame = self.rig.predict(state, &pose);
        state.parameters = pose;
    }

    fn correct(&mut self, _: f64, state: &mut Equilibrium) -> Result<(), PartError> {
        let guess = std::mem::take(&mut state.in_cranium_frame);
        state.in_cranium_frame = self.rig.solve_part(guess, &state.parameters)?;
        Ok(())
    }

    fn gives_up(&self, error: &PartError) -> bool {
        error.is_cancelled()
    }
}
