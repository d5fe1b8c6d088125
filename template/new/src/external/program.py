"""Measures what the sensor `@NAME@` of the cell reads, and sends it. Needs @NEEDS@:

    python3 @NAME@.py
"""

import time
from typing import Optional

from @NAME@_port import RATE_HZ, Order, Port, Reading


def measure(order: Optional[Order]) -> Reading:
    """One reading. Write here how it is measured; what the cell ordered last may say for which robot, and of what."""
    return @EXAMPLE@


def main() -> None:
    with Port() as port:
        while True:
            began = time.monotonic_ns()  # a reading is as old as this
            order = port.order()
            port.send(measure(order), began, order)
            time.sleep(max(0.0, 1 / RATE_HZ - (time.monotonic_ns() - began) / 1e9))


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
