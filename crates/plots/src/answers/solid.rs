//! Boxes and cylinders as wires.

use std::f64::consts::TAU;

use api::PoseBody;
use api::arms::ArmObstacle;

use super::arm::place;

type Point = [f64; 3];

/// The axes of a pose's frame: the columns of `R = Rz(r) Ry(p) Rx(w)`.
pub(super) fn axes(pose: &PoseBody) -> [Point; 3] {
    let (sw, cw) = pose.w_deg.to_radians().sin_cos();
    let (sp, cp) = pose.p_deg.to_radians().sin_cos();
    let (sr, cr) = pose.r_deg.to_radians().sin_cos();
    [
        [cr * cp, sr * cp, -sp],
        [cr * sp * sw - sr * cw, sr * sp * sw + cr * cw, cp * sw],
        [cr * sp * cw + sr * sw, sr * sp * cw - cr * sw, cp * cw],
    ]
}

/// A point of a frame, in the frame that its pose is in.
fn placed(pose: &PoseBody, point: Point) -> Point {
    let mut sum = place(pose);
    for (axis, along) in axes(pose).into_iter().zip(point) {
        for (sum, axis) in sum.iter_mut().zip(axis) {
            *sum += axis * along;
        }
    }
    sum
}

/// The edges of an obstacle.
pub(super) fn wires(obstacle: &ArmObstacle) -> Vec<Vec<Point>> {
    match obstacle {
        ArmObstacle::Box { pose, size_mm } => {
            let half = size_mm.map(|size| size / 2.0);
            box_wires(half.map(|half| -half), half, |point| placed(pose, point))
        }
        ArmObstacle::KeepOut { min_mm, max_mm } => box_wires(*min_mm, *max_mm, |point| point),
        ArmObstacle::Cylinder {
            pose,
            radius_mm,
            height_mm,
        } => {
            let at = |turn: f64, z: f64| {
                let (sin, cos) = (turn * TAU).sin_cos();
                placed(pose, [radius_mm * cos, radius_mm * sin, z])
            };
            let half = height_mm / 2.0;
            let round = |z: f64| (0..=36).map(|n| at(f64::from(n) / 36.0, z)).collect();
            let mut wires: Vec<Vec<Point>> = vec![round(-half), round(half)];
            wires.extend((0..6).map(|n| {
                let turn = f64::from(n) / 6.0;
                vec![at(turn, -half), at(turn, half)]
            }));
            wires
        }
    }
}

fn box_wires(low: Point, high: Point, placed: impl Fn(Point) -> Point) -> Vec<Vec<Point>> {
    let ([x0, y0, z0], [x1, y1, z1]) = (low, high);
    let round = |z: f64| {
        let corners = [
            [x0, y0, z],
            [x1, y0, z],
            [x1, y1, z],
            [x0, y1, z],
            [x0, y0, z],
        ];
        corners.map(&placed).to_vec()
    };
    let mut wires = vec![round(z0), round(z1)];
    for (x, y) in [(x0, y0), (x1, y0), (x1, y1), (x0, y1)] {
        wires.push(vec![placed([x, y, z0]), placed([x, y, z1])]);
    }
    wires
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(w: f64, p: f64, r: f64) -> PoseBody {
        [10.0, 20.0, 30.0, w, p, r].into()
    }

    fn is(found: Point, wanted: Point) {
        for (found, wanted) in found.iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
        }
    }

    #[test]
    fn angles_turn_about_the_fixed_axes() {
        // R 90: x goes to y, y to -x.
        let [x, y, z] = axes(&pose(0.0, 0.0, 90.0));
        is(x, [0.0, 1.0, 0.0]);
        is(y, [-1.0, 0.0, 0.0]);
        is(z, [0.0, 0.0, 1.0]);
        // W 180, as at an arm's home: z points down.
        is(axes(&pose(180.0, 0.0, 0.0))[2], [0.0, 0.0, -1.0]);
        // First W, then P: y goes up by W 90, and then to x by P 90 about the fixed y.
        is(axes(&pose(90.0, 90.0, 0.0))[1], [1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_box_has_twelve_edges_and_its_corners_where_they_are() {
        let wires = wires(&ArmObstacle::Box {
            pose: pose(0.0, 0.0, 90.0),
            size_mm: [2.0, 4.0, 6.0],
        });
        let edges: usize = wires.iter().map(|wire| wire.len() - 1).sum();
        assert_eq!(edges, 12);
        let corners = wires.iter().flatten();
        for corner in corners {
            is(
                [
                    (corner[0] - 10.0).abs(),
                    (corner[1] - 20.0).abs(),
                    (corner[2] - 30.0).abs(),
                ],
                [2.0, 1.0, 3.0],
            );
        }
    }
}
