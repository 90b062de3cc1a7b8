"""Who a client is for limits: one machine, or the network that one household or school has."""

import ipaddress

UNKNOWN = 1  # what is gone already


def network_of(peer: tuple | None) -> int:
    """Of a socket's peer → 64 bits, not 0. An IPv6 network has 2^64 addresses, any of which one machine may take: its
    first half counts, but of link-local addresses, which all begin alike, the second."""
    if not peer:
        return UNKNOWN
    address = ipaddress.ip_address(peer[0])
    if isinstance(address, ipaddress.IPv6Address) and address.ipv4_mapped is not None:
        address = address.ipv4_mapped
    if isinstance(address, ipaddress.IPv4Address):
        return 0xFFFF << 32 | int(address)
    first, second = divmod(int(address), 1 << 64)
    return (second if address.is_link_local else first) or UNKNOWN
