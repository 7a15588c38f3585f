// What is printed: the title and a picture of every step with its caption.
import { make } from "./elements";
import type { Chapter, Lesson } from "./lesson";
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
    signal: AbortSignal,
    private readonly chapter: Chapter | null,
  ) {
    window.addEventListener("beforeprint", () => this.fill(), { signal });
    const empty = (): void => {
      this.element.replaceChildren();
      restored();
    };
    window.addEventListener("afterprint", empty, { signal });
    signal.addEventListener("abort", () => this.element.remove());
  }

  private fill(): void {
    const { lesson, picture, timeline } = this;
    this.element.replaceChildren(make("h1", {}, lesson.title));
    if (this.chapter) {
      this.element.append(make("h2", {}, this.chapter.title), ...this.chapter.text.map((each) => make("p", {}, each)));
    }
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
