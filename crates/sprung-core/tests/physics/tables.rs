//! Denavit-Hartenberg tables against products of homogeneous matrices.
use sprung_core::chain::{ChainJoint, DhRow};

use crate::support::{Random, Worst};

/// A homogeneous matrix, row by row.
type Frame = [[f64; 4]; 4];

const BASE: Frame = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, 0.0, 1.0],
];

fn product(a: &Frame, b: &Frame) -> Frame {
    a.map(|row| std::array::from_fn(|j| (0..4).map(|k| row[k] * b[k][j]).sum()))
}

/// A turn about x and a shift along it.
fn twist(row: &DhRow) -> Frame {
    let (sin, cos) = row.alpha.sin_cos();
    [
        [1.0, 0.0, 0.0, row.a],
        [0.0, cos, -sin, 0.0],
        [0.0, sin, cos, 0.0],
        BASE[3],
    ]
}

/// A turn about z and a shift along it.
fn turn(row: &DhRow, q: f64, shift: f64) -> Frame {
    let (sin, cos) = (row.theta + q).sin_cos();
    [
        [cos, -sin, 0.0, 0.0],
        [sin, cos, 0.0, 0.0],
        [0.0, 0.0, 1.0, shift],
        BASE[3],
    ]
}

/// Frame of the last joint relative to the base.
fn last_frame(joints: &[ChainJoint], q: &[f64]) -> Frame {
    let mut frame = BASE;
    for (joint, q) in joints.iter().zip(q) {
        let transform = joint.transform(*q);
        let mut local = BASE;
        for (i, row) in local.iter_mut().take(3).enumerate() {
            let [x, y, z] = transform.axes.map(|axis| axis[i]);
            *row = [x, y, z, transform.origin[i]];
        }
        frame = product(&frame, &local);
    }
    frame
}

#[test]
fn joints_stand_where_their_tables_put_them() {
    let mut worst = Worst::default();
    let mut random = Random::new(8);
    for _ in 0..50 {
        let rows = [(); 4].map(|()| DhRow {
            alpha: random.between(-3.0, 3.0),
            a: random.between(-1.0, 1.0),
            d: random.between(-1.0, 1.0),
            theta: random.between(-3.0, 3.0),
        });
        let q = random.list(4, 3.0);
        let [mut modified, mut classic] = [BASE; 2];
        for (j, row) in rows.iter().enumerate() {
            let rotation = turn(row, q[j], row.d);
            modified = product(&modified, &product(&twist(row), &rotation));
            // The frame of the last link is only rotated, so its twist does not count.
            let rest = if j < 3 {
                product(&rotation, &twist(row))
            } else {
                turn(row, q[j], 0.0)
            };
            classic = product(&classic, &rest);
        }
        let by_modified: [_; 4] =
            std::array::from_fn(|j| ChainJoint::modified_dh(j.checked_sub(1), &rows[j]));
        let by_classic: [_; 4] = std::array::from_fn(|j| {
            let parent = j.checked_sub(1);
            ChainJoint::classic_dh(parent, parent.map(|parent| &rows[parent]), &rows[j])
        });
        for (joints, expected) in [(by_modified, modified), (by_classic, classic)] {
            let found = last_frame(&joints, &q);
            for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
                worst.see(found - expected, 1.0);
            }
        }
    }
    worst.assert_below(1e-14, "tables");
}
