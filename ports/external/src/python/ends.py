class OtherMessages(Exception):
    """The port was opened with messages of another version, or is not this user's."""


def _node() -> Any:
    """This program's place among the ports of this user."""
    folder = os.environ.get("MRROC_PORTS") or f"/tmp/mrroc-ports-{os.geteuid()}"
    os.makedirs(folder, mode=0o700, exist_ok=True)
    about = os.lstat(folder)
    if about.st_uid != os.geteuid() or about.st_mode & 0o077:
        raise OtherMessages(f"the folder {folder} of ports is not this user's alone")
    prefix = f"mrroc_ports_{_hash(folder):016x}_"
    iox2.set_log_level(iox2.LogLevel.Fatal)
    config = iox2.config.default()
    config.global_cfg.prefix = iox2.FileName.new(prefix)
    config.global_cfg.root_path = iox2.Path.new(folder)
    builder = iox2.NodeBuilder.new().config(config)
    builder = builder.signal_handling_mode(iox2.SignalHandlingMode.Disabled)
    node = builder.create(iox2.ServiceType.Ipc)
    _close_to_others(prefix)
    return node


def _channel(node: Any, name: str, message: Any, kept: int) -> Any:
    """A service that one program writes."""
    service = node.service_builder(iox2.ServiceName.new(name)).publish_subscribe(message)
    service = service.max_publishers(1).max_subscribers(8).max_nodes(9)
    service = service.history_size(0).subscriber_max_buffer_size(kept).enable_safe_overflow(True)
    try:
        return service.open_or_create()
    except iox2.PublishSubscribeOpenOrCreateError as error:
        raise OtherMessages(f"`{name}` has been opened with other messages: {error}") from None


def _hash(text: str) -> int:
    """FNV-1a."""
    value = 0xCBF29CE484222325
    for byte in text.encode():
        value = ((value ^ byte) * 0x100000001B3) % 2**64
    return value


def _close_to_others(prefix: str) -> None:
    """iceoryx2 lets all users write to one of its segments; nobody but this user may from here on."""
    for name in os.listdir("/dev/shm"):
        if name.startswith(prefix) and name.endswith(".global_mgmt"):
            file = os.open(f"/dev/shm/{name}", os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
            os.fchmod(file, 0o600)
            os.close(file)
