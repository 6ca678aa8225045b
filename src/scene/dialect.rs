//! The dialect of RON in which scenes are written.

use ron::extensions::Extensions;

/// The dialect of RON in which scenes are written.
pub(super) fn ron_options() -> ron::Options {
    let extensions = Extensions::IMPLICIT_SOME
        | Extensions::UNWRAP_NEWTYPES
        | Extensions::UNWRAP_VARIANT_NEWTYPES;
    ron::Options::default().with_default_extension(extensions)
}
