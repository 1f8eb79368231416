"""Where a flight is sent while it flies: `flightgear[:host[:port]]`, checked before it is flown."""

from __future__ import annotations

import socket
from typing import NamedTuple

from uavftc.errors import InputError

FLIGHTGEAR = "flightgear"
HOST, PORT = "127.0.0.1", 5550


class Target(NamedTuple):
    """An address of UDP."""

    family: int
    address: tuple[str, int]


def target_of(text: str) -> Target:
    """Return the address that `--live` names.

    Raises
    ------
    InputError
        If it is no such text, the port is none, or the host has no address.
    """
    where = f"--live {text[:100]}"
    program, _, rest = text.partition(":")
    if program != FLIGHTGEAR:
        expected = "flightgear, flightgear:HOST or flightgear:HOST:PORT"
        raise InputError(where, found=f"'{program[:60]}'", expected=expected, remedy="write --live flightgear")
    if rest.startswith("["):  # [::1]:5550
        host, _, after = rest[1:].partition("]")
        port_text = after.removeprefix(":")
    else:
        host, _, port_text = rest.partition(":")
    port = PORT
    if port_text:
        port = int(port_text) if port_text.isascii() and port_text.isdigit() and len(port_text) < 6 else 0
        if not 1 <= port <= 65535:
            remedy = "write flightgear:127.0.0.1:5550"
            raise InputError(where, found=f"the port '{port_text[:20]}'", expected="1 to 65535", remedy=remedy)
    try:
        family, _, _, _, address = socket.getaddrinfo(host or HOST, port, type=socket.SOCK_DGRAM)[0]
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        found = f"the host '{host[:60]}', which has no address: {reason}"
        remedy = "check its spelling; without a host it is this computer"
        raise InputError(where, found=found, expected="a host of this network", remedy=remedy) from None
    return Target(family, (str(address[0]), int(address[1])))
