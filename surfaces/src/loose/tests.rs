use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use super::*;
use crate::free_space::RayEnd;

/// Points as an eye 1.4 m over the origin sees them, a hundredth of the distance apart: of the floor from 0.6 to 2 m
/// ahead and of `things`, each with its height at a place of the floor.
fn seen(things: &dyn Fn(f64, f64) -> f64) -> FreeSpace {
    let eye_W = Point3::new(0.0, 0.0, 1.4);
    let mut points = Vec::new();
    for (i, j) in (0..120).flat_map(|i| (0..100).map(move |j| (i, j))) {
        let down = 0.6 + 0.007 * f64::from(i);
        let way = Vector3::new(down.cos(), 0.01 * f64::from(j - 50), -down.sin());
        // On, in small steps, until it is no longer over what is there.
        let at = |t: f64| eye_W + way * t;
        let over = |t: &f64| at(*t).z > things(at(*t).x, at(*t).y);
        let end = (0..1500).map(|k| 0.002 * f64::from(k)).find(|t| !over(t));
        if let Some(t) = end {
            points.push(RayEnd {
                p_W: at(t),
                sigma_m: 0.003,
            });
        }
    }
    FreeSpace {
        eye_W,
        beside: points,
        density: 1e4,
        ..FreeSpace::default()
    }
}

fn floor() -> Face {
    Face::rectangle("floor", Isometry3::translation(1.0, 0.0, 0.0), [3.0, 3.0]).unwrap()
}

/// A block 12 cm thick and 0.3 m wide.
fn block(x: f64, y: f64) -> f64 {
    if (1.2..1.32).contains(&x) && y.abs() < 0.15 {
        0.13
    } else {
        0.0
    }
}

#[test]
fn a_thing_on_no_face_is_a_body_and_the_floor_is_none() {
    assert!(loose(&[floor()], &[&seen(&|_, _| 0.0)]).is_empty());
    let view = seen(&block);
    let bodies = loose(&[floor()], &[&view]);
    assert!((1..4).contains(&bodies.len()), "{bodies:?}");
    let all = bodies.iter().flat_map(|body| &body.points_W);
    let ends = |axis: usize| {
        let along = all.clone().map(|p| p[axis]);
        along.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| {
            (a.min(x), b.max(x))
        })
    };
    let near = |(low, high): (f64, f64), a: f64, b: f64| {
        assert!(
            (low - a).abs() < 0.035 && (high - b).abs() < 0.035,
            "{low} … {high}"
        );
    };
    near(ends(0), 1.2, 1.32);
    near(ends(1), -0.15, 0.15);
    near(ends(2), 0.0, 0.13);
    bodies
        .iter()
        .for_each(|body| assert!(body.validate().is_ok() && is_loose(body)));
}

/// Of a floor whose face is two parts with a gap between, all that was seen is in the way, and nothing is over it.
#[test]
fn what_a_face_lost_is_behind_its_plane() {
    let part = |id: &str, x: f64| {
        Face::rectangle(id, Isometry3::translation(x, 0.0, 0.0), [0.6, 3.0]).unwrap()
    };
    let faces = [part("near", 0.7), part("far", 1.5)];
    // Noise of 1 cm up and down.
    let view = seen(&|x, y| 0.01 * (1e3 * (x + 2.0 * y)).sin());
    let bodies = loose(&faces, &[&view]);
    let within = |y: f64| {
        bodies.iter().any(|body| {
            let along = |axis: usize| body.points_W.iter().map(move |p| p[axis]);
            let covers = |axis: usize, low: f64, high: f64| {
                along(axis).any(|x| x <= low) && along(axis).any(|x| x >= high)
            };
            covers(0, 1.03, 1.17) && covers(1, y, y)
        })
    };
    assert!(
        (-20..=20).all(|k| within(0.02 * f64::from(k))),
        "{bodies:?}"
    );
    for body in &bodies {
        body.validate().unwrap();
        assert!(
            !is_loose(body) && body.points_W.iter().all(|p| p.z < 1e-9),
            "{body:?}"
        );
    }
}

/// The end of a wall is not over what it stands under.
#[test]
fn what_is_near_two_planes_is_over_neither() {
    // A step of 13 cm at x = 1.2, whose face begins and ends 3 cm from its ends.
    let view = seen(&|x, _| {
        if x < 1.2 {
            0.0
        } else {
            0.13 + 0.015 * (1e3 * x).sin()
        }
    });
    let floor = Face::rectangle("floor", Isometry3::translation(0.2, 0.0, 0.0), [1.9, 3.0]);
    let top = Face::rectangle("top", Isometry3::translation(2.24, 0.0, 0.13), [2.0, 3.0]);
    let turn = UnitQuaternion::from_axis_angle(&-Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
    let wall = Face::rectangle(
        "wall",
        Isometry3::from_parts(Translation3::new(1.2, 0.0, 0.065), turn),
        [0.07, 3.0],
    );
    let bodies = loose(&[floor.unwrap(), top.unwrap(), wall.unwrap()], &[&view]);
    let walls = bodies.iter().filter(|body| body.id.starts_with("wall"));
    let highest = walls.flat_map(|body| &body.points_W).map(|p| p.z);
    let highest = highest.fold(f64::NEG_INFINITY, f64::max);
    assert!(
        (0.11..0.13 + POINT_M + 1e-9).contains(&highest),
        "{highest}"
    );
}

#[test]
fn points_between_a_thing_and_what_is_behind_it_are_no_thing() {
    let mut view = seen(&|_, _| 0.0);
    // A row of single points across the view, each anywhere between eye and floor.
    let eye_W = view.eye_W;
    for (k, seen) in view.beside.iter_mut().skip(60 * 100).take(100).enumerate() {
        let part = 0.5 + 0.4 * (k as f64 * 0.37).fract();
        seen.p_W = eye_W + (seen.p_W - eye_W) * part;
    }
    assert!(loose(&[floor()], &[&view]).is_empty());
}

/// Whether about so many of some are left of the k-th of points in a row.
fn of_each(part: f64, k: usize) -> bool {
    (4e4 * (k as f64).sin()).rem_euclid(1.0) < part
}

/// Along a wall 0.2 m beside it, at 6° to 10°, a sensor sees few points, and loses more than half of them.
#[test]
fn a_wall_along_which_the_view_looks_is_a_body() {
    let mut view = seen(&|x, y| {
        if x > 1.1 && (0.2..0.25).contains(&y) {
            2.0
        } else {
            0.0
        }
    });
    let is_wall = |seen: &RayEnd| seen.p_W.z > 0.1;
    let mut count = 0..;
    view.beside
        .retain(|seen| !is_wall(seen) || count.next().is_some_and(|k| of_each(0.4, k)));
    let wall: Vec<Point3<f64>> = (view.beside.iter().filter(|seen| is_wall(seen)))
        .map(|seen| seen.p_W)
        .collect();
    let bodies = loose(&[floor()], &[&view]);
    let near = |p: &Point3<f64>, body: &Obstacle| {
        (0..3).all(|axis| {
            let along = || body.points_W.iter().map(|q| q[axis] - p[axis]);
            along().any(|x| x < 0.02) && along().any(|x| x > -0.02)
        })
    };
    let bare = (wall
        .iter()
        .filter(|p| !bodies.iter().any(|body| near(p, body))))
    .count();
    assert!(
        wall.len() > 90 && 5 * bare < wall.len(),
        "{bare} of {}",
        wall.len()
    );
}

/// As many points as such a wall has, over a floor that others show behind them.
#[test]
fn a_part_of_a_floors_points_above_it_is_no_thing() {
    let mut view = seen(&|_, _| 0.0);
    let eye_W = view.eye_W;
    for (_, seen) in view
        .beside
        .iter_mut()
        .enumerate()
        .filter(|(k, _)| of_each(0.06, *k))
    {
        seen.p_W = eye_W + (seen.p_W - eye_W) * ((eye_W.z - 0.04) / eye_W.z);
    }
    assert!(loose(&[floor()], &[&view]).is_empty());
}

/// In a cloud of few points each may be all that a cell can have.
#[test]
fn a_few_points_of_a_thin_cloud_in_line_are_a_body_or_none() {
    for count in [0, 1, 5, 6, 20] {
        let points = (0..count).map(|k| RayEnd {
            p_W: Point3::new(1.0, 0.01 * f64::from(k), 0.5),
            sigma_m: 0.003,
        });
        let view = FreeSpace {
            eye_W: Point3::new(0.0, 0.0, 1.4),
            beside: points.collect(),
            ..FreeSpace::default()
        };
        for body in loose(&[floor()], &[&view]) {
            assert!(count > 5, "{body:?}");
            body.validate().unwrap();
            let along = |axis: usize| body.points_W.iter().map(move |p| p[axis]);
            let wide = |axis: usize| {
                along(axis).fold(f64::NEG_INFINITY, f64::max)
                    - along(axis).fold(f64::INFINITY, f64::min)
            };
            assert!((0..3).all(|axis| wide(axis) >= 0.0099), "{body:?}");
        }
    }
}

#[test]
fn planes_side_by_side_say_what_each_says_by_itself() {
    let place = |k: usize| (k as f64 * 0.618_034).fract() - 0.5;
    // More than lie side by side, turned and moved to anywhere within some metres.
    let face = |k: usize| {
        let [roll, pitch, yaw] = [1, 2, 3].map(|j| 6.0 * place(j * k + j));
        let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        let move_m = Translation3::new(4.0 * place(5 * k), 4.0 * place(7 * k), 2.0 * place(11 * k));
        let size_m = [0.2 + 0.1 * (k % 7) as f64, 0.3 + 0.2 * (k % 3) as f64];
        Face::rectangle(format!("f{k}"), Isometry3::from_parts(move_m, turn), size_m).unwrap()
    };
    let faces: Vec<Face> = (1..20).map(face).collect();
    let plates = Plates::new(&faces);
    let eye_W = Point3::new(0.0, 0.0, 1.4);
    let (mut found, mut of_some, mut held) = (Vec::new(), 0, 0);
    for k in 0..20_000 {
        let p_W = Point3::new(5.0 * place(k), 5.0 * place(3 * k), 3.0 * place(17 * k));
        let seen = RayEnd {
            p_W,
            sigma_m: 0.002 * (k % 20) as f64,
        };
        let way_W = p_W - eye_W;
        let each = plates.all.iter().map(|plate| {
            let off_m = plate.height_m(&p_W).abs();
            plate.off(off_m, &seen, &way_W)
        });
        let each: Vec<Option<f64>> = each.collect();
        let is_held = each.iter().flatten().any(|off| *off < 0.0);
        assert_eq!(plates.beside(&seen, &way_W, &mut found), !is_held, "{p_W}");
        if !is_held {
            let of = (0..).zip(each).filter_map(|(k, off)| Some((off?, k)));
            assert_eq!(found, of.collect::<Vec<_>>(), "{p_W}");
        }
        of_some += usize::from(!is_held && !found.is_empty());
        held += usize::from(is_held);
    }
    assert!(of_some > 50 && held > 50, "{of_some} {held}");
}
