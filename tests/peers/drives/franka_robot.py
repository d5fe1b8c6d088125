"""A simulated Franka on this machine's loopback, as an FR3 with its control interface: franka-sim or franky-sim.

franka-sim enforces what the robot enforces: limits of joint positions, velocities, accelerations and jerks, and the reflex after 20
answers that do not come. franky-sim enforces nothing, and is by another author. Both simulate physics by MuJoCo.

It says where it is when it is ready. For each line that it reads it prints what it saw since the last one, as one line of JSON, and
ends where its input ends.
`drop N` drops N answers in a row from then on, again and again while the arm moves, before franka-sim sees them.
`feel` and a line of JSON put numbers in the place of the wrench and the frames in franka-sim's states, which has all of the wrench
zero, as franky-sim has; for connections from then on.
"""

import argparse
import importlib.util
import json
import os
import struct
import sys
import tempfile
import threading
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent))
from device_priority import urgent  # noqa: E402

# Threads hand over soon: each millisecond has an answer that is waited for.
sys.setswitchinterval(0.0002)

COMMAND = 371


class Seen:
    """What the robot was told and what became of it."""

    def __init__(self):
        self.told = 0
        self.dropped = 0
        self.gaps = 0
        self.reflexes = []
        self.collision = self.stiffness = self.load = None
        self.connections = 0
        self.motions = 0
        self.fastest = 0.0
        self.largest_acceleration = 0.0
        self.largest_jerk = 0.0
        self.range = None
        self.end = None
        self.end_speed = 0.0
        self._last = None

    def take(self, count, q):
        """An answer that the robot has taken; differences are those of answers to states that follow one another."""
        self.told += 1
        dq = ddq = None
        if self._last is not None and self._last[0] + 1 == count:
            _, before, dq_before, ddq_before = self._last
            dq = [(b - a) * 1e3 for a, b in zip(before, q)]
            self.fastest = max(self.fastest, *map(abs, dq))
            if dq_before is not None:
                ddq = [(b - a) * 1e3 for a, b in zip(dq_before, dq)]
                self.largest_acceleration = max(self.largest_acceleration, *map(abs, ddq))
            if ddq_before is not None:
                jerk = [(b - a) * 1e3 for a, b in zip(ddq_before, ddq)]
                self.largest_jerk = max(self.largest_jerk, *map(abs, jerk))
        self._last = (count, q, dq, ddq)
        self.range = [
            (min(low, a), max(high, a)) for (low, high), a in zip(self.range or [(a, a) for a in q], q)
        ]
        self.end, self.end_speed = q, max(map(abs, dq)) if dq else 0.0

    def report(self):
        known = {name: value for name, value in vars(self).items() if not name.startswith("_")}
        known["range"] = [high - low for low, high in self.range or []]
        return json.dumps(known)


def model():
    """franky-sim's FR3 with its meshes where franka-sim looks for them, which fetches its own from the network otherwise."""
    assets = Path(importlib.util.find_spec("franky_sim").origin).parent / "assets"
    folder = Path(tempfile.mkdtemp())
    (folder / "fr3.xml").write_bytes((assets / "fr3.xml").read_bytes())
    (folder / "assets").symlink_to(assets / "meshes")
    return str(folder / "fr3.xml")


def franka_sim(options, seen):
    os.environ["FR3_MJCF"] = model()
    from franka_sim import FrankaSimServer
    from franka_sim.server import state_stream

    class Lossy(state_stream.socket.socket):
        """Drops so many answers in a row, every 300 answers with which the arm moves."""

        before, moving, dropping = None, 0, 0

        def recvfrom(self, size):
            data, sender = super().recvfrom(size)
            if not options.drop or len(data) != COMMAND:
                return data, sender
            q = struct.unpack_from("<7d", data, 8)
            moves = self.before is not None and max(abs(a - b) for a, b in zip(q, self.before)) > 5e-5
            self.before = q
            if self.dropping == 0:
                self.moving += moves
                if self.moving == 300:
                    self.moving, self.dropping = 0, options.drop
                    seen.gaps += 1
            if self.dropping > 0:
                self.dropping -= 1
                seen.dropped += 1
                raise BlockingIOError
            return data, sender

    class Socket:
        """The module's sockets, with these in place of its own."""

        def __getattr__(self, name):
            return getattr(state_stream_socket, name)

        socket = Lossy

    state_stream_socket, state_stream.socket = state_stream.socket, Socket()

    ready = threading.Event()

    class Robot(FrankaSimServer):
        def _dispatch_control_command(self, command, **others):
            if not command.get("extrapolated"):
                seen.take(command["message_id"], command["q_c"])
            return super()._dispatch_control_command(command, **others)

        def run_server(self):
            ready.set()
            return super().run_server()

        def handle_client(self, client):
            seen.connections += 1
            return super().handle_client(client)

        def reset_state(self):
            super().reset_state()
            self.robot_state.state.update(options.feels)
            # It computes F_T_EE from what is known of the hand.
            self._refresh_ee_transform()

        def handle_move_command(self, *arguments):
            seen.motions += 1
            return super().handle_move_command(*arguments)

        def handle_set_collision_behavior_command(self, client, header, payload):
            seen.collision = struct.unpack("<52d", payload)
            return super().handle_set_collision_behavior_command(client, header, payload)

        def handle_set_joint_impedance_command(self, client, header, payload):
            seen.stiffness = struct.unpack("<7d", payload)
            return super().handle_set_joint_impedance_command(client, header, payload)

        def handle_set_load_command(self, client, header, payload):
            seen.load = struct.unpack("<13d", payload)
            return super().handle_set_load_command(client, header, payload)

        def _abort_with_error(self, *arguments, **others):
            seen.reflexes.append(f"{others or arguments[:2]} after {seen.told} answers, at {seen.end_speed:.3f} rad/s")
            return super()._abort_with_error(*arguments, **others)

    robot = Robot(
        host=options.address,
        port=1337,
        enable_gripper=False,
        physics="mujoco",
        enforce_comm_constraints=True,
        enforce_motion_limits=True,
    )
    threading.Thread(target=robot.start, daemon=True).start()
    ready.wait(60)
    return robot.stop


def franky_sim(options, seen):
    import franky_sim as franky
    from franky_sim.run_server import load_simulator

    simulator, _ = load_simulator("mujoco")
    entered = simulator(enable_visualization=False)
    simulation = entered.__enter__()
    simulation.add_robot()
    server = franky.SimulationServer(simulation, hostname_candidates=[options.address])
    server.__enter__()
    threading.Thread(target=server.run_forever, daemon=True).start()
    return lambda: None


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("simulator", choices=["franka-sim", "franky-sim"])
    parser.add_argument("--address", default="127.0.0.1")
    options = parser.parse_args()
    # Before other programs of this machine, on a core that the cell leaves alone. Where that is not permitted, it runs as they do.
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:1])
    urgent()
    options.drop, options.feels = 0, {}
    seen = Seen()
    stop = {"franka-sim": franka_sim, "franky-sim": franky_sim}[options.simulator](options, seen)
    print(f"a simulated Franka at {options.address}", flush=True)
    for line in sys.stdin:
        print(seen.report(), flush=True)
        seen.__init__()
        if line.startswith("drop "):
            options.drop = int(line.split()[1])
        elif line.startswith("feel "):
            options.feels = json.loads(line.removeprefix("feel "))
    threading.Timer(5, os._exit, [0]).start()
    stop()
    os._exit(0)


if __name__ == "__main__":
    main()
