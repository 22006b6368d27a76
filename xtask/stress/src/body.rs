//! Bodies that are solved: blocks of tetrahedra, their materials, what holds them.

use crate::named::Named;
use crate::row::{Evidence, Settings};
use crate::{Failure, balance};
use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{
    Assembly, AssemblyBuilder, AssemblyError, Dofs, Quasistatic, RenewingError, VolumePatches,
    solve_renewing, solve_walking,
};
use fem_solvers::{ContinuationParams, Newton, NewtonInfo, NewtonParams};

/// Adds terms that are no elements: contacts, loads.
type Terms =
    Box<dyn Fn(AssemblyBuilder<3>) -> Result<AssemblyBuilder<3>, AssemblyError> + Send + Sync>;

/// Some elements and what they are made of.
pub struct ElementGroup {
    /// The elements.
    pub elements: Vec<usize>,
    /// Their material.
    pub material: Named,
}

/// A body with everything that an independent sum of its forces needs.
pub struct Body {
    mesh: SimplexMesh<3>,
    prescribed: Vec<usize>,
    groups: Vec<ElementGroup>,
    patches: Option<(VolumePatches, Vec<f64>)>,
    terms: Option<Terms>,
}

/// An equilibrium that was found, and judged.
pub struct JudgedEquilibrium {
    /// Positions of all nodes, m.
    pub positions: Vec<[f64; 3]>,
    /// What the solver says.
    pub info: NewtonInfo,
    /// What is left of its forces.
    pub evidence: Evidence,
}

impl Body {
    /// A mesh of one material; nothing holds it yet.
    pub fn new(mesh: SimplexMesh<3>, material: Named) -> Self {
        let elements = (0..mesh.num_elements()).collect();
        Self {
            mesh,
            prescribed: Vec::new(),
            groups: vec![ElementGroup { elements, material }],
            patches: None,
            terms: None,
        }
    }

    /// A block of cubes, each cut into six.
    pub fn block(cells: [usize; 3], size: [f64; 3], material: Named) -> Result<Self, Failure> {
        let mesh = kuhn_grid(cells[0], cells[1], cells[2], size)?;
        Ok(Self::new(mesh, material))
    }

    /// Holds the nodes whose place at rest is wanted.
    #[must_use]
    pub fn holding(mut self, wanted: impl Fn([f64; 3]) -> bool) -> Self {
        let nodes = self.mesh.nodes();
        self.prescribed = (0..nodes.len()).filter(|&n| wanted(nodes[n])).collect();
        self
    }

    /// Other materials: the group of each element by its number, a material for each group.
    #[must_use]
    pub fn of_groups(mut self, group: impl Fn(usize) -> usize, materials: Vec<Named>) -> Self {
        let groups = materials.into_iter().enumerate();
        let inside = |p: usize| -> Vec<usize> {
            let all = 0..self.mesh.num_elements();
            all.filter(|&e| group(e) == p).collect()
        };
        self.groups = groups
            .map(|(p, material)| ElementGroup {
                elements: inside(p),
                material,
            })
            .collect();
        self
    }

    /// Patches that resist changes of their volume with this modulus, Pa.
    #[must_use]
    pub fn with_patches(mut self, bulk: f64) -> Self {
        let patches = VolumePatches::around_edges(&self.mesh);
        self.patches = Some((patches, vec![bulk; self.mesh.num_elements()]));
        self
    }

    /// Terms that are no elements. Their forces are their own gradients, summed stencil by stencil.
    #[must_use]
    pub fn with_terms(
        mut self,
        terms: impl Fn(AssemblyBuilder<3>) -> Result<AssemblyBuilder<3>, AssemblyError>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        self.terms = Some(Box::new(terms));
        self
    }

    /// The mesh.
    pub fn mesh(&self) -> &SimplexMesh<3> {
        &self.mesh
    }
    /// What it is made of.
    pub fn groups(&self) -> &[ElementGroup] {
        &self.groups
    }
    /// Its patches and the bulk modulus of each element.
    pub fn patches(&self) -> Option<(&VolumePatches, &[f64])> {
        self.patches.as_ref().map(|(p, bulk)| (p, bulk.as_slice()))
    }

    /// Everything in it.
    pub fn assembly(&self) -> Result<Assembly<3>, Failure> {
        let dofs = Dofs::with_prescribed_nodes(self.mesh.nodes(), &self.prescribed)?;
        let mut builder = AssemblyBuilder::new(&self.mesh, dofs)?;
        for ElementGroup { elements, material } in &self.groups {
            let Named { model, parameters } = material;
            builder = fem_catalog::region(builder, elements, model, parameters)??;
        }
        if let Some((patches, bulk)) = &self.patches {
            builder = builder.mean_volume(patches, bulk)?;
        }
        if let Some(terms) = &self.terms {
            builder = terms(builder)?;
        }
        Ok(builder.build()?)
    }

    /// ∂E/∂x at every node of what is no element, N; nothing where there is none.
    pub fn forces_of_terms(&self, x: &[[f64; 3]]) -> Result<Option<Vec<[f64; 3]>>, Failure> {
        let Some(terms) = &self.terms else {
            return Ok(None);
        };
        let dofs = Dofs::with_prescribed_nodes(self.mesh.nodes(), &self.prescribed)?;
        let mut alone = terms(AssemblyBuilder::new(&self.mesh, dofs)?)?.build()?;
        let at = alone.configuration(x, &[])?;
        alone.renew(at)?;
        let forces = alone.forces_everywhere(alone.configuration(x, &[])?);
        Ok(Some(forces.into_iter().map(|f| f.map(|c| -c)).collect()))
    }

    /// Places of all nodes: those that are prescribed where `prescribed` moves them, the others where
    /// `free` does.
    pub fn placed(
        &self,
        prescribed: impl Fn([f64; 3]) -> [f64; 3],
        mut free: impl FnMut([f64; 3]) -> [f64; 3],
    ) -> Vec<[f64; 3]> {
        let mut x: Vec<[f64; 3]> = self.mesh.nodes().iter().map(|&p| free(p)).collect();
        for &n in &self.prescribed {
            x[n] = prescribed(self.mesh.nodes()[n]);
        }
        x
    }

    /// Solves with at most so many steps, and trusts nothing.
    pub fn solve(
        &self,
        start: Vec<[f64; 3]>,
        settings: &Settings,
        steps: usize,
    ) -> Result<JudgedEquilibrium, Failure> {
        self.solve_with(start, &settings.newton(steps))
    }

    /// The same with settings of one's own.
    pub fn solve_with(
        &self,
        start: Vec<[f64; 3]>,
        params: &NewtonParams,
    ) -> Result<JudgedEquilibrium, Failure> {
        let mut assembly = self.assembly()?;
        let mut newton = Newton::new(&Quasistatic::new(&assembly, start.clone(), vec![])?);
        let solved = solve_renewing(&mut assembly, &mut newton, start, &[], params);
        if let Err(RenewingError::Newton { last, .. }) = &solved {
            finite(last)?;
        }
        let solved = solved?;
        let info = solved
            .info
            .ok_or_else(|| Failure::lie("a solution without a solve"))?;
        let evidence = self.judge(&assembly, &solved.positions, params, &info)?;
        Ok(JudgedEquilibrium {
            positions: solved.positions,
            evidence: Evidence {
                steps: solved.iterations,
                ..evidence
            },
            info,
        })
    }

    /// From rest to where `to` puts what is prescribed at each share of the way: each part from the
    /// last, halved where that fails.
    pub fn walk(
        &self,
        to: impl Fn(f64) -> Vec<[f64; 3]>,
        parts: usize,
        params: &NewtonParams,
    ) -> Result<JudgedEquilibrium, Failure> {
        let walk = ContinuationParams {
            smallest_step: 1.0 / 64.0,
            ..ContinuationParams::default()
        };
        let mut assembly = self.assembly()?;
        let mut x = self.mesh.nodes().to_vec();
        let mut newton = Newton::new(&Quasistatic::new(&assembly, x.clone(), vec![])?);
        let mut steps = 0;
        for part in 1..=parts {
            let to = to(part as f64 / parts as f64);
            let there = solve_walking(&mut assembly, &mut newton, x, &to, &[], params, &walk)?;
            (x, steps) = (there.positions, steps + there.iterations);
        }
        // A solve that starts at its own solution says what it promises.
        let last = self.solve_with(x, params)?;
        let note = format!("{} steps more from its own solution", last.info.iterations);
        let evidence = Evidence {
            note,
            steps,
            ..last.evidence
        };
        Ok(JudgedEquilibrium { evidence, ..last })
    }

    /// Trusts nothing of a solution.
    pub fn judge(
        &self,
        assembly: &Assembly<3>,
        positions: &[[f64; 3]],
        params: &NewtonParams,
        info: &NewtonInfo,
    ) -> Result<Evidence, Failure> {
        finite(positions)?;
        let at = assembly.configuration(positions, &[])?;
        if !assembly.energy(at).is_finite() {
            return Err(Failure::lie("a solution whose energy is not finite"));
        }
        let forces = balance::forces(self, positions)?;
        let problem = Quasistatic::new(assembly, positions.to_vec(), vec![])?;
        let x = problem.unknowns();
        Ok(Evidence {
            steps: info.iterations,
            ..balance::kept(&problem, &x, &forces, params, info.stop)?
        })
    }
}

fn finite(positions: &[[f64; 3]]) -> Result<(), Failure> {
    match positions.as_flattened().iter().all(|c| c.is_finite()) {
        true => Ok(()),
        false => Err(Failure::lie("the state left behind is not finite")),
    }
}

/// The largest distance between nodes of the same number, m; NaN where one is.
pub fn apart(x: &[[f64; 3]], y: &[[f64; 3]]) -> f64 {
    let distance =
        |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    x.iter()
        .zip(y)
        .map(distance)
        .fold(0.0, workbench::numbers::worse)
}
