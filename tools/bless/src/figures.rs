//! The figures of `docs/method.md`: a function for each, which returns the SVG's text.
