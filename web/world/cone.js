// The view cone of a camera, with its current picture in it.
import {
  BufferAttribute, BufferGeometry, DoubleSide, Group, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial, Vector3,
} from "three";
import { pictureTexture } from "./room.js";

export class Cone {
  constructor({ pose, rays, distance }, opacities, colour, changed) {
    this.opacities = opacities;
    this.changed = changed;
    this.group = new Group(); // the camera's axes: ahead, left, up
    this.group.applyMatrix4(new Matrix4().set(...pose.flat()));
    const [rows, columns] = [rays.length, rays[0].length];
    const point = ([right, down]) => [distance, -distance * right, -distance * down];
    const positions = new Float32Array(rays.flat().flatMap(point));
    const uv = new Float32Array(rays.flatMap((row, j) => row.flatMap((_, i) => [i / (columns - 1), j / (rows - 1)])));
    const indices = [];
    for (let j = 0; j + 1 < rows; j++) {
      for (let i = 0; i + 1 < columns; i++) {
        const a = j * columns + i;
        indices.push(a, a + columns, a + 1, a + 1, a + columns, a + columns + 1);
      }
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setAttribute("uv", new BufferAttribute(uv, 2));
    geometry.setIndex(indices);
    this.texture = pictureTexture();
    this.material = new MeshBasicMaterial({ map: this.texture, transparent: true, side: DoubleSide, depthWrite: false });
    this.picture = new Mesh(geometry, this.material);
    this.picture.visible = false;
    this.picture.renderOrder = 10;
    const corners = [rays[0][0], rays[0][columns - 1], rays[rows - 1][columns - 1], rays[rows - 1][0]].map(point);
    const edges = corners.flatMap((corner, i) => [[0, 0, 0], corner, corner, corners[(i + 1) % 4]]);
    const lines = new BufferGeometry();
    lines.setAttribute("position", new BufferAttribute(new Float32Array(edges.flat()), 3));
    this.edges = new LineSegments(lines, new LineBasicMaterial({ color: colour, transparent: true, opacity: 0.9 }));
    this.edges.renderOrder = 11;
    this.group.add(this.picture, this.edges);
  }

  async show(bytes) {
    const bitmap = bytes?.byteLength ? await createImageBitmap(new Blob([bytes], { type: "image/jpeg" })) : null;
    this.picture.visible = bitmap !== null;
    if (bitmap) {
      this.texture.dispose(); // because the size may have changed
      this.texture.image?.close?.();
      this.texture.image = bitmap;
      this.texture.needsUpdate = true;
    }
    this.changed();
  }

  // From the front, an opaque picture would hide the robot.
  see(eye) {
    const local = this.picture.worldToLocal(eye.clone());
    this.material.opacity = local.x > 0.34 ? this.opacities.front : this.opacities.behind;
  }

  get origin() {
    return this.group.getWorldPosition(new Vector3());
  }
}
