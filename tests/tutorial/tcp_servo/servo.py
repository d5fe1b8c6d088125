"""A servo: says every 4 ms where it is, and goes where it is told, at most at 2 rad/s. Enter: an emergency stop, or its end."""
import select, socket, struct, sys, time

PERIOD, SPEED = 0.004, 2.0
servo = socket.create_server(("127.0.0.1", int(sys.argv[1]) if len(sys.argv) > 1 else 2000))
servo.setblocking(False)
print("a servo at {}:{}".format(*servo.getsockname()), flush=True)
line, count, position, goal, stopped, begins = None, 0, 0.0, 0.0, 0, time.monotonic()
while True:
    begins += PERIOD
    time.sleep(max(0.0, begins - time.monotonic()))
    if select.select([sys.stdin], [], [], 0)[0] and sys.stdin.readline():
        stopped = 1 - stopped
        print("emergency stop" if stopped else "released", flush=True)
    if select.select([servo], [], [], 0)[0]:
        caller = servo.accept()[0]
        if line:
            caller.close()  # one at a time
        else:
            line, count = caller, 0
            line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    if not line:
        continue
    try:
        while select.select([line], [], [], 0)[0]:
            (goal,) = struct.unpack("<d", line.recv(8) or b"")
        before = position
        if not stopped:
            position += max(-SPEED * PERIOD, min(SPEED * PERIOD, goal - position))
        line.sendall(struct.pack("<QddB", count, position, (position - before) / PERIOD, stopped))
        count += 1
    except (OSError, struct.error):
        line = None
