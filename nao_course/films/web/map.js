// A map that is drawn from numbers: the field, paths with the robot at their end, ellipses, landmarks, rays and points.
// The films and the live map share it. Lengths are in the scene's units (a millimetre), angles in milliradians.
const NaoMap = (() => {
  const WIDTHS = { path: 3, ellipses: 5, landmarks: 3, points: 2, curve: 2, lines: 4, cells: 2, cone: 5, axis: 5, wedge: 5 };
  const ANGLES = { path: [2], cone: [2], axis: [2], wedge: [2] };
  const TURN = 2000 * Math.PI;
  const LENS = 58, REACHES = [50, 100, 200, 500, 1000], ENLARGES = 1.5; // px, mm around the robot, least magnification
  const WIDER = [100, 50, 20, 10, 5, 2, 1], WIDEST = 1200; // magnifications of angles, and the widest angle in the lens
  const LINE = 1.8, ROBOT = 5.5, LANDMARK = 4.5, MARGIN = { left: 34, right: 14, top: 8, bottom: 22 };

  // --- numbers between two frames ---

  const between = (a, b, part, isAngle) => {
    if (!isAngle) return a + (b - a) * part;
    const turn = b - a;
    return a + (turn - TURN * Math.round(turn / TURN)) * part;
  };

  // Entries that only the later frame has appear at once: they have no earlier position to come from.
  const mix = (kind, from, to, part) => {
    if (!from || from === to || part >= 1) return to;
    if (part <= 0) return from;
    const width = WIDTHS[kind], angles = ANGLES[kind] || [];
    return to.map((value, i) => i < from.length && !(kind === "landmarks" && i % 3 === 2)
      ? between(from[i], value, part, angles.includes(i % width)) : value);
  };

  // --- theme ---

  const onPhone = () => matchMedia("(max-width: 46em)").matches;
  const isDark = element => {
    const parts = getComputedStyle(element).color.match(/[\d.]+/g) || [0, 0, 0];
    return 0.299 * parts[0] + 0.587 * parts[1] + 0.114 * parts[2] > 140;
  };

  // A theme's style sheet may arrive after its name, and in a hidden tab much later.
  const onTheme = (element, redraw) => {
    let dark = isDark(element);
    const look = () => { if (isDark(element) !== dark) { dark = !dark; redraw(); } };
    const later = () => [0, 100, 400, 1500].forEach(wait => setTimeout(look, wait));
    const observer = new MutationObserver(later);
    for (const each of [document.documentElement, document.body])
      observer.observe(each, { attributes: true, attributeFilter: ["class", "data-theme", "data-jp-theme-light", "data-jp-theme-name"] });
    const query = matchMedia("(prefers-color-scheme: dark)");
    query.addEventListener("change", later);
    document.addEventListener("visibilitychange", later);
    return () => {
      observer.disconnect();
      query.removeEventListener("change", later);
      document.removeEventListener("visibilitychange", later);
    };
  };

  // --- shapes ---

  const MARKERS = {
    o: (c, r) => c.arc(0, 0, r, 0, 2 * Math.PI),
    s: (c, r) => c.rect(-0.9 * r, -0.9 * r, 1.8 * r, 1.8 * r),
    "^": (c, r) => polygon(c, [[0, -1.15 * r], [1.1 * r, 0.85 * r], [-1.1 * r, 0.85 * r]]),
    D: (c, r) => polygon(c, [[0, -1.2 * r], [1.2 * r, 0], [0, 1.2 * r], [-1.2 * r, 0]]),
    P: (c, r) => polygon(c, [[-1, -3], [1, -3], [1, -1], [3, -1], [3, 1], [1, 1], [1, 3], [-1, 3], [-1, 1], [-3, 1], [-3, -1], [-1, -1]]
      .map(([x, y]) => [x * r / 2.7, y * r / 2.7])),
    "*": (c, r) => polygon(c, Array.from({ length: 10 }, (_, i) => {
      const size = (i % 2 ? 0.5 : 1.3) * r, angle = Math.PI * (i / 5 - 0.5);
      return [size * Math.cos(angle), size * Math.sin(angle)];
    })),
  };
  const polygon = (c, points) => { points.forEach(([x, y], i) => i ? c.lineTo(x, y) : c.moveTo(x, y)); c.closePath(); };

  const marker = (c, name, x, y, r, colour, rim, open = false) => {
    c.save();
    c.translate(x, y);
    c.beginPath();
    if (name === "x" || name === "+") {
      for (const [dx, dy] of name === "x" ? [[1, 1], [1, -1]] : [[1.3, 0], [0, 1.3]]) { c.moveTo(-dx * r, -dy * r); c.lineTo(dx * r, dy * r); }
      c.lineWidth = 1.7; c.strokeStyle = colour; c.stroke();
    } else {
      (MARKERS[name] || MARKERS.o)(c, r);
      if (open) { c.lineWidth = 1.5; c.strokeStyle = colour; c.stroke(); }
      else {
        c.lineWidth = 2.2; c.lineJoin = "round"; c.strokeStyle = rim; c.stroke();
        c.fillStyle = colour; c.fill();
      }
    }
    c.restore();
  };

  const translucent = (colour, alpha) => colour + Math.round(255 * alpha).toString(16).padStart(2, "0");

  const ellipse = (c, view, x, y, a, b, d, colour, fill, width) => {
    c.beginPath();
    for (let i = 0; i <= 40; i++) {
      const cos = Math.cos(i * Math.PI / 20), sin = Math.sin(i * Math.PI / 20);
      c.lineTo(view.x(x + a * cos + b * sin), view.y(y + b * cos + d * sin));
    }
    c.fillStyle = translucent(colour, fill); c.fill();
    c.lineWidth = width; c.strokeStyle = translucent(colour, 0.95); c.stroke();
  };

  const polyline = (c, view, values, width, step) => {
    c.beginPath();
    for (let i = 0; i + 1 < values.length; i += step) c.lineTo(view.x(values[i]), view.y(values[i + 1]));
    c.lineWidth = width; c.lineJoin = "round"; c.stroke();
  };

  const strokes = (c, lines, width, colour, rim) => {
    c.lineCap = "round"; c.lineJoin = "round";
    for (const [tone, more] of [[rim, 2], [colour, 0]]) {
      c.beginPath();
      for (const line of lines) line.forEach(([u, v], i) => i ? c.lineTo(u, v) : c.moveTo(u, v));
      c.lineWidth = width + more; c.strokeStyle = tone; c.stroke();
    }
  };

  // Where the robot of a path is between two frames; empty before its first pose.
  const robotPose = ({ poses, upto }) => {
    const whole = Math.min(Math.floor(upto), poses.length / 3 - 1);
    const last = poses.slice(3 * whole, 3 * whole + 3), next = poses.slice(3 * whole + 3, 3 * whole + 6);
    return next.length ? mix("path", last, next, upto - whole) : last;
  };

  // A robot outside of the map: an arrow at the edge points to it.
  const outside = (c, view, layer, [x, y], tone) => {
    const [x0, y0, x1, y1] = view.bounds, away = Math.hypot(Math.max(x0 - x, x - x1, 0), Math.max(y0 - y, y - y1, 0));
    if (away < 50) return; // mm
    const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
    const u = clamp(view.x(x), view.x(x0) + 12, view.x(x1) - 12), v = clamp(view.y(y), view.y(y1) + 12, view.y(y0) - 12);
    c.save();
    c.translate(u, v); c.rotate(Math.atan2(view.y(y) - v, view.x(x) - u));
    c.beginPath(); polygon(c, [[10, 0], [-6, -8], [-6, 8]]);
    c.lineWidth = 2.2; c.lineJoin = "round"; c.strokeStyle = tone.rim; c.stroke();
    c.fillStyle = tone.of(layer); c.fill();
    c.restore();
    const right = u > view.x((x0 + x1) / 2), words = `${(away / 1000).toFixed(1)} m outside`;
    const at = [u + (right ? -14 : 14), clamp(v, view.y(y1) + 20, view.y(y0) - 20)];
    c.textAlign = right ? "right" : "left"; c.textBaseline = "middle"; c.font = "12px system-ui, sans-serif";
    c.lineWidth = 4; c.strokeStyle = tone.paper; c.strokeText(words, ...at);
    c.fillStyle = tone.text; c.fillText(words, ...at);
  };

  const robot = (c, view, layer, [x, y, angle], tone) => {
    const u = view.x(x), v = view.y(y), cos = Math.cos(angle / 1000), sin = Math.sin(angle / 1000), reach = 3.2 * ROBOT;
    for (const [colour, width] of [[tone.rim, 4.6], [tone.of(layer), 2.6]]) {
      c.beginPath(); c.moveTo(u, v); c.lineTo(u + reach * cos, v - reach * sin);
      c.lineCap = "round"; c.lineWidth = width; c.strokeStyle = colour; c.stroke();
    }
    marker(c, layer.marker, u, v, ROBOT, tone.of(layer), tone.rim);
  };

  // Each draws one kind of layer; `value` holds the frame's numbers, for a path those of all frames.
  const DRAW = {
    cells(c, view, layer, value, tone) {
      const side = layer.side * view.scale;
      c.fillStyle = translucent(tone.of(layer), layer.fill ?? 0.5);
      const many = value.length > 1000; // round corners of so many cells would take 50 ms
      c.beginPath();
      for (let i = 0; i < value.length; i += 2) {
        const u = view.x(value[i]) - side / 2, v = view.y(value[i + 1]) - side / 2;
        if (many) c.fillRect(u, v, side, side);
        else c.roundRect(u, v, side, side, side / 4);
      }
      c.fill();
    },
    cone(c, view, layer, value, tone) {
      for (let i = 0; i < value.length; i += 5) {
        const [x, y, angle, half, reach] = value.slice(i, i + 5), u = view.x(x), v = view.y(y), r = reach * view.scale;
        const shade = c.createRadialGradient(u, v, 0, u, v, r);
        shade.addColorStop(0, translucent(tone.of(layer), tone.dark ? 0.35 : 0.8)); shade.addColorStop(1, translucent(tone.of(layer), 0.06));
        c.beginPath(); c.moveTo(u, v); c.arc(u, v, r, -(angle + half) / 1000, -(angle - half) / 1000); c.closePath();
        c.fillStyle = shade; c.fill();
      }
    },
    lines(c, view, layer, value, tone) {
      c.strokeStyle = translucent(tone.of(layer), layer.alpha ?? 0.7);
      c.lineWidth = layer.width ?? 1;
      c.beginPath();
      for (let i = 0; i < value.length; i += 4) {
        c.moveTo(view.x(value[i]), view.y(value[i + 1])); c.lineTo(view.x(value[i + 2]), view.y(value[i + 3]));
      }
      c.stroke();
    },
    curve(c, view, layer, value, tone) {
      c.setLineDash((layer.dash || []).map(each => each * LINE));
      c.strokeStyle = tone.of(layer);
      polyline(c, view, value, layer.width ?? LINE, 2);
    },
    ellipses(c, view, layer, value, tone) {
      for (let i = 0; i < value.length; i += 5)
        ellipse(c, view, ...value.slice(i, i + 5), tone.of(layer), layer.fill ?? 0.16, layer.width ?? 1.3);
    },
    landmarks(c, view, layer, value, tone) {
      for (let i = 0; i < value.length; i += 3)
        marker(c, layer.markers[value[i + 2]] || "o", view.x(value[i]), view.y(value[i + 1]), layer.size ?? LANDMARK, tone.of(layer), tone.rim, layer.open);
    },
    points(c, view, layer, value, tone) {
      const small = (layer.size ?? LANDMARK) < 2;
      c.fillStyle = translucent(tone.of(layer), layer.alpha ?? 1);
      for (let i = 0; i < value.length; i += 2) {
        const u = view.x(value[i]), v = view.y(value[i + 1]);
        if (small) c.fillRect(u - layer.size, v - layer.size, 2 * layer.size, 2 * layer.size);
        else marker(c, layer.marker, u, v, layer.size ?? LANDMARK, tone.of(layer), tone.rim, layer.open);
        if (layer.texts) { c.textAlign = "left"; c.textBaseline = "alphabetic"; c.fillStyle = tone.text; c.font = "12px system-ui, sans-serif"; c.fillText(layer.texts[i / 2] ?? "", u + 6, v - 6); }
      }
    },
    // The half axis that is claimed, to both sides, and beside it the error: both have the scale of the map.
    axis(c, view, layer, value, tone) {
      for (let i = 0; i < value.length; i += 5) {
        const [x, y, angle, claimed, error] = value.slice(i, i + 5), half = claimed * view.scale, off = error * view.scale;
        if (half + off < 10) continue;
        c.save();
        c.translate(view.x(x), view.y(y)); c.rotate(-angle / 1000);
        strokes(c, [[[-half, -4], [-half, 4]], [[-half, 0], [half, 0]], [[half, -4], [half, 4]]], 3, tone.of(layer), tone.rim);
        strokes(c, [[[0, 0], [0, 9]], [[0, 7], [off, 7]], [[off - 4, 4], [off, 7], [off - 4, 10]]], 1.6, tone.of(layer), tone.rim);
        c.restore();
      }
    },
    // The headings that are claimed, and the true one; both angles are magnified, because they are often small.
    wedge(c, view, layer, value, tone) {
      if (!view.wedge || !value.length) return;
      const [x, y, angle, claimed, error] = value, r = view.wedge.radius, colour = tone.of(layer);
      const [half, off] = [claimed, error].map(each => each * view.wedge.wider / 1000);
      c.save();
      c.translate(view.x(x), view.y(y)); c.rotate(-angle / 1000);
      c.beginPath(); c.moveTo(0, 0); c.arc(0, 0, r, -half, half); c.closePath();
      c.fillStyle = translucent(colour, 0.3); c.fill();
      c.lineWidth = 1.6; c.strokeStyle = colour; c.stroke();
      c.rotate(-off);
      c.setLineDash([4, 3]);
      strokes(c, [[[0, 0], [r, 0]]], 1.6, colour, tone.rim);
      c.setLineDash([]);
      strokes(c, [[[r - 6, -4], [r, 0], [r - 6, 4]]], 1.6, colour, tone.rim);
      c.restore();
    },
    path(c, view, layer, value, tone) {
      const { poses, upto } = value, here = robotPose(value), whole = Math.floor(upto);
      if (!poses.length) return;
      if (layer.trail !== false) {
        c.setLineDash((layer.dash || []).map(each => each * LINE));
        c.strokeStyle = tone.of(layer);
        polyline(c, view, [...poses.slice(0, 3 * whole + 3), ...here], layer.width ?? LINE, 3);
        c.setLineDash([]);
      }
      if (layer.robot !== false) robot(c, view, layer, here, tone);
    },
  };

  const drawField = (c, view, field, tone) => {
    const { x, y, scale } = view;
    const box = ([x0, y0, x1, y1]) => c.fillRect(x(x0), y(y1), (x1 - x0) * scale, (y1 - y0) * scale);
    c.fillStyle = tone.dark ? field.carpet.dark : field.carpet.colour;
    c.save();
    c.translate(x(field.pose[0]), y(field.pose[1])); c.rotate(-field.pose[2] / 1000); c.translate(-x(0), -y(0));
    box(field.carpet.box);
    c.fillStyle = c.strokeStyle = tone.dark ? field.line.dark : field.line.colour;
    field.lines.forEach(box);
    c.lineWidth = Math.max(field.width * scale, 1);
    for (const [cx, cy, radius, first, last] of field.arcs) {
      c.beginPath(); c.arc(x(cx), y(cy), radius * scale, -last / 1000, -first / 1000); c.stroke();
    }
    c.strokeStyle = field.goal.colour; c.lineWidth = 3;
    for (const [x1, y1, x2, y2] of field.bars) { c.beginPath(); c.moveTo(x(x1), y(y1)); c.lineTo(x(x2), y(y2)); c.stroke(); }
    for (const [px, py, radius] of field.posts) {
      c.beginPath(); c.arc(x(px), y(py), Math.max(radius * scale, 3), 0, 2 * Math.PI);
      c.fillStyle = field.goal.colour; c.fill(); c.lineWidth = 1; c.strokeStyle = field.goal.rim; c.stroke();
    }
    c.restore();
  };

  const drawAxes = (c, view, tone) => {
    const [x0, y0, x1, y1] = view.bounds, most = Math.max(x1 - x0, y1 - y0) / 1000;
    const step = 1000 * (most > 24 ? 5 : most > 12 ? 2 : most > 3 ? 1 : 0.5);
    c.fillStyle = c.strokeStyle = tone.text; c.font = "11px system-ui, sans-serif"; c.lineWidth = 1;
    c.textAlign = "center"; c.textBaseline = "top";
    const named = (at, most) => `${at / 1000}${at + step > most ? " m" : ""}`; // the last tick has the unit
    const tick = (u, v, du, dv) => { c.beginPath(); c.moveTo(u, v); c.lineTo(u + du, v + dv); c.stroke(); };
    const bottom = view.y(y0), left = view.x(x0);
    for (let x = Math.ceil(x0 / step) * step; x <= x1; x += step) { tick(view.x(x), bottom, 0, 4); c.fillText(named(x, x1), view.x(x), bottom + 6); }
    c.textAlign = "right"; c.textBaseline = "middle";
    for (let y = Math.ceil(y0 / step) * step; y <= y1; y += step) { tick(left, view.y(y), -4, 0); c.fillText(named(y, y1), left - 6, view.y(y)); }
  };

  // --- the legend ---

  const SAMPLES = { path: [0, 0, 1200], cone: [0, 0, 0, 400, 900], cells: [0, 0], ellipses: [0, 0, 450, 0, 260],
    axis: [-240, 60, 0, 280, 760], wedge: [-400, -160, 0, 200, 500] };
  const key = (layer, tone) => {
    const canvas = document.createElement("canvas"), ratio = devicePixelRatio || 1, width = 34, height = 18;
    canvas.width = width * ratio; canvas.height = height * ratio;
    canvas.style.cssText = `width: ${width}px; height: ${height}px; border-radius: 3px; background: ${tone.paper}`;
    canvas.setAttribute("aria-hidden", "true");
    const c = canvas.getContext("2d");
    c.scale(ratio, ratio);
    const view = { x: u => width / 2 + u * 0.025, y: v => height / 2 - v * 0.025, scale: 0.025 };
    if (layer.posts) {
      c.strokeStyle = tone.of(layer);
      polyline(c, view, [-600, 0, 600, 0], 3, 2);
      marker(c, "o", width / 2, height / 2, 3, layer.posts.colour, layer.posts.rim);
    } else if (layer.kind === "path") {
      c.setLineDash((layer.dash || []).map(each => each * LINE)); c.strokeStyle = tone.of(layer);
      polyline(c, view, [-600, 0, 600, 0], LINE, 2);
      if (layer.robot !== false) marker(c, layer.marker, width / 2, height / 2, 4, tone.of(layer), tone.rim);
    } else if (layer.kind === "cone") DRAW.cone(c, { ...view, x: () => 4 }, layer, SAMPLES.cone, tone);
    else if (layer.kind === "curve" || layer.kind === "lines") {
      c.strokeStyle = tone.of(layer); c.setLineDash((layer.dash || []).map(each => each * LINE));
      polyline(c, view, [-600, 0, 600, 0], layer.width ?? LINE, 2);
    } else if (layer.kind === "landmarks") {
      const shown = layer.keys ?? [0];
      shown.forEach((kind, i) => marker(c, layer.markers[kind], width * (i + 1) / (shown.length + 1), height / 2, 4, tone.of(layer), tone.rim, layer.open));
    } else if (layer.kind === "cells") DRAW.cells(c, view, { ...layer, side: 480 }, SAMPLES.cells, tone);
    else if (layer.kind === "points" && (layer.size ?? LANDMARK) < 2) DRAW.points(c, view, layer, [-240, 80, 40, -160, 200, 120], tone);
    else if (layer.kind === "points") marker(c, layer.marker, width / 2, height / 2, 4, tone.of(layer), tone.rim, layer.open);
    else DRAW[layer.kind](c, { ...view, wedge: { radius: 20, wider: 1 } }, layer, SAMPLES[layer.kind], tone);
    return canvas;
  };

  // --- the map ---

  // A canvas that is given its size again is cleared, and the page is laid out again.
  const resize = (canvas, width, height, ratio) => {
    const [own, tall] = [width, height].map(each => Math.round(each * ratio));
    if (canvas.width === own && canvas.height === tall) return;
    canvas.width = own; canvas.height = tall;
    canvas.style.width = `${width}px`; canvas.style.height = `${height}px`;
  };

  class FieldMap {
    constructor(root, scene, alt) {
      this.scene = scene; this.root = root; this.values = [];
      this.canvas = document.createElement("canvas");
      this.canvas.className = "nao-map-canvas";
      this.canvas.setAttribute("role", "img");
      this.canvas.setAttribute("aria-label", alt);
      this.legend = document.createElement("div");
      this.legend.className = "nao-map-legend";
      this.lens = document.createElement("figure");
      this.lens.className = "nao-map-lens";
      this.lens.append(document.createElement("canvas"), document.createElement("figcaption"));
      const side = document.createElement("div");
      side.className = "nao-map-side";
      side.append(this.legend, this.lens);
      root.append(this.canvas, side);
      this.sizes = new ResizeObserver(() => this.draw());
      this.sizes.observe(root);
      this.stopTheme = onTheme(root, () => { this.keys = ""; this.draw(); this.onTheme?.(); });
    }
    tone() {
      const dark = isDark(this.root), paper = this.scene.paper, text = getComputedStyle(this.root).color;
      return { dark, text, rim: dark ? "#10180f" : "#ffffff", paper: dark ? paper.dark : paper.colour,
        of: layer => dark ? layer.dark : layer.colour };
    }
    show(values) { this.values = values; this.draw(); }
    draw() {
      const width = this.root.clientWidth, [x0, y0, x1, y1] = this.scene.bounds, ratio = devicePixelRatio || 1;
      if (!width || !this.root.isConnected) return;
      const { left, right, top, bottom } = MARGIN;
      const tallest = onPhone() ? Math.min(this.scene.tallest, 300) : this.scene.tallest; // leaves room for a matrix
      const most = tallest || this.root.clientHeight - this.legend.offsetHeight; // 0: as tall as its place
      const scale = Math.min((width - left - right) / (x1 - x0), (most - top - bottom) / (y1 - y0));
      const height = Math.round(scale * (y1 - y0) + top + bottom), own = Math.round(scale * (x1 - x0) + left + right);
      resize(this.canvas, own, height, ratio);
      const c = this.canvas.getContext("2d"), tone = this.tone();
      c.setTransform(ratio, 0, 0, ratio, 0, 0);
      c.clearRect(0, 0, own, height);
      const view = { scale, bounds: this.scene.bounds, x: u => left + (u - x0) * scale, y: v => top + (y1 - v) * scale };
      this.view = view;
      c.save();
      c.beginPath(); c.rect(left, top, own - left - right, height - top - bottom); c.clip();
      c.fillStyle = tone.paper; c.fillRect(0, 0, own, height);
      this.drawContents(c, view, tone);
      c.restore();
      this.scene.layers.forEach((layer, i) => {
        if (layer.kind === "path" && layer.robot !== false && this.isShown(i)) outside(c, view, layer, robotPose(this.values[i]), tone);
      });
      drawAxes(c, view, tone);
      this.drawLens(tone, scale);
      this.drawLegend(tone);
    }
    drawContents(c, view, tone) {
      if (this.scene.field) drawField(c, view, this.scene.field, tone);
      this.scene.layers.forEach((layer, i) => {
        const value = this.values[i];
        if (!value) return;
        c.save(); DRAW[layer.kind](c, view, layer, value, tone); c.restore();
      });
    }
    // The surroundings of the robot, enlarged until its ellipse and the other robots' positions can be compared.
    drawLens(tone, scale) {
      const i = this.scene.layers.findIndex(each => each.lens), [x, y, a, b, d] = this.values[i] ?? [];
      const others = this.scene.layers.flatMap((each, j) => each.lensed && this.isShown(j) ? [this.values[j].poses.slice(-3)] : []);
      const needs = Math.max(1.1 * Math.hypot(a, b, d), ...others.map(([u, v]) => 1.3 * Math.hypot(u - x, v - y)));
      const wedge = this.scene.layers.flatMap((each, j) => each.kind === "wedge" && this.isShown(j) ? [this.values[j]] : [])[0];
      const reach = REACHES.find(each => each >= needs) ?? (wedge && REACHES.at(-1));
      this.lens.hidden = !reach || (LENS / reach < ENLARGES * scale && !wedge);
      if (this.lens.hidden) return;
      const [canvas, caption] = this.lens.children, ratio = devicePixelRatio || 1, size = 2 * LENS;
      resize(canvas, size, size, ratio);
      const c = canvas.getContext("2d"), near = LENS / reach;
      c.save();
      c.setTransform(ratio, 0, 0, ratio, 0, 0);
      c.clearRect(0, 0, size, size);
      c.beginPath(); c.arc(LENS, LENS, LENS - 1, 0, 2 * Math.PI); c.clip();
      c.fillStyle = tone.paper; c.fillRect(0, 0, size, size);
      const wider = wedge && (WIDER.find(each => each * Math.max(wedge[3], Math.abs(wedge[4])) <= WIDEST) ?? 1);
      this.drawContents(c, { scale: near, x: u => LENS + (u - x) * near, y: v => LENS - (v - y) * near,
        wedge: { radius: LENS - 6, wider } }, tone);
      c.beginPath(); c.arc(LENS, LENS, LENS - 1, 0, 2 * Math.PI);
      c.lineWidth = 2; c.strokeStyle = tone.text; c.stroke();
      c.restore();
      const words = `${reach / 10} cm around the estimate, enlarged${wider > 1 ? `; angles ${wider} × as wide` : ""}`;
      if (caption.textContent !== words) caption.textContent = words;
    }
    legendEntries() {
      const { field, layers } = this.scene, shown = layers.flatMap((layer, i) => {
        if (!layer.label || !(layer.always || this.isShown(i))) return [];
        if (!layer.kinds) return [layer];
        const kinds = new Set(this.values[i].filter((_, j) => j % 3 === 2));
        return [...kinds].sort().map(kind => ({ ...layer, label: `${layer.label} ${layer.kinds[kind]}`, keys: [kind] }));
      });
      const drawnTwice = field?.label && shown.some(each => each.kinds);
      return drawnTwice ? [{ ...field.line, label: field.label, posts: field.goal }, ...shown] : shown;
    }
    drawLegend(tone) {
      const shown = this.legendEntries();
      const names = shown.map(each => each.label).join("|") + tone.dark;
      if (names === this.keys) return;
      this.keys = names;
      this.legend.replaceChildren(...shown.map(layer => {
        const entry = document.createElement("span");
        if (layer.kind) entry.className = layer.kind;
        entry.append(key(layer, tone), layer.label);
        return entry;
      }));
    }
    isShown(i) {
      const value = this.values[i];
      return Boolean(value && (value.poses ?? value).length);
    }
    remove() { this.sizes.disconnect(); this.stopTheme(); }
  }

  return { FieldMap, mix, isDark, WIDTHS };
})();
