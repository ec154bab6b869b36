// The player of a film: a map, perhaps matrices beside it, and controls that mouse, keyboard and screen reader can use.
const NaoFilm = (() => {
  const { FieldMap, mix, isDark } = NaoMap;

  // A frame that is null equals the one before it; a layer with a single frame stands still.
  const unpacked = frames => {
    let last = [];
    return frames.map(each => (last = each ?? last));
  };

  const valuesAt = (layers, time) => layers.map(layer => {
    if (layer.kind === "path") {
      const { poses, counts } = layer, i = Math.min(Math.floor(time), counts.length - 1);
      const next = counts[Math.min(i + 1, counts.length - 1)];
      return counts[i] ? { poses: poses.slice(0, 3 * next), upto: counts[i] - 1 + (time - i) * (next - counts[i]) } : null;
    }
    const { frames } = layer, i = Math.min(Math.floor(time), frames.length - 1), next = frames[Math.min(i + 1, frames.length - 1)];
    if (layer.keeps) return [].concat(...frames.slice(0, i + 1));
    return layer.jumps ? frames[i] : mix(layer.kind, frames[i], next, time - i);
  });

  // --- a symmetric matrix beside the map ---

  class Matrix {
    constructor(root, data, layers) {
      this.data = data;
      this.frames = unpacked(data.frames);
      const figure = document.createElement("figure"), title = document.createElement("figcaption");
      this.canvas = document.createElement("canvas");
      this.canvas.setAttribute("role", "img");
      this.canvas.setAttribute("aria-label", data.alt);
      title.textContent = data.title;
      this.bar = document.createElement("div");
      this.bar.className = "nao-film-bar";
      figure.append(title, this.canvas, this.bar);
      root.append(figure);
      this.root = figure;
    }
    colour(value, dark) {
      if (!value) return dark ? this.data.zero.dark : this.data.zero.colour;
      const end = value > 0 ? this.data.positive : this.data.negative, base = dark ? [24, 28, 34] : [255, 255, 255];
      const part = 0.16 + 0.84 * Math.min(Math.abs(value) / this.data.levels, 1);
      const rgb = [1, 3, 5].map(i => parseInt((dark ? end.dark : end.colour).slice(i, i + 2), 16));
      return `rgb(${rgb.map((each, i) => Math.round(base[i] + (each - base[i]) * part))})`;
    }
    draw(time) {
      const dark = isDark(this.root), text = getComputedStyle(this.root).color, ratio = devicePixelRatio || 1;
      const i = Math.min(Math.floor(time), this.frames.length - 1), now = this.frames[i];
      const { size, blocks, names } = this.data, room = 30;
      const width = Math.min(this.root.clientWidth, 420);
      if (width < 40) return;
      const cell = (width - room - 4) / size, whole = cell * size;
      this.canvas.width = Math.round(width * ratio); this.canvas.height = Math.round((whole + room) * ratio);
      this.canvas.style.width = `${width}px`; this.canvas.style.height = `${whole + room}px`;
      const c = this.canvas.getContext("2d");
      c.setTransform(ratio, 0, 0, ratio, 0, 0);
      c.clearRect(0, 0, width, whole + room);
      let place = 0;
      for (let row = 0; row < size; row++) for (let column = row; column < size; column++) {
        c.fillStyle = this.colour(now[place++] ?? 0, dark);
        c.fillRect(room + column * cell, room + row * cell, cell + 0.5, cell + 0.5);
        c.fillRect(room + row * cell, room + column * cell, cell + 0.5, cell + 0.5);
      }
      c.strokeStyle = text; c.fillStyle = text; c.font = "11px system-ui, sans-serif"; c.textBaseline = "middle";
      c.strokeRect(room, room, whole, whole);
      let from = 0;
      blocks.forEach((length, number) => {
        const middle = room + (from + length / 2) * cell, edge = room + (from + length) * cell;
        if (names[number]) {
          c.textAlign = "center"; c.fillText(names[number], middle, room - 10);
          const turns = c.measureText(names[number]).width > room - 6;
          c.save();
          c.translate(turns ? room - 10 : room - 5, middle);
          if (turns) c.rotate(-Math.PI / 2);
          c.textAlign = turns ? "center" : "right"; c.fillText(names[number], 0, 0);
          c.restore();
        }
        c.globalAlpha = number ? 0.3 : 0.8;
        c.beginPath(); c.moveTo(edge, room); c.lineTo(edge, room + whole); c.moveTo(room, edge); c.lineTo(room + whole, edge);
        c.lineWidth = number ? 0.6 : 1.4; c.stroke();
        c.globalAlpha = 1;
        from += length;
      });
      const marked = this.data.marked && unpacked(this.data.marked)[i];
      if (marked) {
        c.lineWidth = 2; c.strokeStyle = this.data.mark;
        for (const row of marked) for (const column of marked) c.strokeRect(room + column * cell, room + row * cell, cell, cell);
      }
      const tones = (this.data.signs ? [[-1, "negative"], [1, "positive"]] : [[-1, "−1"], [-0.5, ""], [0, "0"], [0.5, ""], [1, "1"]]);
      this.bar.replaceChildren(...tones.map(([value, words]) => {
        const entry = document.createElement("span"), patch = document.createElement("i");
        patch.style.background = this.colour(value * this.data.levels, dark);
        entry.append(patch, words);
        return entry;
      }));
    }
  }

  // --- controls ---

  const button = (words, title, press) => {
    const made = document.createElement("button");
    made.type = "button"; made.textContent = words; made.title = title;
    made.addEventListener("click", event => {
      press();
      if (event.detail) made.closest(".nao-film")?.focus({ preventScroll: true }); // after the mouse, space plays
    });
    return made;
  };

  class Player {
    constructor(root, film) {
      this.film = film; this.root = root; this.time = 0; this.last = film.captions.length - 1;
      for (const layer of film.layers) {
        layer.frames = unpacked(layer.frames);
        if (layer.kind === "path") {
          layer.poses = [].concat(...layer.frames);
          let count = 0;
          layer.counts = layer.frames.map(each => (count += each.length / 3));
        }
      }
      root.classList.add("nao-film");
      root.setAttribute("role", "group");
      root.setAttribute("aria-label", film.title);
      root.tabIndex = 0;
      root.dataset.lmSuppressShortcuts = "true"; // JupyterLab leaves the keys of this element alone
      this.build();
      this.still = matchMedia("(prefers-reduced-motion: reduce)");
      this.go(film.start ?? 0);
      if (film.plays && !this.still.matches) this.toggle(1);
    }
    build() {
      const { film } = this, views = document.createElement("div"), bar = document.createElement("div");
      views.className = "nao-film-views";
      const map = document.createElement("div");
      map.className = "nao-map";
      views.append(map);
      this.map = new FieldMap(map, film, film.alt);
      this.map.onTheme = () => this.draw();
      this.matrices = film.matrices.map(each => new Matrix(views, each));
      this.sizes = new ResizeObserver(() => this.matrices.forEach(each => each.draw(this.time)));
      this.sizes.observe(this.root);
      bar.className = "nao-film-controls";
      this.play = button("▶ Play", "Play or pause (space)", () => this.toggle(1));
      this.play.classList.add("nao-film-play");
      this.back = button("◀ Step", "One step back (left arrow)", () => this.step(-1));
      this.on = button("Step ▶", "One step on (right arrow)", () => this.step(1));
      this.slider = document.createElement("input");
      Object.assign(this.slider, { type: "range", min: 0, max: this.last, step: 1, value: 0 });
      this.slider.setAttribute("aria-label", film.step);
      this.slider.addEventListener("input", () => { this.pause(); this.go(Number(this.slider.value)); });
      this.speed = document.createElement("select");
      this.speed.setAttribute("aria-label", `${film.step}s per second`);
      this.speed.title = `${film.step}s per second`;
      for (const pace of film.paces) this.speed.add(new Option(`${pace} a second`, pace, false, pace === film.pace));
      this.where = document.createElement("span");
      this.where.className = "nao-film-where";
      const keys = document.createElement("span");
      keys.className = "nao-film-keys";
      keys.textContent = "Keys: space, ← →, b for backwards";
      bar.append(this.play, this.back, this.on, this.slider, this.where, this.speed, keys);
      this.words = document.createElement("p");
      this.words.className = "nao-film-words";
      this.words.setAttribute("role", "status");
      this.root.append(views, bar, this.words);
      this.root.addEventListener("keydown", event => this.key(event));
    }
    // --- from outside ---
    go(time) {
      this.time = Math.min(Math.max(time, 0), this.last);
      this.draw();
    }
    step(direction) {
      this.pause();
      this.go(direction > 0 ? Math.floor(this.time + 1e-6) + 1 : Math.ceil(this.time - 1e-6) - 1);
    }
    toggle(direction) {
      const stops = this.direction === direction;
      this.pause();
      if (stops) return;
      if (direction > 0 && this.time >= this.last) this.time = 0;
      if (direction < 0 && this.time <= 0) this.time = this.last;
      this.onPlay?.();
      this.direction = direction;
      this.play.textContent = "❚❚ Pause";
      this.words.setAttribute("aria-live", "off"); // a screen reader cannot follow a film
      this.before = performance.now();
      const tick = now => {
        if (!this.direction || !this.root.isConnected) return this.pause();
        this.clock = (this.clock ?? this.time) + direction * Math.max(now - this.before, 0) / 1000 * Number(this.speed.value);
        this.before = now;
        this.go(this.still.matches ? Math.round(this.clock) : this.clock);
        if (direction > 0 ? this.clock >= this.last : this.clock <= 0) return this.pause();
        this.frame = requestAnimationFrame(tick);
      };
      this.clock = this.time;
      this.frame = requestAnimationFrame(tick);
    }
    pause() {
      cancelAnimationFrame(this.frame);
      this.direction = 0; this.clock = undefined;
      this.play.textContent = "▶ Play";
      this.words.setAttribute("aria-live", "polite");
    }
    draw() {
      const at = Math.floor(this.time + 1e-6), words = this.film.captions[at];
      this.map.show(valuesAt(this.film.layers, this.time));
      this.matrices.forEach(each => each.draw(this.time));
      this.slider.value = at;
      this.slider.setAttribute("aria-valuetext", words);
      this.where.textContent = `${at} of ${this.last}`;
      if (this.words.textContent !== words) this.words.textContent = words;
      this.root.dataset.frame = at;
    }
    key(event) {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const typing = event.target.tagName === "SELECT", pressing = event.target.tagName === "BUTTON";
      const act = { ArrowRight: () => this.step(1), ArrowLeft: () => this.step(-1), Home: () => { this.pause(); this.go(0); },
        End: () => { this.pause(); this.go(this.last); }, " ": () => this.toggle(1), b: () => this.toggle(-1) }[event.key];
      if (!act || typing || (pressing && event.key === " ")) return;
      event.preventDefault(); event.stopPropagation();
      act();
    }
    remove() { this.pause(); this.map.remove(); this.sizes.disconnect(); this.root.replaceChildren(); }
  }

  // On a page, each element of class nao-film-here holds its film as JSON.
  const startPage = () => {
    for (const place of document.querySelectorAll(".nao-film-here")) {
      const film = JSON.parse(place.querySelector("script").textContent), root = document.createElement("div");
      place.replaceChildren(root);
      new Player(root, film);
    }
  };

  return { Player, startPage };
})();
