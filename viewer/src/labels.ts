// Letters and landmarks over the picture; they follow the skin and vanish where it hides them.
import * as THREE from "three";
import type { Label } from "./lesson";
import type { Shown, Stage } from "./stage";

interface Rider {
  kind: Label["kind"];
  element: HTMLElement;
  stage: Stage;
  places: (THREE.Vector3 | null)[];
  seen: boolean;
}

export class Labels {
  private readonly labels: Rider[] = [];
  private readonly checked = new Map<Stage, number>();
  private again = 0;

  constructor(
    into: HTMLElement,
    stages: Stage[],
    private readonly requestDraw: () => void,
  ) {
    for (const stage of stages) {
      for (const { kind, text, places } of stage.procedure.labels) {
        const element = document.createElement("span");
        element.className = `label ${kind}`;
        element.textContent = text;
        into.append(element);
        this.labels.push({ kind, element, stage, places: places.map((place) => place && stage.placed(place)), seen: true });
      }
    }
  }

  /** Puts the labels of a stage where they are in a part of the picture (CSS pixels). */
  place(stage: Stage, time: number, camera: THREE.Camera, part: DOMRect, shown: Shown): void {
    const frame = Math.floor(time + 1e-6);
    const share = time - frame;
    const fresh = performance.now() - (this.checked.get(stage) ?? 0) > 140;
    for (const label of this.labels) {
      if (label.stage !== stage) continue;
      const here = label.places[Math.min(label.places.length - 1, frame)];
      const next = label.places[Math.min(label.places.length - 1, frame + 1)] ?? here;
      if (!here || !next || !(label.kind === "corner" ? shown.letters : shown.landmarks)) {
        label.element.hidden = true;
        continue;
      }
      const place = here.clone().lerp(next, share);
      if (fresh) label.seen = stage.seen(place, camera);
      const on = place.project(camera);
      const inside = Math.abs(on.x) < 1 && Math.abs(on.y) < 1 && on.z < 1;
      label.element.hidden = !inside || !label.seen;
      const x = part.x + (0.5 + 0.5 * on.x) * part.width;
      const y = part.y + (0.5 - 0.5 * on.y) * part.height;
      label.element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    }
    if (fresh) this.checked.set(stage, performance.now());
    else {
      clearTimeout(this.again); // what is seen is looked up once more when the picture rests
      this.again = window.setTimeout(this.requestDraw, 160);
    }
  }
}
