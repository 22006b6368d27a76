//! Prescribed motion that is too far for one step.

use crate::assembly::Assembly;
use crate::configuration::Configuration;
use crate::error::AssemblyError;
use crate::predictor::predicted;
use crate::renewing::{RenewedSolution, RenewingError, solve_renewing};
use fem_solvers::{
    ContinuationError, ContinuationInfo, ContinuationParams, Newton, NewtonFailure, NewtonParams,
    Path, follow_path,
};

/// An equilibrium that was walked to.
#[derive(Clone, Debug, PartialEq)]
pub struct WalkedSolution<const D: usize> {
    /// All positions, meters.
    pub positions: Vec<[f64; D]>,
    /// Places on the way that were solved (1 when the first try was enough), and tries that failed.
    pub walk: ContinuationInfo,
    /// Newton steps of all places that were solved.
    pub iterations: usize,
}

/// Why the place was not reached.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum WalkError<const D: usize> {
    /// Lists or steps that make no sense.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// Even the smallest step failed.
    #[error(
        "stuck {percent:.1} % of the way{}: {source}",
        element.map_or_else(String::new, |e| format!(", element {e} would leave its domain next"))
    )]
    Stuck {
        /// How far the walk came, per cent.
        percent: f64,
        /// The first element that is outside its domain when only the prescribed coordinates go on.
        element: Option<usize>,
        /// Where it stands, meters.
        last: Vec<[f64; D]>,
        /// What failed next.
        source: Box<RenewingError<D>>,
    },
    /// The walk could not begin: a setting is outside its range.
    #[error(transparent)]
    Walk(Box<ContinuationError<RenewingError<D>>>),
}

/// Moves the prescribed coordinates from where they are in `from` to where they are in `to` (the free
/// ones of `to` are not read), and finds the equilibrium there.
///
/// The whole way is tried first, with the free nodes moved along the tangent where that lowers the
/// energy, so that the first layer of elements does not take all of the motion (docs/solvers.md).
/// Where that leaves the domain of a material, or Newton's method fails, half of it is tried, and so
/// on, down to `walk.smallest_step`; each equilibrium is the start of the next. `from` must be in the
/// domain of every term, and `newton` made for this assembly.
///
/// ```
/// use fem_assembly::{AssemblyBuilder, Dofs, Quasistatic, solve_walking};
/// use fem_materials::NeoHookean;
/// use fem_solvers::{ContinuationParams, Newton, NewtonParams};
///
/// // A cube of four layers, its top pushed in by one and a half of them.
/// let mesh = fem_assembly::mesh::kuhn_grid(2, 2, 4, [1.0; 3])?;
/// let ends: Vec<usize> = (0..45).filter(|&n| mesh.nodes()[n][2] * (1.0 - mesh.nodes()[n][2]) == 0.0).collect();
/// let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &ends)?;
/// let flesh = NeoHookean { mu: 1e4, lambda: 1e4 };
/// let mut body = AssemblyBuilder::new(&mesh, dofs)?.material(flesh)?.build()?;
/// let rest = mesh.nodes().to_vec();
/// let pushed: Vec<[f64; 3]> = rest.iter().map(|&[x, y, z]| [x, y, if z == 1.0 { 0.625 } else { z }]).collect();
///
/// let mut newton = Newton::new(&Quasistatic::held(&body, rest.clone(), vec![])?);
/// let (params, walk) = (NewtonParams::default(), ContinuationParams::default());
/// let there = solve_walking(&mut body, &mut newton, rest, &pushed, &[], &params, &walk)?;
/// assert!(body.volume_ratios(body.positions(&there.positions)?)?.iter().all(|&j| j > 0.3));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`WalkError::Stuck`] says how far it came and which element is in the way; [`WalkError::Assembly`] and
/// [`WalkError::Walk`] that a list or a setting of the walk makes no sense.
pub fn solve_walking<const D: usize>(
    assembly: &mut Assembly<D>,
    newton: &mut Newton<'_, D>,
    from: Vec<[f64; D]>,
    to: &[[f64; D]],
    controls: &[f64],
    params: &NewtonParams,
    walk: &ContinuationParams,
) -> Result<WalkedSolution<D>, WalkError<D>> {
    for positions in [from.as_slice(), to] {
        assembly.configuration(positions, controls)?;
    }
    let start = from.clone();
    let mut state = from;
    let mut way = Way {
        start: &start,
        to,
        controls,
        params,
        newton,
        assembly,
        iterations: 0,
    };
    match follow_path(&mut way, &mut state, walk) {
        Ok(walk) => Ok(WalkedSolution {
            positions: state,
            walk,
            iterations: way.iterations,
        }),
        Err(ContinuationError::Stuck {
            reached,
            step,
            source,
            ..
        }) => {
            let mut next = state.clone();
            way.place(&mut next, reached + step);
            let at = Configuration::trusted(&next, controls);
            Err(WalkError::Stuck {
                percent: 100.0 * reached,
                element: way.assembly.element_outside_domain(at),
                last: state,
                source: Box::new(source),
            })
        }
        Err(source) => Err(WalkError::Walk(Box::new(source))),
    }
}

/// The prescribed coordinates on the straight line from start to end.
struct Way<'a, 'n, const D: usize> {
    start: &'a [[f64; D]],
    to: &'a [[f64; D]],
    controls: &'a [f64],
    params: &'a NewtonParams,
    newton: &'a mut Newton<'n, D>,
    assembly: &'a mut Assembly<D>,
    iterations: usize,
}

impl<const D: usize> Way<'_, '_, D> {
    /// Prescribed coordinates at their place.
    fn place(&self, state: &mut [[f64; D]], to: f64) {
        for (node, x) in state.iter_mut().enumerate() {
            for axis in 0..D {
                if self.assembly.dofs().is_prescribed(node, axis) {
                    let (a, b) = (self.start[node][axis], self.to[node][axis]);
                    x[axis] = if to == 1.0 { b } else { a + to * (b - a) };
                }
            }
        }
    }
}

impl<const D: usize> Path for Way<'_, '_, D> {
    type State = Vec<[f64; D]>;
    type Error = RenewingError<D>;

    fn predict(&mut self, state: &mut Vec<[f64; D]>, _: f64, to: f64) {
        let mut goal = state.clone();
        self.place(&mut goal, to);
        let at = Configuration::trusted(state, self.controls);
        let params = self.params;
        let guess = predicted(self.assembly, self.newton, at, &goal, params);
        *state = guess.unwrap_or(goal);
    }

    fn correct(&mut self, _: f64, state: &mut Vec<[f64; D]>) -> Result<(), RenewingError<D>> {
        let guess = std::mem::take(state);
        let (assembly, newton) = (&mut *self.assembly, &mut *self.newton);
        let solved: RenewedSolution<D> =
            solve_renewing(assembly, newton, guess, self.controls, self.params)?;
        self.iterations += solved.iterations;
        *state = solved.positions;
        Ok(())
    }

    fn gives_up(&self, error: &RenewingError<D>) -> bool {
        matches!(error, RenewingError::Newton { source, .. } if source.reason == NewtonFailure::Cancelled)
    }
}
