// What lies on the carpet and hangs in the air: paths, ellipses, landmarks and rays.
import {
  BufferAttribute, BufferGeometry, CircleGeometry, CylinderGeometry, Group, LineBasicMaterial, LineLoop, Matrix4, Mesh,
  MeshBasicMaterial, Vector3,
} from "three";
import { groundQuads, LEVEL } from "./room.js";

const WIDTH = 0.022; // m, of a path
const DASH = 0.07; // m
const RAY = 0.007; // m, radius

const circle = new CircleGeometry(1, 40);
const ring = new BufferGeometry();
ring.setAttribute("position", new BufferAttribute(circle.attributes.position.array.slice(3), 3));
const cylinder = new CylinderGeometry(RAY, RAY, 1, 8).rotateX(Math.PI / 2).translate(0, 0, 0.5);
const disc = new CircleGeometry(1, 20);
const plus = groundQuads([[[-1, -0.36], [1, -0.36], [1, 0.36], [-1, 0.36]], [[-0.36, -1], [0.36, -1], [0.36, 1], [-0.36, 1]]], 0);

// Objects that are made when they are first needed, and hidden when they are not.
class Pool extends Group {
  constructor(make) {
    super();
    this.make = make;
  }

  show(items, place) {
    while (this.children.length < items.length) this.add(this.make());
    this.children.forEach((child, i) => {
      child.visible = i < items.length;
      if (child.visible) place(child, items[i]);
    });
  }
}

function layered(colour, geometry, size, height) {
  const group = new Group();
  [["#ffffff", size * 1.35], [colour, size]].forEach(([each, radius], i) => {
    const mesh = new Mesh(geometry, new MeshBasicMaterial({ color: each, side: 2 }));
    mesh.scale.set(radius, radius, 1);
    mesh.position.z = height + 0.001 * i;
    group.add(mesh);
  });
  return group;
}

export class Overlay {
  constructor(scene, source) {
    this.scene = scene;
    this.group = new Group();
    const { colour } = scene.sources[source];
    const fill = new MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.28, depthWrite: false });
    const edge = new LineBasicMaterial({ color: colour });
    this.ellipses = new Pool(() => {
      const group = new Group();
      group.matrixAutoUpdate = false;
      group.add(new Mesh(circle, fill), new LineLoop(ring, edge));
      group.children[0].renderOrder = -3;
      return group;
    });
    this.marks = {
      post: new Pool(() => layered(colour, disc, 0.03, LEVEL.marks)),
      corner: new Pool(() => layered(colour, plus, 0.045, LEVEL.marks)),
    };
    this.rays = {};
    for (const [name, { colour: each }] of Object.entries(scene.sources)) {
      const material = new MeshBasicMaterial({ color: each });
      const pool = new Pool(() => {
        const group = new Group();
        group.add(new Mesh(cylinder, material), layered(each, disc, 0.022, 0));
        return group;
      });
      this.rays[name] = pool;
      this.group.add(pool);
    }
    this.trails = {};
    this.group.add(this.ellipses, ...Object.values(this.marks));
  }

  update({ ellipses, landmarks }) {
    this.ellipses.show(ellipses, (group, [[x, y], [ax, ay], [bx, by]]) => {
      group.matrix.copy(new Matrix4().set(ax, bx, 0, x, ay, by, 0, y, 0, 0, 1, LEVEL.ellipses, 0, 0, 0, 1));
      // A mirrored circle would show its back.
      if (ax * by - ay * bx < 0) group.matrix.multiply(new Matrix4().makeScale(1, -1, 1));
    });
    for (const [kind, pool] of Object.entries(this.marks)) {
      const mine = landmarks.filter(([, , each]) => each === kind);
      pool.show(mine, (group, [x, y]) => group.position.set(x, y, 0));
    }
  }

  showRays(rays, origin) {
    for (const [name, pool] of Object.entries(this.rays)) {
      const mine = rays.filter(([source, camera]) => source === name && origin(source, camera));
      pool.show(mine, (group, [source, camera, x, y, z]) => {
        const [line, end] = group.children;
        const [start, point] = [origin(source, camera), new Vector3(x, y, z)];
        line.position.copy(start);
        line.lookAt(point);
        line.scale.set(1, 1, start.distanceTo(point));
        end.position.set(x, y, z + LEVEL.marks);
      });
    }
  }

  // Paths in millimetres, [x, y, x, y, ...], by source; only the truth's line has no gaps.
  setTrails(trails) {
    for (const [name, flat] of Object.entries(trails)) {
      let mesh = this.trails[name];
      if (!mesh) {
        const material = new MeshBasicMaterial({ color: this.scene.sources[name].colour, side: 2 });
        mesh = this.trails[name] = new Mesh(new BufferGeometry(), material);
        mesh.renderOrder = -4;
        mesh.frustumCulled = false;
        this.group.add(mesh);
      }
      mesh.geometry.dispose();
      mesh.geometry = groundQuads(ribbon(flat, name !== "truth"), LEVEL.trails);
    }
    for (const name of Object.keys(this.trails)) this.trails[name].visible = name in trails;
  }
}

function ribbon(flat, dashed) {
  const quads = [];
  let along = 0;
  for (let i = 0; i + 3 < flat.length; i += 2) {
    const [x0, y0, x1, y1] = flat.slice(i, i + 4).map((value) => value / 1000);
    const length = Math.hypot(x1 - x0, y1 - y0);
    if (length < 1e-6) continue;
    const [ux, uy] = [(x1 - x0) / length, (y1 - y0) / length];
    const pieces = dashed ? cut(along, length) : [[0, length]];
    for (const [a, b] of pieces) {
      const [nx, ny] = [(-uy * WIDTH) / 2, (ux * WIDTH) / 2];
      const [xa, ya, xb, yb] = [x0 + a * ux, y0 + a * uy, x0 + b * ux, y0 + b * uy];
      quads.push([[xa - nx, ya - ny], [xb - nx, yb - ny], [xb + nx, yb + ny], [xa + nx, ya + ny]]);
    }
    along += length;
  }
  return quads;
}

// The parts of a segment that belong to a dash, as distances from its start.
function cut(along, length) {
  const found = [];
  for (let dash = Math.floor(along / (1.5 * DASH)); dash * 1.5 * DASH < along + length; dash++) {
    const [a, b] = [dash * 1.5 * DASH - along, dash * 1.5 * DASH + DASH - along];
    if (b > 0 && a < length) found.push([Math.max(a, 0), Math.min(b, length)]);
  }
  return found;
}
