//! The marker file of a store, the layout that it names, and what can be wrong with it.

/// The file that marks a store.
pub(super) const FILE: &str = ".specforge-store";
/// The layout of the stores that this version reads and writes.
pub(super) const LAYOUT: u32 = 1;

/// Why a marker does not show that this version can use the store.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Flaw {
    /// The store was made by another version.
    #[error("its layout is {0}, and this version of specforge knows only layout {LAYOUT}")]
    Layout(u32),
    /// No version writes such a marker.
    #[error("its mark `{FILE}` is damaged: {0}")]
    Damaged(String),
}
