// A robot of links and joints from the scene's plain data, opaque or translucent.
import { BufferAttribute, BufferGeometry, Group, Mesh, MeshBasicMaterial, Quaternion, Vector3 } from "three";
import { Shaded, toRgb } from "./shaded.js";

// One geometry for each link, shared by all robots of a scene.
export function linkGeometries(data) {
  const bytes = (view) => view.buffer.slice(view.byteOffset, view.byteOffset + view.byteLength);
  const corners = new Int16Array(bytes(data.corners));
  const triangles = new Uint16Array(bytes(data.triangles));
  const perShape = corners.length / data.shapes.length;
  const found = new Map();
  for (const { name } of data.links) {
    const mine = data.shapes.map((shape, i) => [shape, i]).filter(([shape]) => shape.link === name);
    if (!mine.length) continue;
    const positions = new Float32Array(mine.length * perShape);
    const colours = new Float32Array(mine.length * perShape);
    const indices = new Uint32Array(mine.length * triangles.length);
    mine.forEach(([shape, i], n) => {
      const colour = toRgb(shape.colour);
      for (let k = 0; k < perShape; k++) positions[n * perShape + k] = corners[i * perShape + k] * data.unit;
      for (let k = 0; k < perShape; k += 3) colours.set(colour, n * perShape + k);
      for (let k = 0; k < triangles.length; k++) indices[n * triangles.length + k] = triangles[k] + (n * perShape) / 3;
    });
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setAttribute("color", new BufferAttribute(colours, 3));
    geometry.setIndex(new BufferAttribute(indices, 1));
    geometry.computeVertexNormals();
    found.set(name, geometry);
  }
  return found;
}

export class Robot {
  constructor(data, geometries, ghost) {
    this.data = data;
    this.group = new Group(); // on the ground below the robot, at its pose
    this.body = new Group(); // tilted
    this.group.add(this.body);
    this.links = new Map();
    this.phase = 0;
    this.walking = 0;
    const layers = ghost
      ? [
          // The first pass fills the depth buffer, so that the second one shows nothing of the robot's inside.
          [new MeshBasicMaterial({ colorWrite: false, transparent: true }), 20],
          [new Shaded(ghost.colour, ghost.opacity), 21],
        ]
      : [[new Shaded(null), 0]];
    for (const { name, parent, origin, axis } of data.links) {
      const group = new Group();
      group.position.set(...origin);
      group.userData.axis = new Vector3(...axis);
      (parent ? this.links.get(parent) : this.body).add(group);
      this.links.set(name, group);
      if (!geometries.has(name)) continue;
      for (const [material, order] of layers) {
        const mesh = new Mesh(geometries.get(name), material);
        mesh.renderOrder = order;
        group.add(mesh);
      }
    }
    this.materials = layers.map(([material]) => material);
  }

  place([x, y, theta], head, [pitch, roll]) {
    this.group.position.set(x, y, 0);
    this.group.rotation.set(0, 0, theta);
    this.body.rotation.set(roll, pitch, 0, "ZYX");
    const angles = { ...this.data.rest, HeadYaw: head[0], HeadPitch: head[1] };
    const { joints, angles: table } = this.data.gait;
    if (this.walking > 0.001) {
      const at = ((((this.phase / (2 * Math.PI)) % 1) + 1) % 1) * table.length;
      const [low, high, part] = [table[Math.floor(at)], table[Math.ceil(at) % table.length], at % 1];
      joints.forEach((name, i) => {
        const angle = low[i] + part * (high[i] - low[i]);
        angles[name] += this.walking * (angle - angles[name]);
      });
    }
    for (const [name, angle] of Object.entries(angles)) {
      const link = this.links.get(name);
      link.quaternion.copy(new Quaternion().setFromAxisAngle(link.userData.axis, angle));
    }
  }

  // Let the legs follow a motion of the body: metres ahead and radians to the left in `seconds`.
  step(ahead, turn, seconds) {
    const distance = ahead + Math.sign(ahead || 1) * Math.abs(turn) * 0.08;
    this.phase += (2 * Math.PI * distance) / this.data.gait.stride;
    const goal = Math.abs(distance) > 1e-5 ? 1 : 0;
    this.walking += (goal - this.walking) * Math.min(1, seconds / 0.12);
  }

  get resting() {
    return this.walking < 0.001;
  }

  dispose() {
    for (const material of this.materials) material.dispose();
  }
}
