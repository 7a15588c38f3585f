// The key of a map: its colors, the value at the top, its unit.
import { make } from "./elements";
import type { Lesson } from "./lesson";
import { type Look, rampGradient } from "./materials";
import type { Words } from "./words";

export class Legend {
  readonly element = make("div", { id: "legend", role: "group" });
  private readonly title = make("p");
  private readonly numbers = make("div", { class: "numbers" });
  private look: Look = "grid";

  constructor(
    private readonly lesson: Lesson,
    private readonly words: Words,
  ) {
    const bar = make("div", { class: "ramp" });
    bar.style.background = rampGradient(lesson.ramp);
    this.element.append(this.title, bar, this.numbers);
    this.element.hidden = true;
  }

  speak(): void {
    const scale = this.lesson.procedures[0].quantities[this.look];
    this.element.hidden = !scale;
    if (!scale) return;
    const what = this.words.say(`surface.${this.look}`);
    this.element.setAttribute("aria-label", what);
    this.title.textContent = scale.unit ? `${what} (${scale.unit})` : what;
    const number = new Intl.NumberFormat(this.words.language, { maximumSignificantDigits: 3 });
    const stops = [0, 0.25, 0.5, 0.75, 1].map((share) => number.format(share * scale.full));
    stops[4] = `≥ ${stops[4]}`;
    this.numbers.replaceChildren(...stops.map((text) => make("span", {}, text)));
  }

  update(look: Look): void {
    if (look === this.look) return;
    this.look = look;
    this.speak();
  }
}
