def _get(shape: Any, words: Iterator) -> Any:
    """Reads a value from words."""
    if shape == "float":
        return struct.unpack("<d", struct.pack("<Q", next(words)))[0]
    if shape == "single":
        return struct.unpack("<f", struct.pack("<I", next(words)))[0]
    if shape == "unsigned":
        return next(words)
    if shape == "signed":
        return struct.unpack("<q", struct.pack("<Q", next(words)))[0]
    if shape == "truth":
        return next(words) != 0
    if shape[0] == "words":
        return tuple(next(words) for _ in range(shape[1]))
    if shape[0] == "choice":
        return shape[1](next(words))
    if shape[0] == "array":
        return tuple(_get(shape[1], words) for _ in range(shape[2]))
    return shape[1](*(_get(part, words) for part in shape[2]))
