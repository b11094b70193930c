"""model.png: the FMU as a block with its inputs and outputs, drawn dot by dot."""

from __future__ import annotations

import struct
import zlib

from flexhex.fmus.common.interface import Interface, Variable

# columns of 5 x 8 dots, lowest bit on top, for the characters that names and numbers have
_CHARACTERS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ[]_.-abcdefghijklmnopqrstuvwxyz"
_COLUMNS = bytes.fromhex(
    "3e5149453e00427f40004261514946214145 4b311814127f1027454545393c4a494930"
    "01710905033649494936064949291e7c1211127c7f494949363e414141227f4141413e"
    "7f494949417f090909013e414151737f0808087f00417f41002040413f017f08142241"
    "7f404040407f021c027f7f0408107f3e4141413e7f090909063e4151215e7f09192946"
    "264949493203017f01033f4040403f1f2040201f3f4038403f63140814630304780403"
    "6159494d43007f4141410041 41417f40404040400060600000080808080820545478407f284444383844444428"
    "384444287f385454541800087e090218a4a49c787f0804047800447d40002040403d00"
    "7f1028440000417f40007c047804787c080404783844444438fc1824241818242418fc"
    "7c08040408485454542404043f44243c4040207c1c2040201c3c4030403c4428102844"
    "4c9090907c4464544c44".replace(" ", "")
)
_GLYPHS = {c: _COLUMNS[5 * k : 5 * k + 5] for k, c in enumerate(_CHARACTERS)}
WHITE, INK, BLUE, PALE = 0, 1, 2, 3
_PALETTE = bytes.fromhex("ffffff 222222 1f6fb2 eef4fa".replace(" ", ""))
_WIDTH, _ROW, _HEAD, _EDGE = 560, 26, 70, 150


class _Canvas:
    """Dots of a picture, each an index into the palette."""

    def __init__(self, width: int, height: int) -> None:
        self.width, self.height = width, height
        self.rows = [bytearray(width) for _ in range(height)]

    def fill(self, left: int, top: int, right: int, bottom: int, colour: int) -> None:
        """A rectangle, right and bottom excluded."""
        for row in self.rows[max(top, 0) : bottom]:
            row[left:right] = bytes([colour]) * (right - left)

    def write(self, left: int, top: int, text: str, scale: int, colour: int = INK) -> None:
        """Text from its upper left corner; characters without a glyph stay blank."""
        for k, character in enumerate(text):
            for i, column in enumerate(_GLYPHS.get(character, bytes(5))):
                for j in range(8):
                    if column >> j & 1:
                        x, y = left + scale * (6 * k + i), top + scale * j
                        self.fill(x, y, x + scale, y + scale, colour)

    def arrow(self, left: int, right: int, y: int) -> None:
        """A line to the right with a head."""
        self.fill(left, y, right, y + 2, INK)
        for k in range(7):
            self.fill(right - 7 + k, y - 6 + k, right - 6 + k, y + 8 - k, INK)

    def png(self) -> bytes:
        """The picture as a PNG file."""
        head = struct.pack(">IIBBBBB", self.width, self.height, 8, 3, 0, 0, 0)
        dots = zlib.compress(b"".join(b"\0" + bytes(row) for row in self.rows), 9)
        chunks = ((b"IHDR", head), (b"PLTE", _PALETTE), (b"IDAT", dots), (b"IEND", b""))
        return b"\x89PNG\r\n\x1a\n" + b"".join(
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
            for kind, data in chunks
        )


def _label(variable: Variable) -> str:
    return variable.name if variable.size is None else f"{variable.name}[1..{variable.size}]"


def picture(interface: Interface) -> bytes:
    """PNG of the block: inputs on the left, outputs on the right, sample time below the name."""
    sides = (interface.inputs, interface.outputs)
    height = _HEAD + _ROW * max(len(side) for side in sides) + 40
    canvas = _Canvas(_WIDTH, height)
    canvas.fill(_EDGE, 10, _WIDTH - _EDGE, height - 10, BLUE)
    canvas.fill(_EDGE + 2, 12, _WIDTH - _EDGE - 2, height - 12, PALE)
    for text, top, scale in ((interface.name, 24, 3), (f"Ts {interface.Ts * 1e3:g} ms", 54, 2)):
        canvas.write((_WIDTH - 6 * scale * len(text)) // 2, top, text, scale)
    for left, side in ((0, sides[0]), (_WIDTH - _EDGE, sides[1])):
        for k, variable in enumerate(side):
            y = _HEAD + 20 + _ROW * k
            canvas.arrow(left + 6, left + _EDGE - 6 if left else left + _EDGE, y + 8)
            canvas.write(left + 8, y - 10, _label(variable)[:23], 1)
    return canvas.png()
