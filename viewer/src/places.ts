// Places on the tissue: where they are, how far a click is from them, what they are called.
import * as THREE from "three";
import type { Candidate, Places, Vector } from "./lesson";
import type { Stage } from "./stage";
import type { Words } from "./words";

/** The middle of a place in each frame. */
export function middles(places: Places): (Vector | null)[] {
  return places.map((points) => points && ([0, 1, 2].map((axis) => mean(points.map((each) => each[axis]))) as Vector));
}

/** The points of a place, each as a place of its own. */
export function ends(places: Places): (Vector | null)[][] {
  const count = Math.max(0, ...places.map((points) => points?.length ?? 0));
  return Array.from({ length: count }, (_, k) => places.map((points) => points?.[k] ?? null));
}

/**
 * Distance in mm from a click to a place in a frame; infinite where it is not there. Between the ends of a suture the
 * whole thread counts, where they are so near to each other that a click between them means it.
 */
export function distance(click: THREE.Vector3, places: Places, frame: number, stage: Stage, within: number): number {
  const points = places[frame]?.map((each) => stage.placed(each)) ?? [];
  const gaps = points.map((each) => each.distanceTo(click));
  const near = new THREE.Vector3();
  points.slice(1).forEach((each, k) => {
    if (each.distanceTo(points[k]) > 2 * within) return;
    new THREE.Line3(points[k], each).closestPointToPoint(click, true, near);
    gaps.push(near.distanceTo(click));
  });
  return Math.min(Infinity, ...gaps);
}

/** What candidates are called: by letter, label or number, and by where they lie seen from above. */
export function namesOf(candidates: Candidate[], frame: number, stage: Stage, words: Words): string[] {
  const places = candidates.map(({ places }) => middles(places)[frame]).map((each) => each && stage.placed(each));
  const known = places.filter((each) => each !== null);
  const low = new THREE.Box3().setFromPoints(known);
  const size = low.getSize(new THREE.Vector3());
  const third = (value: number, from: number, span: number): number =>
    span < 2 ? 1 : Math.min(2, Math.floor((3 * (value - from)) / span));
  return candidates.map((each, k) => {
    const place = places[k];
    const name = words.say(`place.${each.kind}`, { name: each.name, number: k + 1 });
    if (!place) return name;
    const row = ["low", "middle", "high"][third(place.y, low.min.y, size.y)];
    const column = ["left", "middle", "right"][third(place.x, low.min.x, size.x)];
    return words.say("place.where", { name, where: words.say(`where.${row}.${column}`) });
  });
}

function mean(values: number[]): number {
  return values.reduce((sum, each) => sum + each, 0) / values.length;
}
