// Noise that shaders look up: a block of numbers that repeats, of three sizes of unevenness added up.
import * as THREE from "three";

const SIZE = 64; // numbers along an edge
const CELLS = 16; // cells of the coarsest along an edge

export function noiseTexture(): THREE.Data3DTexture {
  const sum = new Float32Array(SIZE ** 3);
  for (const [cells, weight] of [[CELLS, 0.55], [2 * CELLS, 0.3], [4 * CELLS, 0.15]]) add(sum, cells, weight);
  const data = Uint8Array.from(sum, (each) => Math.round(255 * each));
  const made = new THREE.Data3DTexture(data, SIZE, SIZE, SIZE);
  made.format = THREE.RedFormat;
  made.wrapS = made.wrapT = made.wrapR = THREE.RepeatWrapping;
  made.minFilter = made.magFilter = THREE.LinearFilter;
  made.unpackAlignment = 1;
  made.needsUpdate = true;
  return made;
}

/** Adds smooth steps between random numbers at the corners of cells. */
function add(sum: Float32Array, cells: number, weight: number): void {
  let seed = 12345 + cells; // the same everywhere: a lesson looks the same wherever it is opened
  const corners = Float32Array.from({ length: cells ** 3 }, () => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return seed / 2 ** 32;
  });
  const low = new Int32Array(SIZE);
  const high = new Int32Array(SIZE);
  const share = new Float32Array(SIZE);
  for (let i = 0; i < SIZE; i++) {
    const at = (i * cells) / SIZE;
    low[i] = Math.floor(at);
    high[i] = (low[i] + 1) % cells;
    const t = at - low[i];
    share[i] = t * t * (3 - 2 * t);
  }
  let k = 0;
  for (let z = 0; z < SIZE; z++) {
    for (let y = 0; y < SIZE; y++) {
      const [a, b, c, d] = [
        (low[z] * cells + low[y]) * cells,
        (low[z] * cells + high[y]) * cells,
        (high[z] * cells + low[y]) * cells,
        (high[z] * cells + high[y]) * cells,
      ];
      const [v, w] = [share[y], share[z]];
      for (let x = 0; x < SIZE; x++, k++) {
        const [i, j, u] = [low[x], high[x], share[x]];
        const near = (corners[a + i] + u * (corners[a + j] - corners[a + i])) * (1 - v) +
          (corners[b + i] + u * (corners[b + j] - corners[b + i])) * v;
        const far = (corners[c + i] + u * (corners[c + j] - corners[c + i])) * (1 - v) +
          (corners[d + i] + u * (corners[d + j] - corners[d + i])) * v;
        sum[k] += weight * (near * (1 - w) + far * w);
      }
    }
  }
}
