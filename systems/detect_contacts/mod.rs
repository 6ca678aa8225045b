//! Contact detection.
