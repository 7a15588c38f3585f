// The bar below the picture: the steps, play, the time, the speed.
import { icon, iconButton, make, name } from "./elements";
import type { Player } from "./player";
import type { Words } from "./words";

const SPEEDS = [0.25, 0.5, 1, 2];

export class Transport {
  readonly element = make("section", { id: "transport" });
  readonly slider = make("input", { type: "range", id: "time", min: 0, step: "any", value: 0 });
  private readonly play: HTMLButtonElement;
  private readonly previous: HTMLButtonElement;
  private readonly next: HTMLButtonElement;
  private readonly steps = make("ol", { id: "steps" });
  private readonly ticks = make("div", { class: "ticks", "aria-hidden": "true" });
  private readonly speed = make("select", { id: "speed" });
  private readonly hold = make("input", { type: "checkbox", id: "hold", checked: true });
  private readonly holdText = make("span");
  private readonly count = make("span", { class: "count" });
  private step = -1;
  private playing: boolean | null = null;

  constructor(
    private readonly player: Player,
    private readonly words: Words,
  ) {
    this.play = iconButton("play", () => player.toggle(), { id: "play" });
    this.previous = iconButton("previous", () => player.skip(-1), { id: "previous" });
    this.next = iconButton("next", () => player.skip(1), { id: "next" });
    this.slider.max = String(player.timeline.length);
    this.slider.addEventListener("input", () => {
      player.playing = false;
      player.seek(Number(this.slider.value));
    });
    for (const each of SPEEDS) this.speed.append(make("option", { value: each, selected: each === 1 }, `${each}×`));
    this.speed.addEventListener("change", () => (player.speed = Number(this.speed.value)));
    this.hold.addEventListener("change", () => (player.hold = this.hold.checked));
    for (const { time } of player.timeline.steps) {
      const tick = make("i");
      tick.style.left = `${(100 * time) / Math.max(1e-9, player.timeline.length)}%`;
      this.ticks.append(tick);
    }
    player.timeline.steps.forEach((_, k) => {
      const button = make("button", { type: "button" });
      button.addEventListener("click", () => player.toStep(k));
      this.steps.append(make("li", {}, button));
    });
    this.element.append(
      make("nav", { id: "step-list" }, this.steps),
      make(
        "div",
        { class: "bar" },
        make("div", { class: "buttons" }, this.previous, this.play, this.next),
        make("div", { class: "track" }, this.slider, this.ticks),
        this.count,
        make("label", { class: "hold" }, this.hold, this.holdText),
        this.speed,
      ),
    );
    this.speak();
  }

  speak(): void {
    const { words, player } = this;
    name(this.previous, words.say("previous"));
    name(this.next, words.say("next"));
    this.slider.setAttribute("aria-label", words.say("time"));
    this.speed.setAttribute("aria-label", words.say("speed"));
    this.holdText.textContent = words.say("hold");
    this.steps.parentElement!.setAttribute("aria-label", words.say("steps"));
    name(this.element, words.say("time"));
    this.steps.querySelectorAll("button").forEach((button, k) => {
      const number = make("span", { class: "number" }, String(k + 1));
      button.replaceChildren(number, make("span", {}, this.caption(k)));
    });
    this.step = -1;
    this.playing = null;
    this.update(player.time);
  }

  /** What a step shows. */
  caption(step: number): string {
    const { steps } = this.player.timeline;
    if (!steps.length) return "";
    return this.words.say(`step.${steps[step].kind}`, { time: steps[step].frame + 1 });
  }

  update(time: number): void {
    const { player, words } = this;
    const count = Math.round(player.timeline.length) + 1;
    const number = Math.min(count, Math.floor(time + 1e-6) + 1);
    if (document.activeElement !== this.slider || Number(this.slider.value) !== time) this.slider.value = String(time);
    const share = player.timeline.length ? time / player.timeline.length : 1;
    this.slider.style.setProperty("--done", `${100 * share}%`);
    const frame = words.say("frame", { number, count });
    this.slider.setAttribute("aria-valuetext", `${this.caption(player.step)}, ${frame}`);
    this.count.textContent = `${number} / ${count}`;
    if (player.playing !== this.playing) {
      this.playing = player.playing;
      this.play.replaceChildren(icon(player.playing ? "pause" : "play"));
      name(this.play, words.say(player.playing ? "pause" : "play"));
    }
    if (player.step !== this.step) {
      this.step = player.step;
      this.steps.querySelectorAll("button").forEach((button, k) => {
        if (k === this.step) {
          button.setAttribute("aria-current", "step");
          const list = this.steps.parentElement!;
          list.scrollTo({ left: button.offsetLeft - (list.clientWidth - button.offsetWidth) / 2 });
        } else button.removeAttribute("aria-current");
      });
    }
  }
}
