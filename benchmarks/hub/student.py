"""A simulated student: a browser's requests to the hub, and JupyterLab's messages to a kernel and its widgets."""

from __future__ import annotations

import asyncio
import json
import re
import time
import uuid
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import aiohttp

PROTOCOL = "v1.kernel.websocket.jupyter.org"  # what JupyterLab speaks with its server
PICTURE = "nao-image-bottom"  # class of the live picture of the panel's chosen camera
SECONDS = 600.0  # for anything that a student waits for


@dataclass
class Seen:
    """What a student's session showed."""

    server: float = 0.0  # seconds until the student's server answered
    cells: list[float] = field(default_factory=list)  # seconds from each cell's request to its reply
    errors: list[str] = field(default_factory=list)  # exceptions of cells
    # times at which the panel's chosen camera sent a picture during a drive, monotonic seconds
    pictures: list[float] = field(default_factory=list)


class Student:
    """A session of one student; use it with ``async with``.

    `claim` is the student's name as a learning platform would give it, and `url` the hub's address.
    """

    def __init__(self, url: str, claim: str, password: str) -> None:
        """Open nothing yet."""
        self.url, self.claim, self.password = url, claim, password
        self.seen = Seen()
        self.name = ""  # of the account; known after the login
        self._http = aiohttp.ClientSession(
            cookie_jar=aiohttp.CookieJar(unsafe=True), timeout=aiohttp.ClientTimeout(SECONDS)
        )
        self._socket: aiohttp.ClientWebSocketResponse | None = None
        self._reader: asyncio.Task[None] | None = None
        self._waiting: dict[str, asyncio.Future[dict[str, Any]]] = {}
        self._models: dict[str, dict[str, Any]] = {}  # state of each widget, by its comm
        self._status = asyncio.Event()  # set when the panel's status has changed

    async def __aenter__(self) -> Student:
        return self

    async def __aexit__(self, *_: object) -> None:
        """Close the connections; the server and the kernel go on, as after a browser is closed."""
        if self._reader:
            self._reader.cancel()
        await self._http.close()

    async def log_in(self) -> None:
        """Log in with the hub's form."""
        async with self._http.get(f"{self.url}/hub/login") as page:
            token = re.search(r'name="_xsrf" value="([^"]*)"', await page.text())
        form = {"username": self.claim, "password": self.password, "_xsrf": token[1] if token else ""}
        # The hub goes on to the student's server; the page after this one is not of interest yet.
        async with self._http.post(f"{self.url}/hub/login", data=form, allow_redirects=False) as answer:
            if answer.status != 302:
                raise RuntimeError(f"{self.claim} cannot log in: {answer.status} {answer.reason}")
        async with self._http.get(f"{self.url}/hub/home") as page:
            found = re.search(r'user: "(nao-[a-z0-9-]+)"', await page.text())
        if not found:
            raise RuntimeError(f"{self.claim} is not logged in")
        self.name = found[1]

    async def start_server(self) -> None:
        """Start the student's server, and wait until JupyterLab's page comes from it."""
        began = time.monotonic()
        async with self._http.get(f"{self.url}/hub/spawn", allow_redirects=False) as answer:
            if answer.status >= 400:
                raise RuntimeError(f"{self.name}'s server does not start: {answer.status} {answer.reason}")
        while True:
            async with self._http.get(f"{self.url}/user/{self.name}/lab") as page:
                # Until it has started, the hub answers with a page of its own.
                if page.status == 200 and page.url.path == f"/user/{self.name}/lab":
                    break
                if page.status >= 500:
                    raise RuntimeError(f"{self.name}'s server has not started: {page.status} {page.reason}")
            if time.monotonic() - began > SECONDS:
                raise TimeoutError(f"{self.name}'s server has not started")
            await asyncio.sleep(0.5)
        self.seen.server = time.monotonic() - began

    async def open_lesson(self, lesson: str) -> list[str]:
        """Open a notebook, start its kernel and connect to it; return its code cells."""
        api = f"{self.url}/user/{self.name}/api"
        async with self._http.get(f"{api}/contents/{lesson}.ipynb") as answer:
            answer.raise_for_status()
            cells = (await answer.json())["content"]["cells"]
        wanted = {
            "path": f"{lesson}.ipynb",
            "name": lesson,
            "type": "notebook",
            "kernel": {"name": "python3"},
        }
        async with self._http.post(f"{api}/sessions", json=wanted, headers=self._headers()) as answer:
            answer.raise_for_status()
            kernel = (await answer.json())["kernel"]["id"]
        self._socket = await self._http.ws_connect(
            f"{api}/kernels/{kernel}/channels?session_id={uuid.uuid4().hex}",
            protocols=[PROTOCOL],
            max_msg_size=0,
        )
        self._reader = asyncio.create_task(self._read(self._socket))
        await self._ask("kernel_info_request", {})
        return [each["source"] for each in cells if each["cell_type"] == "code"]

    def _headers(self) -> dict[str, str]:
        """Return the header that shows a request to be of the student's own page."""
        path = f"/user/{self.name}/"
        for cookie in self._http.cookie_jar:
            if cookie.key == "_xsrf" and cookie["path"] == path:
                return {"X-XSRFToken": cookie.value}
        return {}

    async def run(self, sources: Iterable[str]) -> None:
        """Run cells one after the other."""
        for source in sources:
            began = time.monotonic()
            options = {"silent": False, "store_history": True, "allow_stdin": False, "stop_on_error": False}
            reply = await self._ask("execute_request", {"code": source, "user_expressions": {}, **options})
            self.seen.cells.append(time.monotonic() - began)
            if reply["status"] != "ok":
                self.seen.errors.append(f"{reply.get('ename')}: {reply.get('evalue')}")

    async def drive(self, presses: int) -> None:
        """Press the panel's button for a step ahead and wait until the robot stands, and then back, some times."""
        for press in range(presses):
            button = self._model(f"nao-do-{'back' if press % 2 else 'forward'}")
            driven = asyncio.create_task(self._until_done())
            await self._send(
                "comm_msg", {"comm_id": button, "data": {"method": "custom", "content": {"event": "click"}}}
            )
            await asyncio.wait_for(driven, SECONDS)

    async def _until_done(self) -> None:
        moving = False
        while True:
            self._status.clear()
            await self._status.wait()
            said = [str(state.get("value", "")) for state in self._models.values()]
            busy = any("ahead …" in each or "back …" in each for each in said)
            if moving and not busy:
                return
            moving = moving or busy

    def _model(self, name: str) -> str:
        """Return the newest widget with a class."""
        found = [key for key, state in self._models.items() if name in state.get("_dom_classes", ())]
        if not found:
            raise LookupError(f"no cell has shown a widget of class {name}")
        return found[-1]

    async def _ask(self, kind: str, content: dict[str, Any]) -> dict[str, Any]:
        """Send a request, and return the content of its reply once the kernel is idle again."""
        identity = await self._send(kind, content)
        return await asyncio.wait_for(self._waiting[identity], SECONDS)

    async def _send(self, kind: str, content: dict[str, Any]) -> str:
        assert self._socket is not None
        identity = uuid.uuid4().hex
        self._waiting[identity] = asyncio.get_running_loop().create_future()
        header = {
            "msg_id": identity,
            "msg_type": kind,
            "session": self.name,
            "username": "",
            "version": "5.4",
        }
        header["date"] = "2012-09-06T00:00:00Z"
        parts = [b"shell", *(json.dumps(each).encode() for each in (header, {}, {}, content))]
        await self._socket.send_bytes(_packed(parts))
        return identity

    async def _read(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        async for message in socket:
            if message.type == aiohttp.WSMsgType.BINARY:
                _, header, parent, _, content, *_ = _unpacked(message.data)
                self._take(json.loads(header)["msg_type"], json.loads(parent), json.loads(content))
        for each in self._waiting.values():
            if not each.done():
                each.set_exception(ConnectionError(f"{self.name}'s kernel has hung up"))

    def _take(self, kind: str, parent: dict[str, Any], content: dict[str, Any]) -> None:
        if kind == "comm_open":
            self._models[content["comm_id"]] = content["data"].get("state", {})
        elif kind == "comm_msg":
            state, data = self._models.get(content["comm_id"], {}), content["data"]
            state.update(data.get("state", {}))
            if PICTURE in state.get("_dom_classes", ()) and ["value"] in data.get("buffer_paths", ()):
                self.seen.pictures.append(time.monotonic())
            self._status.set()
        elif kind.endswith("_reply"):
            waiting = self._waiting.pop(parent.get("msg_id", ""), None)
            if waiting is not None and not waiting.done():
                waiting.set_result(content)


def _packed(parts: list[bytes]) -> bytes:
    """Return a message of the protocol: the number of offsets, the offsets, and the parts."""
    offsets = [8 * (len(parts) + 2)]
    for part in parts:
        offsets.append(offsets[-1] + len(part))
    numbers = [len(offsets), *offsets]
    return b"".join([*(each.to_bytes(8, "little") for each in numbers), *parts])


def _unpacked(message: bytes) -> list[bytes]:
    """Return a message's channel, header, parent header, metadata, content and buffers."""
    count = int.from_bytes(message[:8], "little")
    offsets = [int.from_bytes(message[8 * i : 8 * i + 8], "little") for i in range(1, count + 1)]
    return [message[start:end] for start, end in pairwise(offsets)]
