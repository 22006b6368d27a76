//! Collects mesh, constraints, materials, fibers and obstacles into an [`Assembly`].

use crate::assembly::Assembly;
use crate::block::RestElement;
use crate::dofs::{Dofs, FIXED};
use crate::error::AssemblyError;
use crate::law::Uniform;
use crate::mesh::SimplexMesh;
use crate::part::{Elements, Part};
use crate::penalty::Penalty;
use fem_materials::Material;
use fem_solvers::BlockPattern;
use std::ops::Range;
use std::sync::Arc;

/// Consecutive matrix rows and the elements that touch them.
pub(crate) struct Chunk<const D: usize> {
    pub rows: Range<usize>,
    pub parts: Vec<Box<dyn Part<D>>>,
}

/// Rows below which a chunk is not worth its border.
const SMALLEST_CHUNK: usize = 512;
/// Chunks per thread, so that an uneven load evens out.
const CHUNKS_PER_THREAD: usize = 2;

/// Packs the chosen entries of one law for a chunk (`None`: the all-prescribed elements).
type Pack<const D: usize> = dyn Fn(&[Entry], &Packing<D>) -> Box<dyn Part<D>>;

/// One entry of a layer (its index there) and the element that it belongs to.
#[derive(Clone, Copy)]
pub(crate) struct Entry {
    pub index: u32,
    pub element: u32,
}

/// What a law needs to know to pack its elements.
pub(crate) struct Packing<'a, const D: usize> {
    pub elements: &'a [RestElement<D>],
    /// The chunk's rows; `None` for elements that touch no free node.
    pub rows: Option<Range<usize>>,
    pub pattern: &'a BlockPattern,
}

struct Layer<const D: usize> {
    /// The element of each entry: of each element of a region, of each fiber of a field.
    element_of_entry: Vec<u32>,
    pack: Box<Pack<D>>,
}

/// Builds an [`Assembly`].
///
/// ```
/// use fem_assembly::{AssemblyBuilder, Dofs};
/// use fem_materials::NeoHookean;
///
/// let mesh = fem_assembly::mesh::kuhn_grid(2, 2, 2, [1.0; 3])?;
/// let clamped: Vec<usize> = (0..9).collect();
/// let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &clamped)?;
/// let flesh = NeoHookean { mu: 1e4, lambda: 1e5 };
/// let assembly = AssemblyBuilder::new(&mesh, dofs)?.material(flesh)?.build()?;
/// assert!(assembly.energy(mesh.nodes(), &[]).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct AssemblyBuilder<const D: usize> {
    dofs: Dofs<D>,
    rest: Vec<[f64; D]>,
    elements: Vec<RestElement<D>>,
    layers: Vec<Layer<D>>,
    penalties: Vec<Penalty<D>>,
    channels: usize,
}

impl<const D: usize> AssemblyBuilder<D> {
    /// Takes the rest shape and the split into prescribed and free coordinates.
    ///
    /// # Errors
    /// When the constraints are those of another mesh, or an element is too thin to invert D_m.
    pub fn new(mesh: &SimplexMesh<D>, dofs: Dofs<D>) -> Result<Self, AssemblyError> {
        let rest = mesh.nodes();
        if dofs.nodes() != rest.len() {
            let (what, found) = ("nodes of the constraints", dofs.nodes());
            return Err(AssemblyError::WrongLength {
                what,
                found,
                expected: rest.len(),
            });
        }
        let elements = mesh
            .elements()
            .enumerate()
            .map(|(e, nodes)| RestElement::new(e, nodes, rest, dofs.rank()))
            .collect::<Result<_, _>>()?;
        let (layers, penalties) = (Vec::new(), Vec::new());
        Ok(Self {
            dofs,
            rest: rest.to_vec(),
            elements,
            layers,
            penalties,
            channels: 0,
        })
    }

    /// One material for the whole mesh. Materials given to the same element add up.
    ///
    /// # Errors
    /// None today; the signature matches [`AssemblyBuilder::region`].
    pub fn material<M: Material<D> + 'static>(self, material: M) -> Result<Self, AssemblyError> {
        let all: Vec<usize> = (0..self.elements.len()).collect();
        self.region(&all, material)
    }

    /// One material for some elements. Materials given to the same element add up.
    ///
    /// # Errors
    /// When an element does not exist.
    pub fn region<M: Material<D> + 'static>(
        mut self,
        elements: &[usize],
        material: M,
    ) -> Result<Self, AssemblyError> {
        let element_of_entry = self.existing(elements)?;
        let pack = Box::new(
            move |entries: &[Entry], packing: &Packing<D>| -> Box<dyn Part<D>> {
                Box::new(Elements::pack(Uniform(material), entries, packing))
            },
        );
        self.layers.push(Layer {
            element_of_entry,
            pack,
        });
        Ok(self)
    }

    /// Adds a penalty against an obstacle (document 000, 5.7).
    ///
    /// # Errors
    /// When one of its nodes does not exist, a number is not finite, the stiffness or the radius is
    /// not positive, or the normal is not of length 1 (to 1e-3).
    pub fn penalty(mut self, penalty: Penalty<D>) -> Result<Self, AssemblyError> {
        let count = self.rest.len();
        if let Some(&node) = penalty.nodes.iter().find(|&&n| n >= count) {
            return Err(AssemblyError::NoSuchNode { node, count });
        }
        penalty.check(self.penalties.len())?;
        self.penalties.push(penalty);
        Ok(self)
    }

    pub(crate) fn existing(&self, elements: &[usize]) -> Result<Vec<u32>, AssemblyError> {
        let count = self.elements.len();
        let check = |&element: &usize| {
            if element < count {
                Ok(element as u32)
            } else {
                Err(AssemblyError::NoSuchElement { element, count })
            }
        };
        elements.iter().map(check).collect()
    }

    pub(crate) fn add_layer(
        &mut self,
        element_of_entry: Vec<u32>,
        channels: usize,
        pack: Box<Pack<D>>,
    ) {
        self.channels = self.channels.max(channels);
        self.layers.push(Layer {
            element_of_entry,
            pack,
        });
    }

    /// Numbers, sorts and packs everything.
    ///
    /// # Errors
    /// When the Hessian's blocks cannot be counted with 32 bits.
    pub fn build(self) -> Result<Assembly<D>, AssemblyError> {
        let Self {
            dofs,
            rest,
            elements,
            layers,
            penalties,
            channels,
        } = self;
        let pattern = pattern(&dofs, &elements)?;
        let chunks = cut(&dofs, &elements)
            .into_iter()
            .map(|rows| {
                let parts = layers
                    .iter()
                    .filter_map(|layer| layer.pack(&elements, Some(rows.clone()), &pattern))
                    .collect();
                Chunk { rows, parts }
            })
            .collect();
        let prescribed = layers
            .iter()
            .filter_map(|layer| layer.pack(&elements, None, &pattern))
            .collect();
        let pattern = Arc::new(pattern);
        Ok(Assembly {
            dofs,
            rest,
            elements,
            pattern,
            chunks,
            prescribed,
            penalties,
            channels,
            force_scale: std::sync::OnceLock::new(),
        })
    }
}

impl<const D: usize> Layer<D> {
    /// The entries whose element touches `rows`, by first row and then by index, packed.
    fn pack(
        &self,
        elements: &[RestElement<D>],
        rows: Option<Range<usize>>,
        pattern: &BlockPattern,
    ) -> Option<Box<dyn Part<D>>> {
        let first_row = |entry: &Entry| elements[entry.element as usize].rows[0];
        let touches = |entry: &Entry| {
            let element = &elements[entry.element as usize];
            match &rows {
                Some(range) => element.rows.iter().any(|&r| range.contains(&(r as usize))),
                None => element.is_prescribed(),
            }
        };
        let all = self.element_of_entry.iter().enumerate();
        let mut entries: Vec<Entry> = all
            .map(|(k, &element)| Entry {
                index: k as u32,
                element,
            })
            .filter(touches)
            .collect();
        if entries.is_empty() {
            return None;
        }
        entries.sort_by_key(first_row);
        let packing = Packing {
            elements,
            rows,
            pattern,
        };
        Some((self.pack)(&entries, &packing))
    }
}

fn pattern<const D: usize>(
    dofs: &Dofs<D>,
    elements: &[RestElement<D>],
) -> Result<BlockPattern, AssemblyError> {
    let pairs = elements
        .iter()
        .flat_map(|e| (1..=D).flat_map(move |a| (0..a).map(move |b| (e.rows[a], e.rows[b]))));
    let free = pairs.filter(|&(a, b)| a != FIXED && b != FIXED);
    BlockPattern::from_adjacency(
        dofs.free_nodes(),
        free.map(|(a, b)| (a as usize, b as usize)),
    )
    .map_err(|_| AssemblyError::TooManyNodes {
        count: dofs.free_nodes(),
    })
}

/// Cuts the rows into runs of about equal work.
fn cut<const D: usize>(dofs: &Dofs<D>, elements: &[RestElement<D>]) -> Vec<Range<usize>> {
    let rows = dofs.free_nodes();
    let wanted = CHUNKS_PER_THREAD * rayon::current_num_threads();
    let count = (rows / SMALLEST_CHUNK).clamp(1, wanted.max(1));
    let mut first_row = vec![0_usize; rows + 1];
    for element in elements.iter().filter(|e| !e.is_prescribed()) {
        first_row[element.rows[0] as usize + 1] += 1;
    }
    let mut total = 0;
    let mut ranges = Vec::with_capacity(count);
    let (mut begin, share) = (0, elements.len().div_ceil(count).max(1));
    for row in 0..rows {
        total += first_row[row + 1];
        if total >= share * (ranges.len() + 1) && row + 1 < rows && ranges.len() + 1 < count {
            ranges.push(begin..row + 1);
            begin = row + 1;
        }
    }
    ranges.push(begin..rows);
    ranges
}
