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

/** Where a place is in each frame: its points, or null where it is not on the tissue. */
export type Places = (Vector[] | null)[];

export interface Hotspot {
  title: string;
  text: string;
  places: Places;
}

export interface Candidate {
  kind: "corner" | "landmark" | "suture" | "hook";
  name: string;
  right: boolean;
  places: Places;
}

interface AnyQuestion {
  ask: string;
  step: number | null; // index of the step that belongs to it
  right: string;
  wrong: string;
}

export interface ChoiceQuestion extends AnyQuestion {
  choices: string[];
  answers: number[];
  several: boolean;
}

export interface PlaceQuestion extends AnyQuestion {
  within: number; // mm
  candidates: Candidate[];
}

export type Question = ChoiceQuestion | PlaceQuestion;

export interface Chapter {
  title: string;
  text: string[];
  part: number;
  look: string;
  view: "oblique" | "top" | "low" | "behind";
  step: number; // index
  hotspots: Hotspot[];
  questions: Question[];
}

/** A lesson of several procedures. */
export interface Course extends Omit<Lesson, "procedures" | "bytes" | "size"> {
  mastery: number | null; // percent
  reports?: "scorm" | "h5p";
  parts: Pick<Lesson, "procedures" | "bytes" | "size">[];
  chapters: Chapter[];
}
