//! The shapes of elements: how many nodes and quadrature points, and where the points lie.

/// Elements with straight edges whose kernels are compiled here: [`Linear`] and [`Quadratic`].
///
/// A quadrature point carries its weight and the gradients of the shape functions; node 0 is left
/// out everywhere, since its gradient is minus the sum of the others. The lists are arrays of fixed
/// lengths, so that kernels unroll.
pub trait ElementShape<const D: usize>: sealed::Sealed + Copy + Send + Sync + 'static {
    /// Nodes of an element.
    const NODES: usize;
    /// Quadrature points of an element.
    const POINTS: usize;
    /// One for each node but the first.
    type Rows<T: Copy + Send + Sync>: Copy + AsRef<[T]> + AsMut<[T]> + Send + Sync;
    /// One for each node (or more).
    type Nodes<T: Copy + Send + Sync>: Copy + AsRef<[T]> + AsMut<[T]> + Send + Sync;
    /// One for each pair of nodes a ≥ b (or more).
    type Pairs<T: Copy + Send + Sync>: Copy + AsRef<[T]> + AsMut<[T]> + Send + Sync;
    /// One for each quadrature point.
    type Points<T: Copy + Send + Sync>: Copy + AsRef<[T]> + AsMut<[T]> + Send + Sync;

    /// The same for each node but the first.
    fn rows<T: Copy + Send + Sync>(value: T) -> Self::Rows<T>;
    /// The same for each node.
    fn nodes<T: Copy + Send + Sync>(value: T) -> Self::Nodes<T>;
    /// The same for each pair of nodes.
    fn pairs<T: Copy + Send + Sync>(value: T) -> Self::Pairs<T>;
    /// The same for each quadrature point.
    fn points<T: Copy + Send + Sync>(value: T) -> Self::Points<T>;
}

mod sealed {
    pub trait Sealed {}
}

/// Linear triangles and tetrahedra: D + 1 nodes, one quadrature point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Linear;

/// Quadratic triangles (6 nodes, 3 points) and tetrahedra (10 nodes, 4 points) with straight edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quadratic;

impl sealed::Sealed for Linear {}
impl sealed::Sealed for Quadratic {}

macro_rules! lists {
    ($rows:tt, $nodes:tt, $pairs:tt, $points:tt) => {
        type Rows<T: Copy + Send + Sync> = [T; $rows];
        type Nodes<T: Copy + Send + Sync> = [T; $nodes];
        type Pairs<T: Copy + Send + Sync> = [T; $pairs];
        type Points<T: Copy + Send + Sync> = [T; $points];

        #[inline(always)]
        fn rows<T: Copy + Send + Sync>(value: T) -> Self::Rows<T> {
            [value; $rows]
        }
        #[inline(always)]
        fn nodes<T: Copy + Send + Sync>(value: T) -> Self::Nodes<T> {
            [value; $nodes]
        }
        #[inline(always)]
        fn pairs<T: Copy + Send + Sync>(value: T) -> Self::Pairs<T> {
            [value; $pairs]
        }
        #[inline(always)]
        fn points<T: Copy + Send + Sync>(value: T) -> Self::Points<T> {
            [value; $points]
        }
    };
}

// Triangles use three of the four places and six of the ten pairs.
impl<const D: usize> ElementShape<D> for Linear {
    const NODES: usize = D + 1;
    const POINTS: usize = 1;
    lists!(D, 4, 10, 1);
}
impl ElementShape<2> for Quadratic {
    const NODES: usize = 6;
    const POINTS: usize = 3;
    lists!(5, 6, 21, 3);
}
impl ElementShape<3> for Quadratic {
    const NODES: usize = 10;
    const POINTS: usize = 4;
    lists!(9, 10, 55, 4);
}
