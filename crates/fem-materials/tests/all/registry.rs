//! Every model by name: elastic pairs, aliases, and what is refused.

use fem_kinematics::Mat;
use fem_materials::registry::{
    ELASTIC_PAIRS, Entry, ModelError, ModelVisitor, ParameterError, Parameters, SolidVisitor,
    UseSolid, at_rest, for_each_model, for_each_solid, solid_names, with_solid,
};
use fem_materials::{Lame, Material, Space};

const LAME: Lame = Lame {
    mu: 1.3e4,
    lambda: 7.1e4,
};

/// Each pair of constants of [`LAME`].
fn pairs() -> [[(&'static str, f64); 2]; 3] {
    let space = Space::Solid;
    [
        [
            ("young", LAME.young(space)),
            ("poisson", LAME.poisson(space)),
        ],
        [("lambda", LAME.lambda), ("mu", LAME.mu)],
        [("bulk", LAME.bulk(space)), ("shear", LAME.mu)],
    ]
}

/// How many models and pairs were compared.
#[derive(Default)]
struct Linearizations {
    models: usize,
    pairs: usize,
}

impl SolidVisitor for Linearizations {
    fn visit<M: Material<3> + 'static>(&mut self, entry: &Entry<M>) {
        let Some(elastic) = entry.elastic else {
            return;
        };
        self.models += 1;
        let replaced: Vec<&str> = elastic(LAME).iter().map(|(name, _)| *name).collect();
        for (pair, known) in pairs().iter().zip(ELASTIC_PAIRS) {
            assert_eq!([pair[0].0, pair[1].0], [known[0].name, known[1].name]);
            // Its own μ and λ, which need not be Lamé's.
            if pair.iter().all(|(name, _)| replaced.contains(name)) {
                continue;
            }
            self.pairs += 1;
            // No fibers and no damage: what is left of the model is elastic.
            let others = entry
                .parameters
                .iter()
                .filter(|p| !replaced.contains(&p.name));
            let texts = others.map(|p| {
                let without = p.unit == "Pa" || p.name == "d";
                (p.name, if without { "0" } else { p.default }.to_owned())
            });
            let constants = pair.iter().map(|(name, value)| (*name, value.to_string()));
            let parameters: Parameters = texts.chain(constants).collect();
            let model = entry.build(&parameters).expect(entry.name);
            let found = at_rest(&model);
            let error = (found.mu - LAME.mu)
                .abs()
                .max((found.lambda - LAME.lambda).abs());
            assert!(
                error < 1e-12 * LAME.p_wave(),
                "{} {pair:?}: {found:?}",
                entry.name
            );
            let stress = model.stress(&Mat::<f64, 3>::identity());
            assert!(
                stress.norm_squared().sqrt() < 1e-11 * LAME.p_wave(),
                "{}",
                entry.name
            );
        }
    }
}

#[test]
fn elastic_pairs_give_the_same_linearization_at_rest() {
    let mut seen = Linearizations::default();
    for_each_solid(&mut seen);
    assert!(
        seen.models >= 12 && seen.pairs >= 2 * seen.models,
        "{}",
        seen.pairs
    );
}

#[derive(Default)]
struct Names(Vec<(&'static str, usize)>);

impl ModelVisitor for Names {
    fn visit<M: Material<D>, const D: usize>(&mut self, entry: &Entry<M>) {
        for name in entry.aliases.iter().chain([&entry.name]) {
            self.0.push((name, D));
        }
        let mut names: Vec<&str> = entry
            .parameters
            .iter()
            .flat_map(|p| p.aliases.iter().chain([&p.name]))
            .copied()
            .collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count, "{}", entry.name);
    }
}

/// How many models were seen to be defined everywhere, and how many not.
#[derive(Default)]
struct Domains([usize; 2]);

impl ModelVisitor for Domains {
    fn visit<M: Material<D>, const D: usize>(&mut self, entry: &Entry<M>) {
        let model = entry.build(&entry.defaults()).expect(entry.name);
        let mirror = Mat::<f64, D>::from_fn(|i, j| match (i, j) {
            (0, 0) => -0.7,
            (i, j) if i == j => 1.2,
            _ => 0.0,
        });
        let flat = Mat::<f64, D>::from_fn(|i, j| f64::from(u8::from(i == j && i > 0)));
        let finite = [mirror, flat].map(|F| model.energy(&F).is_finite());
        let expected = !entry.domain.starts_with("J > 0");
        assert_eq!(
            finite, [expected; 2],
            "{} {D}D: {}",
            entry.name, entry.domain
        );
        self.0[usize::from(expected)] += 1;
    }
}

#[test]
fn a_model_is_defined_where_its_entry_says() {
    let mut seen = Domains::default();
    for_each_model(&mut seen);
    assert!(seen.0.iter().all(|count| *count > 8), "{:?}", seen.0);
}

/// A model that registers itself no more is missed by nothing that walks through the registry.
#[test]
fn every_model_of_the_documents_is_there() {
    let names = solid_names();
    for name in [
        "arap",
        "corotated",
        "fiber_isochoric",
        "fiber_total",
        "fixed_corotated",
        "gent",
        "hgo",
        "inv_mooney_rivlin",
        "inv_neo_hookean",
        "inv_stvk",
        "linear",
        "mooney_rivlin",
        "mooney_rivlin_isochoric",
        "muscle_isochoric",
        "muscle_total",
        "neo_hookean",
        "ogden",
        "qr_aniso",
        "qr_damage",
        "stable_neo_hookean",
        "stable_neo_hookean_nolog",
        "stvk",
        "volumetric_log",
        "yeoh",
    ] {
        assert!(names.contains(&name), "{name}: {names:?}");
    }
}

/// Lengths, not their squares, are held to a thousandth; λ* may be 1, where a curve is straight at once.
#[test]
fn directions_and_stretches_at_the_edge_of_what_is_allowed() {
    let built = |name: &str, value: &str| {
        let all = [
            ("curve", "physbam"),
            ("P1", "0.05"),
            ("P2", "6.6"),
            ("lambda_star", "1.4"),
            ("max_isometric_stress", "3e5"),
            ("optimal_stretch", "1"),
            ("alpha", "0.3"),
            ("a0", "0.6 0 0.8"),
        ];
        let given = |(n, v)| (n, if n == name { value } else { v });
        let parameters = all.into_iter().map(given).collect();
        with_solid("fiber_total", &parameters, Energy).map(|_| ())
    };
    assert_eq!(built("a0", "1.0009 0 0"), Ok(()));
    assert_eq!(built("a0", "0 0.9991 0"), Ok(()));
    assert!(built("a0", "1.0011 0 0").is_err());
    assert!(built("a0", "0 0.9989 0").is_err());
    assert_eq!(built("lambda_star", "1"), Ok(()));
    assert!(built("lambda_star", "0.999").is_err());
}

#[test]
fn no_two_models_and_no_two_parameters_of_a_model_share_a_name() {
    let mut names = Names::default();
    for_each_model(&mut names);
    let count = names.0.len();
    names.0.sort_unstable();
    names.0.dedup();
    assert_eq!(names.0.len(), count);
}

/// The energy at one F.
struct Energy;

impl UseSolid for Energy {
    type Output = f64;
    fn call<M: Material<3> + 'static>(self, model: M) -> f64 {
        model.energy(&Mat([[1.1, 0.2, 0.0], [0.0, 0.9, 0.1], [0.0, 0.0, 1.2]]))
    }
}

#[test]
fn aliases_mean_the_same() {
    let own: Parameters = [("mu", "1e4"), ("lambda", "5e4")].into_iter().collect();
    let energy = |name| with_solid(name, &own, Energy).expect(name);
    assert_eq!(energy("snh"), energy("stable_neo_hookean"));
    let flesh = |names: [&'static str; 3]| {
        let parameters = names.into_iter().zip(["6e4", "2e4", "5e4"]).collect();
        with_solid("mooney_rivlin", &parameters, Energy).expect("flesh")
    };
    assert_eq!(flesh(["A", "B", "K"]), flesh(["a", "b", "bulk"]));
}

fn refused(name: &str, parameters: &[(&str, &str)]) -> (ModelError, String) {
    let parameters = parameters.iter().copied().collect();
    let error = with_solid(name, &parameters, Energy).expect_err(name);
    let text = error.to_string();
    (error, text)
}

#[test]
fn errors_name_the_model_its_parameters_and_their_units() {
    let (error, text) = refused("yeo", &[]);
    assert!(matches!(error, ModelError::Unknown { known, .. } if known == solid_names()));
    assert!(text.contains("`yeo`") && text.contains("yeoh"), "{text}");

    let (error, text) = refused("neo_hookean", &[("young", "3e4"), ("nu", "0.4")]);
    let ModelError::Parameters { known, .. } = error else {
        panic!("{text}")
    };
    assert_eq!((known.own.len(), known.pairs.len()), (2, 2));
    assert!(text.ends_with(&known.to_string()), "{text}");
    assert!(text.contains("has no parameter"), "{text}");
    assert!(text.contains("young in Pa and poisson"), "{text}");
    assert!(!text.contains("lambda in Pa and mu in Pa"), "{text}");

    let (_, text) = refused("gent", &[("mu", "-1"), ("Jm", "30"), ("K", "1e6")]);
    assert!(
        text.contains("`mu` is -1; it must be 0 or greater"),
        "{text}"
    );
    assert!(text.contains("mu in Pa, Jm, K in Pa"), "{text}");

    let (_, text) = refused(
        "yeoh",
        &[("c1", "30 kPa"), ("c2", "0"), ("c3", "0"), ("K", "1")],
    );
    assert!(
        text.contains("`30 kPa`, which is no finite number"),
        "{text}"
    );
    assert!(text.contains("c1 in Pa"), "{text}");
}

#[test]
fn pairs_that_no_material_has_and_parameters_given_twice_are_refused() {
    for (young, poisson) in [("3e4", "0.5"), ("-3e4", "0.4"), ("3e4", "-1")] {
        let (error, text) = refused("neo_hookean", &[("young", young), ("poisson", poisson)]);
        let elastic = matches!(
            error,
            ModelError::Parameters {
                source: ParameterError::Elastic(_),
                ..
            }
        );
        assert!(
            elastic && text.contains("young") && text.contains("poisson"),
            "{text}"
        );
    }
    let twice = [("young", "3e4"), ("poisson", "0.4"), ("mu", "1e4")];
    assert!(
        refused("neo_hookean", &twice)
            .1
            .contains("`mu` is given twice")
    );
    let twice = [("A", "1"), ("a", "1"), ("B", "1"), ("K", "1")];
    assert!(
        refused("mooney_rivlin", &twice)
            .1
            .contains("`A` is given twice")
    );
}
