"""A device with inputs and outputs by pymodbus on this machine's loopback, and a cell that switches them.

    modbus_io.py PROGRAM CELL   runs the program of that file against servers, and says what falls short; where this machine was late,
                                what was told in order until then is all that is tested
    modbus_io.py --serve        a server, which prints its port, and when it is ended what it saw as a line of JSON

Input 0 follows coil 16 and input 5 follows coil 19, each 20 ms later as a contactor does; the analog input reads the analog output.
"""

import asyncio
import json
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent))
from cell_outcome import Outcome, Shortfall, has, not_tested  # noqa: E402
from device_priority import urgent  # noqa: E402

FOLLOWS = {16: 0, 19: 5}
DELAY = 0.02
COILS, INPUTS = 16, 8
READ_INPUTS, SWITCH, SET = 2, 5, 6
OFF = [SWITCH, 19, False]


async def serve():
    from pymodbus.server import ModbusTcpServer
    from pymodbus.simulator import DataType, SimData, SimDevice

    seen, pending, inputs = [], [], [False] * INPUTS
    level = [0]

    async def act(function, start, address, count, registers, words):
        now = time.monotonic()
        # What is written is asked for once more, for its answer.
        if function in (SWITCH, SET) and words is None:
            return None
        if function == SWITCH:
            seen.append([SWITCH, address, bool(words[0])])
            if address in FOLLOWS:
                pending.append((now + DELAY, FOLLOWS[address], bool(words[0])))
        elif function == SET:
            seen.append([SET, address, words[0]])
            level[0] = words[0]
        elif function == READ_INPUTS:
            while pending and pending[0][0] <= now:
                _, place, on = pending.pop(0)
                inputs[place] = on
            # Sixteen bits are a register.
            registers[0] = sum(1 << place for place, on in enumerate(inputs) if on)
        elif function == 4:
            registers[address - start] = level[0]
        return None

    def block(address, kind, count=1):
        return [SimData(address, values=[False] * 16 * count if kind == DataType.BITS else [0], datatype=kind)]

    # Coils 16 to 31, inputs 0 to 15, and a register each.
    blocks = block(1, DataType.BITS), block(0, DataType.BITS), block(0, DataType.REGISTERS), block(0, DataType.REGISTERS)
    server = ModbusTcpServer(SimDevice(1, blocks, action=act), address=("127.0.0.1", 0))
    await server.serve_forever(background=True)
    print(server.transport.sockets[0].getsockname()[1], flush=True)
    ended = asyncio.Event()
    asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, ended.set)
    await ended.wait()
    print(json.dumps(seen), flush=True)


def run(program, cell, times=1, kill_after=None):
    """What the cell says, how it ended, and what the server saw."""
    server = subprocess.Popen([sys.executable, __file__, "--serve"], stdout=subprocess.PIPE, text=True, preexec_fn=urgent)
    port = int(server.stdout.readline())
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "cell.toml"
        file.write_text(pathlib.Path(cell).read_text().replace("127.0.0.1:1503", f"127.0.0.1:{port}"))
        told = pathlib.Path(folder) / "outcome.json"
        command = [program, "--cell", str(file), "--processes", "--no-picture", "--outcome", str(told), "--", "--times", str(times)]
        running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if kill_after is not None:
            time.sleep(kill_after)
            server.kill()
        said = running.communicate(timeout=60)[0]
        outcome = Outcome(told, said)
    server.terminate()
    return said, outcome, json.loads(server.communicate()[0].strip() or "[]")


def main(program, cell):
    said, outcome, seen = run(program, cell)
    relays = [[SWITCH, 16, True], [SWITCH, 16, False], [SWITCH, 19, True], [SWITCH, 19, False]]
    # 2.5 V of 10 V on 12 bits; where a program stands in between, an output is told once more.
    wanted = relays + [[SET, 0, 1024]]
    once = [what for i, what in enumerate(seen) if i == 0 or what != seen[i - 1]]
    if outcome.ended_well(controller=True):
        has(once == wanted and "pressure: 2.501 V" in said, f"the device was told {seen}: {said}")
        print(f"modbus: {len(relays)} relays switched and followed, an analog output at 2.5 V read back")
    else:
        # When the cell stops, the second relay goes off.
        stopped = [*once[:-1], *([] if once[-1:] == [OFF] else once[-1:])]
        has(once == wanted[: len(once)] or stopped == wanted[: len(stopped)], f"the device was told {seen}: {said}")
        not_tested("modbus", f"that all relays are switched, and an analog output (it was told {seen})", outcome)
    said, outcome, _ = run(program, cell, times=100, kill_after=1.5)
    is_told = "communication lost" in outcome.text or "the connection was closed" in outcome.text
    has(not outcome.ended_by("RobotStopped") or is_told, f"a lost device was not told: {outcome}")
    if outcome.kind != "RobotStopped":
        not_tested("modbus", "how a device is lost", outcome)
    print(f"modbus: {outcome}")


if __name__ == "__main__":
    if sys.argv[1] == "--serve":
        asyncio.run(serve())
    else:
        try:
            main(*sys.argv[1:])
        except Shortfall as why:
            sys.exit(f"modbus: {why}")
