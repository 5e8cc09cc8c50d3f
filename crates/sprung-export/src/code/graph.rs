//! Expressions of the model: a number type that records the operations of the kernels.
//!
//! A kernel over [`Scalar`] that runs with [`Symbol`] appends its operations to a [`Graph`]. Equal
//! operations are shared, constants are folded, and operations with zero and one disappear.

use std::cell::RefCell;
use std::collections::HashMap;
use std::ops::{Add, Mul, Neg, Sub};

use sprung_core::scalar::Scalar;

/// An operand: a constant by its bits, or a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Operand {
    Constant(u64),
    Node(u32),
}

/// A function of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Function {
    Neg,
    Sin,
    Cos,
    Exp,
    Tanh,
    Ln,
    /// The reciprocal; zero of zero.
    Recip,
    Abs,
    /// 1 of numbers that are not negative, otherwise 0.
    IsForward,
}

/// An operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Operation {
    /// The input with this index.
    Input(usize),
    Of(Function, Operand),
    Add(Operand, Operand),
    Sub(Operand, Operand),
    Mul(Operand, Operand),
}

/// Operations, each after its operands.
#[derive(Debug, Default)]
pub(super) struct Graph {
    nodes: RefCell<Vec<Operation>>,
    known: RefCell<HashMap<Operation, u32>>,
}

impl Graph {
    /// Returns the input with an index.
    pub(super) fn input(&self, index: usize) -> Symbol<'_> {
        self.node(Operation::Input(index))
    }

    fn node(&self, operation: Operation) -> Symbol<'_> {
        let mut nodes = self.nodes.borrow_mut();
        let next = nodes.len() as u32;
        let id = *(self.known.borrow_mut()).entry(operation).or_insert(next);
        if id == next {
            nodes.push(operation);
        }
        Symbol::Node(self, id)
    }

    fn operation(&self, id: u32) -> Operation {
        self.nodes.borrow()[id as usize]
    }

    /// Returns the operations that the results need, with their numbers, each after its operands.
    pub(super) fn needed(&self, results: &[Operand]) -> Vec<(u32, Operation)> {
        let nodes = self.nodes.borrow();
        let mut needed = vec![false; nodes.len()];
        let mark = |operand: Operand, needed: &mut [bool]| {
            if let Operand::Node(id) = operand {
                needed[id as usize] = true;
            }
        };
        for result in results {
            mark(*result, &mut needed);
        }
        for (id, operation) in nodes.iter().enumerate().rev() {
            if !needed[id] {
                continue;
            }
            match *operation {
                Operation::Input(_) => {}
                Operation::Of(_, x) => mark(x, &mut needed),
                Operation::Add(x, y) | Operation::Sub(x, y) | Operation::Mul(x, y) => {
                    mark(x, &mut needed);
                    mark(y, &mut needed);
                }
            }
        }
        (nodes.iter().enumerate())
            .filter(|(id, _)| needed[*id])
            .map(|(id, operation)| (id as u32, *operation))
            .collect()
    }
}

/// Returns the values of results at given inputs.
///
/// - `needed`: from [`Graph::needed`] with the same results.
pub(super) fn values(needed: &[(u32, Operation)], results: &[Operand], inputs: &[f64]) -> Vec<f64> {
    let length = needed.last().map_or(0, |(id, _)| *id as usize + 1);
    let mut known = vec![0.0; length];
    let of = |operand: Operand, known: &[f64]| match operand {
        Operand::Constant(bits) => f64::from_bits(bits),
        Operand::Node(id) => known[id as usize],
    };
    for (id, operation) in needed {
        known[*id as usize] = match *operation {
            Operation::Input(index) => inputs[index],
            Operation::Of(function, x) => function.value(of(x, &known)),
            Operation::Add(x, y) => of(x, &known) + of(y, &known),
            Operation::Sub(x, y) => of(x, &known) - of(y, &known),
            Operation::Mul(x, y) => of(x, &known) * of(y, &known),
        };
    }
    results.iter().map(|result| of(*result, &known)).collect()
}

impl Function {
    fn value(self, x: f64) -> f64 {
        match self {
            Self::Neg => -x,
            Self::Sin => Scalar::sin_cos(x).0,
            Self::Cos => Scalar::sin_cos(x).1,
            Self::Exp => Scalar::exp(x),
            Self::Tanh => Scalar::tanh(x),
            Self::Ln => Scalar::ln(x),
            Self::Recip if x == 0.0 => 0.0,
            Self::Recip => Scalar::recip(x),
            Self::Abs => Scalar::abs(x),
            Self::IsForward => Scalar::is_forward(x),
        }
    }
}

/// A number of the model: a constant, or a node of a graph.
#[derive(Clone, Copy, Debug)]
pub(super) enum Symbol<'g> {
    Constant(f64),
    Node(&'g Graph, u32),
}

impl<'g> Symbol<'g> {
    pub(super) fn operand(self) -> Operand {
        match self {
            // Both zeros are the same constant.
            Self::Constant(value) => Operand::Constant((value + 0.0).to_bits()),
            Self::Node(_, id) => Operand::Node(id),
        }
    }

    /// Returns `x` if the number is `-x`.
    fn negated(self) -> Option<Self> {
        let Self::Node(graph, id) = self else {
            return None;
        };
        match graph.operation(id) {
            Operation::Of(Function::Neg, Operand::Node(x)) => Some(Self::Node(graph, x)),
            Operation::Input(_)
            | Operation::Of(..)
            | Operation::Add(..)
            | Operation::Sub(..)
            | Operation::Mul(..) => None,
        }
    }

    fn is(self, value: f64) -> bool {
        matches!(self, Self::Constant(constant) if constant.to_bits() == value.to_bits() || constant == 0.0 && value == 0.0)
    }

    fn of(self, function: Function) -> Self {
        match self {
            Self::Constant(value) => Self::Constant(function.value(value)),
            Self::Node(graph, id) => graph.node(Operation::Of(function, Operand::Node(id))),
        }
    }

    fn graph(self, other: Self) -> Option<&'g Graph> {
        match (self, other) {
            (Self::Node(graph, _), _) | (_, Self::Node(graph, _)) => Some(graph),
            _ => None,
        }
    }

    /// Returns two operands in the order that all equal operations have.
    fn sorted(self, other: Self) -> (Operand, Operand) {
        let (a, b) = (self.operand(), other.operand());
        if a <= b { (a, b) } else { (b, a) }
    }
}

impl Neg for Symbol<'_> {
    type Output = Self;

    fn neg(self) -> Self {
        self.negated().unwrap_or_else(|| self.of(Function::Neg))
    }
}

impl Add for Symbol<'_> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        match (self, other) {
            (Self::Constant(a), Self::Constant(b)) => return Self::Constant(a + b),
            _ if self.is(0.0) => return other,
            _ if other.is(0.0) => return self,
            _ => {}
        }
        if let Some(other) = other.negated() {
            return self - other;
        }
        if let Some(negated) = self.negated() {
            return other - negated;
        }
        let (a, b) = self.sorted(other);
        self.graph(other)
            .map_or(self, |graph| graph.node(Operation::Add(a, b)))
    }
}

impl Sub for Symbol<'_> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        match (self, other) {
            (Self::Constant(a), Self::Constant(b)) => return Self::Constant(a - b),
            _ if self.is(0.0) => return -other,
            _ if other.is(0.0) => return self,
            _ if self.operand() == other.operand() => return Self::ZERO,
            _ => {}
        }
        if let Some(other) = other.negated() {
            return self + other;
        }
        if let Some(negated) = self.negated() {
            return -(negated + other);
        }
        let (a, b) = (self.operand(), other.operand());
        self.graph(other)
            .map_or(self, |graph| graph.node(Operation::Sub(a, b)))
    }
}

impl Mul for Symbol<'_> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        match (self, other) {
            (Self::Constant(a), Self::Constant(b)) => return Self::Constant(a * b),
            (Self::Constant(_), _) => return other * self,
            _ if other.is(0.0) => return Self::ZERO,
            _ if other.is(1.0) => return self,
            _ if other.is(-1.0) => return -self,
            // Products with a number and with its negative share one operation.
            (_, Self::Constant(factor)) if factor < 0.0 => return -(self * -factor),
            _ => {}
        }
        if let Some(negated) = self.negated() {
            return -(negated * other);
        }
        if let Some(other) = other.negated() {
            return -(self * other);
        }
        let (a, b) = self.sorted(other);
        self.graph(other)
            .map_or(self, |graph| graph.node(Operation::Mul(a, b)))
    }
}

impl Mul<f64> for Symbol<'_> {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        self * Self::Constant(factor)
    }
}

impl Scalar for Symbol<'_> {
    const ZERO: Self = Self::Constant(0.0);

    fn constant(value: f64) -> Self {
        Self::Constant(value)
    }

    /// Returns the value of a constant; a node has none.
    fn value(self) -> f64 {
        match self {
            Self::Constant(value) => value,
            Self::Node(..) => f64::NAN,
        }
    }

    fn abs(self) -> Self {
        self.negated().unwrap_or(self).of(Function::Abs)
    }

    fn is_forward(self) -> Self {
        self.of(Function::IsForward)
    }

    fn sin_cos(self) -> (Self, Self) {
        match self.negated() {
            Some(negated) => (-negated.of(Function::Sin), negated.of(Function::Cos)),
            None => (self.of(Function::Sin), self.of(Function::Cos)),
        }
    }

    fn exp(self) -> Self {
        self.of(Function::Exp)
    }

    fn tanh(self) -> Self {
        match self.negated() {
            Some(negated) => -negated.of(Function::Tanh),
            None => self.of(Function::Tanh),
        }
    }

    fn ln(self) -> Self {
        self.of(Function::Ln)
    }

    fn recip(self) -> Self {
        self.of(Function::Recip)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_operations_are_shared_and_constants_disappear() {
        let graph = Graph::default();
        let [x, y] = [0, 1].map(|index| graph.input(index));
        let zero = Symbol::constant(0.0);
        for (a, b) in [
            (x + y, y + x),
            (x * y, y * x),
            (x * zero + y, y),
            (x * 1.0 - zero, x),
            (-(-x), x),
            (x - (-y), y + x),
            ((-x) * (-y), y * x),
            (zero - x, -x),
            ((-x).sin_cos().0, -x.sin_cos().0),
            (x - x, zero),
        ] {
            assert_eq!(a.operand(), b.operand(), "{a:?} {b:?}");
        }
        let results = [(x * y + x.abs()).operand()];
        assert_eq!(graph.needed(&results).len(), 5);
        let found = values(&graph.needed(&results), &results, &[-2.0, 3.0]);
        assert_eq!(found, [-4.0]);
    }
}
