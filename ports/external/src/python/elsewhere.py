class OtherMessages(Exception):
    """The cell has messages of another version."""


class Port:
    """This program's end of the way to the cell, which is on another machine; one program at a time may send.

    `certificates` is the folder that `certificates` has made for this sensor; beside this file unless it is said. The cell need not
    be there yet: it is called until it is, and again when it is gone.
    """

    def __init__(self, certificates: Optional[str] = None) -> None:
        folder = certificates or os.path.join(os.path.dirname(os.path.abspath(__file__)), "certificates")
        self._program = secrets.randbits(62) + 1
        self._came: Optional[tuple] = None  # whose readings count, when that was sent, and when it came
        self._order: Optional[bytes] = None  # the newest order
        config = zenoh.Config.from_json5(json.dumps(_config(folder)))
        zenoh.try_init_log_from_env()
        self._session = zenoh.open(config)
        key = f"mrroc/@sensor/{SENSOR}"
        self._readings = self._session.declare_publisher(
            f"{key}/readings", congestion_control=zenoh.CongestionControl.DROP, priority=zenoh.Priority.REAL_TIME, express=True
        )
        self._orders = self._session.declare_subscriber(f"{key}/orders", self._hear)
        self._token = self._session.liveliness().declare_token(f"{key}/@program/{self._program}")

    def _hear(self, sample: Any) -> None:
        now, said = time.monotonic_ns(), sample.payload.to_bytes()
        self._came = (*struct.unpack_from("<QQ", said), now)
        if len(said) > 16:
            self._order = said[16:]

    def _newest(self) -> Optional[tuple]:
        """When the newest word of the cell was sent, by its clock, and when it came, by this one."""
        if self._came is None:
            return None
        holder, sent, came = self._came
        if holder not in (0, self._program):
            raise SecondWriter(f"another program sends what `{SENSOR}` reads; end it first")
        return sent, came

    def order(self) -> Optional[Order]:
        """The newest order of the cell; None before the first one."""
        self._newest()
        if self._order is None:
            return None
        if len(self._order) != ctypes.sizeof(_Message):
            raise OtherMessages(f"the cell has messages of {len(self._order)} bytes, this module of {ctypes.sizeof(_Message)}")
        return _order(_Message.from_buffer_copy(self._order))

    def send(self, reading: Reading, measured_at: int, order: Optional[Order] = None) -> None:
        """Sends what was measured at a time of time.monotonic_ns(), for an order if it was measured for one.

        Nothing is sent before the cell is there: nobody waits for it.
        """
        newest = self._newest()
        if newest:
            head = struct.pack("<QQQ", self._program, *newest)
            self._readings.put(head + bytes(_message(reading, measured_at, order)))

    def close(self) -> None:
        """Gives the port back."""
        self._session.close()

    def __enter__(self) -> "Port":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()


def _config(folder: str) -> dict:
    """zenoh's configuration: one connection, to the cell, with certificates of both sides."""
    name = f"sensor.{SENSOR}"
    files = {file: os.path.join(folder, file) for file in ("authority.pem", f"{name}.pem", f"{name}.key")}
    for file in files.values():
        if not os.path.isfile(file):
            raise FileNotFoundError(f"{file}: make certificates by `certificates FOLDER`, and copy FOLDER/{name} to {folder}")
    if os.stat(files[f"{name}.key"]).st_mode & 0o077:
        raise PermissionError(f"others may read {files[f'{name}.key']}: chmod 600")
    return {
        "mode": "peer",
        "listen": {"endpoints": []},
        "connect": {
            "endpoints": [f"quic/{ADDRESS}"],
            "timeout_ms": -1,
            "exit_on_failure": False,
            "retry": {"period_init_ms": 200, "period_max_ms": 1000, "period_increase_factor": 2},
        },
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "timestamping": {"enabled": False},
        "transport": {
            "unicast": {"lowlatency": True, "qos": {"enabled": False}, "max_links": 1},
            "link": {
                "protocols": ["quic"],
                "tx": {"lease": 300, "keep_alive": 4},
                "tls": {
                    "root_ca_certificate": files["authority.pem"],
                    "connect_private_key": files[f"{name}.key"],
                    "connect_certificate": files[f"{name}.pem"],
                    "enable_mtls": True,
                    "verify_name_on_connect": True,
                    "close_link_on_expiration": False,
                },
            },
        },
    }
