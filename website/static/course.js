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
