// The live map: Python sends what has changed since the last message, and the browser moves everything there.
const NaoLive = (() => {
  const { FieldMap, mix } = NaoMap;
  const LONGEST = 150; // ms that a movement takes at most
  const PAUSE = 24; // ms: with it a movement has 30 frames a second. Each takes time from the robot's next picture.

  class LiveMap {
    constructor(root, scene) {
      this.scene = scene; this.root = root;
      root.classList.add("nao-map");
      this.names = scene.layers.map(each => each.name);
      this.from = scene.layers.map(() => []); this.to = scene.layers.map(() => []);
      this.number = -1; this.arrived = 0;
      this.map = new FieldMap(root, scene, scene.alt);
    }
    // Returns whether the message fits to what is here; if not, the whole state has to be sent.
    receive({ number, whole, layers, alt, tweens }) {
      if (!whole && number !== this.number + 1) return number <= this.number;
      this.number = number;
      const now = performance.now();
      this.length = whole || !tweens ? 0 : Math.min(now - this.arrived, LONGEST);
      this.arrived = now;
      this.from = [...this.to];
      for (const [name, change] of Object.entries(layers)) {
        const i = this.names.indexOf(name);
        this.to[i] = change.add ? [...this.to[i], ...change.add] : change;
        if (whole || (this.scene.layers[i].kind === "path" && !change.add)) this.from[i] = this.to[i];
      }
      if (alt) this.map.canvas.setAttribute("aria-label", alt);
      this.schedule(0);
      return true;
    }
    schedule(pause) {
      this.stop();
      const draw = () => { this.frame = requestAnimationFrame(() => this.move()); };
      if (pause) this.timer = setTimeout(draw, pause);
      else draw();
    }
    stop() { clearTimeout(this.timer); cancelAnimationFrame(this.frame); }
    move() {
      const part = this.length ? Math.min((performance.now() - this.arrived) / this.length, 1) : 1;
      this.map.show(this.scene.layers.map((layer, i) => {
        const from = this.from[i], to = this.to[i];
        if (layer.kind !== "path") return layer.jumps ? to : mix(layer.kind, from, to, part);
        const before = from.length / 3 - 1, after = to.length / 3 - 1;
        return { poses: to, upto: before < 0 ? after : before + part * (after - before) };
      }));
      if (part < 1) this.schedule(PAUSE);
    }
    remove() { this.stop(); this.map.remove(); }
  }

  return { LiveMap };
})();
