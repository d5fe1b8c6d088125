"""A device with inputs and outputs by pymodbus on this machine's loopback, and a cell that switches them.

    modbus_io.py PROGRAM CELL   runs the program of that file against servers, and says what falls short; ends with 75 where this
                                machine is late
    modbus_io.py --serve        a server, which prints its port, and when it is ended what it saw as a line of JSON

Input 0 follows coil 16 and input 5 follows coil 19, each 20 ms later as a contactor does; the analog input reads the analog output.
"""

import asyncio
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent))
from late import late  # noqa: E402

FOLLOWS = {16: 0, 19: 5}
DELAY = 0.02
COILS, INPUTS = 16, 8
READ_INPUTS, SWITCH, SET = 2, 5, 6


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
    """What the cell says, its exit status, and what the server saw."""
    server = subprocess.Popen([sys.executable, __file__, "--serve"], stdout=subprocess.PIPE, text=True)
    port = int(server.stdout.readline())
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "cell.toml"
        file.write_text(pathlib.Path(cell).read_text().replace("127.0.0.1:1503", f"127.0.0.1:{port}"))
        command = [program, "--cell", str(file), "--processes", "--no-picture"]
        env = {**os.environ, "MRROC_TIMES": str(times)}
        running = subprocess.Popen(command, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if kill_after is not None:
            time.sleep(kill_after)
            server.kill()
        said = running.communicate(timeout=60)[0]
    server.terminate()
    return said, running.returncode, json.loads(server.communicate()[0].strip() or "[]")


def main(program, cell):
    said, status, seen = run(program, cell)
    # The last is said of a server in Python.
    if late(said, "no answer came", "no reading came"):
        sys.exit(75)
    relays = [[SWITCH, 16, True], [SWITCH, 16, False], [SWITCH, 19, True], [SWITCH, 19, False]]
    # 2.5 V of 10 V on 12 bits; where a program stands in between, an output is told once more.
    wanted = relays + [[SET, 0, 1024]]
    once = [what for i, what in enumerate(seen) if i == 0 or what != seen[i - 1]]
    if status != 0 or once != wanted or "pressure: 2.501 V" not in said:
        sys.exit(f"modbus: it ended with {status}, and the device was told {seen}: {said}")
    print(f"modbus: {len(relays)} relays switched and followed, an analog output at 2.5 V read back")
    said, status, _ = run(program, cell, times=100, kill_after=1.5)
    if status != 1 or "communication lost" not in said and "the connection was closed" not in said:
        if late(said):
            sys.exit(75)
        sys.exit(f"modbus: a lost device was not told: {status}: {said}")
    print("modbus:", next(line for line in said.splitlines() if line.startswith("error")))


if __name__ == "__main__":
    if sys.argv[1] == "--serve":
        asyncio.run(serve())
    else:
        main(*sys.argv[1:])
