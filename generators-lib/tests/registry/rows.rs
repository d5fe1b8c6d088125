// The generators of the library, by name: a row for each file of `src/generators`.
//
// In: nothing but the names in it, so that whoever needs no compiled library reads it as well. Out, by a macro of whoever includes it: type
// and class, what a generator is made of and told when it is tried, what is odd about its numbers, and goals that no arm reaches.

registry! {
    // Copied by users into their projects.
    copied: {
        await_operator: AwaitOperator<Irp6, fn() -> bool> {
            class: "ECP f*0(c)",
            make: AwaitOperator::until(|| false),
            given: alone,
            odd: |_| vec![AwaitOperator::until(|| true)],
        }
        circular_move: CircularMove<Irp6> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: CircularMove::through(
                start().translation.vector + Vector3::new(0.05, 0.03, 0.0),
                start() * Pose::new(Vector3::new(0.0, 0.1, 0.02), Vector3::new(0.1, 0.2, 0.3)),
                smooth_limits(0.3, 1.0, 10.0),
            ),
            given: alone,
            odd: |x| {
                let at = start().translation.vector;
                let mut odd = Vec::new();
                for [v, a, j] in odd_limits(x) {
                    for via in [at, at + Vector3::repeat(x), Vector3::repeat(x), Vector3::new(0.1, x, 0.3)] {
                        odd.extend(odd_poses(x).map(|pose| CircularMove::through(via, pose, smooth_limits(v, a, j))));
                    }
                }
                odd
            },
            out_of_reach: [
                NoInverseKinematics: CircularMove::through(beside(3.0, 1.5).translation.vector, beside(0.0, 0.1), smooth_limits(0.1, 0.5, 5.0)),
            ],
        }
        compliant_transmit: CompliantTransmit<Irp6, Wrist> {
            class: "ECP f*5(c0, c, v)",
            make: CompliantTransmit::by(squeeze_law(0.01).expect("has reserve"), 1),
            given: |step| felt(step, Displacement { pose: Pose::translation(0.0, 0.0, 1e-4 * step as f64) }),
            odd: |x| squeeze_law(x).map(|law| CompliantTransmit::by(law, 1)).into_iter().collect(),
        }
        constant_order: ConstantOrder<Two, Displacement> {
            class: "MP f**() = const",
            make: ConstantOrder::to_all(Displacement { pose: Pose::identity() }),
            given: pair,
            odd: |_| vec![ConstantOrder::to_all(Displacement { pose: Pose::identity() })],
        }
        curve_move: CurveMove<Irp6, Helix> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: CurveMove::along(helix(0.05, 0.02, 6.0).expect("in range"), JerkLimits { velocity: 0.2, acceleration: 1.0, jerk: 10.0 }),
            given: alone,
            odd: |x| {
                let curves = [helix(0.05, 0.02, 6.0), helix(x, 0.02, 6.0), helix(0.05, x, 6.0), helix(0.05, 0.02, x), helix(x, x, x)];
                let limits = odd_limits(x).map(|[velocity, acceleration, jerk]| JerkLimits { velocity, acceleration, jerk });
                curves
                    .into_iter()
                    .flatten()
                    .flat_map(|curve| limits.map(|limits| CurveMove::along(curve, limits)))
                    .collect()
            },
            out_of_reach: [
                // Once round, with the far side 4 m away; the end is where it begins.
                NoInverseKinematics: CurveMove::along(helix(2.0, 0.0, TAU).expect("a helix"), JerkLimits { velocity: 0.1, acceleration: 0.5, jerk: 5.0 }),
            ],
        }
        delay: Delay<Irp6> {
            class: "ECP f*0(c)",
            make: Delay::lasting(0.5),
            given: alone,
            odd: |x| vec![Delay::lasting(x)],
        }
        eye_in_hand: EyeInHand<Irp6, Camera> {
            class: "ECP f*3(c, e, v)",
            make: EyeInHand::to(Pose::identity(), Pose::translation(0.0, 0.05, 0.0), |seen: &Displacement| Some(seen.pose), servoing(0.2, 0.2, 4.0)),
            given: |step| seen(step as f64 * 1e-4),
            odd: |x| {
                let mut odd: Vec<_> = odd_poses(x)
                    .map(|pose| EyeInHand::to(pose, Pose::identity(), |seen: &Displacement| Some(seen.pose), servoing(0.2, 0.2, 4.0)))
                    .collect();
                let how = [servoing(x, 0.2, 4.0), servoing(0.2, x, 4.0), servoing(0.2, 0.2, x), servoing(x, x, x)];
                odd.extend(how.map(|how| EyeInHand::to(Pose::identity(), Pose::identity(), |seen: &Displacement| Some(seen.pose), how)));
                odd
            },
        }
        follow_master: FollowMaster<Two, StraightBody> {
            class: "MP f*2(c0, e)",
            make: FollowMaster::along(body(), 0.02),
            given: pair,
            odd: |x| {
                let lags = [x, 0.02].into_iter().flat_map(|lag| odd_bodies(x).map(move |path| FollowMaster::along(path, lag)));
                lags.collect()
            },
        }
        followed_frame: FollowedFrame<Irp6, Camera> {
            class: "ECP f*1(c, v), first step f*3(c, e, v)",
            make: followed(Pose::identity(), 10.0, 1.0, 0.5, 1.0),
            given: |step| seen(step as f64 * 4e-4),
            odd: |x| {
                let mut odd: Vec<_> = odd_poses(x).map(|pose| followed(pose, 10.0, 1.0, 0.5, 1.0)).collect();
                odd.extend([(x, 1.0), (10.0, x), (x, x)].map(|(rate, most)| followed(Pose::identity(), rate, most, 0.5, 1.0)));
                odd.extend([(x, 1.0), (0.5, x), (x, x)].map(|(approach, duration)| followed(Pose::identity(), 10.0, 1.0, approach, duration)));
                odd
            },
        }
        force_law: ForceLaw<Irp6, Wrist> {
            class: "ECP f*1(c, v), first step f*3(c, e, v)",
            make: ForceLaw::lasting(law(10.0, 0.01, Give::FORCE).expect("in range"), 2.0, 1),
            given: |step| pressed(-0.02 * step as f64),
            odd: |x| {
                let gives = [(x, 1.0), (0.01, x), (x, x)].map(|(reciprocal_damping, inertia)| Give { reciprocal_damping, inertia });
                let mut laws = vec![law(x, 0.01, Give::FORCE), law(10.0, x, Give::FORCE), law(x, x, Give::FORCE)];
                laws.extend(gives.map(|give| law(10.0, 0.01, give)));
                let mut odd: Vec<_> = laws.into_iter().flatten().map(|law| ForceLaw::lasting(law, 2.0, 1)).collect();
                odd.push(ForceLaw::lasting(law(10.0, 0.01, Give::FORCE).expect("in range"), x, 1));
                odd
            },
        }
        guarded_approach: GuardedApproach<Irp6, Wrist> {
            class: "ECP f*1(c, v), first step f*3(c, e, v)",
            make: GuardedApproach::along(Vector3::z_axis(), 0.05, 0.5, 0.5, |w: &Wrench| w.force.z < -5.0),
            given: |step| pressed(-0.02 * step as f64),
            odd: |x| vec![
                GuardedApproach::along(Vector3::z_axis(), x, 0.5, 0.5, |_| false),
                GuardedApproach::along(Vector3::z_axis(), 0.05, x, 0.5, |_| false),
                GuardedApproach::along(Vector3::z_axis(), 0.05, 0.5, x, |_| false),
                GuardedApproach::along(Vector3::z_axis(), x, x, x, |_| false),
            ],
        }
        guided_body: GuidedBody<Two, [Wrist; 2]> {
            class: "MP f*3(c0, e, v)",
            make: GuidedBody::yielding(Give::FORCE, 1.0, 1.0, 2.0),
            given: |step| Given { order: Order::new(()), e: pair_state(), v: Reading::new([load(0.01 * step as f64), load(-0.5)]) },
            odd: |x| {
                let gives = [(x, 1.0), (0.01, x), (x, x)].map(|(reciprocal_damping, inertia)| Give { reciprocal_damping, inertia });
                let mut odd: Vec<_> = gives.map(|give| GuidedBody::yielding(give, 1.0, 1.0, 2.0)).into();
                odd.extend([(x, 1.0, 2.0), (1.0, x, 2.0), (1.0, 1.0, x)].map(|(a, b, c)| GuidedBody::yielding(Give::FORCE, a, b, c)));
                odd
            },
        }
        jog: Jog<Irp6, fn() -> Jogging> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: Jog::by(|| Jogging { along: Vector3::x() * 0.1, record: true, ..Jogging::default() }, 1.0, 1.0, 1),
            given: alone,
            odd: |x| vec![
                Jog::by(|| Jogging { along: Vector3::x() * 0.1, ..Jogging::default() }, x, 1.0, 1),
                Jog::by(|| Jogging { about: Vector3::x() * f64::NAN, ..Jogging::default() }, 1.0, 1.0, 1),
                Jog::by(|| Jogging { about: Vector3::x() * 1e300, ..Jogging::default() }, 1.0, x, 1),
                Jog::by(|| Jogging { along: Vector3::x() * 1e100, ..Jogging::default() }, 1e300, 1e300, 0),
            ],
        }
        joint_move: JointMove<Irp6> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: JointMove::to(arm() + Six::repeat(0.2), Six::repeat(0.5), Six::repeat(1.0)),
            given: alone,
            odd: |x| vec![
                JointMove::to(arm(), Six::repeat(1.0), Six::repeat(1.0)),
                JointMove::to(Six::repeat(x), Six::repeat(1.0), Six::repeat(1.0)),
                JointMove::to(Six::zeros(), Six::repeat(x), Six::repeat(1.0)),
                JointMove::to(Six::zeros(), Six::repeat(1.0), Six::repeat(x)),
                JointMove::to(Six::zeros(), Six::repeat(x), Six::repeat(x)),
                JointMove::to(arm() + Six::new(x, 0.0, 0.0, 0.0, 0.0, 0.1), Six::repeat(1.0), Six::repeat(1.0)),
            ],
            out_of_reach: [
                DemandOutOfRange: JointMove::to(turned(9.0), Six::repeat(0.2), Six::repeat(0.4)),
            ],
        }
        joint_spline: JointSpline<Irp6> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: JointSpline::through(
                vec![arm() + Six::repeat(0.1), arm() + Six::new(0.2, 0.1, 0.1, 0.0, -0.1, 0.3)],
                Six::repeat(0.5),
                Six::repeat(1.0),
                0.2,
            ),
            given: alone,
            odd: |x| {
                let mut odd = vec![JointSpline::through(vec![], Six::repeat(1.0), Six::repeat(1.0), 0.2)];
                for points in [vec![arm()], vec![arm(), arm()], vec![Six::repeat(x)], vec![Six::repeat(x), arm()]] {
                    for [v, a, ramp] in [[0.5, 1.0, 0.2], [x, 1.0, 0.2], [0.5, x, 0.2], [0.5, 1.0, x], [x, x, x]] {
                        odd.push(JointSpline::through(points.clone(), Six::repeat(v), Six::repeat(a), ramp));
                    }
                }
                odd
            },
            allocates: true,
            out_of_reach: [
                DemandOutOfRange: JointSpline::through(vec![turned(9.0), turned(0.1)], Six::repeat(0.2), Six::repeat(0.4), 0.1),
            ],
        }
        joint_velocity: JointVelocity<Irp6> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: JointVelocity::of(Six::repeat(0.1), Six::repeat(1.0)),
            given: alone,
            odd: |x| vec![
                JointVelocity::of(Six::zeros(), Six::repeat(1.0)),
                JointVelocity::of(Six::repeat(x), Six::repeat(1.0)),
                JointVelocity::of(Six::repeat(0.1), Six::repeat(x)),
                JointVelocity::of(Six::repeat(x), Six::repeat(x)),
            ],
        }
        joint_via: JointVia<Irp6> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: JointVia::through(
                vec![arm() + Six::repeat(0.1), arm() + Six::new(0.2, 0.1, 0.1, 0.0, -0.1, 0.3)],
                Six::repeat(0.01),
                joint_limits(0.5, 1.0, 10.0),
            ),
            given: alone,
            odd: |x| {
                let mut odd = vec![JointVia::through(vec![], Six::repeat(0.01), joint_limits(0.5, 1.0, 10.0))];
                for points in [vec![arm()], vec![arm(), arm()], vec![Six::repeat(x)], vec![Six::repeat(x), arm()]] {
                    for [v, a, j] in odd_limits(x) {
                        odd.push(JointVia::through(points.clone(), Six::repeat(0.01), joint_limits(v, a, j)));
                        odd.push(JointVia::through(points.clone(), Six::repeat(x), joint_limits(v, a, j)));
                    }
                }
                odd
            },
            allocates: true,
            out_of_reach: [
                DemandOutOfRange: JointVia::through(vec![turned(9.0), turned(0.1)], Six::repeat(0.01), joint_limits(0.2, 0.4, 8.0)),
            ],
        }
        line_via: LineVia<Irp6> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: LineVia::through(
                vec![away(), start() * Pose::translation(0.05, 0.05, 0.05), start()],
                within(0.005, 0.05),
                smooth_limits(0.3, 1.0, 10.0),
            ),
            given: alone,
            odd: |x| {
                let mut odd = vec![LineVia::through(vec![start()], within(0.01, 0.01), smooth_limits(0.1, 1.0, 10.0))];
                for [v, a, j] in odd_limits(x) {
                    for pose in odd_poses(x) {
                        for poses in [vec![pose], vec![pose, start()], vec![away(), pose, away()]] {
                            odd.push(LineVia::through(poses.clone(), within(0.01, 0.1), smooth_limits(v, a, j)));
                            odd.push(LineVia::through(poses, within(0.01, x), smooth_limits(v, a, j)));
                        }
                    }
                }
                odd
            },
            allocates: true,
            out_of_reach: [
                NoInverseKinematics: LineVia::through(vec![beside(3.0, 0.0), beside(0.05, 0.0)], within(0.01, 0.1), smooth_limits(0.1, 0.5, 5.0)),
            ],
        }
        moving_frame: MovingFrame<Irp6, Belt> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: MovingFrame::to(belt(), start(), 0.5, 1.0),
            given: alone,
            odd: |x| {
                let mut odd = vec![MovingFrame::to(belt(), start(), x, 1.0), MovingFrame::to(belt(), start(), 0.5, x), MovingFrame::to(belt(), start(), x, x)];
                odd.extend(odd_poses(x).map(|pose| MovingFrame::to(belt(), pose, 0.5, 1.0)));
                odd
            },
        }
        ordered_force: OrderedForce<Irp6, Wrist> {
            class: "ECP f*7(c0, c, e, v)",
            make: OrderedForce::with_tool(13.18, Give::FORCE, WIDE),
            given: |step| felt(step, Pressing { force: 0.01 * step as f64, across: [0.01, 0.0] }),
            odd: |x| {
                let gives = [(x, 1.0), (0.01, x), (x, x)].map(|(reciprocal_damping, inertia)| Give { reciprocal_damping, inertia });
                let mut odd: Vec<_> = gives.map(|give| OrderedForce::with_tool(10.0, give, WIDE)).into();
                odd.push(OrderedForce::with_tool(x, Give::FORCE, WIDE));
                odd.push(OrderedForce::with_tool(10.0, Give::FORCE, Bound { speed: x, travel: x }));
                odd
            },
        }
        pose_spline_move: PoseSplineMove<Irp6> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: PoseSplineMove::through(
                vec![away(), start() * Pose::translation(0.05, 0.05, 0.05), start()],
                smooth_limits(0.3, 1.0, 10.0),
            ),
            given: alone,
            odd: |x| {
                let mut odd = vec![PoseSplineMove::through(vec![], smooth_limits(0.1, 1.0, 10.0))];
                for [v, a, j] in odd_limits(x) {
                    for pose in odd_poses(x) {
                        for poses in [vec![pose], vec![pose, start()], vec![away(), pose, away()]] {
                            odd.push(PoseSplineMove::through(poses, smooth_limits(v, a, j)));
                        }
                    }
                }
                odd
            },
            allocates: true,
            out_of_reach: [
                NoInverseKinematics: PoseSplineMove::through(vec![beside(3.0, 0.0), beside(0.05, 0.0)], smooth_limits(0.1, 0.5, 5.0)),
            ],
        }
        reach_state: ReachState<Irp6> {
            class: "ECP f*4(c0, c), first step f*6(c0, c, e)",
            make: ReachState::within(joint_limits(0.5, 1.0, 10.0)),
            given: |step| reaching(if step < 100 { 0.2 } else { -0.1 }),
            odd: |x| odd_limits(x).map(|[v, a, j]| ReachState::within(joint_limits(v, a, j))).into(),
        }
        replay: Replay<Irp6> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: Replay::of(shown(0.1, 0.5, Space::Zyz).expect("in range"), Six::repeat(1.0), Six::repeat(2.0), tool_limits(0.3, 1.0)),
            given: alone,
            odd: |x| {
                let all = [Space::Motor, Space::Joint, Space::Zyz, Space::AngleAxis].into_iter();
                let taught = all.flat_map(|space| [shown(x, 0.5, space), shown(0.1, x, space), shown(x, x, space)]).flatten();
                let one = |taught: Taught| [
                    Replay::of(taught.clone(), Six::repeat(1.0), Six::repeat(2.0), tool_limits(0.3, 1.0)),
                    Replay::of(taught.clone(), Six::repeat(x), Six::repeat(2.0), tool_limits(x, 1.0)),
                    Replay::of(taught, Six::repeat(1.0), Six::repeat(x), tool_limits(0.3, x)),
                ];
                taught.flat_map(one).collect()
            },
            allocates: true,
            out_of_reach: [
                DemandOutOfRange: Replay::of(swung(0.05, 9.0), Six::repeat(0.2), Six::repeat(0.4), tool_limits(0.1, 0.5)),
            ],
        }
        rigid_carry: RigidCarry<Two, StraightBody> {
            class: "MP f*0(c0), first step f*2(c0, e)",
            make: RigidCarry::along(BodyFrame::Centroid, body()),
            given: pair,
            odd: |x| odd_bodies(x).map(|path| RigidCarry::along(BodyFrame::Centroid, path)).collect(),
        }
        settle: Settle<Irp6> {
            class: "ECP f*2(c, e)",
            make: Settle::within(Six::repeat(1e-3), 0.5, 1.0),
            given: |step| Given { order: Order::new(()), e: State::new(behind(0.9_f64.powi(step as i32))), v: Reading::new(()) },
            odd: |x| vec![
                Settle::within(Six::repeat(x), 0.5, 1.0), Settle::within(Six::repeat(1e-3), x, 1.0),
                Settle::within(Six::repeat(1e-3), 0.5, x), Settle::within(Six::repeat(x), x, x),
            ],
        }
        shared_drive: SharedDrive<Two, StraightBody> {
            class: "MP f*0(c0), first step f*2(c0, e)",
            make: drive(body(), tool_limits(0.3, 1.0)),
            given: pair,
            odd: |x| {
                let limits = [tool_limits(0.3, 1.0), tool_limits(x, 1.0), tool_limits(1.0, x)];
                limits.into_iter().flat_map(|limits| odd_bodies(x).map(move |path| drive(path, limits))).collect()
            },
        }
        sleep: Sleep<Irp6> {
            class: "ECP f*0(c)",
            make: Sleep::lasting(0.5),
            given: alone,
            odd: |x| vec![Sleep::lasting(x)],
        }
        smooth_joint_move: SmoothJointMove<Irp6> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: SmoothJointMove::to(arm() + Six::repeat(0.2), joint_limits(0.5, 1.0, 10.0)),
            given: alone,
            odd: |x| {
                let mut odd = vec![SmoothJointMove::to(arm(), joint_limits(0.5, 1.0, 10.0))];
                for [v, a, j] in odd_limits(x) {
                    odd.push(SmoothJointMove::to(Six::repeat(x), joint_limits(v, a, j)));
                    odd.push(SmoothJointMove::to(Six::zeros(), joint_limits(v, a, j)));
                    odd.push(SmoothJointMove::to(arm() + Six::new(x, 0.0, 0.0, 0.0, 0.0, 0.1), joint_limits(v, a, j)));
                }
                odd
            },
            out_of_reach: [
                DemandOutOfRange: SmoothJointMove::to(turned(9.0), joint_limits(0.2, 0.4, 8.0)),
            ],
        }
        spiral_search: SpiralSearch<Irp6> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: SpiralSearch::over(0.02, 8e-3, JerkLimits { velocity: 0.1, acceleration: 0.5, jerk: 5.0 }),
            given: alone,
            odd: |x| {
                let limits = odd_limits(x).map(|[velocity, acceleration, jerk]| JerkLimits { velocity, acceleration, jerk });
                let of = |limits| odd_sizes(x).map(|[radius, pitch]| SpiralSearch::over(radius, pitch, limits));
                limits.into_iter().flat_map(of).collect()
            },
        }
        spline_track: SplineTrack<Irp6, Points> {
            class: "ECP f*0(c)",
            make: track(&wave(40, 2e-3), feed(0.1, 1.0)).expect("in range"),
            given: alone,
            odd: |x| {
                let odd_points = [x * Vector3::x(), Vector3::new(x, -x, 1.0), Vector3::repeat(x)];
                let mut odd: Vec<_> = odd_points
                    .into_iter()
                    .flat_map(|p| [track(&[p, p], feed(0.1, 1.0)), track(&[Vector3::zeros(), p, Vector3::y()], feed(0.1, 1.0))])
                    .collect();
                odd.extend([track(&wave(20, x), feed(0.1, 1.0)), track(&[], feed(0.1, 1.0)), track(&wave(1, x), feed(0.1, 1.0))]);
                odd.extend([feed(x, 1.0), feed(0.1, x), feed(x, x)].map(|limits| track(&wave(20, 1e-3), limits)));
                odd.into_iter().flatten().collect()
            },
        }
        squeezed_carry: SqueezedCarry<Two, [Wrist; 2], StraightBody> {
            class: "MP f*1(c0, v), first step f*3(c0, e, v)",
            make: squeezed(body(), 5.0, 0.01).expect("has reserve"),
            given: |step| Given { order: Order::new(()), e: pair_state(), v: Reading::new([load(0.01 * step as f64), load(-0.5)]) },
            odd: |x| {
                let squeezes = [(x, 0.01), (5.0, x)].into_iter();
                squeezes.flat_map(|(squeeze, inertia)| odd_bodies(x).filter_map(move |path| squeezed(path, squeeze, inertia))).collect()
            },
        }
        straight_line: StraightLine<Irp6> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: StraightLine::by(Pose::new(Vector3::new(0.05, 0.02, 0.1), Vector3::new(0.1, 0.2, 0.3)), tool_limits(0.3, 1.0)),
            given: alone,
            odd: |x| {
                let mut odd = vec![StraightLine::to(start(), tool_limits(0.1, 1.0))];
                for limits in [tool_limits(0.3, 1.0), tool_limits(x, 1.0), tool_limits(1.0, x), tool_limits(x, x)] {
                    odd.extend(odd_poses(x).map(|pose| StraightLine::to(pose, limits)));
                    odd.extend(odd_poses(x).map(|pose| StraightLine::by(pose, limits)));
                }
                odd
            },
            out_of_reach: [
                NoInverseKinematics: StraightLine::to(beside(3.0, 0.0), tool_limits(0.1, 0.5)),
                NoInverseKinematics: StraightLine::by(Pose::translation(3.0, 0.0, 0.0), smooth_limits(0.1, 0.5, 5.0)),
            ],
        }
        tell: Tell<Irp6> {
            class: "ECP f*0(c)",
            make: Tell::output(flow(), 0.5),
            given: alone,
            odd: |x| vec![Tell::output(flow(), x)],
        }
        tilt_search: TiltSearch<Irp6> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: TiltSearch::within(0.1, 0.04, JerkLimits { velocity: 0.5, acceleration: 2.0, jerk: 20.0 }),
            given: alone,
            odd: |x| {
                let limits = odd_limits(x).map(|[velocity, acceleration, jerk]| JerkLimits { velocity, acceleration, jerk });
                let of = |limits| odd_sizes(x).map(|[largest, pitch]| TiltSearch::within(largest, pitch, limits));
                limits.into_iter().flat_map(of).collect()
            },
        }
        time_optimal_curve: TimeOptimalCurve<Irp6, Helix> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: TimeOptimalCurve::along(
                Irp6::nominal(),
                helix(0.05, 0.02, 6.0).expect("a helix"),
                path_limits(0.5, 1.0, f64::INFINITY),
            ),
            given: alone,
            odd: |x| {
                let helices = [helix(0.05, 0.02, 6.0), helix(x, 0.02, 6.0), helix(0.05, x, 6.0), helix(0.05, 0.02, x)];
                let limits = odd_limits(x).map(|[v, a, speed]| path_limits(v, a, speed));
                let all = helices.into_iter().flatten().flat_map(|helix| limits.map(|limits| (helix, limits)));
                all.map(|(helix, limits)| TimeOptimalCurve::along(Irp6::nominal(), helix, limits)).collect()
            },
            allocates: true,
        }
        time_optimal_joints: TimeOptimalJoints<Irp6> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: TimeOptimalJoints::through(
                vec![arm() + Six::repeat(0.1), arm() + Six::new(0.2, 0.1, 0.1, 0.0, -0.1, 0.3)],
                path_limits(0.5, 1.0, f64::INFINITY),
            ),
            given: alone,
            odd: |x| {
                let mut odd = vec![TimeOptimalJoints::through(vec![], path_limits(1.0, 1.0, 1.0))];
                for points in [vec![arm()], vec![arm(), arm()], vec![Six::repeat(x)], vec![Six::repeat(x), arm()]] {
                    for [v, a, speed] in odd_limits(x) {
                        odd.push(TimeOptimalJoints::through(points.clone(), path_limits(v, a, speed)));
                    }
                }
                odd
            },
            allocates: true,
            out_of_reach: [
                DemandOutOfRange: TimeOptimalJoints::through(vec![turned(9.0), turned(0.1)], path_limits(0.2, 0.4, f64::INFINITY)),
            ],
        }
        tool_offset: ToolOffset<Irp6> {
            class: "ECP f*0(c)",
            make: ToolOffset::by(Pose::new(Vector3::new(0.05, 0.02, 0.1), Vector3::new(0.1, 0.2, 0.3)), tool_limits(0.3, 1.0)),
            given: alone,
            odd: |x| {
                let limits = [tool_limits(0.3, 1.0), tool_limits(x, 1.0), tool_limits(1.0, x), tool_limits(x, x)];
                limits.into_iter().flat_map(|limits| odd_poses(x).map(move |pose| ToolOffset::by(pose, limits))).collect()
            },
            out_of_reach: [
                NoInverseKinematics: ToolOffset::by(Pose::translation(3.0, 0.0, 0.0), tool_limits(0.1, 0.5)),
            ],
        }
        transmit_displacement: TransmitDisplacement<Irp6> {
            class: "ECP f*4(c0, c)",
            make: TransmitDisplacement::new(),
            given: |step| ordered(1e-4 * step as f64),
            odd: |_| vec![TransmitDisplacement::new()],
        }
        watched_transmit: WatchedTransmit<Irp6> {
            class: "ECP f*6(c0, c, e)",
            make: WatchedTransmit::within(5e-3, 0.05),
            given: |step| ordered(1e-4 * step as f64),
            odd: |x| vec![WatchedTransmit::within(x, 0.05), WatchedTransmit::within(5e-3, x)],
        }
        yielding_transmit: YieldingTransmit<Irp6FiveDof> {
            class: "ECP f*4(c0, c), first step f*6(c0, c, e)",
            make: YieldingTransmit::by(Irp6FiveDof::nominal(), FreeDirection::Turn(Vector3::x_axis())),
            given: |step| {
                let pose = Pose::translation(0.0, 1e-5 * step as f64, 0.0);
                Given { order: Order::new(Displacement { pose }), e: State::new(five()), v: Reading::new(()) }
            },
            odd: |_| vec![YieldingTransmit::by(Irp6FiveDof::nominal(), FreeDirection::Turn(Vector3::x_axis()))],
        }
    }
    // What a person jogs by, and what follows trajectories of others, is used as it is: its bounds are of the whole system, and no template.
    used: {
        follow_trajectory: FollowTrajectory<Irp6> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: FollowTrajectory::along(&trajectory(arm(), &[0.5, 1.0], 0.1).expect("sound")),
            given: alone,
            odd: |x| {
                let all = [(arm(), [0.5, 1.0], x), (arm(), [x, 1.0], 0.1), (arm(), [0.5, x], 0.1), (Six::repeat(x), [0.5, 1.0], 0.1)];
                let made = all.into_iter().filter_map(|(from, times, by)| trajectory(from, &times, by));
                made.map(|trajectory| FollowTrajectory::along(&trajectory)).collect()
            },
            allocates: true,
        }
        panel_jog: PanelJog<Irp6> {
            class: "ECP f*0(c), first step f*2(c, e)",
            make: jogged(JogLimits::default()),
            given: alone,
            odd: |x| vec![
                jogged(JogLimits { speed: x, ..JogLimits::default() }),
                jogged(JogLimits { turn: x, ..JogLimits::default() }),
                jogged(JogLimits { acceleration: x, ..JogLimits::default() }),
                jogged(JogLimits { turning_acceleration: x, ..JogLimits::default() }),
                jogged(JogLimits { joints: x, ..JogLimits::default() }),
                jogged(JogLimits { margin: x, ..JogLimits::default() }),
            ],
        }
    }
}
