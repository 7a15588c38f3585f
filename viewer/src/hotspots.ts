// Numbered marks on the tissue with a text each; the same stand in the panel as a list that opens.
import { iconButton, make, name } from "./elements";
import type { Rider } from "./labels";
import type { Hotspot } from "./lesson";
import type { LessonView } from "./lesson_view";
import { middles } from "./places";
import type { Words } from "./words";

const MARGIN = 12; // pixels around the card
const BESIDE = 20; // pixels between a place and a card below it
const HIGH = 52; // pixels that a mark stands above its place
const NARROW = 520; // pixels: in narrower pictures the card is at their edge

export class Hotspots {
  readonly list = make("div", { class: "hotspots" });
  private readonly heading = make("h3");
  private readonly entries: HTMLButtonElement[];
  private readonly marks: HTMLButtonElement[];
  private readonly riders: Rider[] = [];
  private readonly card = make("div", { id: "hotspot-card", hidden: true });
  private readonly close: HTMLButtonElement;
  private open = -1;

  constructor(
    private readonly hotspots: Hotspot[],
    private readonly view: LessonView,
    private readonly words: Words,
  ) {
    const rows = make("ol");
    this.entries = hotspots.map(({ title, text }, k) => {
      const button = make("button", { type: "button", "aria-expanded": "false" });
      button.append(make("span", { class: "number" }, String(k + 1)), make("span", {}, title));
      button.addEventListener("click", () => this.toggle(k));
      rows.append(make("li", {}, button, make("p", { hidden: true }, text)));
      return button;
    });
    // The marks are for pointers only; keyboards and screen readers have the list.
    this.marks = hotspots.map((_, k) => {
      const mark = make("button", { type: "button", class: "label hotspot", tabindex: -1 }, String(k + 1));
      mark.addEventListener("click", () => this.toggle(k));
      return mark;
    });
    this.close = iconButton("close", () => this.toggle(this.open), { tabindex: -1 });
    this.card.setAttribute("aria-hidden", "true");
    this.list.append(this.heading, rows);
  }

  begin(): void {
    const { labels } = this.view.picture;
    this.hotspots.forEach(({ places }, k) => {
      this.riders.push(labels.add(this.marks[k], this.view.stages[0], middles(places)));
    });
    this.view.canvas.parentElement!.append(this.card);
  }

  speak(): void {
    this.heading.textContent = this.words.say("hotspots");
    name(this.close, this.words.say("close"));
  }

  /** Keeps the card beside its mark. */
  moved(): void {
    if (this.open < 0) return;
    const rider = this.riders[this.open];
    const gone = rider.element.hidden;
    const frame = this.card.parentElement!;
    const [width, height] = [frame.clientWidth, frame.clientHeight];
    const [w, h] = [this.card.offsetWidth, this.card.offsetHeight];
    const at = /translate\(([-\d.]+)px, ([-\d.]+)px\)/.exec(rider.element.style.transform);
    let [x, y] = at ? [Number(at[1]), Number(at[2])] : [MARGIN, MARGIN];
    if (gone || width < NARROW) {
      y = !gone && y > height - h - BESIDE ? MARGIN : height - h - MARGIN;
      x = (width - w) / 2;
    } else {
      x = Math.max(MARGIN, Math.min(width - w - MARGIN, x - w / 2));
      y = y + BESIDE + h < height - MARGIN ? y + BESIDE : y - HIGH - h;
      y = Math.max(MARGIN, Math.min(height - h - MARGIN, y));
    }
    this.card.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
  }

  private toggle(which: number): void {
    this.open = this.open === which ? -1 : which;
    this.entries.forEach((entry, k) => {
      entry.setAttribute("aria-expanded", String(k === this.open));
      (entry.nextElementSibling as HTMLElement).hidden = k !== this.open;
      this.marks[k].classList.toggle("open", k === this.open);
    });
    this.card.hidden = this.open < 0;
    if (this.open >= 0) {
      const { title, text } = this.hotspots[this.open];
      const number = make("span", { class: "number" }, String(this.open + 1));
      this.card.replaceChildren(make("div", { class: "head" }, number, make("b", {}, title), this.close), make("p", {}, text));
      this.toPlace(this.open);
    }
    this.view.changed();
    this.moved();
  }

  /** Goes to a moment at which the place is on the tissue, where it is not. */
  private toPlace(which: number): void {
    const { places } = this.hotspots[which];
    const { player } = this.view;
    if (places[Math.floor(player.time + 1e-6)]) return;
    const steps = player.timeline.steps.findIndex((step) => places[step.frame]);
    if (steps >= 0) player.toStep(steps);
  }
}
