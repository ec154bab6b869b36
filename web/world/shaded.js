// The light on robots and goals, the same as in nao_course/widgets/world/canvas.py: sky from above, and one lamp. It is
// computed at the corners, because a computer without a graphics card has to draw it, too.
import { ShaderMaterial, Vector3 } from "three";

export const toRgb = (colour) => [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16) / 255);

const VERTEX = `
#ifdef ONE_COLOUR
uniform vec3 colour;
#else
attribute vec3 color;
#endif
#ifdef LINKS
attribute float link;
uniform mat4 frames[LINKS];
#endif
varying vec3 shade;
void main() {
#ifdef LINKS
  mat4 frame = frames[int(link + 0.5)];
#else
  mat4 frame = modelMatrix;
#endif
  vec3 up = normalize(mat3(frame) * normal);
  float light = 0.56 + 0.16 * up.z + 0.36 * max(dot(up, normalize(vec3(0.35, -0.45, 0.82))), 0.0);
#ifdef ONE_COLOUR
  shade = colour * light;
#else
  shade = color * light;
#endif
  gl_Position = projectionMatrix * viewMatrix * frame * vec4(position, 1.0);
}`;

const FRAGMENT = `
uniform float opacity;
varying vec3 shade;
void main() { gl_FragColor = vec4(shade, opacity); }`;

// A colour for the whole surface, or null for a colour at each corner; `frames` are the links' matrices in the world.
export class Shaded extends ShaderMaterial {
  constructor(colour, opacity = 1, frames = null) {
    const uniforms = { opacity: { value: opacity } };
    if (colour) uniforms.colour = { value: new Vector3(...toRgb(colour)) };
    const defines = colour ? { ONE_COLOUR: "" } : {};
    if (frames) {
      uniforms.frames = { value: frames };
      defines.LINKS = frames.length;
    }
    super({ uniforms, defines, vertexShader: VERTEX, fragmentShader: FRAGMENT, transparent: opacity < 1 });
  }
}
