// The scene on a canvas: drawn when something changes, and in between two updates of a driving robot.
import {
  Mesh, MeshBasicMaterial, PerspectiveCamera, PlaneGeometry, Scene, Vector3, WebGLRenderer,
} from "three";
import { Cone } from "./cone.js";
import { Overlay } from "./overlay.js";
import { Robot, robotGeometry } from "./robot.js";
import { LEVEL, Room, shadowTexture } from "./room.js";

const JUMP = 0.7; // m: a robot that is put somewhere else does not walk there
const TWEEN = [40, 260]; // ms: shortest and longest time between two updates that is filled with motion
const CHANGE_OF_VIEW = 450; // ms
const SLOW = 38; // ms a frame: with more, the picture gets fewer pixels

const turnOf = (from, to) => Math.atan2(Math.sin(to - from), Math.cos(to - from));
const mix = (from, to, part) => from + part * (to - from);
const mixPose = (from, to, part) => [
  mix(from[0], to[0], part), mix(from[1], to[1], part), from[2] + part * turnOf(from[2], to[2]),
];

// Whether the processor draws, for which smooth edges take too long; an error where there is no WebGL at all.
function isSoftware() {
  const context = document.createElement("canvas").getContext("webgl2");
  if (!context) throw new Error("the browser makes no context");
  const details = context.getExtension("WEBGL_debug_renderer_info");
  const name = context.getParameter(details ? details.UNMASKED_RENDERER_WEBGL : context.RENDERER);
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

export class View {
  constructor(parent, scene, model) {
    this.data = scene;
    this.canvas = document.createElement("canvas");
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: !isSoftware(), alpha: true });
    parent.append(this.canvas);
    this.source = model.get("source");
    this.scene = new Scene();
    this.camera = new PerspectiveCamera((scene.fieldOfView * 180) / Math.PI, 1.6, 0.05, 40);
    this.camera.up.set(0, 0, 1);
    this.room = new Room(scene, () => this.invalidate());
    this.overlay = new Overlay(scene, this.source);
    const geometry = robotGeometry(scene.robot);
    const { colour } = scene.sources[this.source];
    this.robots = {
      truth: new Robot(scene.robot, geometry, null),
      estimate: new Robot(scene.robot, geometry, { colour, opacity: scene.opacities.ghost }),
    };
    this.shadow = new Mesh(
      new PlaneGeometry(0.46, 0.46),
      new MeshBasicMaterial({ map: shadowTexture(), transparent: true, depthWrite: false }),
    );
    this.shadow.position.z = LEVEL.shadow;
    this.shadow.renderOrder = -2;
    this.cones = {};
    for (const [name, camera] of Object.entries(scene.cameras)) {
      this.cones[name] = new Cone(camera, scene.opacities, scene.colours.cone, () => this.invalidate());
    }
    this.scene.add(this.room.group, this.overlay.group, this.shadow, ...Object.values(this.robots).map(({ group }) => group));
    this.frames = 0;
    this.ratio = Math.min(devicePixelRatio || 1, 2);
    this.observe(parent);
    this.snap(model.get("contents"));
    this.setTrails(model.get("trails"));
    for (const name of Object.keys(this.cones)) this.setPicture(name, model.get(name));
  }

  observe(parent) {
    this.sizes = new ResizeObserver(() => {
      const { clientWidth: width, clientHeight: height } = parent;
      if (!width || !height) return;
      this.size = [width, height];
      this.resize();
    });
    this.sizes.observe(parent);
    this.onScreen = true;
    this.sight = new IntersectionObserver(([entry]) => {
      this.onScreen = entry.isIntersecting;
      if (this.onScreen) this.invalidate();
    });
    this.sight.observe(parent);
  }

  resize() {
    const [width, height] = this.size;
    this.renderer.setPixelRatio(this.ratio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.invalidate();
  }

  setPicture(name, bytes) {
    this.cones[name].show(bytes).catch((error) => console.warn(`A picture could not be shown: ${error.message}`));
  }

  setTrails(trails) {
    this.overlay.setTrails(trails);
    this.invalidate();
  }

  // Show new contents at once.
  snap(contents) {
    this.goal = contents;
    this.from = null;
    this.now = { truth: contents.truth, estimate: contents.estimate, head: contents.head, tilt: contents.tilt };
    this.overlay.update(contents);
    this.attachCones();
    this.invalidate();
  }

  // Move to new contents in the time that passed since the last ones.
  update(contents) {
    const far = (name) => {
      const [a, b] = [this.now[name], contents[name]];
      return !a !== !b || (a && Math.hypot(a[0] - b[0], a[1] - b[1]) > JUMP);
    };
    if (far("truth") || far("estimate") || !this.onScreen) {
      this.snap(contents);
      return;
    }
    const time = performance.now();
    const since = Math.min(Math.max(time - (this.updated ?? 0), TWEEN[0]), TWEEN[1]);
    this.updated = time;
    this.from = { ...this.now, began: time, lasts: since * 1.1 };
    this.goal = contents;
    this.overlay.update(contents);
    this.invalidate();
  }

  attachCones() {
    const robot = this.robots[this.now.truth ? "truth" : "estimate"];
    const shown = this.now.truth || this.now.estimate;
    for (const cone of Object.values(this.cones)) {
      if (shown) robot.links.get("HeadPitch").add(cone.group);
      else cone.group.removeFromParent();
    }
  }

  // Look from a viewpoint; `smoothly` moves there.
  look(viewpoint, smoothly = false) {
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.leaving = smoothly && !still && this.placed ? { ...this.placed, began: performance.now() } : null;
    this.viewpoint = viewpoint;
    this.invalidate();
  }

  // Where the viewpoint is at the moment, in the world: it may follow the robot.
  place() {
    const { azimuth, elevation, distance, target, follows } = this.viewpoint;
    const [x, y, theta] = follows ? (this.now.truth ?? this.now.estimate ?? [0, 0, 0]) : [0, 0, 0];
    const [c, s] = [Math.cos(theta), Math.sin(theta)];
    const at = [x + c * target[0] - s * target[1], y + s * target[0] + c * target[1], target[2]];
    return { azimuth: azimuth + theta, elevation, distance, target: at };
  }

  placeCamera(time) {
    let placed = this.place();
    if (this.leaving) {
      const part = Math.min((time - this.leaving.began) / CHANGE_OF_VIEW, 1);
      const eased = part * part * (3 - 2 * part);
      placed = {
        azimuth: this.leaving.azimuth + eased * turnOf(this.leaving.azimuth, placed.azimuth),
        elevation: mix(this.leaving.elevation, placed.elevation, eased),
        distance: mix(this.leaving.distance, placed.distance, eased),
        target: placed.target.map((value, i) => mix(this.leaving.target[i], value, eased)),
      };
      if (part >= 1) this.leaving = null;
    }
    this.placed = placed;
    const level = Math.cos(placed.elevation);
    const away = new Vector3(level * Math.cos(placed.azimuth), level * Math.sin(placed.azimuth), Math.sin(placed.elevation));
    const target = new Vector3(...placed.target);
    this.camera.position.copy(target).addScaledVector(away, placed.distance);
    this.camera.lookAt(target);
  }

  moveRobots(time) {
    const before = this.now;
    let part = 1;
    if (this.from) {
      part = Math.min((time - this.from.began) / this.from.lasts, 1);
      const pose = (name) => (this.goal[name] ? mixPose(this.from[name], this.goal[name], part) : null);
      const pair = (name) => this.goal[name].map((value, i) => mix(this.from[name][i], value, part));
      this.now = { truth: pose("truth"), estimate: pose("estimate"), head: pair("head"), tilt: pair("tilt") };
      if (part >= 1) this.from = null;
    }
    const seconds = Math.min((time - (this.drawn ?? time)) / 1000, 0.1);
    for (const [name, robot] of Object.entries(this.robots)) {
      // Rays of the estimate need its cameras also where there is only a true robot.
      const [pose, old] = [this.now[name] ?? this.now.truth, before[name]];
      robot.group.visible = Boolean(this.now[name]);
      if (!pose) continue;
      if (old) {
        const ahead = (pose[0] - old[0]) * Math.cos(old[2]) + (pose[1] - old[1]) * Math.sin(old[2]);
        robot.step(ahead, turnOf(old[2], pose[2]), seconds);
      }
      robot.place(pose, this.now.head, name === "truth" ? this.now.tilt : [0, 0]);
    }
    const onGround = this.now.truth ?? this.now.estimate;
    this.shadow.visible = Boolean(onGround);
    if (onGround) this.shadow.position.set(onGround[0], onGround[1], LEVEL.shadow);
    return part < 1 || Object.values(this.robots).some((robot) => robot.group.visible && !robot.resting);
  }

  // Ask for a new frame.
  invalidate() {
    if (this.waiting || this.closed) return;
    this.waiting = requestAnimationFrame((time) => {
      this.waiting = 0;
      if (this.onScreen && this.size && this.viewpoint) this.draw(time);
    });
  }

  draw(time) {
    const moving = this.moveRobots(time);
    this.placeCamera(time);
    this.scene.updateMatrixWorld();
    const eye = this.camera.position;
    this.room.see(eye, this.data.wallsFade);
    for (const cone of Object.values(this.cones)) cone.see(eye);
    this.overlay.showRays(this.goal.rays, (source, camera) => this.cameraOf(source, camera));
    this.renderer.render(this.scene, this.camera);
    this.frames += 1;
    if (moving || this.leaving) {
      this.invalidate();
      this.saveTime(time - (this.drawn ?? time));
    }
    this.drawn = moving || this.leaving ? time : undefined;
  }

  // Fewer pixels where frames take long, as without a graphics card.
  saveTime(took) {
    if (!took) return;
    this.pace = mix(this.pace ?? took, took, 0.15);
    if (this.pace < SLOW || this.ratio <= 0.75) return;
    this.ratio = Math.max(this.ratio * 0.75, 0.75);
    this.pace = undefined;
    this.resize();
  }

  cameraOf(source, camera) {
    const robot = this.robots[source === "truth" ? "truth" : "estimate"];
    if (!this.now.truth && !robot.group.visible) return null;
    const [x, y, z] = [0, 1, 2].map((i) => this.data.cameras[camera].pose[i][3]);
    return robot.links.get("HeadPitch").localToWorld(new Vector3(x, y, z));
  }

  close() {
    this.closed = true;
    cancelAnimationFrame(this.waiting);
    this.sizes.disconnect();
    this.sight.disconnect();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }
}
