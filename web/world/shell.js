// The frame around the view: buttons, legend, texts, and the picture where the browser has no WebGL.
import { Controls } from "./controls.js";
import style from "./style.css";
import { View } from "./view.js";

const NAMES = { behind: "Behind", above: "Above", goal: "From the goal" };

const make = (kind, className, parent) => {
  const element = document.createElement(kind);
  if (className) element.className = className;
  parent.append(element);
  return element;
};

export class Shell {
  constructor(model, el) {
    this.model = model;
    this.abort = new AbortController();
    const scene = model.get("scene");
    this.root = make("div", "nao-world", el);
    this.root.naoWorld = this; // for tests and measurements
    make("style", "", this.root).textContent = style;
    const [width, height] = model.get("size");
    this.root.style.maxWidth = `${width}px`;
    this.stage = make("div", "stage", this.root);
    this.stage.style.aspectRatio = `${width} / ${height}`;
    this.view = this.startView(scene);
    this.canvas = this.view ? this.view.canvas : make("img", "", this.stage);
    this.canvas.tabIndex = 0;
    this.canvas.draggable = false;
    // JupyterLab takes keys for its own commands, except below an element with this mark.
    this.root.dataset.lmSuppressShortcuts = "true";
    const views = make("div", "views", this.stage);
    this.buttons = Object.keys(scene.presets).map((name) => {
      const button = make("button", "", views);
      button.type = "button";
      button.textContent = NAMES[name] ?? name;
      button.addEventListener("click", () => this.choose(name));
      return [name, button];
    });
    this.legend = make("div", "legend", this.stage);
    make("div", "keys", this.root).textContent = this.model.get("hint");
    this.controls = new Controls(this.canvas, model.get("viewpoint"), {
      presets: Object.keys(scene.presets),
      choose: (name) => this.choose(name),
      moved: (viewpoint) => this.moved(viewpoint),
      signal: this.abort.signal,
    });
    this.listen();
    this.updateTheme();
    this.updateWords();
    this.showViewpoint();
    if (!this.view) this.showStill();
  }

  startView(scene) {
    try {
      return new View(this.stage, scene, this.model);
    } catch (error) {
      console.warn("No WebGL here, so the view is a picture:", error.message);
      return null;
    }
  }

  listen() {
    const handlers = {
      contents: () => {
        this.updateWords();
        this.view?.update(this.model.get("contents"));
      },
      trails: () => this.view?.setTrails(this.model.get("trails")),
      top: () => this.view?.setPicture("top", this.model.get("top")),
      bottom: () => this.view?.setPicture("bottom", this.model.get("bottom")),
      viewpoint: () => this.showViewpoint(),
      still: () => this.showStill(),
    };
    for (const [name, handler] of Object.entries(handlers)) {
      this.model.on(`change:${name}`, handler);
      this.abort.signal.addEventListener("abort", () => this.model.off(`change:${name}`, handler));
    }
    const themes = new MutationObserver(() => this.updateTheme());
    themes.observe(document.body, { attributes: true, attributeFilter: ["data-jp-theme-light", "class"] });
    const preference = matchMedia("(prefers-color-scheme: dark)");
    preference.addEventListener("change", () => this.updateTheme(), { signal: this.abort.signal });
    this.abort.signal.addEventListener("abort", () => themes.disconnect());
    if (!this.view) {
      this.model.set("needs_still", true);
      this.model.save_changes();
    }
  }

  updateTheme() {
    const told = document.body.dataset.jpThemeLight;
    const dark = told === undefined ? matchMedia("(prefers-color-scheme: dark)").matches : told === "false";
    this.root.classList.toggle("dark", dark);
  }

  updateWords() {
    const words = this.model.get("summary");
    if (this.view) this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `3-D view of the field. ${words}. ${this.model.get("hint")}`);
    const { truth, estimate } = this.model.get("contents");
    const { sources } = this.model.get("scene");
    const source = this.model.get("source");
    const entries = [];
    if (truth) entries.push([sources.truth.colour, "true robot"]);
    if (estimate) entries.push([sources[source].colour, this.model.get("estimate_name") || `${sources[source].label} estimate`]);
    const key = JSON.stringify(entries);
    if (key === this.legendKey || (entries.length < 2 && !estimate)) return;
    this.legendKey = key;
    this.legend.replaceChildren();
    for (const [colour, label] of entries) {
      const entry = make("span", "", this.legend);
      make("i", "", entry).style.background = colour;
      entry.append(label);
    }
  }

  choose(name) {
    this.controls.set({ ...this.model.get("scene").presets[name] });
    this.moved(this.controls.viewpoint, true);
  }

  // The reader moved the view: show it at once, and let Python know when the movement pauses.
  moved(viewpoint, smoothly = false) {
    this.view?.look(viewpoint, smoothly);
    this.mark(viewpoint);
    clearTimeout(this.later);
    this.later = setTimeout(() => {
      this.model.set("viewpoint", { ...viewpoint });
      this.model.save_changes();
    }, this.view ? 300 : 60);
  }

  showViewpoint() {
    const viewpoint = this.model.get("viewpoint");
    if (JSON.stringify(viewpoint) === JSON.stringify(this.controls.viewpoint) && this.shown) return;
    this.controls.set({ ...viewpoint });
    this.view?.look(viewpoint, this.shown);
    this.shown = true;
    this.mark(viewpoint);
  }

  mark(viewpoint) {
    const { presets } = this.model.get("scene");
    for (const [name, button] of this.buttons) {
      const same = Object.entries(presets[name]).every(([key, value]) => String(viewpoint[key]) === String(value));
      button.setAttribute("aria-pressed", String(same));
    }
  }

  showStill() {
    const bytes = this.model.get("still");
    if (this.view || !bytes?.byteLength) return;
    if (this.address) URL.revokeObjectURL(this.address);
    this.address = URL.createObjectURL(new Blob([bytes], { type: "image/jpeg" }));
    this.canvas.src = this.address;
    this.canvas.alt = this.canvas.getAttribute("aria-label");
  }

  close() {
    clearTimeout(this.later);
    this.abort.abort();
    this.view?.close();
    if (this.address) URL.revokeObjectURL(this.address);
    this.root.remove();
  }
}
