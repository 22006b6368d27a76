//! Nodal forces and element stiffness by the formulas that the documents print, on single elements.

use super::random::{self, Triangles};
use fem_assembly::mesh::SimplexMesh;
use fem_assembly::{Assembly, AssemblyBuilder, Dofs};
use fem_kinematics::{
    BLOCK_ORDER_3D, Dual, Mat, ROW_MAJOR_3D, RestShape, Tensor4, cauchy_from_piola,
    deformation_gradient, piola_from_second_piola, second_piola_from_piola, shape_matrix,
    signed_svd, to_flat,
};
use fem_materials::isotropic::{ByStretches, DiagonalBlocks, StretchEnergy};
use fem_materials::{CorotatedLinear, HessianProjection, Material, NeoHookean};
use fem_solvers::{BlockSymmetric, LinearOperator};

const FLESH: NeoHookean = NeoHookean {
    mu: 3.0,
    lambda: 7.0,
};
const COROTATED: CorotatedLinear = CorotatedLinear {
    mu: 3.0,
    lambda: 7.0,
};

/// Edges of a triangle, faces of a tetrahedron: size times outward normal of the facet opposite to
/// each vertex, from the positions alone.
trait Facets<const D: usize> {
    fn facets(x: &[[f64; D]]) -> Vec<[f64; D]>;
}

struct Geometry;

impl Facets<2> for Geometry {
    fn facets(x: &[[f64; 2]]) -> Vec<[f64; 2]> {
        (0..3)
            .map(|a| {
                let (p, q) = (x[(a + 1) % 3], x[(a + 2) % 3]);
                // The edge p → q of a counter-clockwise triangle, turned clockwise.
                [q[1] - p[1], p[0] - q[0]]
            })
            .collect()
    }
}

impl Facets<3> for Geometry {
    fn facets(x: &[[f64; 3]]) -> Vec<[f64; 3]> {
        (0..4)
            .map(|a| {
                let [p, q, r]: [[f64; 3]; 3] = core::array::from_fn(|k| x[(a + k + 1) % 4]);
                let (u, v): ([f64; 3], [f64; 3]) = (
                    core::array::from_fn(|k| q[k] - p[k]),
                    core::array::from_fn(|k| r[k] - p[k]),
                );
                // Half u × v; pointing away from vertex a.
                let n: [f64; 3] = core::array::from_fn(|k| {
                    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                    0.5 * (u[i] * v[j] - u[j] * v[i])
                });
                let inward: f64 = (0..3).map(|k| n[k] * (x[a][k] - p[k])).sum();
                n.map(|c| if inward > 0.0 { -c } else { c })
            })
            .collect()
    }
}

/// A random element at rest and deformed, as its own mesh.
struct Element<const D: usize> {
    rest: Vec<[f64; D]>,
    x: Vec<[f64; D]>,
    shape: RestShape<f64, D>,
    F: Mat<f64, D>,
}

fn elements<const D: usize>() -> Vec<Element<D>> {
    let mut random = random::Random(3);
    let mut found = Vec::new();
    while found.len() < 40 {
        let rest: Vec<[f64; D]> = (0..=D).map(|_| random.point()).collect();
        let Ok(shape) = RestShape::from_vertices(&rest) else {
            continue;
        };
        let x: Vec<[f64; D]> = (0..=D).map(|_| random.point()).collect();
        let F = deformation_gradient(&shape_matrix(&x), &shape.inverse);
        let upright = shape_matrix(&rest).determinant() > 0.05 && F.determinant() > 0.05;
        if upright && F.norm_squared() < 50.0 {
            found.push(Element { rest, x, shape, F });
        }
    }
    found
}

fn assembly<const D: usize>(
    rest: &[[f64; D]],
    material: impl Material<D> + 'static,
) -> Assembly<D> {
    let mesh = SimplexMesh::new(rest.to_vec(), (0..=D as u32).collect()).unwrap();
    AssemblyBuilder::new(&mesh, Dofs::all_free(mesh.nodes()).unwrap())
        .unwrap()
        .material(material)
        .unwrap()
        .build()
        .unwrap()
}

fn near<const D: usize>(a: [f64; D], b: [f64; D], scale: f64, what: &str) {
    for k in 0..D {
        let apart = (a[k] - b[k]).abs();
        assert!(apart <= 1e-13 * scale, "{what}: {a:?} {b:?}, scale {scale}");
    }
}

/// −1/D · M Σ s n over the facets that meet in vertex `a`.
fn pulled<const D: usize>(M: &Mat<f64, D>, facets: &[[f64; D]], a: usize) -> [f64; D] {
    let sum: [f64; D] = core::array::from_fn(|k| {
        let around = facets.iter().enumerate().filter(|(b, _)| *b != a);
        around.map(|(_, n)| n[k]).sum()
    });
    M.mul_vec(sum).map(|c| -c / D as f64)
}

/// Document 000, 4.4, equations 16-21, and document 004's g_i = P b_i for every vertex.
fn check_forces<const D: usize>()
where
    Geometry: Facets<D>,
{
    for element in elements::<D>() {
        let Element { rest, x, shape, F } = element;
        let (J, log_J) = (F.determinant(), F.determinant().ln());
        // σ = (μ (b − I) + λ ln J I)/J and S = μ (I − C⁻¹) + λ ln J C⁻¹, straight from textbooks.
        let I = Mat::<f64, D>::identity();
        let sigma =
            ((F.mul_tr(&F) - I).scale(FLESH.mu) + I.scale(FLESH.lambda * log_J)).scale(1.0 / J);
        let C_inverse = F.tr_mul(&F).inverse();
        let second = I.scale(FLESH.mu) + C_inverse.scale(FLESH.lambda * log_J - FLESH.mu);
        let P = FLESH.stress(&F);
        let size = P.norm_squared().sqrt() * F.norm_squared().sqrt() * (1.0 + 1.0 / J);
        for i in 0..D {
            near(
                cauchy_from_piola(&F, &P).0[i],
                sigma.0[i],
                size,
                "σ = P Fᵀ/J",
            );
            near(
                piola_from_second_piola(&F, &second).0[i],
                P.0[i],
                size,
                "P = F S",
            );
            let back = second_piola_from_piola(&F, &P).0[i];
            near(
                back,
                second.0[i],
                size * F.inverse().norm_squared().sqrt(),
                "S = F⁻¹ P",
            );
            let pushed = (F * second).mul_tr(&F).scale(1.0 / J);
            near(pushed.0[i], sigma.0[i], size, "σ = F S Fᵀ/J");
        }
        let (deformed, material) = (Geometry::facets(&x), Geometry::facets(&rest));
        let body = assembly(&rest, FLESH);
        let forces = body.forces_everywhere(body.configuration(&x, &[]).unwrap());
        let size =
            size * (deformed.iter().chain(&material).flatten()).fold(0.0, |m, c| c.abs().max(m));
        for a in 0..=D {
            // a n = J F⁻ᵀ A N.
            let nanson = F.cofactor().mul_vec(material[a]);
            near(nanson, deformed[a], 1.0 + F.norm_squared(), "Nanson");
            near(
                forces[a],
                pulled(&sigma, &deformed, a),
                size,
                "−1/D σ Σ a n",
            );
            near(forces[a], pulled(&P, &material, a), size, "−1/D P Σ A N");
            let pull = material[a].map(|c| c / D as f64);
            near(
                forces[a],
                P.mul_vec(pull),
                size,
                "1/D P A N of the opposite facet",
            );
            near(forces[a], P.mul_vec(shape.area_normal(a)), size, "P b");
            let b = pulled(&I, &material, a);
            near(shape.area_normal(a), b, 1.0, "b = −1/D Σ A N");
        }
        // B_m = −V D_m⁻ᵀ: D_mᵀ B_m = −V I.
        let volume = shape_matrix(&rest).tr_mul(&shape.area_normals());
        for i in 0..D {
            near(volume.0[i], I.scale(-shape.volume).0[i], 1.0, "D_mᵀ B_m");
        }
    }
}

#[test]
fn edge_normals_pull_the_vertices_of_a_triangle() {
    check_forces::<2>();
}

#[test]
fn face_normals_pull_the_vertices_of_a_tetrahedron() {
    check_forces::<3>();
}

/// Document 002: D⁻¹ and |T| once, then D, F, P, H = −|T| P D⁻ᵀ, and f₀ = −Σ f.
fn five_steps<const D: usize>(mesh: &SimplexMesh<D>, x: &[[f64; D]]) {
    let rest = mesh.nodes();
    let mut forces = vec![[0.0; D]; rest.len()];
    for nodes in mesh.elements() {
        let corner =
            |p: &[[f64; D]]| -> Vec<[f64; D]> { nodes.iter().map(|&n| p[n as usize]).collect() };
        let D0 = shape_matrix(&corner(rest));
        let area = D0.determinant() / [2.0, 6.0][D - 2];
        let F = shape_matrix(&corner(x)) * D0.inverse();
        let H = FLESH.stress(&F).mul_tr(&D0.inverse()).scale(-area);
        for (j, &node) in nodes.iter().skip(1).enumerate() {
            for k in 0..D {
                forces[node as usize][k] += H.0[k][j];
                forces[nodes[0] as usize][k] -= H.0[k][j];
            }
        }
    }
    let dofs = Dofs::all_free(rest).unwrap();
    let body = AssemblyBuilder::new(mesh, dofs)
        .unwrap()
        .material(FLESH)
        .unwrap()
        .build()
        .unwrap();
    let scale = forces.iter().flatten().fold(0.0_f64, |m, f| m.max(f.abs()));
    for (ours, theirs) in body
        .forces_everywhere(body.configuration(x, &[]).unwrap())
        .iter()
        .zip(&forces)
    {
        near(*ours, *theirs, scale, "five steps");
    }
}

#[test]
fn the_five_steps_of_document_002_give_the_forces_of_a_mesh() {
    let mut random = random::Random(5);
    let mesh = Triangles::new(4, 3).mesh();
    let x: Vec<_> = mesh.nodes().iter().map(|p| random.near(p, 0.08)).collect();
    five_steps(&mesh, &x);
    let mesh = fem_assembly::mesh::kuhn_grid(2, 3, 2, [0.9, 1.2, 0.8]).unwrap();
    let x: Vec<_> = mesh.nodes().iter().map(|p| random.near(p, 0.05)).collect();
    five_steps(&mesh, &x);
}

/// Dual numbers through the stress: dP without any tensor.
fn dual_differential(
    material: &impl Material<3>,
    F: &Mat<f64, 3>,
    dF: &Mat<f64, 3>,
) -> Mat<f64, 3> {
    let moved = Mat::from_fn(|i, j| Dual::new(F.0[i][j], dF.0[i][j]));
    let P = material.stress(&moved);
    Mat::from_fn(|i, j| P.0[i][j].derivative)
}

/// K of the assembly by its matrix, one unit vector at a time, in the mesh's numbering of nodes.
fn stiffness(body: &Assembly<3>, x: &[[f64; 3]]) -> [[f64; 12]; 12] {
    let mut hessian = BlockSymmetric::zeros(body.pattern().clone());
    body.hessian(
        body.configuration(x, &[]).unwrap(),
        HessianProjection::None,
        &mut hessian,
    );
    let mut K = [[0.0; 12]; 12];
    for column in 0..12 {
        let mut unit = vec![[0.0; 3]; 4];
        unit[column / 3][column % 3] = 1.0;
        let mut product = vec![0.0; 12];
        hessian.apply(&body.dofs().gather(&unit).unwrap(), &mut product);
        let mut by_node = vec![[0.0; 3]; 4];
        body.dofs().scatter(&product, &mut by_node).unwrap();
        for row in 0..12 {
            K[row][column] = by_node[row / 3][row % 3];
        }
    }
    K
}

fn largest(K: &[[f64; 12]; 12]) -> f64 {
    K.iter().flatten().fold(0.0, |m, k| k.abs().max(m))
}

fn same(a: &[[f64; 12]; 12], b: &[[f64; 12]; 12], what: &str) {
    let scale = largest(b);
    for (p, q) in a.iter().flatten().zip(b.iter().flatten()) {
        assert!(
            (p - q).abs() <= 2e-13 * scale,
            "{what}: {p} {q}, scale {scale}"
        );
    }
}

/// −dG in every column, G = P B_m and g₀ = −Σ g, for dD_s with a single 1 (for vertex 0: −1 in a
/// whole row).
fn by_columns(
    shape: &RestShape<f64, 3>,
    dP: impl Fn(&Mat<f64, 3>) -> Mat<f64, 3>,
) -> [[f64; 12]; 12] {
    let mut K = [[0.0; 12]; 12];
    for column in 0..12 {
        let (node, axis) = (column / 3, column % 3);
        let dDs = Mat::from_fn(|i, j| match (i == axis, node) {
            (false, _) => 0.0,
            (true, 0) => -1.0,
            (true, node) => f64::from(j + 1 == node),
        });
        let dG = dP(&(dDs * shape.inverse)) * shape.area_normals();
        for k in 0..3 {
            K[k][column] = (0..3).map(|j| dG.0[k][j]).sum();
            for j in 0..3 {
                K[3 * (j + 1) + k][column] = -dG.0[k][j];
            }
        }
    }
    K
}

/// Document 000, 4.5, and document 004's K = dG/dF dF/du, for a model whose blocks at F̂ are known.
#[test]
fn the_element_stiffness_by_columns_in_closed_form_and_by_the_assembly_is_one() {
    for Element { rest, x, shape, F } in elements::<3>() {
        let material = ByStretches(COROTATED);
        let body = assembly(&rest, material);
        let truth = by_columns(&shape, |dF| dual_differential(&material, &F, dF));
        let K = stiffness(&body, &x);
        same(&K, &truth, "assembled against dual numbers");
        // Symmetric, and a translation meets no resistance: semidefinite at best.
        let scale = largest(&K);
        for row in 0..12 {
            for column in 0..12 {
                assert!((K[row][column] - K[column][row]).abs() <= 1e-13 * scale);
            }
            for axis in 0..3 {
                let moved: f64 = (0..4).map(|node| K[row][3 * node + axis]).sum();
                assert!(moved.abs() <= 1e-13 * scale);
            }
        }

        // dG = U {dP/dF(F̂) : Uᵀ dF V} Vᵀ B_m.
        let svd = signed_svd(&F);
        let blocks: DiagonalBlocks<f64, 3> = COROTATED.blocks(&svd.sigma);
        let rotated = |dF: &Mat<f64, 3>| {
            let inner = (svd.U.tr_mul(dF)) * svd.V;
            (svd.U * blocks.apply(&inner)).mul_tr(&svd.V)
        };
        same(
            &by_columns(&shape, rotated),
            &truth,
            "U {dP/dF(F̂) : Uᵀ dF V} Vᵀ B_m",
        );

        // (12×9)(9×9)(9×12): u ↦ F is linear, and so is P ↦ G.
        let tensor = to_flat::<f64, 3, 9>(&material.stress_derivative(&F), &ROW_MAJOR_3D);
        let dF_du = |row: usize, column: usize| {
            let ((i, j), (node, axis)) = (ROW_MAJOR_3D[row], (column / 3, column % 3));
            let slope = match node {
                0 => -(0..3).map(|k| shape.inverse.0[k][j]).sum::<f64>(),
                node => shape.inverse.0[node - 1][j],
            };
            if i == axis { slope } else { 0.0 }
        };
        let dG_dP = |row: usize, column: usize| {
            let ((i, j), (node, axis)) = (ROW_MAJOR_3D[column], (row / 3, row % 3));
            if i == axis {
                shape.area_normal(node)[j]
            } else {
                0.0
            }
        };
        let closed: [[f64; 12]; 12] = core::array::from_fn(|row| {
            core::array::from_fn(|column| {
                let inner = |m: usize| (0..9).map(|n| tensor[m][n] * dF_du(n, column)).sum::<f64>();
                -(0..9).map(|m| dG_dP(row, m) * inner(m)).sum::<f64>()
            })
        });
        same(&closed, &truth, "dG/dF dF/du");

        // Without any matrix.
        let free: [[f64; 12]; 12] = {
            let columns: Vec<_> = (0..12)
                .map(|column| {
                    let mut unit = vec![[0.0; 3]; 4];
                    unit[column / 3][column % 3] = 1.0;
                    body.hessian_vector_everywhere(body.configuration(&x, &[]).unwrap(), &unit)
                        .unwrap()
                })
                .collect();
            core::array::from_fn(|row| {
                core::array::from_fn(|column| columns[column][row / 3][row % 3])
            })
        };
        same(&free, &truth, "matrix-free");
    }
}

/// M of document 000: dP̂ = M dF̂ with both as columns of nine in the order 11, 22, 33, 12, 21, …, and
/// nothing outside of A and the three B.
#[test]
fn the_9x9_matrix_at_a_diagonal_F_has_the_order_and_the_blocks_of_document_000() {
    const ORDER: [(usize, usize); 9] = [
        (1, 1),
        (2, 2),
        (3, 3),
        (1, 2),
        (2, 1),
        (1, 3),
        (3, 1),
        (2, 3),
        (3, 2),
    ];
    assert_eq!(BLOCK_ORDER_3D.map(|(i, j)| (i + 1, j + 1)), ORDER);
    let numbered = Tensor4::<f64, 3>::from_fn(|i, j, k, l| {
        (1000 * (i + 1) + 100 * (j + 1) + 10 * (k + 1) + l + 1) as f64
    });
    let named = to_flat::<f64, 3, 9>(&numbered, &BLOCK_ORDER_3D);
    assert_eq!(
        (named[0][0], named[3][4], named[4][3]),
        (1111.0, 1221.0, 2112.0)
    );
    assert_eq!(
        (named[5][6], named[8][7], named[2][6]),
        (1331.0, 3223.0, 3331.0)
    );
    let mut random = random::Random(9);
    for sigma in [
        [1.7, 0.9, 0.55],
        [1.2, 1.2, 0.8],
        [1.0, 1.0, 1.0],
        [2.0, 0.6, 0.3],
    ] {
        let F_hat = Mat::from_diagonal(sigma);
        for (name, tensor) in [
            ("neo-Hookean", FLESH.stress_derivative(&F_hat)),
            (
                "corotated",
                ByStretches(COROTATED).stress_derivative(&F_hat),
            ),
        ] {
            let M = to_flat::<f64, 3, 9>(&tensor, &BLOCK_ORDER_3D);
            let block = |n: usize| if n < 3 { 0 } else { (n - 1) / 2 };
            let size = M.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
            for (r, row) in M.iter().enumerate() {
                for (c, entry) in row.iter().enumerate() {
                    let outside = block(r) != block(c);
                    assert!(
                        !outside || entry.abs() <= 1e-15 * size,
                        "{name} ({r}, {c}): {entry}"
                    );
                }
            }
            let dF: Mat<f64, 3> = Mat::from_fn(|_, _| random.unit());
            let exact = match name {
                "neo-Hookean" => dual_differential(&FLESH, &F_hat, &dF),
                _ => dual_differential(&ByStretches(COROTATED), &F_hat, &dF),
            };
            for (n, &(i, j)) in ORDER.iter().enumerate() {
                let along = |m: usize| dF.0[ORDER[m].0 - 1][ORDER[m].1 - 1];
                let ours: f64 = (0..9).map(|m| M[n][m] * along(m)).sum();
                let truth = exact.0[i - 1][j - 1];
                assert!(
                    (ours - truth).abs() <= 1e-13 * size,
                    "{name} {i}{j}: {ours} {truth}"
                );
            }
        }
    }
}

/// Document 000, 5.6: dx·df = −V dF : dP/dF : dF element by element, so the signs are opposite.
#[test]
fn an_element_softens_exactly_where_its_material_does() {
    let mut random = random::Random(21);
    let mut signs = [0; 2];
    for Element {
        rest, mut x, shape, ..
    } in elements::<3>()
    {
        for squeeze in [1.0, 0.2] {
            x.iter_mut().for_each(|p| p[2] *= squeeze);
            let F = deformation_gradient(&shape_matrix(&x), &shape.inverse);
            let material = ByStretches(COROTATED);
            let body = assembly(&rest, material);
            for _ in 0..20 {
                let dx: Vec<[f64; 3]> = (0..4).map(|_| random.point()).collect();
                let product = body
                    .hessian_vector_everywhere(body.configuration(&x, &[]).unwrap(), &dx)
                    .unwrap();
                let work: f64 = -(0..12)
                    .map(|n| dx[n / 3][n % 3] * product[n / 3][n % 3])
                    .sum::<f64>();
                let dF = shape_matrix(&dx) * shape.inverse;
                let curvature = dF.dot(&dual_differential(&material, &F, &dF));
                let scale = shape.volume * dF.norm_squared() * 1e3;
                assert!((work + shape.volume * curvature).abs() <= 1e-12 * scale);
                assert!(curvature.abs() <= 1e-9 * scale || (work < 0.0) == (curvature > 0.0));
                signs[usize::from(curvature > 0.0)] += 1;
            }
        }
    }
    assert!(
        signs[0] > 20 && signs[1] > 200,
        "both signs occur: {signs:?}"
    );
}
