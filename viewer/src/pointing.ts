// Answering on the picture: while it is asked for a place, a click on the tissue is an answer. Marks show what came of it.
import * as THREE from "three";
import { make } from "./elements";
import type { Rider } from "./labels";
import type { Places, Vector } from "./lesson";
import type { LessonView } from "./lesson_view";
import { ends } from "./places";
import type { Words } from "./words";

const STILL = 6; // pixels that a pointer may move between down and up for a click

interface Asked {
  clicked: (place: THREE.Vector3) => void;
  ended: () => void;
}

export class Pointing {
  private readonly banner = make("div", { id: "asking", hidden: true });
  private readonly text = make("p");
  private readonly cancel = make("button", { type: "button" });
  private readonly riders: Rider[] = [];
  private asked: Asked | null = null;
  private down: [number, number] | null = null;

  constructor(
    private readonly view: LessonView,
    private readonly words: Words,
  ) {
    const { canvas } = view;
    this.banner.append(this.text, this.cancel);
    this.cancel.addEventListener("click", () => this.end());
    canvas.addEventListener("pointerdown", (event) => (this.down = event.isPrimary ? [event.clientX, event.clientY] : null));
    canvas.addEventListener("pointerup", (event) => this.up(event));
    canvas.parentElement?.append(this.banner);
    this.banner.addEventListener("keydown", (event) => event.key === "Escape" && this.end());
    canvas.addEventListener("keydown", (event) => event.key === "Escape" && this.end());
  }

  speak(): void {
    this.cancel.textContent = this.words.say("cancel");
  }

  /** Asks for a click; what was asked before ends. */
  ask(question: string, clicked: Asked["clicked"], ended: Asked["ended"]): void {
    this.end();
    this.clear();
    if (!this.banner.parentElement) this.view.canvas.parentElement!.append(this.banner);
    this.asked = { clicked, ended };
    this.text.textContent = question;
    this.banner.hidden = false;
    this.view.canvas.parentElement!.classList.add("pointed");
    this.view.canvas.scrollIntoView({ block: "nearest" });
  }

  end(): void {
    const { asked } = this;
    this.asked = null;
    this.banner.hidden = true;
    this.view.canvas.parentElement?.classList.remove("pointed");
    asked?.ended();
  }

  /** Lays a mark on a place of the tissue, on both ends of a suture. */
  mark(kind: string, text: string, places: Places): void {
    for (const end of ends(places)) {
      const element = make("span", { class: `label ${kind}` }, text);
      const rider = this.view.picture.labels.add(element, this.view.stages[0], end);
      rider.through = true;
      this.riders.push(rider);
    }
    this.view.canvas.parentElement!.classList.add("marked");
  }

  /** Lays a mark where it was clicked; it stays while the picture shows the same moment. */
  markClick(place: THREE.Vector3, right: boolean): void {
    const element = make("span", { class: `label clicked ${right ? "right" : "wrong"}` });
    const { labels } = this.view.picture;
    const stage = this.view.stages[0];
    const here = Math.floor(this.view.player.time + 1e-6);
    const rider = labels.add(element, stage, stage.procedure.times.map((): Vector | null => null));
    rider.places[here] = place.clone();
    rider.through = true;
    this.riders.push(rider);
  }

  /** Takes all marks away. */
  clear(): void {
    for (const rider of this.riders.splice(0)) this.view.picture.labels.remove(rider);
    this.view.canvas.parentElement?.classList.remove("marked");
    this.view.changed();
  }

  private up(event: PointerEvent): void {
    const { down, asked } = this;
    this.down = null;
    if (!asked || !down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > STILL) return;
    const box = this.view.canvas.getBoundingClientRect();
    const found = this.view.picture.pick(event.clientX - box.left, event.clientY - box.top);
    if (found) asked.clicked(found.place);
  }
}
