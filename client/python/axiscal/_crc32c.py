"""CRC-32C (Castagnoli, RFC 3720) of the bytes of a chunk or program, as core/base/crc32c.h computes it.

The bytes are cut into lanes of 256 which advance together in numpy; the lanes' remainders are then combined, because a CRC is linear over
GF(2). A chunk of 64 KB takes about 2 ms; a loop over its bytes would take twenty times as long.
"""
import functools

import numpy as np
import numpy.typing as npt

_POLYNOMIAL = 0x82F63B78  # bits reversed
_LANE = 256  # bytes


def _table() -> "npt.NDArray[np.uint32]":
    table = np.arange(256, dtype=np.uint32)
    for _ in range(8):
        table = np.where(table & 1, (table >> 1) ^ np.uint32(_POLYNOMIAL), table >> 1).astype(np.uint32)
    return table


_TABLE = _table()
_TABLE_INTS = [int(entry) for entry in _TABLE]


@functools.lru_cache(maxsize=1)
def _over_a_lane() -> "list[list[int]]":
    """What each value of each byte of a remainder becomes over a lane of zero bytes."""
    state = np.concatenate([np.arange(256, dtype=np.uint32) << np.uint32(8 * byte) for byte in range(4)])
    for _ in range(_LANE):
        state = _TABLE[state & 0xFF] ^ (state >> 8)
    return [[int(entry) for entry in state[256 * byte:256 * (byte + 1)]] for byte in range(4)]


def crc32c(data: bytes, crc: int = 0) -> int:
    """The CRC of what `crc` stands for, followed by `data`."""
    crc ^= 0xFFFFFFFF
    lanes = len(data) // _LANE
    if lanes >= 4:
        columns = np.ascontiguousarray(np.frombuffer(data, np.uint8, lanes * _LANE).reshape(lanes, _LANE).T)
        state = np.zeros(lanes, np.uint32)
        for column in columns:
            state = _TABLE[(state ^ column) & 0xFF] ^ (state >> 8)
        by_byte = _over_a_lane()
        for remainder in state.tolist():
            crc = (by_byte[0][crc & 0xFF] ^ by_byte[1][crc >> 8 & 0xFF] ^ by_byte[2][crc >> 16 & 0xFF] ^
                   by_byte[3][crc >> 24] ^ remainder)
        data = data[lanes * _LANE:]
    for byte in data:
        crc = _TABLE_INTS[(crc ^ byte) & 0xFF] ^ crc >> 8
    return crc ^ 0xFFFFFFFF
