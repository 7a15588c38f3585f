// The materials of a lesson: skin with its printed grid or a map, cut walls by their layers, bed, thread, steel.
import * as THREE from "three";
import type { Layers, Lesson } from "./lesson";
import { noiseTexture } from "./noise";
import surface from "./surface.glsl";

export type Look = "painted" | "grid" | "tension" | "strain" | "stress";

const WIDTH = 512;
let noise: THREE.Data3DTexture | undefined; // one for all procedures

const vertexHead = `
attribute vec3 rest;
attribute vec2 grid;
attribute float depth;
attribute float row;
attribute float quantity;
varying vec3 vRest;
varying vec2 vGrid;
varying float vDepth;
varying float vRow;
varying float vQuantity;
`;

const vertexBody = `
vRest = rest;
vGrid = grid;
vDepth = depth;
vRow = row;
vQuantity = quantity;
`;

export interface Shared {
  uLook: { value: number };
  uRamp: { value: THREE.Texture };
  uLayers: { value: THREE.Texture };
  uReach: { value: number };
  uNoise: { value: THREE.Texture };
}

/** Linear color to sRGB bytes. */
function bytes(color: readonly number[], into: Uint8Array, at: number): void {
  for (let k = 0; k < 3; k++) {
    const c = Math.min(1, Math.max(0, color[k]));
    into[at + k] = Math.round(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));
  }
  into[at + 3] = 255;
}

function texture(data: Uint8Array<ArrayBuffer>, width: number, height: number, filter: THREE.MagnificationTextureFilter): THREE.DataTexture {
  const made = new THREE.DataTexture(data, width, height, THREE.RGBAFormat);
  made.colorSpace = THREE.SRGBColorSpace;
  made.magFilter = filter;
  made.minFilter = filter;
  made.needsUpdate = true;
  return made;
}

/** The color of a share of full scale, linear. */
export function rampColor(ramp: Lesson["ramp"], share: number): number[] {
  let k = 1;
  while (k < ramp.length - 1 && ramp[k][0] < share) k++;
  const [a, b] = [ramp[k - 1], ramp[k]];
  const t = Math.min(1, Math.max(0, (share - a[0]) / (b[0] - a[0])));
  return [0, 1, 2].map((c) => a[1][c] + t * (b[1][c] - a[1][c]));
}

/** The ramp as a CSS gradient from left to right. */
export function rampGradient(ramp: Lesson["ramp"]): string {
  const stops = [];
  const color = new Uint8Array(4);
  for (let k = 0; k <= 20; k++) {
    bytes(rampColor(ramp, k / 20), color, 0);
    stops.push(`rgb(${color[0]} ${color[1]} ${color[2]}) ${5 * k}%`);
  }
  return `linear-gradient(to right, ${stops.join(", ")})`;
}

/** A linear color for CSS. */
export function cssColor(color: readonly number[]): string {
  const made = new Uint8Array(4);
  bytes(color, made, 0);
  return `rgb(${made[0]} ${made[1]} ${made[2]})`;
}

function rampTexture(ramp: Lesson["ramp"]): THREE.DataTexture {
  const data = new Uint8Array(4 * 256);
  for (let k = 0; k < 256; k++) bytes(rampColor(ramp, k / 255), data, 4 * k);
  return texture(data, 256, 1, THREE.LinearFilter);
}

function layerTexture(layers: Layers): [THREE.DataTexture, number] {
  const rows = Math.max(...layers.column) + 1;
  const reach = 1.25 * Math.max(...layers.depthFrom) || 1;
  const data = new Uint8Array(4 * WIDTH * rows);
  for (let row = 0; row < rows; row++) {
    for (let x = 0; x < WIDTH; x++) {
      const depth = ((x + 0.5) / WIDTH) * reach;
      let kind = layers.kind[0];
      layers.column.forEach((own, k) => {
        if (own === row && depth >= layers.depthFrom[k]) kind = layers.kind[k];
      });
      bytes(layers.colors[kind], data, 4 * (row * WIDTH + x));
    }
  }
  return [texture(data, WIDTH, rows, THREE.NearestFilter), reach];
}

/** The materials of one way to draw. */
export interface Surfaces {
  /** Skin, wound wall, underside and rim. */
  tissue: THREE.Material[];
  bed: THREE.Material;
  body: THREE.Material;
}

export class Materials {
  readonly shared: Shared;
  readonly fine: Surfaces;
  /** Of a picture that moves and is drawn by the processor: without relief and gloss, which take a fifth of its time. */
  readonly quick: Surfaces;
  readonly layerRows: number;

  constructor(lesson: Lesson, layers: Layers) {
    const [picture, reach] = layerTexture(layers);
    this.layerRows = Math.max(...layers.column) + 1;
    this.shared = {
      uLook: { value: 1 },
      uRamp: { value: rampTexture(lesson.ramp) },
      uLayers: { value: picture },
      uReach: { value: reach },
      uNoise: { value: noise ??= noiseTexture() },
    };
    this.fine = this.surfaces(false);
    this.quick = this.surfaces(true);
  }

  setLook(look: Look): void {
    this.shared.uLook.value = look === "painted" ? 0 : look === "grid" ? 1 : 2;
  }

  /** Below 1 the skin and walls let vessels show. */
  setOpacity(opacity: number): void {
    for (const material of [...this.fine.tissue, ...this.quick.tissue]) {
      material.transparent = opacity < 1;
      material.opacity = opacity;
      material.depthWrite = opacity >= 1;
      material.needsUpdate = true;
    }
  }

  private surfaces(quick: boolean): Surfaces {
    const soft = "mix(layer(0.1), vec3(0.80, 0.535, 0.405), 0.3)";
    const made = (color: string, height: string, roughness: number, glow: number): THREE.Material =>
      this.surface(color, quick ? null : height, roughness, glow);
    return {
      tissue: [
        made("skin()", "fine()", 0.56, 0.04),
        made("layer(0.3)", "moist()", 0.34, 0.09),
        made("layer(0.3)", "moist()", 0.4, 0.06),
        made(soft, "fine()", 0.6, 0.04),
      ],
      bed: made("bed()", "moist()", 0.48, 0.1),
      body: made("painted()", "fine()", 0.6, 0.02),
    };
  }

  /** A surface of a color and a height, both expressions of surface.glsl, the height null where there is neither relief
      nor gloss; glow: share of it that no light changes. */
  private surface(color: string, height: string | null, roughness: number, glow: number): THREE.Material {
    const material = height ? new THREE.MeshStandardMaterial({ roughness, metalness: 0 }) : new THREE.MeshLambertMaterial();
    material.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, this.shared);
      shader.vertexShader =
        vertexHead + shader.vertexShader.replace("#include <begin_vertex>", `#include <begin_vertex>\n${vertexBody}`);
      const relief = `#include <normal_fragment_maps>
             normal = uneven(normal, -vViewPosition, ${height});`;
      shader.fragmentShader =
        (height ? "" : "#define QUICK\n") +
        surface +
        shader.fragmentShader
          .replace("#include <normal_fragment_maps>", height ? relief : "")
          .replace("#include <color_fragment>", `vec3 own = ${color};\ndiffuseColor.rgb = own;`)
          .replace(
            "#include <emissivemap_fragment>",
            `float lit = ${color === "skin()" ? "uLook == 2 ? 0.5 : " : ""}${glow.toFixed(2)};
             totalEmissiveRadiance = lit * own;
             diffuseColor.rgb *= 1.0 - 0.8 * lit;`,
          );
    };
    material.customProgramCacheKey = () => `${color}${height ? "" : " quick"}`;
    return material;
  }
}

const strandColors: Record<string, THREE.MeshStandardMaterialParameters> = {
  marks: { color: new THREE.Color(0.115, 0.045, 0.26), roughness: 0.9 },
  threads: { color: new THREE.Color(0.012, 0.02, 0.075), roughness: 0.32 },
  hooks: { color: new THREE.Color(0.6, 0.63, 0.66), roughness: 0.26, metalness: 0.35 },
  lips: { color: new THREE.Color(0.3, 0.045, 0.04), roughness: 0.6 },
};

/** By how much what lies on the skin is drawn as if it were nearer, in mm: threads sink into skin that bulges. */
const LIFTED: Record<string, number> = { threads: 0.6, marks: 0.35, lips: 0.15 };

export function strandMaterial(name: string, color?: readonly number[]): THREE.MeshStandardMaterial {
  const own = color ? { color: new THREE.Color(...(color as [number, number, number])), roughness: 0.35 } : strandColors[name];
  const material = new THREE.MeshStandardMaterial(own);
  const lift = LIFTED[name];
  if (lift) {
    material.onBeforeCompile = (shader) => {
      shader.vertexShader = shader.vertexShader.replace(
        "#include <project_vertex>",
        `#include <project_vertex>
         vec4 nearer = projectionMatrix * (mvPosition + vec4(0.0, 0.0, ${lift.toFixed(2)}, 0.0));
         gl_Position.z = nearer.z / nearer.w * gl_Position.w;`,
      );
    };
    material.customProgramCacheKey = () => `lifted ${lift}`;
  }
  return material;
}

const plain: Record<string, [number, number, number, number]> = {
  eye: [0.86, 0.85, 0.83, 0.15],
  iris: [0.13, 0.19, 0.22, 0.2],
  pupil: [0.01, 0.01, 0.012, 0.1],
  teeth: [0.8, 0.76, 0.66, 0.25],
};

/** The material of a mesh of the scenery; null for skin. */
export function sceneryMaterial(kind: string): THREE.MeshStandardMaterial | null {
  const found = plain[kind];
  if (!found) return null;
  const [r, g, b, roughness] = found;
  return new THREE.MeshStandardMaterial({ color: new THREE.Color(r, g, b), roughness });
}
