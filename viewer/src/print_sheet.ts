// What is printed: the title and a picture of every step with its caption.
import { make } from "./elements";
import type { Lesson } from "./lesson";
import type { Picture } from "./picture";
import type { Shown } from "./stage";
import type { Timeline } from "./timeline";
import type { Transport } from "./transport";
import type { Words } from "./words";

const WIDTH = 960;
const HEIGHT = 640;

export class PrintSheet {
  readonly element = make("section", { id: "sheet", "aria-hidden": "true" });

  constructor(
    private readonly lesson: Lesson,
    private readonly words: Words,
    private readonly picture: Picture,
    private readonly timeline: Timeline,
    private readonly transport: Transport,
    private readonly shown: Shown,
    restored: () => void,
  ) {
    window.addEventListener("beforeprint", () => this.fill());
    window.addEventListener("afterprint", () => {
      this.element.replaceChildren();
      restored();
    });
  }

  private fill(): void {
    const { lesson, picture, timeline } = this;
    this.element.replaceChildren(make("h1", {}, lesson.title));
    picture.stages.forEach((stage, which) => {
      if (picture.stages.length > 1) this.element.append(make("h2", {}, stage.procedure.title));
      const grid = make("div", { class: "figures" });
      const times = timeline.steps.length ? timeline.steps.map((step) => step.time) : [timeline.length];
      times.forEach((time, k) => {
        const source = picture.still_image(time, this.shown, WIDTH, HEIGHT, which);
        const caption = this.transport.caption(k);
        const image = make("img", { src: source, alt: caption });
        grid.append(make("figure", {}, image, make("figcaption", {}, make("b", {}, `${k + 1}  `), caption)));
      });
      this.element.append(grid);
    });
    this.element.append(make("p", {}, this.words.say("made", { version: lesson.version })));
  }
}
