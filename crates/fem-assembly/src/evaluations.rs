//! How often the terms of a body were evaluated: what a report shows and tests pin.

use fem_materials::HessianProjection;
use std::ops::Sub;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// What the stencils of a term are, for the counts of [`Evaluations`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum StencilKind {
    /// Elements with an elastic energy.
    Element,
    /// Muscle fibers in elements.
    Fiber,
    /// Pairs that touch, and points that touch a solid.
    Contact,
    /// Loads, springs, volumes and terms of one's own.
    #[default]
    Other,
}

/// What one evaluation of a term's stencil takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StencilCost {
    /// What the stencils are.
    pub kind: StencilKind,
    /// Singular value decompositions of every evaluation.
    pub decompositions: u64,
    /// Those of a projected Hessian.
    pub projection_decompositions: u64,
}

/// Evaluations of stencils by what was asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Passes {
    /// Energies alone.
    pub energies: u64,
    /// Energies with their gradients.
    pub gradients: u64,
    /// Hessians.
    pub hessians: u64,
    /// Hessians times a displacement, without a matrix.
    pub products: u64,
    /// Forces by a control, of the stencils alone that listen to it.
    pub by_control: u64,
}

/// What an assembly has evaluated, stencil by stencil.
///
/// A stencil counts once for each time that its contribution was summed: the numbers do not depend
/// on threads, although stencils on the border between two owners of rows are evaluated by both. What
/// only prescribed nodes feel counts where it is asked for, in [`Assembly::energy`] and where forces
/// at every node are wanted. Muscle fibers are evaluated whether their muscle is active or not, for
/// their passive tension; a muscle whose curve has none costs nothing while it is relaxed. Subtract an
/// earlier count to see what was done since.
///
/// [`Assembly::energy`]: crate::Assembly::energy
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Evaluations {
    /// Of elements.
    pub elements: Passes,
    /// Of muscle fibers.
    pub fibers: Passes,
    /// Of pairs in contact.
    pub contacts: Passes,
    /// Of everything else.
    pub others: Passes,
    /// Singular value decompositions of deformation gradients.
    pub decompositions: u64,
    /// Stencils whose Hessian was projected.
    pub projections: u64,
    /// Looks for what is near ([`Assembly::renew`](crate::Assembly::renew)), one for each call of a
    /// body with contact; the candidates that a look weighs are not counted.
    pub searches: u64,
}

impl Sub for Passes {
    type Output = Self;
    fn sub(self, earlier: Self) -> Self {
        Self {
            energies: self.energies.saturating_sub(earlier.energies),
            gradients: self.gradients.saturating_sub(earlier.gradients),
            hessians: self.hessians.saturating_sub(earlier.hessians),
            products: self.products.saturating_sub(earlier.products),
            by_control: self.by_control.saturating_sub(earlier.by_control),
        }
    }
}

impl Sub for Evaluations {
    type Output = Self;
    fn sub(self, earlier: Self) -> Self {
        Self {
            elements: self.elements - earlier.elements,
            fibers: self.fibers - earlier.fibers,
            contacts: self.contacts - earlier.contacts,
            others: self.others - earlier.others,
            decompositions: self.decompositions.saturating_sub(earlier.decompositions),
            projections: self.projections.saturating_sub(earlier.projections),
            searches: self.searches.saturating_sub(earlier.searches),
        }
    }
}

/// What a pass over the stencils asks for.
#[derive(Clone, Copy)]
pub(crate) enum Pass {
    Energy,
    Gradient,
    Hessian(HessianProjection),
    Product,
    ByControl,
}

/// The counts of one assembly; passes of several threads may add to them.
#[derive(Debug, Default)]
pub(crate) struct Counter {
    /// By kind, then by pass.
    stencils: [[AtomicU64; 5]; 4],
    decompositions: AtomicU64,
    projections: AtomicU64,
    searches: AtomicU64,
}

impl Counter {
    pub fn add(&self, pass: Pass, cost: StencilCost, stencils: u64) {
        let (column, projections) = match pass {
            Pass::Energy => (0, false),
            Pass::Gradient => (1, false),
            Pass::Hessian(projection) => (2, projection != HessianProjection::None),
            Pass::Product => (3, false),
            Pass::ByControl => (4, false),
        };
        self.stencils[cost.kind as usize][column].fetch_add(stencils, Relaxed);
        let each = match projections {
            true => cost.projection_decompositions,
            false => cost.decompositions,
        };
        self.decompositions.fetch_add(each * stencils, Relaxed);
        if projections {
            self.projections.fetch_add(stencils, Relaxed);
        }
    }

    pub fn searched(&self) {
        self.searches.fetch_add(1, Relaxed);
    }

    pub fn read(&self) -> Evaluations {
        let of = |kind: StencilKind| {
            let [energies, gradients, hessians, products, by_control] = self.stencils
                [kind as usize]
                .each_ref()
                .map(|n| n.load(Relaxed));
            Passes {
                energies,
                gradients,
                hessians,
                products,
                by_control,
            }
        };
        Evaluations {
            elements: of(StencilKind::Element),
            fibers: of(StencilKind::Fiber),
            contacts: of(StencilKind::Contact),
            others: of(StencilKind::Other),
            decompositions: self.decompositions.load(Relaxed),
            projections: self.projections.load(Relaxed),
            searches: self.searches.load(Relaxed),
        }
    }
}
