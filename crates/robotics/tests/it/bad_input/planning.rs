//! Trajectories, paths of the tool, floors.

use api::paths::{PlanRouteBody, PolygonBody, RouteMethod};
use api::trajectory::{
    ToolPathBody, ToolPathKind, TrajectoryBody, TrajectoryKind, TrajectoryResult,
};
use robotics::{Refusal, RefusalKind};

use super::{HOME, M20, NAN, assert_refused};
use crate::common::pose;
use crate::paths::{floor, line};
use crate::trajectories::trajectory;

fn asked(
    kind: TrajectoryKind,
    change: fn(&mut TrajectoryBody),
) -> Result<TrajectoryResult, Refusal> {
    let mut body = trajectory(kind, &HOME, &[40.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
    change(&mut body);
    robotics::trajectory(M20, &body)
}

#[test]
fn trajectories_that_make_no_sense_are_refused() {
    let quintic = TrajectoryKind::Quintic;
    let jerk = TrajectoryKind::JerkLimited;
    assert!(asked(jerk, |_| ()).is_ok());
    // Impossible times.
    assert_refused(
        asked(quintic, |_| ()),
        "durations_s",
        "0 durations of this kind were given; it must be 1",
    );
    assert_refused(
        asked(quintic, |body| body.durations_s = vec![0.0]),
        "durations_s[0]",
        "it is 0 s",
    );
    assert_refused(
        asked(quintic, |body| body.durations_s = vec![NAN]),
        "durations_s[0]",
        "it is NaN s",
    );
    assert_refused(
        asked(jerk, |body| body.durations_s = vec![0.01]),
        "durations_s[0]",
        "J1 cannot arrive after 0.01 s; the next time it can is",
    );
    // Start states outside limits.
    assert_refused(
        asked(jerk, |body| body.start.position_deg_mm[0] = 171.0),
        "start.position_deg_mm[0]",
        "J1 is 171 deg",
    );
    assert_refused(
        asked(jerk, |body| {
            body.start.velocity_deg_mm_s = Some(vec![0.0, 0.0, 0.0, 0.0, 0.0, 600.0]);
        }),
        "start.velocity_deg_mm_s[5]",
        "J6: the velocity is 600 deg/s, its limit is 550 deg/s",
    );
    assert_refused(
        asked(jerk, |body| {
            body.goal.acceleration_deg_mm_s2 = Some(vec![500.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        }),
        "goal.acceleration_deg_mm_s2[0]",
        "J1: the acceleration is 500 deg/s2, its limit is 390 deg/s2",
    );
    assert_refused(
        asked(jerk, |body| {
            body.start.velocity_deg_mm_s = Some(vec![NAN; 6]);
        }),
        "start.velocity_deg_mm_s[0]",
        "it is NaN",
    );
}

#[test]
fn via_points_limits_and_samples_that_make_no_sense_are_refused() {
    let quintic = TrajectoryKind::Quintic;
    let jerk = TrajectoryKind::JerkLimited;
    let blended = TrajectoryKind::Blended;
    // Unreachable via points.
    assert_refused(
        asked(blended, |body| {
            body.via_deg_mm = vec![vec![20.0, 500.0, 0.0, 0.0, -90.0, 0.0]];
        }),
        "via_deg_mm[0][1]",
        "J2 is 500 deg; its range is -70 to 90 deg",
    );
    assert_refused(
        asked(blended, |body| {
            body.via_deg_mm = vec![body.start.position_deg_mm.clone()];
        }),
        "via_deg_mm[0]",
        "the same",
    );
    assert_refused(
        asked(blended, |body| {
            body.start.velocity_deg_mm_s = Some(vec![1.0; 6]);
        }),
        "start.velocity_deg_mm_s[0]",
        "at rest",
    );
    assert_refused(
        asked(quintic, |body| body.via_deg_mm = vec![vec![0.0; 6]]),
        "via_deg_mm",
        "it must be 0",
    );
    // Limits and samples.
    assert_refused(
        asked(jerk, |body| body.max_jerk_deg_mm_s3 = Some(vec![0.0; 6])),
        "max_jerk_deg_mm_s3[0]",
        "it is 0",
    );
    assert_refused(
        asked(jerk, |body| body.max_velocity_deg_mm_s = Some(vec![1.0])),
        "max_velocity_deg_mm_s",
        "1 numbers were given; it must be 6",
    );
    assert_refused(
        asked(jerk, |body| body.period_s = Some(0.0)),
        "period_s",
        "it is 0 s",
    );
    assert_refused(
        asked(quintic, |body| {
            body.durations_s = vec![3600.0];
            body.period_s = Some(0.001);
        }),
        "period_s",
        "at most 5000",
    );
}

#[test]
fn tool_paths_that_make_no_sense_are_refused() {
    let asked = |change: fn(&mut ToolPathBody)| {
        let mut body = line([985.0, 400.0, 940.0, 180.0, 0.0, 0.0]);
        change(&mut body);
        robotics::tool_path(M20, &body)
    };
    assert_refused(
        asked(|body| body.poses.truncate(1)),
        "poses",
        "1 poses of this kind of path were given; it must be 2",
    );
    assert_refused(
        asked(|body| body.poses[1] = body.poses[0]),
        "poses[1]",
        "the same pose",
    );
    assert_refused(
        asked(|body| body.poses[1].z_mm = NAN),
        "poses[1].z_mm",
        "z is NaN mm",
    );
    assert_refused(
        asked(|body| body.speed_mm_s = 0.0),
        "speed_mm_s",
        "it is 0 mm/s",
    );
    assert_refused(
        asked(|body| body.period_s = Some(5.0)),
        "period_s",
        "it is 5 s",
    );
    assert_refused(
        asked(|body| body.start_deg_mm = Some(vec![10.0, 0.0, 0.0, 0.0, -90.0, 0.0])),
        "start_deg_mm[0]",
        "J1 is at 10.000",
    );
    assert_refused(
        asked(|body| {
            body.kind = ToolPathKind::Arc;
            body.poses
                .push(pose([985.0, 800.0, 940.0, 180.0, 0.0, 0.0]));
        }),
        "poses",
        "on a line",
    );
}

#[test]
fn floors_and_polygons_that_make_no_sense_are_refused() {
    let asked = |change: fn(&mut PlanRouteBody)| {
        let mut body = floor(RouteMethod::Trapezoidal);
        change(&mut body);
        robotics::plan_route(&body)
    };
    let corners = "obstacles[0].corners_mm";
    assert_refused(
        asked(|body| body.obstacles[0].corners_mm.clear()),
        corners,
        "0 corners",
    );
    assert_refused(
        asked(|body| {
            body.obstacles[0].corners_mm =
                vec![[400.0, 0.0], [500.0, 0.0], [400.0, 700.0], [450.0, 600.0]];
        }),
        corners,
        "wall: edges",
    );
    assert_refused(
        asked(|body| body.obstacles[0].corners_mm[2][1] = NAN),
        corners,
        "NaN",
    );
    assert_refused(
        asked(|body| body.obstacles[0].corners_mm = vec![[0.0; 2], [1.0, 1.0], [2.0, 2.0]]),
        corners,
        "area",
    );
    assert_refused(
        asked(|body| body.start_mm = [450.0, 300.0]),
        "start_mm",
        "-50.000 mm from wall",
    );
    assert_refused(
        asked(|body| body.goal_mm = [520.0, 300.0]),
        "goal_mm",
        "20.000 mm from wall",
    );
    assert_refused(
        asked(|body| body.goal_mm = [980.0, 300.0]),
        "goal_mm",
        "20.000 mm from the edge of the floor",
    );
    assert_refused(
        asked(|body| body.goal_mm = [NAN, 300.0]),
        "goal_mm[0]",
        "it is NaN mm",
    );
    assert_refused(
        asked(|body| body.radius_mm = -1.0),
        "radius_mm",
        "it is -1 mm",
    );
    assert_refused(
        asked(|body| body.floor.max_mm = [0.0, 0.0]),
        "floor",
        "greatest x of the floor",
    );
    assert_refused(
        asked(|body| body.obstacles = vec![body.obstacles[0].clone(); 201]),
        "obstacles",
        "201 obstacles were given; it must be 0 to 200",
    );
    assert_refused(
        asked(|body| {
            body.search.method = Some(RouteMethod::Quadtree);
            body.search.resolution_mm = Some(0.0);
        }),
        "search.resolution_mm",
        "it is 0 mm",
    );
    assert_refused(
        asked(|body| {
            body.search.method = Some(RouteMethod::Roadmap);
            body.search.samples = Some(0);
        }),
        "search.samples",
        "it is 0",
    );
    // 400 corners leave 250,000 steps in the potential field.
    assert_refused(
        asked(|body| {
            body.obstacles = vec![body.obstacles[0].clone(); 100];
            body.search.method = Some(RouteMethod::PotentialField);
            body.search.steps = Some(300_000);
        }),
        "search.steps",
        "it must be from 1 to 250000",
    );
}

/// Two combs of 250 teeth across each other: 62,500 crossings of their edges, nine times as many with the robot's disc
/// around them. The answer comes before memory ends.
#[test]
fn obstacles_with_too_many_crossings_are_given_up() {
    let mut body = floor(RouteMethod::Trapezoidal);
    body.radius_mm = 0.5;
    body.start_mm = [5.0, 5.0];
    body.goal_mm = [995.0, 995.0];
    let teeth = (0..250_u32).map(|tooth| {
        let along = 100.0 + 3.0 * f64::from(tooth);
        [along, if tooth % 2 == 0 { 30.0 } else { 970.0 }]
    });
    let comb: Vec<[f64; 2]> = teeth.chain([[900.0, 10.0], [50.0, 10.0]]).collect();
    let across = comb.iter().map(|[x, y]| [*y, *x]).collect();
    body.obstacles = [comb, across]
        .map(|corners_mm| PolygonBody {
            name: None,
            corners_mm,
        })
        .to_vec();
    let refused = robotics::plan_route(&body).unwrap_err();
    assert_eq!(refused.kind, RefusalKind::NoWay);
    assert!(refused.detail.contains("400000 cells"), "{refused}");
}
