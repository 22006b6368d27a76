//! Results that do not exist everywhere.

/// A derivative together with the truth of whether it exists there.
///
/// The mask is one `bool` for a scalar kernel, one per lane for a pack. Where it is false the
/// value is finite, but is only what the producing function says it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checked<X, M> {
    /// The result.
    pub value: X,
    /// Does it exist (to rounding)?
    pub exists: M,
}

impl<X> Checked<X, bool> {
    /// The result where it exists.
    pub fn ok(self) -> Option<X> {
        self.exists.then_some(self.value)
    }
}
