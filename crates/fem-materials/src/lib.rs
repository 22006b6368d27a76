//! Constitutive models for simplex finite elements: energy, first Piola-Kirchhoff stress and its derivative
