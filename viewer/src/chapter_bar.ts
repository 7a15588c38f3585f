// The chapters of a lesson below its title, with what is done of each.
import { icon, make, name } from "./elements";
import type { Course } from "./lesson";
import type { Standing } from "./standing";
import type { Words } from "./words";

export class ChapterBar {
  readonly element = make("nav", { id: "chapters" });
  private readonly buttons: HTMLButtonElement[];
  private readonly list = make("ol");
  private readonly progress = make("progress", { max: 1, value: 0 });
  private readonly score = make("span", { class: "score" });

  constructor(
    private readonly course: Course,
    private readonly words: Words,
    private readonly standing: Standing,
    open: (chapter: number) => void,
  ) {
    this.buttons = course.chapters.map((_, k) => {
      const button = make("button", { type: "button" });
      button.addEventListener("click", () => open(k));
      this.list.append(make("li", {}, button));
      return button;
    });
    this.element.append(this.list, this.score, this.progress);
  }

  speak(): void {
    name(this.element, this.words.say("chapters"));
    this.element.removeAttribute("title");
    this.progress.setAttribute("aria-label", this.words.say("progress"));
    this.update();
  }

  update(): void {
    const { course, standing, words } = this;
    course.chapters.forEach(({ title }, k) => {
      const button = this.buttons[k];
      const done = standing.finished(k);
      const mark = make("span", { class: "number" }, done ? icon("check") : String(k + 1));
      const spoken = done ? [make("span", { class: "spoken" }, ` (${words.say("chapter.done")})`)] : [];
      button.replaceChildren(mark, make("span", { class: "name" }, title), ...spoken);
      button.classList.toggle("done", done);
      if (k === standing.chapter) button.setAttribute("aria-current", "page");
      else button.removeAttribute("aria-current");
    });
    const current = this.buttons[standing.chapter];
    this.list.scrollTo({ left: current.offsetLeft - (this.list.clientWidth - current.offsetWidth) / 2 });
    this.progress.value = standing.share;
    this.score.hidden = !standing.questions;
    const values = { right: standing.rightAnswers(), count: standing.questions };
    this.score.textContent = words.say("score", values);
  }
}
