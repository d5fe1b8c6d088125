class Port:
    """The two ends that this program has of the port; one program at a time may send."""

    def __init__(self) -> None:
        self._node = _node()
        try:
            self._readings = self._service("readings").publisher_builder().create()
        except iox2.PublisherCreateError:
            raise SecondWriter(f"another program sends what `{PORT}` reads; end it first") from None
        self._orders = self._service("orders").subscriber_builder().create()
        self._order = None

    def _service(self, direction: str) -> Any:
        return _channel(self._node, f"mrroc/{PORT}/{direction}", _Message, 1)

    def order(self) -> Optional[Order]:
        """The newest order of the cell; None before the first one."""
        while (sample := self._orders.receive()) is not None:
            self._order = _order(sample.payload().contents)
        return self._order

    def send(self, reading: Reading, measured_at: int, order: Optional[Order] = None) -> None:
        """Sends what was measured at a time of time.monotonic_ns(), for an order if it was measured for one."""
        self._readings.send_copy(_message(reading, measured_at, order))

    def close(self) -> None:
        """Gives the port back."""
        for end in (self._readings, self._orders):
            end.delete()
        del self._readings, self._orders, self._node

    def __enter__(self) -> "Port":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()
