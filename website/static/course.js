// A formula that stands in a sentence and is wider than a phone is scrolled; the theme does that for those on a line of their own.
const scrollWide = () => {
  for (const formula of document.querySelectorAll("span.math")) {
    formula.classList.remove("wide");
    const room = formula.closest("p, li, td, dd, summary").clientWidth;
    formula.classList.toggle("wide", formula.firstElementChild?.offsetWidth > room);
  }
};

addEventListener("load", () => window.MathJax?.startup?.promise?.then(scrollWide));
addEventListener("resize", scrollWide);

// The search shows a piece of each page that it finds; a formula's source and a cell's code are not to be read there.
addEventListener("DOMContentLoaded", () => {
  if (typeof Search === "undefined") return;
  const textOf = Search.htmlToText;
  Search.htmlToText = (page, anchor) => {
    const read = new DOMParser().parseFromString(page, "text/html");
    for (const formula of read.querySelectorAll(".math")) formula.replaceWith("(formula)");
    for (const code of read.querySelectorAll(".cell_input")) code.remove();
    return textOf(read.documentElement.outerHTML, anchor);
  };
  // The piece is cut at a number of letters: what is left of a word at its ends goes.
  const pieceOf = Search.makeSearchSummary;
  Search.makeSearchSummary = (...found) => {
    const piece = pieceOf(...found);
    if (piece) piece.textContent = piece.textContent.replace(/^\.\.\.\S*\s+/, "… ").replace(/\s+\S*\.\.\.$/, " …");
    return piece;
  };
});

// Films play where a notebook needs Python.
addEventListener("DOMContentLoaded", NaoFilm.startPage);
