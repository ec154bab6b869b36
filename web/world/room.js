// The parts that do not move: floor, carpet, lines, goals and walls.
import {
  BufferAttribute, BufferGeometry, CanvasTexture, CylinderGeometry, Group, LinearFilter, Mesh,
  MeshBasicMaterial, SRGBColorSpace, Texture, Vector3,
} from "three";
import { Shaded } from "./shaded.js";

export const LEVEL = { carpet: 0.002, lines: 0.004, trails: 0.006, ellipses: 0.008, marks: 0.01, shadow: 0.012 }; // m

// Quadrilaterals [[x, y], ...] on the ground as one geometry.
export function groundQuads(quads, height) {
  const positions = new Float32Array(quads.length * 12);
  const uv = new Float32Array(quads.length * 8);
  const indices = [];
  quads.forEach((quad, n) => {
    quad.forEach(([x, y], k) => {
      positions.set([x, y, height], n * 12 + 3 * k);
      uv.set([x, y], n * 8 + 2 * k);
    });
    const turned = (quad[1][0] - quad[0][0]) * (quad[2][1] - quad[0][1]) - (quad[1][1] - quad[0][1]) * (quad[2][0] - quad[0][0]);
    indices.push(...(turned > 0 ? [0, 1, 2, 0, 2, 3] : [0, 2, 1, 0, 3, 2]).map((i) => i + 4 * n));
  });
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  geometry.setAttribute("uv", new BufferAttribute(uv, 2));
  geometry.setIndex(indices);
  return geometry;
}

// A texture of a picture without smaller copies, which would take time at each change.
export function pictureTexture() {
  const texture = new Texture();
  texture.colorSpace = SRGBColorSpace;
  texture.flipY = false;
  texture.minFilter = LinearFilter;
  texture.generateMipmaps = false;
  return texture;
}

export function shadowTexture() {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 64;
  const context = canvas.getContext("2d");
  const fade = context.createRadialGradient(32, 32, 2, 32, 32, 32);
  fade.addColorStop(0, "rgba(5, 25, 15, 0.62)");
  fade.addColorStop(0.5, "rgba(5, 25, 15, 0.34)");
  fade.addColorStop(1, "rgba(5, 25, 15, 0)");
  context.fillStyle = fade;
  context.fillRect(0, 0, 64, 64);
  return new CanvasTexture(canvas);
}

export function rod([x0, y0, z0, x1, y1, z1, radius], material) {
  const [start, end] = [new Vector3(x0, y0, z0), new Vector3(x1, y1, z1)];
  const mesh = new Mesh(new CylinderGeometry(radius, radius, start.distanceTo(end), 20), material);
  mesh.position.copy(start).lerp(end, 0.5);
  mesh.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), end.clone().sub(start).normalize());
  return mesh;
}

export class Room {
  constructor(scene, changed) {
    this.group = new Group();
    this.walls = [];
    const { colours } = scene;
    const add = (quads, height, material, order) => {
      const mesh = new Mesh(groundQuads(quads, height), material);
      mesh.renderOrder = order;
      this.group.add(mesh);
    };
    // Only the frame around the carpet: without a graphics card, each layer takes time.
    const frame = scene.floor.map((corner, i) => {
      const next = (i + 1) % 4;
      return [corner, scene.floor[next], scene.carpet[next], scene.carpet[i]];
    });
    add(frame, 0, new MeshBasicMaterial({ color: colours.floor }), -10);
    add([scene.carpet], LEVEL.carpet, new MeshBasicMaterial({ color: colours.carpet }), -9);
    add(scene.lines, LEVEL.lines, new MeshBasicMaterial({ color: colours.lines }), -8);
    const paint = new Shaded(colours.goal);
    for (const each of scene.posts) this.group.add(rod(each, paint));
    scene.walls.forEach((wall, i) => this.addWall(wall, i, changed));
  }

  addWall({ corner, across, down, inwards, paint }, i, changed) {
    const at = (a, b) => corner.map((value, k) => value + a * across[k] + b * down[k]);
    const geometry = new BufferGeometry();
    const positions = new Float32Array([at(0, 0), at(1, 0), at(1, 1), at(0, 1)].flat());
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setAttribute("uv", new BufferAttribute(new Float32Array([0, 0, 1, 0, 1, 1, 0, 1]), 2));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    const texture = pictureTexture();
    const material = new MeshBasicMaterial({ map: texture, transparent: true, depthWrite: false, side: 2 });
    const mesh = new Mesh(geometry, material);
    mesh.visible = false;
    mesh.renderOrder = -7 + i / 100;
    this.group.add(mesh);
    const wall = { mesh, texture, corner: new Vector3(...corner), inwards: new Vector3(...inwards), ready: false };
    this.walls.push(wall);
    createImageBitmap(new Blob([paint], { type: "image/webp" })).then((bitmap) => {
      texture.image = bitmap;
      texture.needsUpdate = true;
      wall.ready = true;
      changed();
    });
  }

  // Walls are seen from inside only, and fade out for a viewer above them.
  see(eye, [fade, gone]) {
    const opacity = Math.min(Math.max((gone - eye.z) / (gone - fade), 0), 1);
    for (const { mesh, corner, inwards, ready } of this.walls) {
      mesh.visible = ready && opacity > 0 && inwards.dot(eye.clone().sub(corner)) > 0;
      mesh.material.opacity = opacity;
    }
  }
}

