"""Mutations of files: of bytes, of the tokens of texts, and of the parts of binary formats.

Every mutation is a function of the content and a random generator, so that an input can be made
again from its number alone. Results are at most `MAX_BYTES` long.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Callable, Sequence
from typing import Final, TypeVar

from numpy.random import Generator

MAX_BYTES: Final = 2**16
"""Upper bound of the size of an input (64 KiB)."""

MAX_ROUNDS: Final = 6
"""Upper bound of the mutations of an input."""

NUMBERS: Final[tuple[bytes, ...]] = (
    *(b"0", b"-0", b"1", b"-1", b"2", b"3", b"0.5", b"1e-3", b"1e-9", b"1e-300", b"5e-324"),
    *(b"1e6", b"1e7", b"-1e7", b"10000001", b"1e12", b"1e15", b"1e100", b"1e308", b"-1e308"),
    *(b"1e309", b"nan", b"NaN", b"inf", b"-inf", b"Infinity", b"1e", b"--1", b"1.2.3", b"0x10"),
    *(b"255", b"256", b"65535", b"65536", b"2147483647", b"2147483648", b"4294967296"),
    *(b"9223372036854775807", b"18446744073709551616", b"1" * 30, b"9" * 5000, b"0." + b"0" * 400),
    *(b"\xd9\xa1", b"\xc2\xb2", b"1_000", b"1,5", b".", b"+", b""),
)
"""Replacements of numbers in texts; two of them are digits outside ASCII."""

SIGNS: Final[tuple[bytes, ...]] = (
    *(b"(", b")", b"[", b"]", b"{", b"}", b"<", b">", b'"', b"'", b",", b";", b":", b"=", b"#"),
    *(b"\n", b"\r\n", b"\r", b"\t", b" ", b"\0", b"\x1b[31m", b"\x0b", b"\x1c", b"\xff", b"\xc3"),
    *(b"\xe2\x80\xa8", b"\xe2\x80\xae", b"\xef\xbb\xbf", b"\xed\xa0\x80", b"\xf0\x9f\x98\x80"),
    *(b"../", b"/", b"/dev/zero", b"..", b"%s%n", b"{}", b"\\", b"&amp;", b"&#0;", b"null"),
)
"""Insertions into any text: punctuation, control characters, broken UTF-8, names of files."""

INTEGERS: Final[tuple[int, ...]] = (
    *(0, 1, 2, 3, 4, 7, 8, 16, 100, 127, 128, 255, 256, 32767, 32768, 65535, 65536),
    *(2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 1, 64_000_000, 64_000_001),
)
"""Replacements of integers in binary files, modulo their size."""

NUMERIC: Final = re.compile(rb"\d+\.?\d*(?:[eE][+-]?\d+)?")
TOKEN: Final = re.compile(NUMERIC.pattern + rb"|[A-Za-z_][\w-]*|\s+|[^\w\s]|[^\x00-\x7f]+")
LONGEST_NUMBER: Final = 20
"""Number of bytes of a number that are read when it is multiplied."""

Mutation = Callable[[bytes, Generator, Sequence[bytes], Sequence[bytes]], bytes]
"""Takes a content, the generator, the seeds of the format and its dictionary."""

T = TypeVar("T")


def pick(rng: Generator, choices: Sequence[T]) -> T:
    """Return a random element of a sequence."""
    return choices[int(rng.integers(len(choices)))]


def mutated(
    content: bytes,
    rng: Generator,
    seeds: Sequence[bytes],
    words: Sequence[bytes],
    mutate: Mutation,
) -> bytes:
    """Return a content after one or several mutations.

    Parameters
    ----------
    content : bytes
        A seed.
    rng : numpy.random.Generator
        Random generator.
    seeds : sequence of bytes
        The seeds of the format, for splices.
    words : sequence of bytes
        The dictionary of the format.
    mutate : Mutation
        A mutation that suits the format.
    """
    for _ in range(min(int(rng.geometric(0.5)), MAX_ROUNDS)):
        content = mutate(content, rng, seeds, words)[:MAX_BYTES]
    return content


# Bytes --------------------------------------------------------------------------------------


def of_bytes(
    content: bytes, rng: Generator, seeds: Sequence[bytes], words: Sequence[bytes]
) -> bytes:
    """Change bytes of a binary file: single ones, integers, spans, or the end."""
    raw = bytearray(content or b"\0")
    at = int(rng.integers(len(raw)))
    # Headers are at the beginning.
    if rng.random() < 0.5:
        at = int(rng.integers(min(len(raw), 64)))
    span = 1 + int(rng.integers(min(64, len(raw))))
    match int(rng.integers(9)):
        case 0:
            raw[at] ^= 1 << int(rng.integers(8))
        case 1:
            raw[at] = int(rng.integers(256))
        case 2 | 3:
            size = pick(rng, (1, 2, 4, 8))
            order = pick(rng, ("<", ">"))
            value = pick(rng, INTEGERS) % 2 ** (8 * size)
            raw[at : at + size] = struct.pack(order + " BH I   Q"[size], value)
        case 4:
            del raw[at : at + span]
        case 5:
            raw[at:at] = raw[at : at + span] * 2 ** int(rng.integers(8))
        case 6:
            del raw[at:]
        case 7:
            raw[at:at] = pick(rng, words) if words else rng.bytes(span)
        case _:
            other = pick(rng, seeds)
            raw[at:] = other[int(rng.integers(len(other))) :]
    return bytes(raw)


# Texts --------------------------------------------------------------------------------------


def of_text(
    content: bytes, rng: Generator, seeds: Sequence[bytes], words: Sequence[bytes]
) -> bytes:
    """Change tokens or lines of a text."""
    kind = int(rng.integers(20))
    if kind == 0:
        return of_bytes(content, rng, seeds, words)
    if kind <= 2:
        return b"".join(_changed_lines(content.splitlines(keepends=True), rng))
    tokens = TOKEN.findall(content)
    if not tokens:
        return pick(rng, seeds)
    if kind <= 10:
        return _with_other_number(tokens, rng)
    at = int(rng.integers(len(tokens)))
    span = 1 + int(rng.integers(30))
    match kind:
        case 11 | 12:
            inked = [k for k, token in enumerate(tokens) if not token.isspace()] or [0]
            tokens[pick(rng, inked)] = pick(rng, words) if words else pick(rng, SIGNS)
        case 13:
            tokens.insert(at, pick(rng, words) if words else pick(rng, SIGNS))
        case 14:
            tokens.insert(at, pick(rng, SIGNS))
        case 15:
            del tokens[at : at + span]
        case 16:
            # Often twice, sometimes so often that the result is cut.
            tokens[at:at] = tokens[at : at + span] * 2 ** int(rng.integers(12))
        case 17:
            other = int(rng.integers(len(tokens)))
            tokens[at], tokens[other] = tokens[other], tokens[at]
        case 18:
            del tokens[at:]
        case _:
            others = TOKEN.findall(pick(rng, seeds))
            tokens[at:] = others[int(rng.integers(len(others) + 1)) :]
    return b"".join(tokens)


def _with_other_number(tokens: list[bytes], rng: Generator) -> bytes:
    places = [k for k, token in enumerate(tokens) if NUMERIC.match(token)]
    if not places:
        return b"".join(tokens) + pick(rng, NUMBERS)
    at = pick(rng, places)
    match int(rng.integers(5)):
        case 0 | 1:
            tokens[at] = pick(rng, NUMBERS)
        case 2:
            tokens[at] = b"%d" % rng.integers(-3, 20)
        case 3:
            # What is left of a number that is cut within its exponent is one, too.
            number = NUMERIC.findall(tokens[at][:LONGEST_NUMBER])[0]
            tokens[at] = b"%.3g" % (float(number) * float(rng.normal(1.0, 0.5)))
        case _:
            tokens[at] = tokens[pick(rng, places)]
    return b"".join(tokens)


def _changed_lines(lines: list[bytes], rng: Generator) -> list[bytes]:
    if not lines:
        return lines
    at, other = (int(rng.integers(len(lines))) for _ in range(2))
    match int(rng.integers(4)):
        case 0:
            del lines[at : at + 1 + int(rng.integers(3))]
        case 1:
            lines[at], lines[other] = lines[other], lines[at]
        case 2:
            lines[at:at] = lines[at : at + 1 + int(rng.integers(6))] * 2 ** int(rng.integers(8))
        case _:
            lines[at] = lines[at].rstrip() + lines[other]
    return lines


# Parts of binary formats --------------------------------------------------------------------

PNG_SIGNATURE: Final = b"\x89PNG\r\n\x1a\n"
PNG_CHUNKS: Final = (
    *(b"IHDR", b"PLTE", b"IDAT", b"IEND", b"tRNS", b"gAMA", b"cHRM", b"sRGB", b"iCCP", b"sBIT"),
    *(b"bKGD", b"hIST", b"pHYs", b"sPLT", b"tIME", b"tEXt", b"zTXt", b"iTXt", b"eXIf", b"acTL"),
    *(b"fcTL", b"fdAT", b"caNv", b"prVW"),
)


def of_png(content: bytes, rng: Generator, seeds: Sequence[bytes], words: Sequence[bytes]) -> bytes:
    """Change chunks of a PNG, with valid checksums, or its bytes."""
    chunks = _png_chunks(content)
    if not chunks or rng.random() < 0.2:
        return of_bytes(content, rng, seeds, words)
    at = int(rng.integers(len(chunks)))
    if rng.random() < 0.3:
        at = 0
    kind, body = chunks[at]
    match int(rng.integers(7)):
        case 0 | 1 if kind == b"IDAT":
            # Change the decompressed samples, if they can be decompressed.
            try:
                samples = zlib.decompressobj().decompress(body, MAX_BYTES)
            except zlib.error:
                samples = body
            chunks[at] = kind, zlib.compress(of_bytes(samples, rng, seeds, words)[:MAX_BYTES])
        case 0 | 1 | 2:
            chunks[at] = kind, of_bytes(body, rng, seeds, words)
        case 3:
            del chunks[at]
        case 4:
            chunks.insert(at, (kind, body))
        case 5:
            chunks.insert(at, (pick(rng, PNG_CHUNKS), rng.bytes(int(rng.integers(40)))))
        case _:
            others = _png_chunks(pick(rng, seeds)) or chunks
            chunks[at] = pick(rng, others)
    return PNG_SIGNATURE + b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in chunks
    )


def _png_chunks(content: bytes) -> list[tuple[bytes, bytes]]:
    if not content.startswith(PNG_SIGNATURE):
        return []
    chunks, at = [], len(PNG_SIGNATURE)
    while at + 12 <= len(content):
        (length,) = struct.unpack_from(">I", content, at)
        chunks.append((content[at + 4 : at + 8], content[at + 8 : at + 8 + length]))
        at += 12 + length
    return chunks


def of_image(
    content: bytes, rng: Generator, seeds: Sequence[bytes], words: Sequence[bytes]
) -> bytes:
    """Change an image: the header of a PGM as text, a PNG by its chunks, others by bytes."""
    if content.startswith(PNG_SIGNATURE):
        return of_png(content, rng, seeds, words)
    if content[:1] == b"P" and rng.random() < 0.6:
        return of_text(content[:40], rng, [content], ()) + content[40:]
    return of_bytes(content, rng, seeds, words)


def of_npy(content: bytes, rng: Generator, seeds: Sequence[bytes], words: Sequence[bytes]) -> bytes:
    """Change the header of an array as text, with its length corrected, or its bytes."""
    length = int.from_bytes(content[8:10], "little")
    if rng.random() < 0.4:
        return of_bytes(content, rng, seeds, words)
    header = of_text(content[10 : 10 + length], rng, [content[10 : 10 + length] or b"{}"], words)
    size = (len(header) % 2**16).to_bytes(2, "little")
    return content[:8] + size + header + content[10 + length :]


def of_dxf(content: bytes, rng: Generator, seeds: Sequence[bytes], words: Sequence[bytes]) -> bytes:
    """Change pairs of group code and value of a drawing, or its bytes."""
    if content.startswith(b"AutoCAD Binary") or rng.random() < 0.1:
        return of_bytes(content, rng, seeds, words)
    lines = content.split(b"\n")
    pairs = max(len(lines) // 2, 1)
    at = 2 * int(rng.integers(pairs))
    span = 2 * (1 + int(rng.integers(30)))
    match int(rng.integers(10)):
        case 0 | 1 | 2 | 3:
            values = NUMBERS if rng.random() < 0.6 else words
            lines[at + 1 : at + 2] = [pick(rng, values)]
        case 4:
            lines[at : at + 1] = [b"%3d" % rng.integers(-5, 110)]
        case 5:
            del lines[at : at + span]
        case 6:
            lines[at:at] = lines[at : at + span] * 2 ** int(rng.integers(8))
        case 7:
            other = 2 * int(rng.integers(pairs))
            lines[at : at + 2], lines[other : other + 2] = (
                lines[other : other + 2],
                lines[at : at + 2],
            )
        case 8:
            others = pick(rng, seeds).split(b"\n")
            lines[at:] = others[2 * int(rng.integers(max(len(others) // 2, 1))) :]
        case _:
            lines[at + 1 : at + 2] = [lines[2 * int(rng.integers(pairs)) + 1 :][:1] or [b""]][0]
    return b"\n".join(lines)
