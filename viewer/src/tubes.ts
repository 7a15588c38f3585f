// Round tubes along lines, rebuilt for every moment: threads, hooks, pen marks, vessels, lips of the wound.
import * as THREE from "three";

export interface Line {
  points: Float32Array; // x, y, z of each
  radii: ArrayLike<number>;
}

/** Of two frames' lines the moment between: lines that have a partner move, of the others those of the nearer frame show. */
export function between(lines: Line[], next: Line[], share: number): Line[] {
  if (share === 0 || lines === next) return lines;
  const made: Line[] = [];
  let at = 0;
  const paired = new Set<number>();
  for (const line of lines) {
    let partner = -1;
    for (let k = at; k < next.length; k++) {
      if (next[k].points.length === line.points.length && near(line, next[k])) {
        partner = k;
        break;
      }
    }
    if (partner < 0) {
      if (share < 0.5) made.push(line);
      continue;
    }
    at = partner + 1;
    paired.add(partner);
    const to = next[partner].points;
    made.push({ points: line.points.map((from, i) => from + share * (to[i] - from)), radii: line.radii });
  }
  if (share >= 0.5) next.forEach((line, k) => paired.has(k) || made.push(line));
  return made;
}

const FAR = 12; // mm between two frames: what is farther apart is not the same line

function near(a: Line, b: Line): boolean {
  return Math.hypot(a.points[0] - b.points[0], a.points[1] - b.points[1], a.points[2] - b.points[2]) < FAR;
}

export class Tubes {
  readonly mesh: THREE.Mesh;

  constructor(
    material: THREE.Material,
    private readonly sides: number,
  ) {
    this.mesh = new THREE.Mesh(new THREE.BufferGeometry(), material);
    this.mesh.castShadow = true;
    this.mesh.receiveShadow = true;
    this.mesh.frustumCulled = false;
  }

  /** Draws lines; a ring stands at each point, and one without size at both ends closes the tube. */
  draw(lines: Line[]): void {
    const { sides } = this;
    let rings = 0;
    for (const line of lines) if (line.points.length >= 6) rings += line.points.length / 3 + 2;
    const position = new Float32Array(3 * rings * sides);
    const normal = new Float32Array(position.length);
    const index: number[] = [];
    let ring = 0;
    for (const line of lines) {
      const count = line.points.length / 3;
      if (count < 2) continue;
      this.lay(line, count, ring, position, normal);
      for (let k = 0; k < count + 1; k++) {
        const low = (ring + k) * sides;
        for (let s = 0; s < sides; s++) {
          const t = (s + 1) % sides;
          index.push(low + s, low + t, low + sides + t, low + s, low + sides + t, low + sides + s);
        }
      }
      ring += count + 2;
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(position, 3));
    geometry.setAttribute("normal", new THREE.BufferAttribute(normal, 3));
    geometry.setIndex(index);
    this.mesh.geometry.dispose();
    this.mesh.geometry = geometry;
    this.mesh.visible = rings > 0;
  }

  private lay(line: Line, count: number, ring: number, position: Float32Array, normal: Float32Array): void {
    const along = new THREE.Vector3();
    const across = new THREE.Vector3();
    const beside = new THREE.Vector3();
    const p = line.points;
    const tangent = (k: number): void => {
      const a = 3 * Math.max(0, k - 1);
      const b = 3 * Math.min(count - 1, k + 1);
      along.set(p[b] - p[a], p[b + 1] - p[a + 1], p[b + 2] - p[a + 2]);
      if (along.lengthSq() < 1e-18) along.set(0, 0, 1);
      along.normalize();
    };
    tangent(0);
    across.set(0, 0, 0).setComponent(smallest(along), 1); // carried along the line, so that rings do not twist
    for (let k = -1; k <= count; k++) {
      const point = Math.min(count - 1, Math.max(0, k));
      tangent(point);
      across.addScaledVector(along, -across.dot(along));
      if (across.lengthSq() < 1e-12) across.set(0, 0, 0).setComponent(smallest(along), 1).cross(along);
      across.normalize();
      beside.crossVectors(along, across);
      const radius = k === point ? line.radii[point] : 0;
      for (let s = 0; s < this.sides; s++) {
        const turn = (2 * Math.PI * s) / this.sides;
        const [c, d] = [Math.cos(turn), Math.sin(turn)];
        const at = 3 * ((ring + k + 1) * this.sides + s);
        for (let axis = 0; axis < 3; axis++) {
          const out = c * across.getComponent(axis) + d * beside.getComponent(axis);
          normal[at + axis] = out;
          position[at + axis] = p[3 * point + axis] + radius * out;
        }
      }
    }
  }
}

function smallest(v: THREE.Vector3): number {
  const [x, y, z] = [Math.abs(v.x), Math.abs(v.y), Math.abs(v.z)];
  return x <= y && x <= z ? 0 : y <= z ? 1 : 2;
}
