# SPDX-License-Identifier: BSD-3-Clause
"""Reads MCAP files and messages of ROS 2 by their specifications (mcap.dev/spec, OMG CDR), sharing nothing with the
programs under test: every chunk, checksum, index and count is checked on the way."""
import ctypes
import ctypes.util
import struct
import zlib

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(1, 9)
ATTACHMENT, ATTACHMENT_INDEX, STATISTICS, DATA_END, SUMMARY_OFFSET = 0x09, 0x0A, 0x0B, 0x0F, 0x0E


class Cursor:
    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, count):
        assert self.at + count <= len(self.data), "a record ends early"
        self.at += count
        return self.data[self.at - count:self.at]

    def number(self, form):
        return struct.unpack("<" + form, self.take(struct.calcsize("<" + form)))[0]

    def text(self):
        return self.take(self.number("I")).decode()

    def text_map(self):
        end, found = self.number("I") + self.at, {}
        while self.at < end:
            key = self.text()
            found[key] = self.text()
        return found

    def rest(self):
        return self.take(len(self.data) - self.at)


def unpack(compression, data, size):
    if compression == "":
        return data
    assert compression == "zstd", f"compression '{compression}'"
    library = ctypes.CDLL(ctypes.util.find_library("zstd"))
    library.ZSTD_decompress.restype = ctypes.c_size_t
    out = ctypes.create_string_buffer(size)
    assert library.ZSTD_decompress(out, ctypes.c_size_t(size), data, ctypes.c_size_t(len(data))) == size, "a chunk is corrupt"
    return out.raw


def find_records(data, offset=0):
    """Yields (opcode, contents, offset of the record)."""
    while offset < len(data):
        opcode, size = struct.unpack_from("<BQ", data, offset)
        yield opcode, data[offset + 9:offset + 9 + size], offset
        offset += 9 + size


class File:
    """profile, schemas, channels: as in the file. messages: [(channel, log time in ns, bytes)]. attachments: name -> bytes."""

    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        assert data[:8] == MAGIC and data[-8:] == MAGIC, "no magic at both ends"
        self.profile, self.schemas, self.channels, self.messages, self.attachments = "", {}, {}, [], {}
        self.chunk_count, self.statistics, indexed = 0, None, []
        for opcode, contents, offset in find_records(data[:-8], 8):
            cursor = Cursor(contents)
            if opcode == HEADER:
                self.profile = cursor.text()
            elif opcode in (SCHEMA, CHANNEL):
                self.define(opcode, cursor)
            elif opcode == CHUNK:
                self.take_chunk(cursor)
            elif opcode == ATTACHMENT:
                self.take_attachment(cursor, contents)
            elif opcode == ATTACHMENT_INDEX:
                indexed.append((cursor.number("Q"), cursor.number("Q"), cursor.number("Q"), cursor.number("Q"), cursor.number("Q"),
                                cursor.text(), cursor.text()))
            elif opcode == STATISTICS:
                self.statistics = [cursor.number(form) for form in "QHIIIIQQ"]
            elif opcode == DATA_END:
                assert cursor.number("I") == zlib.crc32(data[:offset]), "checksum of the data section"
            elif opcode == FOOTER:
                summary, crc = cursor.number("Q"), struct.unpack_from("<I", contents, 16)[0]
                assert crc == zlib.crc32(data[summary:offset + 9 + 16]), "checksum of the summary"
        counts = [len(self.messages), len(self.schemas), len(self.channels), len(self.attachments), 0, self.chunk_count]
        assert self.statistics[:6] == counts, f"statistics {self.statistics[:6]}, counted {counts}"
        for offset, length, _, _, size, name, _ in indexed:
            assert data[offset] == ATTACHMENT and struct.unpack_from("<Q", data, offset + 1)[0] == length - 9
            assert size == len(self.attachments[name]), name
        assert len(indexed) == len(self.attachments), "every attachment has its index"

    def define(self, opcode, cursor):
        number = cursor.number("H")
        if opcode == SCHEMA:
            self.schemas[number] = {"name": cursor.text(), "encoding": cursor.text(), "text": cursor.text()}
        else:
            self.channels[number] = {"schema": self.schemas[cursor.number("H")], "topic": cursor.text(), "encoding": cursor.text(),
                                     "metadata": cursor.text_map()}

    def take_chunk(self, cursor):
        self.chunk_count += 1
        start, end, size, crc = (cursor.number(form) for form in "QQQI")
        compression = cursor.text()
        plain = unpack(compression, cursor.take(cursor.number("Q")), size)
        assert crc == zlib.crc32(plain), "checksum of a chunk"
        for opcode, contents, _ in find_records(plain):
            inner = Cursor(contents)
            if opcode in (SCHEMA, CHANNEL):
                self.define(opcode, inner)
                continue
            channel, _, time, _ = (inner.number(form) for form in "HIQQ")
            assert start <= time <= end, "a message lies outside of its chunk's times"
            self.messages.append((self.channels[channel], time, inner.rest()))

    def take_attachment(self, cursor, contents):
        cursor.number("Q"), cursor.number("Q")
        name, _ = cursor.text(), cursor.text()
        self.attachments[name] = cursor.take(cursor.number("Q"))
        assert cursor.number("I") == zlib.crc32(contents[:-4]), "checksum of an attachment"

    def topic(self, name):
        """[(time in s, bytes)] of a topic."""
        return [(time * 1e-9, data) for channel, time, data in self.messages if channel["topic"] == name]

    def find_channel(self, name):
        found = [channel for channel in self.channels.values() if channel["topic"] == name]
        assert len(found) == 1, f"{len(found)} channels of {name}"
        return found[0]


FORMS = {"bool": "?", "byte": "B", "char": "B", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I",
         "int64": "q", "uint64": "Q", "float32": "f", "float64": "d"}


def full_name(name, package):
    parts = name.split("/")
    return f"{parts[0]}/{parts[-1]}" if len(parts) > 1 else f"{package}/{name}"


def parse_ros2msg(name, text):
    """Full name without msg -> [(type, list: None, "" or a size, field)]."""
    parts, current = {}, full_name(name, "")
    for line in text.splitlines():
        line = line.split("#")[0].strip()
        if line.startswith("MSG: "):
            current = full_name(line[5:], "")
        elif line and not line.startswith("===="):
            kind, field = line.split()[:2]
            base, _, size = kind.partition("[")
            base = base if base in FORMS or base == "string" else full_name(base, current.split("/")[0])
            parts.setdefault(current, []).append((base, size[:-1] if size else None, field))
    return parts


class Decoder:
    """CDR of a type by its ros2msg text: message -> nested dict."""

    def __init__(self, schema):
        self.root = full_name(schema["name"], "")
        self.parts = parse_ros2msg(schema["name"], schema["text"])

    def read(self, data):
        assert data[:4] == b"\x00\x01\x00\x00", "plain CDR, little endian"
        self.data, self.at = data[4:], 0
        value = self.read_message(self.root)
        assert len(self.data) - self.at < 4, "bytes are left over"
        return value

    def basic(self, form):
        size = struct.calcsize("<" + form)
        self.at += -self.at % size
        self.at += size
        return struct.unpack_from("<" + form, self.data, self.at - size)[0]

    def read_value(self, base):
        if base == "string":
            size = self.basic("I")
            self.at += size
            return self.data[self.at - size:self.at - 1].decode()
        return self.basic(FORMS[base]) if base in FORMS else self.read_message(base)

    def read_message(self, name):
        message = {}
        for base, size, field in self.parts[name]:
            if size is None:
                message[field] = self.read_value(base)
            else:
                message[field] = [self.read_value(base) for _ in range(int(size) if size else self.basic("I"))]
        return message
