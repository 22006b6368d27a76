//! Goes into a copy of the workspace: the written tables have a row for the added model.
#![allow(missing_docs)]

use model_page::{at_a_glance, parameters, summaries};

#[test]
fn the_page_of_models_gets_a_row_for_the_added_model() {
    let models = summaries();
    let row = "| `exponential_neo_hookean` | `mu`, `lambda` [Pa]; `b` | 3 | J > 0 | – | \
               neo-Hookean elasticity that stiffens exponentially |\n";
    assert!(at_a_glance(&models).contains(row));
    let row = "| `b` | – | rate of stiffening | `exponential_neo_hookean` (1) |\n";
    assert!(parameters(&models).contains(row));
}
