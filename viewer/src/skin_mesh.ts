// The skin of one epoch: a mesh whose vertices and normals are set for every moment.
import * as THREE from "three";
import type { Arrays, Positions } from "./arrays";
import type { Epoch } from "./lesson";
import type { Materials } from "./materials";

/** Area-weighted unit normals. */
export function writeNormals(index: ArrayLike<number>, at: Float32Array, normals: Float32Array): void {
  normals.fill(0);
  for (let f = 0; f < index.length; f += 3) {
    const a = 3 * index[f];
    const b = 3 * index[f + 1];
    const c = 3 * index[f + 2];
    const ux = at[b] - at[a];
    const uy = at[b + 1] - at[a + 1];
    const uz = at[b + 2] - at[a + 2];
    const vx = at[c] - at[a];
    const vy = at[c + 1] - at[a + 1];
    const vz = at[c + 2] - at[a + 2];
    const x = uy * vz - uz * vy;
    const y = uz * vx - ux * vz;
    const z = ux * vy - uy * vx;
    for (const k of [a, b, c]) {
      normals[k] += x;
      normals[k + 1] += y;
      normals[k + 2] += z;
    }
  }
  for (let k = 0; k < normals.length; k += 3) {
    const length = Math.hypot(normals[k], normals[k + 1], normals[k + 2]) || 1;
    normals[k] /= length;
    normals[k + 1] /= length;
    normals[k + 2] /= length;
  }
}

function dynamic(count: number, size: number): THREE.BufferAttribute {
  return new THREE.BufferAttribute(new Float32Array(count * size), size).setUsage(THREE.DynamicDrawUsage);
}

export class SkinMesh {
  readonly mesh: THREE.Mesh;
  /** Positions of the cache's vertices now, in mm. */
  readonly points: Float32Array;
  /** Chains of vertices along the lips of the wound. */
  readonly lips: Uint32Array[] = [];
  private readonly positions: Positions;
  private readonly vertex: Uint32Array;
  private readonly index: Uint32Array;
  private readonly quantities = new Map<string, Uint8Array>();
  private readonly skin: number;
  private shown = "";

  constructor(
    readonly epoch: Epoch,
    arrays: Arrays,
    materials: Materials,
  ) {
    this.positions = arrays.positions(epoch.positions);
    this.points = new Float32Array(3 * this.positions.places);
    this.vertex = arrays.numbers(epoch.vertex) as Uint32Array;
    this.index = arrays.numbers(epoch.triangles) as Uint32Array;
    this.skin = epoch.vertices[0];
    for (const [name, entry] of Object.entries(epoch.quantities)) {
      this.quantities.set(name, arrays.numbers(entry) as Uint8Array);
    }
    const count = this.vertex.length;
    const geometry = new THREE.BufferGeometry();
    geometry.setIndex(new THREE.BufferAttribute(this.index, 1));
    geometry.setAttribute("position", dynamic(count, 3));
    geometry.setAttribute("normal", dynamic(count, 3));
    geometry.setAttribute("quantity", dynamic(count, 1));
    this.positions.write(this.points, 0);
    const rest = new Float32Array(3 * count);
    this.expand(rest);
    geometry.setAttribute("rest", new THREE.BufferAttribute(rest, 3));
    const grid = arrays.numbers(epoch.grid);
    const uv = new Float32Array(2 * count);
    const depth = Float32Array.from(arrays.numbers(epoch.depth), (each) => each * epoch.depthStep);
    const column = arrays.numbers(epoch.column);
    const row = Float32Array.from(column, (each) => (each + 0.5) / materials.layerRows);
    for (let i = 0; i < count; i++) {
      uv[2 * i] = epoch.gridLow[0] + grid[i] * epoch.gridStep;
      uv[2 * i + 1] = epoch.gridLow[1] + grid[count + i] * epoch.gridStep;
    }
    geometry.setAttribute("grid", new THREE.BufferAttribute(uv, 2));
    geometry.setAttribute("depth", new THREE.BufferAttribute(depth, 1));
    geometry.setAttribute("row", new THREE.BufferAttribute(row, 1));
    let start = 0;
    epoch.faces.forEach((faces, k) => {
      if (faces) geometry.addGroup(3 * start, 3 * faces, k);
      start += faces;
    });
    const chains = arrays.numbers(epoch.lips) as Uint32Array;
    let begin = 0;
    for (const length of epoch.lipCounts) {
      this.lips.push(chains.subarray(begin, begin + length));
      begin += length;
    }
    this.mesh = new THREE.Mesh(geometry, materials.fine.tissue);
    this.mesh.castShadow = this.mesh.receiveShadow = true;
    this.mesh.frustumCulled = false;
  }

  /** Shows the moment between two of the epoch's frames; quantity: what a map shows, or null. */
  show(frame: number, next: number, share: number, quantity: string | null): void {
    const wanted = `${frame} ${next} ${share} ${quantity}`;
    if (wanted === this.shown) return;
    this.shown = wanted;
    this.positions.write(this.points, frame + 1, next + 1, share);
    const { position, normal, quantity: mapped } = this.mesh.geometry.attributes as Record<string, THREE.BufferAttribute>;
    this.expand(position.array as Float32Array);
    writeNormals(this.index, position.array as Float32Array, normal.array as Float32Array);
    position.needsUpdate = normal.needsUpdate = true;
    this.mesh.geometry.boundingSphere = null; // for rays
    const values = quantity === null ? undefined : this.quantities.get(quantity);
    if (values) {
      const a = frame * this.skin;
      const b = next * this.skin;
      const into = mapped.array as Float32Array;
      for (let i = 0; i < this.skin; i++) into[i] = (values[a + i] + share * (values[b + i] - values[a + i])) / 255;
      mapped.needsUpdate = true;
    }
  }

  private expand(into: Float32Array): void {
    const { vertex, points } = this;
    for (let i = 0, at = 0; i < vertex.length; i++, at += 3) {
      const from = 3 * vertex[i];
      into[at] = points[from];
      into[at + 1] = points[from + 1];
      into[at + 2] = points[from + 2];
    }
  }
}
