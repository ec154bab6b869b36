"""The load test of the hub: its messages are JupyterLab's, and its calculation is the one that the page states."""

import pytest

from benchmarks.hub import SERVER, on_a_large_server


def test_a_message_survives_packing_and_is_laid_out_as_the_protocol_says():
    pytest.importorskip("aiohttp", reason="JupyterHub is not installed: make .venv/hub.stamp")
    from jupyter_server.services.kernels.connection.base import deserialize_msg_from_ws_v1

    from benchmarks.hub.student import _packed, _unpacked

    parts = [b"shell", b'{"msg_id": "1"}', b"{}", b"{}", b'{"code": "1"}', b"\0\1buffer"]
    assert [bytes(each) for each in _unpacked(_packed(parts))] == parts
    channel, rest = deserialize_msg_from_ws_v1(_packed(parts))
    assert channel == "shell" and [bytes(each) for each in rest] == parts[1:]


def test_a_larger_server_holds_what_its_memory_and_its_processors_allow():
    figures = {"mb_driven": {"both": 300.0}}
    held = on_a_large_server(figures, cpu_s=40.0)
    assert held["students_by_memory"] == (SERVER["memory_gb"] - SERVER["for_the_system_gb"]) * 1024 // 300
    assert held["students_in_an_hour_by_processors"] == SERVER["cores"] * 3600 // 40
