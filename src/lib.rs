//! clastic: granular contact dynamics with elastic bonds.
pub mod scene;
