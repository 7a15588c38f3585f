// What a lesson holds, as `shared/lappet/export/lesson_*.py` write it. Lengths are in mm.
import type { ArrayEntry, PositionsEntry } from "./arrays";

export type Vector = [number, number, number];

export interface Epoch {
  name: string;
  frames: number[]; // indices of the procedure's frames
  faces: number[]; // triangles of skin, wound wall, underside and rim, in this order
  vertices: number[]; // drawn vertices of each of these
  triangles: ArrayEntry;
  vertex: ArrayEntry; // the vertex whose position each drawn vertex has
  column: ArrayEntry;
  grid: ArrayEntry; // all u, then all v
  gridLow: [number, number];
  gridStep: number;
  depth: ArrayEntry;
  depthStep: number;
  positions: PositionsEntry; // the first state is rest, then one for each of `frames`
  lips: ArrayEntry;
  lipCounts: number[];
  quantities: Record<string, ArrayEntry>;
}

export interface Strands {
  lines: number[];
  counts: ArrayEntry;
  points: PositionsEntry;
  radii: ArrayEntry;
  radiusStep: number;
  color?: Vector;
}

export interface Label {
  kind: "corner" | "landmark";
  text: string;
  places: (Vector | null)[];
}

export interface Field {
  center: Vector;
  right: Vector;
  up: Vector;
  normal: Vector;
  points: Vector[];
  context: number;
  scale: number;
}

export interface Layers {
  column: number[];
  depthFrom: number[];
  kind: string[];
  colors: Record<string, Vector>;
}

export interface Procedure {
  title: string;
  fps: number;
  times: number[];
  steps: { frame: number; kind: string }[];
  epochs: Epoch[];
  quantities: Record<string, { full: number; unit: string }>;
  layers: Layers;
  bed: { positions: PositionsEntry; triangles: ArrayEntry } | null;
  scenery: { kind: string; positions: PositionsEntry; triangles: ArrayEntry }[];
  strands: Record<string, Strands>;
  labels: Label[];
  field: Field;
}

export interface Lesson {
  format: number;
  version: string;
  title: string;
  language: string;
  words: Record<string, Record<string, string>>;
  ramp: [number, Vector][];
  procedures: Procedure[];
  bytes: number; // of the deflated block
  size: number; // of the inflated one
}
