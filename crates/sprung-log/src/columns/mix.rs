//! Coupled transmissions: conversion of motor positions and torques to joint positions and torques.

/// A linear change of coordinates and its inverse.
#[derive(Clone, Debug, PartialEq)]
pub struct Mix {
    /// From motors to joints, \[n × n\], row by row.
    pub forward: Vec<Vec<f64>>,
    /// From joints to motors, \[n × n\], row by row.
    pub back: Vec<Vec<f64>>,
}

impl Mix {
    /// Returns a matrix times a vector.
    #[must_use]
    pub fn apply(matrix: &[Vec<f64>], values: &[f64]) -> Vec<f64> {
        let product = |row: &Vec<f64>| row.iter().zip(values).map(|(a, x)| a * x).sum();
        matrix.iter().map(product).collect()
    }
}
