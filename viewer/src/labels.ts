// What lies over the picture and rides on the tissue: letters, landmarks, marks of hotspots and questions. It vanishes
// where skin hides it.
import * as THREE from "three";
import type { Vector } from "./lesson";
import type { Shown, Stage } from "./stage";

export interface Rider {
  element: HTMLElement;
  stage: Stage;
  places: (THREE.Vector3 | null)[];
  wanted: (shown: Shown) => boolean;
  seen: boolean;
  through: boolean; // whether it shows through skin that hides its place
}

export class Labels {
  private readonly riders = new Set<Rider>();
  private readonly checked = new Map<Stage, number>();
  private again = 0;

  constructor(
    private readonly into: HTMLElement,
    stages: Stage[],
    private readonly requestDraw: () => void,
  ) {
    for (const stage of stages) {
      for (const { kind, text, places } of stage.procedure.labels) {
        const element = document.createElement("span");
        element.className = `label ${kind}`;
        element.textContent = text;
        this.add(element, stage, places, (shown) => (kind === "corner" ? shown.letters : shown.landmarks));
      }
    }
  }

  /** Lets an element ride on places of a stage, one in mm for each frame. */
  add(element: HTMLElement, stage: Stage, places: (Vector | null)[], wanted: Rider["wanted"] = () => true): Rider {
    const placed = places.map((place) => place && stage.placed(place));
    const rider: Rider = { element, stage, places: placed, wanted, seen: true, through: false };
    this.into.append(element);
    this.riders.add(rider);
    this.checked.clear();
    this.requestDraw();
    return rider;
  }

  remove(rider: Rider): void {
    rider.element.remove();
    this.riders.delete(rider);
  }

  /** Puts the labels of a stage where they are in a part of the picture (CSS pixels). */
  place(stage: Stage, time: number, camera: THREE.Camera, part: DOMRect, shown: Shown): void {
    const frame = Math.floor(time + 1e-6);
    const share = time - frame;
    const fresh = performance.now() - (this.checked.get(stage) ?? 0) > 140;
    for (const rider of this.riders) {
      if (rider.stage !== stage) continue;
      const here = rider.places[Math.min(rider.places.length - 1, frame)];
      const next = rider.places[Math.min(rider.places.length - 1, frame + 1)] ?? here;
      if (!here || !next || !rider.wanted(shown)) {
        rider.element.hidden = true;
        continue;
      }
      const place = here.clone().lerp(next, share);
      if (fresh) rider.seen = stage.seen(place, camera);
      const on = place.project(camera);
      const inside = Math.abs(on.x) < 1 && Math.abs(on.y) < 1 && on.z < 1;
      rider.element.hidden = !inside || !(rider.seen || rider.through);
      const x = part.x + (0.5 + 0.5 * on.x) * part.width;
      const y = part.y + (0.5 - 0.5 * on.y) * part.height;
      rider.element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    }
    if (fresh) this.checked.set(stage, performance.now());
    else {
      clearTimeout(this.again); // what is seen is looked up once more when the picture rests
      this.again = window.setTimeout(this.requestDraw, 160);
    }
  }
}
