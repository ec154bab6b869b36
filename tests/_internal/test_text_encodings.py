import codecs

import pytest

from nao_course._internal.text_encodings import NotTextError, decode_text

TEXT = "VERTEX_SE2 0 0 0 0 # Größe, 10 €\r\nnaïve\n"
ENCODINGS = ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "cp1252"]


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_text_is_read_in_each_encoding_that_programs_save(encoding):
    assert decode_text(TEXT.encode(encoding)) == TEXT


def test_utf_16_of_either_byte_order_is_read_by_its_mark_and_an_empty_file_is_empty_text():
    for mark, encoding in ((codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be")):
        assert decode_text(mark + TEXT.encode(encoding)) == TEXT
    assert decode_text(b"") == decode_text(codecs.BOM_UTF8) == ""


@pytest.mark.parametrize(
    "data",
    [b"\x89PNG\r\n\x1a\n", b"a\0b", "Zoë".encode("utf-16")[:-1], "Zoë\n".encode() + "Zoë\n".encode("cp1252")],
)
def test_other_bytes_are_refused_with_what_to_do(data):
    with pytest.raises(NotTextError, match="Save it as UTF-8"):
        decode_text(data)
