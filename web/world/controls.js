// Pointer, wheel and keys move the viewpoint around its target.
const ELEVATION = [0.03, 1.555];
const DISTANCE = [0.45, 14];
const clamp = (value, [low, high]) => Math.min(Math.max(value, low), high);

export class Controls {
  constructor(canvas, viewpoint, { presets, choose, moved, signal }) {
    this.viewpoint = { ...viewpoint };
    this.moved = moved;
    this.pointers = new Map();
    const on = (name, handler, options = {}) => canvas.addEventListener(name, handler, { signal, ...options });
    on("pointerdown", (event) => {
      canvas.focus({ preventScroll: true });
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, event);
    });
    on("pointermove", (event) => this.drag(event));
    for (const name of ["pointerup", "pointercancel"]) on(name, (event) => this.pointers.delete(event.pointerId));
    on("contextmenu", (event) => event.preventDefault());
    // Without Shift, the wheel scrolls the page unless the view has the focus: until Escape or a click elsewhere. In the
    // control panel a click gives its key field the keys. With Shift, some browsers turn the wheel sideways.
    const page = canvas.ownerDocument, inFirstPlace = { capture: true, signal };
    page.addEventListener("pointerdown", (event) => (this.clicked = event.target === canvas), inFirstPlace);
    page.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      this.clicked = false;
      canvas.blur();
    }, inFirstPlace);
    on("wheel", (event) => {
      const { activeElement } = canvas.getRootNode();
      const keysAreNear = this.clicked && activeElement?.closest(".nao-panel")?.contains(canvas);
      if (activeElement !== canvas && !keysAreNear && !event.shiftKey) return;
      event.preventDefault();
      this.zoom(Math.exp(clamp(event.deltaY || event.deltaX, [-200, 200]) * 0.0015));
    }, { passive: false });
    on("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const step = event.shiftKey ? 0.25 : 0.08;
      const actions = {
        ArrowLeft: () => this.turn(-step, 0),
        ArrowRight: () => this.turn(step, 0),
        ArrowUp: () => this.turn(0, step),
        ArrowDown: () => this.turn(0, -step),
        "+": () => this.zoom(0.9),
        "=": () => this.zoom(0.9),
        "-": () => this.zoom(1 / 0.9),
      };
      presets.forEach((name, i) => (actions[String(i + 1)] = () => choose(name)));
      const action = actions[event.key];
      if (!action) return;
      action();
      event.preventDefault();
      event.stopPropagation();
    });
  }

  set(viewpoint) {
    this.viewpoint = viewpoint;
  }

  turn(azimuth, elevation) {
    this.viewpoint.azimuth += azimuth;
    this.viewpoint.elevation = clamp(this.viewpoint.elevation + elevation, ELEVATION);
    this.moved(this.viewpoint);
  }

  zoom(factor) {
    this.viewpoint.distance = clamp(this.viewpoint.distance * factor, DISTANCE);
    this.moved(this.viewpoint);
  }

  drag(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const [dx, dy] = [event.clientX - before.clientX, event.clientY - before.clientY];
    if (this.pointers.size === 2) {
      const other = [...this.pointers].find(([id]) => id !== event.pointerId)[1];
      const apart = (a) => Math.hypot(a.clientX - other.clientX, a.clientY - other.clientY);
      this.zoom(apart(before) / Math.max(apart(event), 1));
    } else if (event.shiftKey || event.buttons & 2) {
      this.pan(dx, dy, event.target.clientHeight);
    } else {
      this.turn(-dx * 0.008, dy * 0.006);
    }
    this.pointers.set(event.pointerId, event);
  }

  pan(dx, dy, height) {
    const { azimuth, distance, target } = this.viewpoint;
    const scale = (0.7 * distance) / height;
    const [c, s] = [Math.cos(azimuth), Math.sin(azimuth)];
    this.viewpoint.target = [target[0] + scale * (dx * s - dy * c), target[1] - scale * (dx * c + dy * s), target[2]];
    this.moved(this.viewpoint);
  }
}
