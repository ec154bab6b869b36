#!/usr/bin/env bash
# You expect a reader with a limit for records to refuse a small file that grows to gigabytes when it is read.
# mcap 1.6.0 has record_size_limit, but it limits only the compressed chunk. The size that the chunk states is not
# compared with what comes out of it.
# Seen: files of 6 kB (zstd) and 824 kB (lz4), whose chunk states 10 bytes, take 400 MB, although record_size_limit
# is 1 MB. If you read files of strangers, take the chunks with emit_chunks=True and decompress them yourself
# within a limit.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check mcap==1.6.0 lz4==4.4.5 zstandard==0.25.0
"$folder/venv/bin/python" - <<'PYTHON'
import io
import struct
import tracemalloc

import lz4.frame
import zstandard
from mcap.stream_reader import StreamReader

SIZE = 200_000_000
MAGIC = b"\x89MCAP0\r\n"


def peak(name, compressed):
    unknown = b"\x80" + struct.pack("<Q", SIZE - 9) + bytes(SIZE - 9)  # one record of a type that readers skip
    data = compressed(unknown)
    body = struct.pack("<QQQII", 0, 0, 10, 0, len(name)) + name.encode() + struct.pack("<Q", len(data)) + data
    header = b"\x01" + struct.pack("<Q", 8) + bytes(8)
    footer = b"\x02" + struct.pack("<Q", 20) + bytes(20)
    file = MAGIC + header + b"\x06" + struct.pack("<Q", len(body)) + body + footer + MAGIC
    del unknown
    tracemalloc.start()
    list(StreamReader(io.BytesIO(file), record_size_limit=1_000_000).records)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    print(f"{name}: a file of {len(file):,} bytes, at most {most / 1e6:.0f} MB")
    return len(file), most


for name, compressed in (("zstd", zstandard.compress), ("lz4", lz4.frame.compress)):
    size, most = peak(name, compressed)
    assert size < 1_000_000 and most > 0.9 * SIZE
PYTHON
