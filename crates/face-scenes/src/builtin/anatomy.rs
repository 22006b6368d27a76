//! The muscles of one side of the face, drawn over the material coordinates.
//!
//! Origins, insertions and neighbors after the usual anatomy (H. Gray, "Anatomy of the Human
//! Body", 20th ed., 1918, section IV, on the muscles of the head); widths and courses are drawn to
//! fit this face.

/// A muscle: one or more strips of fibers.
pub(super) struct Strips {
    pub name: &'static str,
    /// Courses of the fibers from the origin to the insertion: material `(a, b, w)`, millimeters
    /// and depth.
    pub paths: &'static [&'static [[f64; 3]]],
    /// Half of the width of a strip in millimeters.
    pub half_width: f64,
    /// Half of its thickness as a share of the thickness of the flesh.
    pub half_depth: f64,
    pub extent: Extent,
}

/// What may stop a strip before its width does.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Extent {
    /// Nothing.
    Whole,
    /// Only flesh above the line of the mouth.
    AboveMouth,
    /// Only flesh below the line of the mouth.
    BelowMouth,
    /// Only flesh above the line of the lids.
    AboveEyes,
}

const fn strip(
    name: &'static str,
    paths: &'static [&'static [[f64; 3]]],
    half_width: f64,
    half_depth: f64,
) -> Strips {
    Strips {
        name,
        paths,
        half_width,
        half_depth,
        extent: Extent::Whole,
    }
}

/// Octagonal rings around the eye.
macro_rules! ring {
    ($a:expr, $b:expr, $w:expr) => {
        &[&[
            [32.0 + $a, 34.0, $w],
            [32.0 + 0.92 * $a, 34.0 + 0.38 * $b, $w],
            [32.0 + 0.71 * $a, 34.0 + 0.71 * $b, $w],
            [32.0 + 0.38 * $a, 34.0 + 0.92 * $b, $w],
            [32.0, 34.0 + $b, $w],
            [32.0 - 0.38 * $a, 34.0 + 0.92 * $b, $w],
            [32.0 - 0.71 * $a, 34.0 + 0.71 * $b, $w],
            [32.0 - 0.92 * $a, 34.0 + 0.38 * $b, $w],
            [32.0 - $a, 34.0, $w],
            [32.0 - 0.92 * $a, 34.0 - 0.38 * $b, $w],
            [32.0 - 0.71 * $a, 34.0 - 0.71 * $b, $w],
            [32.0 - 0.38 * $a, 34.0 - 0.92 * $b, $w],
            [32.0, 34.0 - $b, $w],
            [32.0 + 0.38 * $a, 34.0 - 0.92 * $b, $w],
            [32.0 + 0.71 * $a, 34.0 - 0.71 * $b, $w],
            [32.0 + 0.92 * $a, 34.0 - 0.38 * $b, $w],
            [32.0 + $a, 34.0, $w],
        ]]
    };
}

/// A course along a lid from the inner to the outer corner of the eye, so far from the margin in the
/// middle.
macro_rules! lid {
    ($h:expr) => {
        &[
            [15.0, 34.0 + 0.2 * $h, 0.5],
            [18.5, 34.0 + 0.55 * $h, 0.5],
            [23.0, 34.0 + 0.85 * $h, 0.5],
            [31.0, 34.0 + $h, 0.5],
            [39.0, 34.0 + 0.85 * $h, 0.5],
            [44.5, 34.0 + 0.55 * $h, 0.5],
            [48.0, 34.0 + 0.2 * $h, 0.5],
        ]
    };
}

pub(super) const MUSCLES: [Strips; 23] = [
    strip(
        "frontalis_medial",
        &[&[[12., 105., 0.4], [12., 80., 0.5], [14., 57., 0.7]]],
        10.0,
        0.22,
    ),
    strip(
        "frontalis_lateral",
        &[&[[42., 105., 0.4], [45., 80., 0.5], [49., 57., 0.7]]],
        14.0,
        0.22,
    ),
    strip(
        "procerus",
        &[&[[2.5, 24., 0.25], [3., 40., 0.5], [5., 55., 0.75]]],
        3.5,
        0.22,
    ),
    strip(
        "corrugator_supercilii",
        &[&[[4., 43., 0.05], [14., 49., 0.4], [31., 57., 0.8]]],
        5.0,
        0.3,
    ),
    strip(
        "orbicularis_oculi_palpebral",
        &[
            lid!(2.0),
            lid!(5.0),
            lid!(8.5),
            lid!(-2.0),
            lid!(-4.5),
            lid!(-7.5),
        ],
        3.0,
        0.5,
    ),
    strip(
        "orbicularis_oculi_orbital",
        ring!(26.0, 17.5, 0.68),
        5.5,
        0.25,
    ),
    Strips {
        name: "levator_palpebrae",
        paths: &[&[[32., 51., 0.1], [32., 44., 0.3], [32., 36.0, 0.5]]],
        half_width: 10.0,
        half_depth: 0.22,
        extent: Extent::AboveEyes,
    },
    strip(
        "nasalis",
        &[&[[16., -11., 0.15], [12., 2., 0.5], [2., 15., 0.72]]],
        3.6,
        0.22,
    ),
    strip(
        "levator_labii_superioris_alaeque_nasi",
        &[&[
            [12., 31., 0.2],
            [14.5, 10., 0.5],
            [16., -8., 0.68],
            [13., -21., 0.75],
        ]],
        3.0,
        0.2,
    ),
    strip(
        "levator_labii_superioris",
        &[&[[29., 18., 0.08], [25., 2., 0.4], [17., -21., 0.7]]],
        6.0,
        0.18,
    ),
    strip(
        "zygomaticus_minor",
        &[&[[45., 13., 0.1], [35., -4., 0.45], [21., -23., 0.72]]],
        3.0,
        0.2,
    ),
    strip(
        "zygomaticus_major",
        &[&[[63., 11., 0.08], [47., -9., 0.5], [28., -29., 0.65]]],
        4.2,
        0.2,
    ),
    strip(
        "levator_anguli_oris",
        &[&[[24., 4., 0.05], [26.5, -12., 0.3], [28.5, -31., 0.5]]],
        4.2,
        0.18,
    ),
    strip(
        "risorius",
        &[&[[86., -62., 0.78], [60., -47., 0.76], [30., -34., 0.68]]],
        4.5,
        0.14,
    ),
    strip(
        "buccinator",
        &[&[[87., -60., 0.1], [60., -46., 0.14], [38., -37., 0.2]]],
        9.0,
        0.12,
    ),
    Strips {
        name: "orbicularis_oris_upper",
        paths: &[
            &[
                [31., -32.5, 0.5],
                [22., -27.5, 0.5],
                [10., -26., 0.5],
                [0., -26., 0.5],
            ],
            &[[9., -13., 0.05], [18., -22., 0.15], [29., -31., 0.4]],
        ],
        half_width: 6.0,
        half_depth: 0.28,
        extent: Extent::AboveMouth,
    },
    Strips {
        name: "orbicularis_oris_lower",
        paths: &[
            &[
                [31., -33.5, 0.5],
                [22., -39.5, 0.5],
                [10., -41., 0.5],
                [0., -41., 0.5],
            ],
            &[[9., -53., 0.05], [18., -44., 0.15], [29., -35., 0.4]],
        ],
        half_width: 6.0,
        half_depth: 0.28,
        extent: Extent::BelowMouth,
    },
    strip(
        "depressor_anguli_oris",
        &[&[[40., -77., 0.12], [37., -58., 0.55], [30., -35., 0.68]]],
        6.0,
        0.18,
    ),
    strip(
        "depressor_labii_inferioris",
        &[&[[27., -75., 0.08], [19., -59., 0.4], [11., -43., 0.65]]],
        6.0,
        0.18,
    ),
    strip(
        "mentalis",
        &[&[[5., -54., 0.05], [7., -63., 0.4], [8., -73., 0.82]]],
        5.0,
        0.2,
    ),
    strip(
        "platysma",
        &[&[
            [62., -150., 0.8],
            [64., -112., 0.8],
            [57., -86., 0.8],
            [40., -64., 0.78],
        ]],
        18.0,
        0.14,
    ),
    strip(
        "masseter",
        &[&[[84., 6., 0.3], [84., -22., 0.36], [77., -50., 0.06]]],
        9.5,
        0.24,
    ),
    strip(
        "temporalis",
        &[
            &[
                [78., 82., 0.15],
                [86., 45., 0.3],
                [91., 10., 0.12],
                [90., -13., 0.04],
            ],
            &[
                [92., 84., 0.15],
                [93., 45., 0.3],
                [92., 10., 0.12],
                [90., -13., 0.04],
            ],
            &[
                [106., 70., 0.15],
                [101., 40., 0.3],
                [93., 10., 0.12],
                [90., -13., 0.04],
            ],
        ],
        6.0,
        0.22,
    ),
];
