"""What is wrong with built pages: links that lead nowhere, pictures without words, other hosts that are asked."""

from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

__all__ = ["Page", "offences", "read_page"]

# What a browser fetches by itself when it shows a page; a link to another host is only followed by a click.
FETCHED = {"img": "src", "link": "href", "script": "src", "iframe": "src", "source": "src", "video": "src"}


@dataclass
class Page(HTMLParser):
    """What a page holds that can be wrong."""

    anchors: set[str] = field(default_factory=set)
    links: list[str] = field(default_factory=list)
    fetched: list[str] = field(default_factory=list)
    pictures: set[str] = field(default_factory=set)
    undescribed: list[str] = field(default_factory=list)
    code: list[str] = field(default_factory=list)
    words: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Begin outside of every block of code."""
        super().__init__()
        self._in_code = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note what a tag links to, fetches, names and describes."""
        said = {key: value or "" for key, value in attrs}
        self.anchors |= {said[key] for key in ("id", "name") if said.get(key)}
        if tag == "a" and "href" in said:
            self.links.append(said["href"])
        if FETCHED.get(tag) in said and said.get("rel") not in {
            "canonical",
            "index",
            "search",
            "next",
            "prev",
        }:
            self.fetched.append(said[FETCHED[tag]])
        if tag == "img":
            self.pictures.add(said.get("src", ""))
        if tag == "img" and not said.get("alt", "").strip():
            self.undescribed.append(said.get("src", "")[:80])
        if tag == "pre":
            self._in_code = True
            self.code.append("")

    def handle_endtag(self, tag: str) -> None:
        """Leave a block of code."""
        self._in_code = self._in_code and tag != "pre"

    def handle_data(self, data: str) -> None:
        """Keep the words, those of a block of code apart as well."""
        self.words.append(data)
        if self._in_code:
            self.code[-1] += data


def read_page(path: Path) -> Page:
    """Read an HTML file."""
    page = Page()
    page.feed(path.read_text(encoding="utf-8"))
    page.close()
    return page


def offences(folder: Path) -> list[str]:
    """Return a line for each thing that is wrong on the pages of a folder with index.html."""
    pages = {path.relative_to(folder).as_posix(): read_page(path) for path in sorted(folder.rglob("*.html"))}
    found = [] if "index.html" in pages else ["there is no index.html"]
    for name, page in pages.items():
        found += [f"{name}: a picture without alt text: {source}" for source in page.undescribed]
        found += [
            f"{name}: asks another host: {address}" for address in page.fetched if _is_elsewhere(address)
        ]
        found += [
            f"{name}: leads nowhere: {link}"
            for link in {*page.links, *page.fetched}
            if not _is_elsewhere(link)
            and not link.startswith("data:")
            and _leads_nowhere(folder, name, link, pages)
        ]
    return found


def _is_elsewhere(address: str) -> bool:
    """Whether an address names a host, or another program such as mail."""
    parts = urlsplit(address)
    return bool(parts.netloc) or (bool(parts.scheme) and parts.scheme != "data")


def _leads_nowhere(folder: Path, name: str, link: str, pages: dict[str, Page]) -> bool:
    parts = urlsplit(link)
    target = (folder / name).parent / unquote(parts.path) if parts.path else folder / name
    if target.is_dir():
        target /= "index.html"
    if not target.is_file():
        return True
    key = target.resolve().relative_to(folder.resolve()).as_posix()
    return bool(parts.fragment) and key in pages and unquote(parts.fragment) not in pages[key].anchors
