// A robot of links and joints from the scene's plain data, opaque or translucent.
import { BufferAttribute, BufferGeometry, Group, Mesh, Vector3 } from "three";
import { Shaded, toRgb } from "./shaded.js";

// One geometry for the whole robot, which all robots of a scene share: each corner has the number of its link, because a
// drawing call for each link would take most of the time where there is no graphics card.
export function robotGeometry(data) {
  const bytes = (view) => view.buffer.slice(view.byteOffset, view.byteOffset + view.byteLength);
  const corners = Float32Array.from(new Int16Array(bytes(data.corners)), (value) => value * data.unit);
  const triangles = new Uint16Array(bytes(data.triangles));
  const perShape = corners.length / data.shapes.length / 3;
  const numbers = new Map(data.links.map(({ name }, i) => [name, i]));
  const colours = data.shapes.flatMap(({ colour }) => Array(perShape).fill(toRgb(colour)).flat());
  const links = data.shapes.flatMap(({ link }) => Array(perShape).fill(numbers.get(link)));
  const indices = data.shapes.flatMap((_, n) => Array.from(triangles, (i) => i + n * perShape));
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(corners, 3));
  geometry.setAttribute("color", new BufferAttribute(new Float32Array(colours), 3));
  geometry.setAttribute("link", new BufferAttribute(new Float32Array(links), 1));
  geometry.setIndex(indices);
  geometry.computeVertexNormals();
  return geometry;
}

export class Robot {
  constructor(data, geometry, ghost) {
    this.data = data;
    this.group = new Group(); // on the ground below the robot, at its pose
    this.body = new Group(); // tilted
    this.group.add(this.body);
    this.links = new Map();
    this.phase = 0;
    this.walking = 0;
    for (const { name, parent, origin, axis } of data.links) {
      const group = new Group();
      group.position.set(...origin);
      group.userData.axis = new Vector3(...axis);
      (parent ? this.links.get(parent) : this.body).add(group);
      this.links.set(name, group);
    }
    const frames = [...this.links.values()].map((group) => group.matrixWorld);
    this.materials = ghost
      ? // The first pass fills the depth buffer, so that the second one shows nothing of the robot's inside.
        [new Shaded(ghost.colour, ghost.opacity, frames), new Shaded(ghost.colour, ghost.opacity, frames)]
      : [new Shaded(null, 1, frames)];
    if (ghost) this.materials[0].colorWrite = false;
    this.materials.forEach((material, i) => {
      const mesh = new Mesh(geometry, material);
      mesh.frustumCulled = false;
      mesh.renderOrder = ghost ? 20 + i : 0;
      this.group.add(mesh);
    });
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
      link.quaternion.setFromAxisAngle(link.userData.axis, angle);
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
