"""Trajectories of nodes of rclpy, which two arms follow: the action client of ROS 2 with the real FollowJointTrajectory.

In: the examples `goals` and `goals_bridge`, built. Out: exit status 0 if each goal ends as it should, and the recording says that the arms
went where they were told to.
"""

import json
import math
import re
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cell_outcome import Outcome  # noqa: E402
from ending import interruptible  # noqa: E402
from tried import EXAMPLES, ended_after, has, listen_in, run  # noqa: E402

listen_in("88")

import numpy as np  # noqa: E402
import rclpy  # noqa: E402
from action_msgs.msg import GoalStatus  # noqa: E402
from builtin_interfaces.msg import Duration  # noqa: E402
from control_msgs.action import FollowJointTrajectory as Follow  # noqa: E402
from control_msgs.msg import JointTolerance  # noqa: E402
from mcap.reader import make_reader  # noqa: E402
from rclpy.action import ActionClient  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint, MultiDOFJointTrajectory  # noqa: E402

CELL = Path("ports/ros2/examples/goals.toml").resolve()
STEP = 0.002
HOME = np.array([0.0, -1.57, 0.16, -0.16, 4.71, 0.0])
RESULT = Follow.Result
# What two computations of a joint's position may differ by [rad].
ROUNDING = 1e-9
# By what both arms turn together.
TURN = np.array([0.3, 0.1, -0.05, 0.1, -0.3, 0.2])


def duration(seconds):
    whole = math.floor(seconds)
    return Duration(sec=whole, nanosec=int(round((seconds - whole) * 1e9)))


class Arms:
    """A node of rclpy with an action client for each arm, and for both."""

    def __init__(self):
        self.node = rclpy.create_node("planner")
        names = {"left": "/left", "right": "/right", "both": "/cell"}
        self.clients = {name: ActionClient(self.node, Follow, f"{at}/follow_joint_trajectory") for name, at in names.items()}
        self.buttons = {name: self.node.create_client(Trigger, f"/cell/{name}") for name in ("suspend", "resume", "stop", "acknowledge", "reset")}
        self.feedback = []

    def until(self, is_so, what, seconds=20.0):
        end = time.monotonic() + seconds
        while not is_so():
            has(time.monotonic() < end, f"{what} does not come")
            rclpy.spin_once(self.node, timeout_sec=0.02)

    def spin(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            rclpy.spin_once(self.node, timeout_sec=0.02)

    def press(self, button):
        has(self.buttons[button].wait_for_service(timeout_sec=20), f"{button} is not there")
        answered = self.buttons[button].call_async(Trigger.Request())
        self.until(answered.done, button)
        return answered.result()

    def send(self, to, goal):
        """Its handle, once it is accepted."""
        has(self.clients[to].wait_for_server(timeout_sec=20), f"the action of {to} is not there")
        self.feedback = []
        sent = self.clients[to].send_goal_async(goal, feedback_callback=lambda told: self.feedback.append(told.feedback))
        self.until(sent.done, "an answer to a goal")
        has(sent.result().accepted, "a goal is not accepted")
        return sent.result()

    def outcome(self, handle, seconds=20.0):
        got = handle.get_result_async()
        self.until(got.done, "a result", seconds)
        return got.result().status, got.result().result

    def follow(self, to, goal):
        return self.outcome(self.send(to, goal))


def goal(names, times, positions, velocities=None, accelerations=None, tolerances=()):
    trajectory = JointTrajectory(joint_names=list(names))
    for k, at in enumerate(times):
        point = JointTrajectoryPoint(positions=[float(q) for q in positions[k]], time_from_start=duration(at))
        if velocities is not None:
            point.velocities = [float(v) for v in velocities[k]]
        if accelerations is not None:
            point.accelerations = [float(a) for a in accelerations[k]]
        trajectory.points.append(point)
    return Follow.Goal(trajectory=trajectory, path_tolerance=list(tolerances))


def swing(start, by, seconds=2.0, points=5):
    """Through points of a motion from rest to rest, of degree 5, with all that is told of them."""
    s = np.linspace(0, 1, points)
    place = 10 * s**3 - 15 * s**4 + 6 * s**5
    speed = (30 * s**2 - 60 * s**3 + 30 * s**4) / seconds
    change = (60 * s - 180 * s**2 + 120 * s**3) / seconds**2
    outer = lambda x: np.outer(x, by)  # noqa: E731
    return seconds * s, start + outer(place), outer(speed), outer(change)


def demanded(file):
    """What was demanded of the joints of each arm, by step; in which steps it moved; in which of these its demand had not come."""
    steps, moving, bridged = {"left": {}, "right": {}}, {"left": set(), "right": set()}, {"left": set(), "right": set()}
    with open(file, "rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages():
            name = channel.topic.removeprefix("/robots/")
            if name in steps:
                said = json.loads(message.data)
                steps[name][said["step"]] = np.array(said["demanded"]["joints"])
                # Without power it is demanded to be where it is.
                if said["mode"] in ("moving", "bridging"):
                    moving[name].add(said["step"])
                if said["mode"] == "bridging":
                    bridged[name].add(said["step"])
    return steps, moving, bridged


def expect(told, status, code, text, what):
    got, result = told
    print(f"  {what}: status {got}, code {result.error_code}, {result.error_string!r}")
    has(got == status and result.error_code == code and text in result.error_string, f"{what}: {told}")


def three_kinds(arms, names):
    """Degrees 3 and 5 and bare positions; the joints in another order than the robot's."""
    turn = np.array([0.4, 0.1, -0.05, 0.1, -0.3, 0.2])
    order = [3, 0, 5, 1, 4, 2]
    at = HOME
    for kind, by in (("quintic", turn), ("cubic", -turn), ("bare", 0.5 * turn)):
        times, q, v, a = swing(at, by)
        told = [q[:, order], v[:, order] if kind != "bare" else None, a[:, order] if kind == "quintic" else None]
        expect(
            arms.follow("left", goal([names[k] for k in order], times, *told)),
            GoalStatus.STATUS_SUCCEEDED, RESULT.SUCCESSFUL, "", f"a goal of {kind} points",
        )
        has(len(arms.feedback) > 10, f"{len(arms.feedback)} messages of feedback")
        last = arms.feedback[-1]
        has(list(last.joint_names) == [names[k] for k in order], "feedback is of other joints")
        has(max(abs(e) for e in last.error.positions) < 0.05, "an error of more than 0.05 rad")
        at = at + by
    return at


def refusals(arms, names, at):
    """None of them moves anything."""
    times, q, v, a = swing(at, [0.1] * 6)
    cases = [
        ("too fast", goal(names, times / 20, q, v * 20, a * 400), RESULT.INVALID_GOAL, "on the way to point 2, at most"),
        ("beyond a limit", goal(names, *swing(at, [0, 1.0, 0, 0, 0, 0], 20.0)), RESULT.INVALID_GOAL, "position"),
        ("a joint that is not there", goal(["elbow", *names[1:]], times, q, v, a), RESULT.INVALID_JOINTS, "elbow"),
        ("a joint left out", goal(names[1:], times, q[:, 1:], v[:, 1:], a[:, 1:]), RESULT.INVALID_JOINTS, "missing"),
        ("a joint twice", goal([names[1], *names[1:]], times, q, v, a), RESULT.INVALID_JOINTS, "twice"),
        ("no number", goal(names, times, q * [np.nan, 1, 1, 1, 1, 1], v, a), RESULT.INVALID_GOAL, "no finite number"),
        ("times that fall", goal(names, times[::-1], q, v, a), RESULT.INVALID_GOAL, "times must rise"),
        ("no points", goal(names, [], []), RESULT.INVALID_GOAL, "no points"),
        ("elsewhere", goal(names, times, q + 0.2, v, a), RESULT.INVALID_GOAL, "plan from where the robot is"),
        ("still moving at the end", goal(names, times[:3], q[:3], v[:3], a[:3]), RESULT.INVALID_GOAL, "at rest there"),
    ]
    old = goal(names, times, q, v, a)
    old.trajectory.header.stamp.sec = 1000
    efforts = goal(names, times, q, v, a)
    efforts.trajectory.points[0].effort = [1.0] * 6
    several = goal(names, times, q, v, a)
    several.multi_dof_trajectory = MultiDOFJointTrajectory(joint_names=["base"])
    stranger = goal(names, times, q, v, a, [JointTolerance(name="elbow", position=0.1)])
    cases += [
        ("of the past", old, RESULT.OLD_HEADER_TIMESTAMP, "in the past"),
        ("with efforts", efforts, RESULT.INVALID_GOAL, "efforts"),
        ("of joints with several degrees of freedom", several, RESULT.INVALID_GOAL, "one degree of freedom"),
        ("a tolerance of another joint", stranger, RESULT.INVALID_JOINTS, "elbow"),
    ]
    for what, one, code, text in cases:
        expect(arms.follow("left", one), GoalStatus.STATUS_ABORTED, code, text, what)


def begins_with(*options):
    """A bridge begins, whatever it offers."""
    bridge = subprocess.Popen([EXAMPLES / "goals_bridge", "--cell", CELL, *options], stderr=subprocess.PIPE, text=True, preexec_fn=interruptible)
    said = bridge.stderr.readline()
    bridge.kill()
    bridge.wait()
    has(said.startswith("node /cell: domain"), f"a bridge with {options}: {said}")


def test(folder):
    begins_with()
    begins_with("--goals")
    bridge = subprocess.Popen(
        [EXAMPLES / "goals_bridge", "--cell", CELL, "--goals", "--buttons"], stderr=subprocess.PIPE, text=True, preexec_fn=interruptible
    )
    has("with goals" in bridge.stderr.readline(), "the bridge does not begin")
    options = ["--processes", "--no-picture", "--quiet", "--record", folder / "run.mcap", "--outcome", folder / "outcome.json"]
    cell = subprocess.Popen([EXAMPLES / "goals", "--cell", CELL, *options], preexec_fn=interruptible)
    arms = Arms()
    names = ["column", "lower_arm", "upper_arm", "wrist_t", "wrist_v", "flange_n"]
    both = [f"{arm}/{name}" for arm in ("left", "right") for name in names]
    with ended_after(cell, bridge):
        arms.spin(3.0)
        at = three_kinds(arms, names)
        refusals(arms, names, at)

        times, q, v, a = swing(at, -(at - HOME), 3.0, 31)
        running = arms.send("left", goal(names, times, q, v, a))
        arms.spin(1.0)
        cancelled = running.cancel_goal_async()
        arms.until(cancelled.done, "an answer to a cancellation")
        has(len(cancelled.result().goals_canceling) == 1, "the cancellation is refused")
        expect(arms.outcome(running), GoalStatus.STATUS_CANCELED, RESULT.SUCCESSFUL, "rest on their path", "a goal that is cancelled")
        rest = np.array(arms.feedback[-1].desired.positions)
        has(np.abs(rest - HOME).max() > 0.02, "a goal that is cancelled ran to its end")

        # From where the arm rests: the first point is a time away.
        arms.spin(0.5)
        first = arms.send("left", goal(names, [2.0], [HOME]))
        arms.spin(0.8)
        second = arms.send("left", goal(names, [2.5], [HOME + 0.05]))
        expect(arms.outcome(first), GoalStatus.STATUS_ABORTED, RESULT.INVALID_GOAL, "replaced", "a goal that is replaced")
        expect(arms.outcome(second), GoalStatus.STATUS_SUCCEEDED, RESULT.SUCCESSFUL, "", "the one that replaces it")

        expect(
            arms.follow("left", goal(names, [2.0], [HOME], tolerances=[JointTolerance(name=names[0], position=1e-7)])),
            GoalStatus.STATUS_ABORTED, RESULT.PATH_TOLERANCE_VIOLATED, names[0], "a tolerance that no drive keeps",
        )
        expect(arms.follow("both", goal(both, [2.0], [np.concatenate([HOME, HOME])])), GoalStatus.STATUS_SUCCEEDED, 0, "", "both arms go home")

        times, q, v, a = swing(HOME, TURN, 3.0, 31)
        twice = lambda x: np.hstack([x, x])  # noqa: E731
        together = arms.send("both", goal(both, times, twice(q), twice(v), twice(a)))
        arms.spin(0.8)
        has(arms.press("suspend").success, "suspend is refused")
        arms.spin(1.0)
        has(arms.press("resume").success, "resume is refused")
        shared = arms.follow("left", goal(names, [2.0], [HOME]))
        expect(shared, GoalStatus.STATUS_ABORTED, RESULT.INVALID_GOAL, "other robots", "a goal for one arm of two that move together")
        expect(arms.outcome(together), GoalStatus.STATUS_SUCCEEDED, 0, "", "one goal for both arms, with a suspension within")

        back = arms.send("both", goal(both, times, twice(q[::-1]), twice(-v[::-1]), twice(a[::-1])))
        arms.spin(1.0)
        arms.until(back.cancel_goal_async().done, "a cancellation")
        expect(arms.outcome(back), GoalStatus.STATUS_CANCELED, 0, "", "one goal for both arms, cancelled")

        away = arms.send("both", goal(both, [3.0], [twice(HOME + 1.5 * TURN)]))
        arms.spin(1.0)
        has(arms.press("stop").success, "stop is refused")
        ended = arms.outcome(away)
        expect(ended, GoalStatus.STATUS_ABORTED, RESULT.INVALID_GOAL, "the cell has stopped", "a goal that a stop ends")
        stopped = int(re.search(r"at step (\d+)", ended[1].error_string)[1])
        has(arms.press("acknowledge").success and arms.press("reset").success, "a reset is refused")
        arms.spin(1.5)
        expect(arms.follow("both", goal(both, [2.0], [np.concatenate([HOME, HOME])])), GoalStatus.STATUS_SUCCEEDED, 0, "", "after a reset")

        print("  a killed bridge:")
        arms.send("left", goal(names, [4.0], [HOME + 0.1]))
        arms.spin(1.0)
        bridge.kill()
        bridge.wait()
        time.sleep(1.0)
        has(cell.poll() is None, "the cell ended with its bridge")
    outcome = Outcome(folder / "outcome.json")
    print(f"    {outcome}")
    has("goals" in str(outcome), f"the cell ended by {outcome}")
    compare(*demanded(folder / "run.mcap"), stopped)
    again = subprocess.run([EXAMPLES / "goals", "replay", folder / "run.mcap", "--cell", CELL], capture_output=True, text=True)
    has(again.returncode == 0 and "identical" in again.stdout, f"the replay: {again.stdout}{again.stderr}")
    print(f"  replay: {again.stdout.strip()}")


def compare(steps, moving, bridged, stopped):
    """Arms of one goal are one in each step, on the goal's straight line in their joints, also where it is suspended, cancelled or stopped.

    In real time an arm may have to go on without a demand: it is then off its path by at most the bound of row 6.3 of SAFETY.md. After the reset they begin
    where their encoders say that they are, which differs.
    """
    left, right = steps["left"], steps["right"]
    # The right arm goes home from where its encoders say that it is, by some microradians, and that is no motion.
    moves = lambda of, k: np.abs(of[k] - of[k - 1]).max() > 1e-6  # noqa: E731
    known = left.keys() & right.keys()
    at_work = [k for k in known if all({k, k - 1, k - 2} <= of for of in moving.values()) and k < stopped + 500]
    together = [k for k in at_work if moves(left, k) and moves(right, k)]
    apart = {k: np.abs(left[k] - right[k]).max() for k in together}
    beside = {k: off_line(left[k] - HOME, TURN) for k in together}
    bounds = {k: late_bound(steps, bridged, k) for k in together}
    punctual, straight = (max(of[k] for k in together if bounds[k] is None) for of in (apart, beside))
    print(f"  {len(together)} steps in which both arms move: {punctual:.1e} rad apart, {straight:.1e} rad beside the line")
    late = {k: max(apart[k], beside[k]) / bounds[k] for k in together if bounds[k] is not None}
    if late:
        worst = max(late, key=late.get)
        print(f"  and {len(late)} steps during and after missed demands: at most {late[worst]:.2f} of their bound, {late[worst] * bounds[worst]:.1e} of {bounds[worst]:.1e} rad")
    has(len(together) > 2000 and punctual < ROUNDING and straight < ROUNDING, "arms of one goal are not one")
    has(all(share <= 1 for share in late.values()), "arms of one goal are farther apart, or off their line, than row 6.3 of SAFETY.md says")
    for arm, told in steps.items():
        thrice = [k for k in told if k <= stopped and k - 1 in told and k - 2 in told]
        most = max(np.abs(told[k] - 2 * told[k - 1] + told[k - 2]).max() for k in thrice) / STEP**2
        print(f"  {arm}: at most {most:.3f} rad/s^2 in {len(thrice)} demands, of 7")
        has(most < 7.0 * (1 + 1e-6), f"{arm}: {most} rad/s^2")


def late_bound(steps, bridged, k):
    """How far apart two arms of one goal may be in step `k` [rad], as row 6.3 of SAFETY.md says of each: 8 a t² after a time t without demands.

    Time that was missed counts until the arm is back on its path, for 20 steps; `a` is the path's largest acceleration around then. Without missed
    demands there is no bound: the arms are one.
    """
    around = range(k - 20, k + 1)
    missed = [sum(i in bridged[arm] for i in around) for arm in steps]
    if not any(missed):
        return None
    known = [
        np.abs(of[i] - 2 * of[i - 1] + of[i - 2]).max() for arm, of in steps.items() for i in range(k - 22, k + 23)
        if all(i - n in of and i - n not in bridged[arm] for n in range(3))
    ]
    return ROUNDING + 8 * max(known) * sum(n * n for n in missed)


def off_line(vector, line):
    line = line / np.linalg.norm(line)
    return np.abs(vector - line * (vector @ line)).max()


rclpy.init()
run("arms follow trajectories of rclpy", test)
