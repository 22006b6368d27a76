//! The materials against dual numbers, against each other and against the documents' formulas.
#![allow(non_snake_case)]

mod by_hand;
mod curves;
mod derivatives;
mod inversion;
mod isotropic;
mod lame;
mod meaning;
mod near_rest;
mod numbers;
mod projections;
mod properties;
mod qr;
mod registry;
mod work;
