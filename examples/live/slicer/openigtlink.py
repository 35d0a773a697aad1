"""OpenIGTLink as its protocol document describes it, without the library: the header, and the bodies of the messages that
insonify_slicer sends and takes. Every read checks lengths, padding and checksum."""
import socket
import struct

HEADER = struct.Struct(">H12s20sQQQ")
IMAGE_HEADER = struct.Struct(">HBBBB3H12f3H3H")


def _table():
    for top in range(256):
        rest = top << 56
        for _ in range(8):  # the polynomial of ECMA-182
            rest = (rest << 1 ^ 0x42F0E1EBA9EA3693 if rest >> 63 else rest << 1) & 0xFFFFFFFFFFFFFFFF
        yield rest


TABLE = list(_table())


def crc64(data):
    crc = 0
    for byte in data:
        crc = TABLE[crc >> 56 ^ byte] ^ crc << 8 & 0xFFFFFFFFFFFFFFFF
    return crc


def text(field):
    """A padded field: zeros after the text, and nothing but printable ASCII in it."""
    value = field.rstrip(b"\0")
    assert all(32 <= byte < 127 for byte in value), field
    return value.decode()


def pack(kind, device, body, version=1):
    return HEADER.pack(version, kind.encode(), device.encode(), 0, len(body), crc64(body)) + body


def pack_transform(device, columns):
    """Twelve numbers: the columns of the rotation, then the translation in millimetres."""
    return pack("TRANSFORM", device, struct.pack(">12f", *columns))


def pack_string(device, value):
    return pack("STRING", device, struct.pack(">HH", 3, len(value)) + value.encode())


def pack_command(number, name, value, version=2):
    content = struct.pack(">I128sHI", number, name.encode(), 3, len(value)) + value.encode()
    if version == 1:
        return pack("COMMAND", "test", content)
    return pack("COMMAND", "test", struct.pack(">HHII", 12, 2, 0, 7) + content + b"\0\0", 2)


class Connection:
    def __init__(self, port, seconds=10):
        self.socket = socket.create_connection(("127.0.0.1", port), seconds)

    def close(self):
        self.socket.close()

    def send(self, data):
        self.socket.sendall(data)

    def _exactly(self, size):
        data = bytearray()
        while len(data) < size:
            part = self.socket.recv(min(size - len(data), 1 << 16))
            if not part:
                raise ConnectionError("the server has closed the connection")
            data += part
        return bytes(data)

    def receive(self, check=True):
        """The next message: its type, device, time, version and body."""
        version, kind, device, stamp, size, crc = HEADER.unpack(self._exactly(HEADER.size))
        assert version in (1, 2) and size < 1 << 26, (version, kind, size)
        body = self._exactly(size)
        if check:
            assert crc64(body) == crc, f"{text(kind)}: the checksum is wrong"
        return {"type": text(kind), "device": text(device), "time": stamp / 2**32, "version": version, "body": body}

    def until(self, *kinds, device=None, check=True):
        """The next message of one of the types."""
        while True:
            message = self.receive(check)
            if message["type"] in kinds and device in (None, message["device"]):
                return message


def read_image(body):
    """Size, matrix (the columns i, j, k in mm per pixel and the centre) and rows of gray values."""
    fields = IMAGE_HEADER.unpack_from(body)
    version, components, scalar, endian, coordinates = fields[:5]
    size, matrix, offset, part = fields[5:8], fields[8:20], fields[20:23], fields[23:26]
    assert (version, components, scalar, coordinates) == (1, 1, 3, 1) and endian in (1, 2), fields
    assert offset == (0, 0, 0) and part == size and size[2] == 1, fields
    pixels = body[IMAGE_HEADER.size:]
    assert len(pixels) == size[0] * size[1], (len(pixels), size)
    return size, matrix, pixels


def read_status(body):
    code, sub_code, name = struct.unpack_from(">Hq20s", body)
    assert 1 <= code <= 19 and sub_code == 0
    return code, text(name), body[30:].rstrip(b"\0").decode()


def read_string(body):
    encoding, length = struct.unpack_from(">HH", body)
    assert encoding == 3 and len(body) == 4 + length
    return body[4:].decode()


def read_command(message):
    """Number, name, text and metadata of COMMAND or RTS_COMMAND."""
    body, metadata = message["body"], {}
    if message["version"] == 2:
        extended, index_size, values_size, _ = struct.unpack_from(">HHII", body)
        assert extended == 12
        index = body[len(body) - index_size - values_size:len(body) - values_size]
        values = body[len(body) - values_size:]
        body = body[extended:len(body) - index_size - values_size]
        (count,) = struct.unpack_from(">H", index)
        assert index_size == 2 + 8 * count
        at = 0
        for i in range(count):
            key_size, encoding, value_size = struct.unpack_from(">HHI", index, 2 + 8 * i)
            assert encoding == 3
            metadata[values[at:at + key_size].decode()] = values[at + key_size:at + key_size + value_size].decode()
            at += key_size + value_size
        assert at == values_size
    number, name, encoding, length = struct.unpack_from(">I128sHI", body)
    assert encoding == 3 and len(body) == 138 + length
    return number, text(name), body[138:].decode(), metadata
