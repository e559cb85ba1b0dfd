# SPDX-License-Identifier: Apache-2.0
"""Damages valid bytes."""

def flip_bits(draw, content, most=3):
    """Returns the content with one to `most` random bits inverted."""
    content = bytearray(content)
    for _ in range(1 + draw.randrange(most)):
        if content:
            content[draw.randrange(len(content))] ^= 1 << draw.randrange(8)
    return bytes(content)


TOKENS = ["=", "[", "]", "[[", "]]", "{", "}", '"', "'", '"""', "'''", "\\", "#", ",", ".", "\n", "\r", "\0", "\t",
          "nan", "inf", "-inf", "1e308", "-1", "0", "1e400", "9223372036854775807", "9223372036854775808", "0x", "1_0",
          "true", "false", "1979-05-27T07:32:00Z", '""', '"\\u001b[2J"', '"\\uD800"', "\u202e", "\u0085", "°",
          "[[segment]]", "a.a.a.a = 1",
          "count = 1000000000000000000", 'time = "1e9 d"', 'at = "1e308 °C"', '"../../../etc/passwd"', '"/dev/zero"',
          '"/proc/self/mem"', "\xff"]


def mutate_text(draw, text):
    """Returns the text with pieces removed, inserted, repeated or replaced."""
    content = text.encode()
    for _ in range(1 + draw.randrange(4)):
        at, kind = draw.randrange(len(content) + 1), draw.randrange(6)
        token = draw.choice(TOKENS).encode("utf-8" if draw.randrange(8) else "latin-1", errors="replace")
        size = draw.choice([1, 2, 5, 30, 200])
        if kind == 0:
            content = content[:at] + token + content[at:]
        elif kind == 1:
            content = content[:at] + content[at + size:]
        elif kind == 2:
            content = content[:at] + content[at:at + size] * (1 + draw.randrange(20)) + content[at + size:]
        elif kind == 3:
            content = content[:at] + bytes(draw.randrange(256) for _ in range(draw.randrange(8))) + content[at:]
        elif kind == 4:
            lines = content.split(b"\n")
            lines[draw.randrange(len(lines))] = token
            content = b"\n".join(lines)
        else:
            equal = content.find(b"= ", at)
            end = content.find(b"\n", equal)
            if equal >= 0 and end >= 0:
                content = content[:equal + 2] + token + content[end:]
    return content
