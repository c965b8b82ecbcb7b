"""The encoding of a text: UTF-8 if it is, otherwise the only one of three in which it can be read."""

import re
from codecs import getincrementaldecoder
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass

from allanite.core.errors import DataError
from allanite.phrases.phrase import Phrase, say

UTF16 = (b"\xff\xfe", b"\xfe\xff")  # byte order marks
_JUDGED = 1 << 16  # bytes of lines with letters beyond ASCII that are judged
_BLOCK = 1 << 20  # bytes that are tested at once
LONGEST_LINE = 1 << 26  # bytes of a line beyond which a file is no table
_SIGNS = frozenset("°µ²³·±×№«»–—‘’“”„…•™\u00a0")  # signs that any text may hold beside its letters

_RUSSIAN = re.compile(
    r"врем|темпер|скорост|ускор|угол|угл|гиро|дус|аксел|датчик|частот|период|дискретиз|номер|сч[её]тчик|дата|"
    r"(?<![а-яё])(?:рад|град|сек|мин|час|мс|мкс|гц|ось)(?![а-яё])|[°мд]/[сч]|,\s*[смч](?![а-яё])",
    re.IGNORECASE,
)
_CHINESE = re.compile(
    "时间|温度|角速|加速|陀螺|加表|采样|频率|传感|序号|数据|日期|弧度|米/秒|度/|[(（\\[]度[)）\\]]|小时|[轴秒]"
)


_NO_WORD = re.compile(r"(?<![A-Za-z])[À-ÿ](?![A-Za-z])|[À-ÿ]{3}")


@dataclass(frozen=True)
class _Encoding:
    """An encoding: its name, that of Python, whether a decoded text is plausible, and words that such texts have."""

    name: str
    codec: str
    plausible: Callable[[str], bool]
    words: re.Pattern[str] | None = None


def _is_latin(text: str) -> bool:
    """Signs, and accented letters within words of plain letters or as words like à; of the superset of Windows."""
    text = re.sub(r"(?<!\S)[àèéóíÀÈÉÓ](?!\S)", "", text)
    beyond = (letter for letter in text if ord(letter) > 127)
    return not _NO_WORD.search(text) and all(c in _SIGNS or (c >= "À" and c not in "×÷") for c in beyond)


def _is_russian(text: str) -> bool:
    """Cyrillic words in lower case, capitals, or with one capital, and no letters of other languages among them."""
    if any(ord(c) > 127 and c not in _SIGNS and not "А" <= c <= "я" and c not in "Ёё" for c in text):
        return False
    words = re.findall(r"[^\W\d_°]+", text.replace("мкg", "").replace("мg", ""))
    own = [word for word in words if re.search("[А-яЁё]", word)]
    telling = any(len(word) > 1 for word in own) or _RUSSIAN.search(text)
    return bool(telling) and all(re.fullmatch(r"[А-ЯЁ]?[а-яё]+|[А-ЯЁ]+[A-Za-z]?|[A-Za-z]", word) for word in own)


def _is_chinese(text: str) -> bool:
    """Mostly common characters: signs, and those of the first level of GB 2312."""
    beyond = [letter for letter in text if ord(letter) > 127]
    written = [letter.encode("gb18030") for letter in beyond]
    usual = (*range(0xA1, 0xA7), *range(0xB0, 0xD8))
    common = sum(len(code) == 2 and code[1] > 0xA0 and code[0] in usual for code in written)
    return common >= 0.8 * len(beyond)


_ENCODINGS = (
    _Encoding("GB18030", "gb18030", _is_chinese, _CHINESE),
    _Encoding("cp1251", "cp1251", _is_russian, _RUSSIAN),
    _Encoding("Latin-1", "cp1252", _is_latin),
)


def in_utf8(data: bytes) -> tuple[bytes, tuple[Phrase, ...]]:
    """The text in UTF-8, and a note on the encoding that was assumed, if it was another."""
    if data.isascii():
        return data, ()
    # the whole text may be several times as large in memory: it is tested in blocks
    codec, name = encoding_of(lambda: (data[at : at + _BLOCK] for at in range(0, len(data), _BLOCK)))
    return b"".join(decoded([data], codec, name)) if codec else data, noted(codec, name)


def noted(codec: str, name: str) -> tuple[Phrase, ...]:
    """The note on an encoding that was assumed."""
    return (say("the text is not UTF-8, and is read as {name}", name=name),) if codec not in ("", "utf-16") else ()


def encoding_of(chunks: Callable[[], Iterable[bytes]]) -> tuple[str, str]:
    """The encoding of a text, which `chunks` reads from the beginning: that of Python and its name; empty for UTF-8."""
    if next(iter(chunks()), b"").startswith(UTF16):
        return "utf-16", "UTF-16"
    decoder, fresh = getincrementaldecoder("utf-8")(), True
    try:
        for chunk in chunks():
            if not (fresh and chunk.isascii()):
                decoder.decode(chunk)
                fresh = not decoder.getstate()[0]
        decoder.decode(b"", final=True)
    except UnicodeDecodeError:
        pass
    else:
        return "", ""
    # judged by the first lines that are not ASCII
    lines, size = list[bytes](), 0
    for data in whole_lines(chunks()):
        start = 0
        while size < _JUDGED and (place := re.compile(rb"[\x80-\xff]").search(data, start)):
            first = max(data.rfind(b"\n", 0, place.start()), data.rfind(b"\r", 0, place.start())) + 1
            end = data.find(b"\n", place.start())
            start = len(data) if end < 0 else end + 1
            lines.append(data[first:start][:_JUDGED])
            size += len(lines[-1])
        if size >= _JUDGED:
            break
    encoding = _encoding(b"\n".join(dict.fromkeys(lines)))
    return encoding.codec, encoding.name


def decoded(chunks: Iterable[bytes], codec: str, name: str) -> Iterator[bytes]:
    """A text in UTF-8 instead of this encoding."""
    decoder, line = getincrementaldecoder(codec)(), 1
    try:
        for chunk in chunks:
            text = decoder.decode(chunk).encode()
            line += text.count(b"\n")
            yield text
        decoder.decode(b"", final=True)
    except UnicodeDecodeError as error:
        line += error.object.count(b"\n", 0, error.start)
        raise DataError(f"the file begins like {name} text but is damaged in line {line}") from None


def whole_lines(chunks: Iterable[bytes]) -> Iterator[bytes]:
    """A text in blocks that end with a line; the last may not."""
    rest = list[bytes]()
    for chunk in chunks:
        at = chunk.rfind(b"\n") + 1
        if at:
            yield b"".join((*rest, chunk[:at]))
            rest = []
        rest.append(chunk[at:])
        if sum(map(len, rest)) > LONGEST_LINE:
            raise DataError(f"a line of the text is longer than {LONGEST_LINE} bytes; expected one row per sample")
    if any(rest):
        yield b"".join(rest)


def _encoding(lines: bytes) -> _Encoding:
    """The only encoding in which the lines are plausible, or the only one with words that such files have."""
    plausible = list[tuple[_Encoding, str]]()
    for encoding in _ENCODINGS:
        with suppress(UnicodeDecodeError):
            text = lines.decode(encoding.codec)
            if encoding.plausible(text):
                plausible.append((encoding, text))
    telling = [encoding for encoding, text in plausible if encoding.words and encoding.words.search(text)]
    fitting = [encoding for encoding, _ in plausible]
    for some in (fitting, telling):
        if len(some) == 1:
            return some[0]
    *names, last = (encoding.name for encoding in _ENCODINGS)
    meant = " or ".join(encoding.name for encoding in telling or fitting)
    what = f"may be {meant}" if fitting else f"is neither {', '.join(names)} nor {last}"
    sample = next((line for line in lines.splitlines() if line.strip()), b"")[:40]
    raise DataError(f"the encoding of the text cannot be determined: it is not UTF-8, and {what} ({sample!r}); save it "
                    "as UTF-8, for example with iconv -f GB18030 -t UTF-8, or -f CP1251")  # fmt: skip
