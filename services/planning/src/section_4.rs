//! Section 4 of the paper: a male part in the cavity of a female part. For tests and benches.
//!
//! In (x, z), metres. Boxes are given by their least and greatest corners.

/// The vertices f1 to f12 of the female part.
pub(crate) const FEMALE: [[f64; 2]; 12] = [
    [0., 0.],
    [0., 7.],
    [1., 7.],
    [1., 2.],
    [4., 2.],
    [4., 1.],
    [7., 1.],
    [7., 6.],
    [5., 6.],
    [5., 7.],
    [8., 7.],
    [8., 0.],
];

/// The male part in its assembled state.
pub(crate) const MALE: [[f64; 2]; 2] = [[4.5, 1.01], [6.99, 4.]];

/// The channels in travel order: C_3, C_2, C_1.
pub(crate) const CHANNELS: [[[f64; 2]; 2]; 3] =
    [[[4., 1.], [7., 6.]], [[1., 2.], [7., 6.]], [[1., 2.], [5., 7.]]];
